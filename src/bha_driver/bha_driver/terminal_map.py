"""What is known of a lab's terminal: address, registers, scales, limits and watchdogs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from bha_common import bellows
from bha_common.settings import check_settings, setting
from bha_driver.channel import Channel
from bha_driver.errors import TerminalMapError
from bha_driver.mapping import required

LARGEST_READ, LARGEST_WRITE = 125, 123
"""Most registers of one read and one write (Modbus application protocol 1.1b3, 6.3 and 6.12)."""


@dataclass(frozen=True)
class Timeouts:
    """How long the driver waits for the terminal."""

    request: float = setting(0.02, "Wait for one reply [s]", low=1e-3, high=1.0)
    connect: float = setting(0.25, "Wait for a connection [s]", low=1e-3, high=5.0)
    link: float = setting(
        0.06, "Time without a good exchange after which the connection is lost [s]", low=1e-3
    )
    reconnect: float = setting(0.5, "Time between two tries to connect again [s]", low=0.01)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True)
class Watchdog:
    """The terminal's own watchdog: vents when nobody has written for some time."""

    time: float = setting(0.2, "Time without a write after which it vents [s]", low=0.1, high=10.0)
    register: int | None = setting(
        None, "Register that arms it; none: it is armed on the terminal itself", low=0, high=0xFFFF
    )
    step: float = setting(0.001, "Time of one count in that register [s]", low=1e-6, high=1.0)

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def word(self) -> int:
        """What its register must hold."""
        return max(1, round(self.time / self.step))


@dataclass(frozen=True)
class Limits:
    """What no command may exceed, and which lengths are believed."""

    pressure: float = setting(
        bellows.MAX_PRESSURE, "Highest pressure of a bellows [Pa]", low=1.0, high=2e5
    )
    pressure_rate: float = setting(
        4e5, "Fastest change of a pressure, up or down [Pa/s]", low=1e3, high=1e8
    )
    shortest: float = setting(bellows.MIN_LENGTH, "Shortest length that is believed [m]", low=0.0)
    longest: float = setting(bellows.MAX_LENGTH, "Longest length that is believed [m]", high=2.0)
    length_rate: float = setting(1.0, "Fastest change of a length that is believed [m/s]", low=1e-3)
    length_step: float = setting(0.015, "Change between readings always believed [m]", low=0.0)
    frozen_time: float = setting(
        1.0,
        "Time for which a reading may keep to one raw value while the pressure moves [s]",
        low=0.1,
    )
    frozen_pressure: float = setting(
        1e4, "Motion of a set-point from which its bellows must move as well [Pa]", low=1.0
    )

    def __post_init__(self) -> None:
        check_settings(self)
        if self.longest <= self.shortest:
            raise TerminalMapError(
                f"longest is {self.longest:g}; it must be above shortest, {self.shortest:g} m"
            )


@dataclass(frozen=True)
class BellowsChannels:
    """The registers of a bellows: pressure set-point, potentiometer, measured pressure."""

    set_point: Channel
    length: Channel
    pressure: Channel


@dataclass(frozen=True)
class Identity:
    """Words that the terminal must show; a terminal with others is not driven."""

    register: int = required("First register", low=0, high=0xFFFF)
    words: tuple[int, ...] = required("The words from there on")

    def __post_init__(self) -> None:
        check_settings(self)
        words = self.words
        good = isinstance(words, list | tuple) and 1 <= len(words) <= LARGEST_READ
        if not good or not all(type(word) is int and 0 <= word <= 0xFFFF for word in words):
            raise TerminalMapError(
                f"words is {words!r}; it must be a list of whole numbers from 0 to 65535"
            )
        object.__setattr__(self, "words", tuple(words))


@dataclass(frozen=True)
class TerminalMap:
    """A terminal with nine bellows; made by `terminal_file.load_terminal`.

    Attributes
    ----------
    bellows : The registers of each bellows, in the order of `bha_common.bellows.NAMES`.
    identity : What the terminal is known by; None takes any.
    """

    name: str
    host: str
    bellows: tuple[BellowsChannels, ...]
    port: int = setting(502, "TCP port", low=1, high=0xFFFF)
    unit: int = setting(1, "Modbus unit (device) id", low=0, high=255)
    inputs: str = setting("holding", "Kind of the input registers", choices=("holding", "input"))
    read_back: bool = setting(True, "Whether the set-points can be read as well as written")
    identity: Identity | None = None
    timeouts: Timeouts = Timeouts()
    watchdog: Watchdog = Watchdog()
    limits: Limits = Limits()

    def __post_init__(self) -> None:
        check_settings(self)
        if not self.name or not self.host:
            raise TerminalMapError("name and host must not be empty")
        if len(self.bellows) != bellows.COUNT:
            raise TerminalMapError(f"bellows must be {bellows.COUNT}, got {len(self.bellows)}")
        self._check_overlaps()
        self._check_set_points()
        self._check_inputs()
        self._check_times()

    @property
    def output_block(self) -> tuple[int, int]:
        """First register and number of the set-points, which one write covers."""
        return _block([item.set_point.register for item in self.bellows])

    @property
    def input_block(self) -> tuple[int, int]:
        """First register and number of the inputs, which one read covers."""
        return _block(self._input_registers)

    @property
    def _input_registers(self) -> list[int]:
        return [
            channel.register for item in self.bellows for channel in (item.length, item.pressure)
        ]

    def _check_set_points(self) -> None:
        for name, item in zip(bellows.NAMES, self.bellows, strict=True):
            try:
                item.set_point.set_point_range(self.limits.pressure)
            except TerminalMapError as error:
                raise TerminalMapError(f"bellows.{name}.set_point.{error}") from None
        first, count = self.output_block
        registers = {item.set_point.register for item in self.bellows}
        missing = sorted(set(range(first, first + count)) - registers)
        if missing:
            raise TerminalMapError(
                f"bellows: the set-points must lie in one row, for one write sets them all and "
                f"would overwrite {', '.join(map(str, missing[:5]))} in between"
            )

    def _check_inputs(self) -> None:
        first, count = self.input_block
        if count > LARGEST_READ:
            raise TerminalMapError(
                f"bellows: the inputs lie in the registers {first} to {first + count - 1}; one "
                f"read covers {LARGEST_READ} at most, and these are {count}"
            )

    def _check_overlaps(self) -> None:
        """Refuse two meanings of one register: a watchdog's time would be a set-point."""
        seen: dict[tuple[str, int], str] = {}
        for kind, register, field in self._registers():
            if (kind, register) in seen:
                raise TerminalMapError(
                    f"{field} is {register}, which is that of {seen[kind, register]} already"
                )
            seen[kind, register] = field.removesuffix(".register")

    def _registers(self) -> Iterator[tuple[str, int, str]]:
        """Give kind, address and field of each register; the kinds have addresses of their own."""
        for name, item in zip(bellows.NAMES, self.bellows, strict=True):
            field = f"bellows.{name}"
            yield "holding", item.set_point.register, f"{field}.set_point.register"
            yield self.inputs, item.length.register, f"{field}.length.register"
            yield self.inputs, item.pressure.register, f"{field}.pressure.register"
        if self.watchdog.register is not None:
            yield "holding", self.watchdog.register, "watchdog.register"
        if self.identity is not None:
            for index in range(len(self.identity.words)):
                register = self.identity.register + index
                yield "holding", register, f"the register of identity.words[{index}]"

    def _check_times(self) -> None:
        times, watchdog = self.timeouts, self.watchdog
        if times.request > times.link:
            raise TerminalMapError(
                f"timeouts.request is {times.request:g}; it must be at most timeouts.link, "
                f"{times.link:g} s"
            )
        if times.link > 0.5 * watchdog.time:
            raise TerminalMapError(
                f"timeouts.link is {times.link:g}; it must be at most half of watchdog.time, "
                f"{watchdog.time:g} s, so that the driver knows before the terminal acts"
            )
        if not math.isclose(watchdog.word * watchdog.step, watchdog.time, rel_tol=0.01):
            raise TerminalMapError(
                f"watchdog.time is {watchdog.time:g}; it must be a multiple of watchdog.step, "
                f"{watchdog.step:g} s"
            )
        if watchdog.word > 0xFFFF:
            raise TerminalMapError(
                f"watchdog.step is {watchdog.step:g}: {watchdog.time:g} s would be "
                f"{watchdog.word} counts; a register holds 65535"
            )


def _block(registers: list[int]) -> tuple[int, int]:
    return min(registers), max(registers) - min(registers) + 1
