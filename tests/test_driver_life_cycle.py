"""Every order of the driver's transitions, on the real node with a terminal behind it.

The node is made in this process and turned by hand: hundreds of short lives in a few seconds.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState

from bha_common.ros_node import ERROR, WARN
from bha_driver import driver_node
from bha_driver.driver_node import Driver
from bha_driver.robot_time import RobotTime
from bha_driver.scaling import Scaling
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.terminal_file import example_path, parse_terminal
from running_graph import PATIENCE, ros_domain
from terminal_bench import plant

pytestmark = pytest.mark.graph

TEXT = (
    example_path("emulated")
    .read_text()
    .replace("{request: 0.2, connect: 0.5, link: 1.0,", "{request: 1.0, connect: 1.0, link: 1.5,")
    .replace("time: 2.0", "time: 3.0")
)
MAP = parse_terminal(TEXT)
LENGTH = 4
CONFIGURE, ACTIVATE, DEACTIVATE, CLEANUP, SHUTDOWN = (
    "configure",
    "activate",
    "deactivate",
    "cleanup",
    "shutdown",
)
MOVES = {
    ("unconfigured", CONFIGURE): "inactive",
    ("inactive", CLEANUP): "unconfigured",
    ("inactive", ACTIVATE): "active",
    ("active", DEACTIVATE): "inactive",
    ("unconfigured", SHUTDOWN): "finalized",
    ("inactive", SHUTDOWN): "finalized",
    ("active", SHUTDOWN): "finalized",
}
MOST = 2e4  # [Pa]


class Life:
    """A driver from its begin to its end, and the terminal behind it."""

    def __init__(self, emulator: TerminalEmulator) -> None:
        self.emulator = emulator
        self.driver = Driver()
        self.scaling = Scaling(MAP)

    def change(self, move: str) -> bool:
        request = ChangeState.Request(transition=Transition(label=move))
        answer = self.driver._service_change_state.callback(request, ChangeState.Response())
        return bool(answer.success)

    @property
    def state(self) -> str:
        return self.driver.life_label

    @property
    def highest(self) -> float:
        words = np.array(self.emulator.registers.outputs)
        return float(self.scaling.commanded(words).max())

    def until(self, condition: Callable[[], bool]) -> None:
        """Turn the node, with a fresh command at every cycle, until a condition holds."""
        begin = time.monotonic()
        while not condition():
            assert time.monotonic() - begin < PATIENCE, f"{self.state}, {self.highest:.0f} Pa"
            time.sleep(self.driver.work())
            self.emulator.step()
            if self.driver._now:
                self.driver._take_command(self.driver._now, np.full(9, MOST))


@pytest.fixture(scope="module")
def emulator() -> Iterator[TerminalEmulator]:
    with TerminalEmulator(MAP, plant()) as running:
        yield running


@pytest.fixture(scope="module")
def context(emulator: TerminalEmulator, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    file = tmp_path_factory.mktemp("terminal") / "patient.yaml"
    file.write_text(TEXT)
    values = {
        "terminal": file,
        "port": emulator.port,
        "control_period": 0.005,
        "vent_rate": 1e6,
    }
    settings = [part for name, value in values.items() for part in ("-p", f"{name}:={value}")]
    with ros_domain():
        rclpy.init(args=["--ros-args", *settings])
        yield
        rclpy.try_shutdown()


@pytest.fixture
def make_life(context: None, emulator: TerminalEmulator) -> Iterator[Callable[[], Life]]:
    lives = []

    def make() -> Life:
        emulator.registers.boot()
        emulator.registers.forget_writes()
        lives.append(Life(emulator))
        return lives[-1]

    yield make
    emulator.end_all()
    for life in lives:
        life.driver.close()
        life.driver.destroy_node()


def orders() -> list[tuple[str, ...]]:
    """All sequences of transitions; after a shutdown one more, for nothing comes of the others."""
    living = [CONFIGURE, ACTIVATE, DEACTIVATE, CLEANUP]
    found = list(itertools.product(living, repeat=LENGTH))
    for length in range(LENGTH):
        for before in itertools.product(living, repeat=length):
            found.append((*before, SHUTDOWN, living[len(found) % 4]))
    return found


@pytest.mark.parametrize("first", [CONFIGURE, ACTIVATE, DEACTIVATE, CLEANUP, SHUTDOWN])
def test_every_order_of_transitions(make_life: Callable[[], Life], first: str) -> None:
    life = make_life()
    registers = life.emulator.registers
    for order in (order for order in orders() if order[0] == first):
        if life.state == "finalized":
            life.driver.destroy_node()
            life = make_life()
        registers.forget_writes()
        state, may_have_pressed = "unconfigured", False
        for move in order:
            expected = MOVES.get((state, move))
            assert life.change(move) == (expected is not None), (order, move)
            state = expected or state
            assert life.state == state, order
            count = len(registers.writes)
            if state == "active":
                life.until(lambda life=life: life.highest > 0.5 * MOST)
                may_have_pressed = True
            elif state == "inactive":
                life.until(lambda life=life: life.highest == 0.0)
                life.until(lambda life=life, now=life.driver._now: life.driver._now > now)
                late = [words for _, words in registers.writes[count:]]
                for words, after in pairwise(late):
                    assert (np.array(after) <= np.array(words)).all(), "it pressed while inactive"
            else:
                assert life.highest == 0.0, "vented before the transition was answered"
                life.driver.work()
            if not may_have_pressed:
                assert not registers.writes, "nothing is driven before activation"
        if life.state == "active":
            assert life.change(DEACTIVATE)
        if life.state == "inactive":
            assert life.change(CLEANUP)
        assert life.highest == 0.0


@pytest.mark.parametrize("broken", ["deactivate", "activate", "open"])
def test_an_error_within_a_transition_vents(
    make_life: Callable[[], Life], monkeypatch: pytest.MonkeyPatch, broken: str
) -> None:
    """Whatever it is: rclpy turns every exception into the state after `on_error`."""
    life = make_life()
    owner = life.driver._safety if broken == "deactivate" else life.driver._cycle
    sound, calls = getattr(owner, broken), []

    def break_once(*arguments: object) -> object:
        calls.append(arguments)
        if len(calls) == 1:
            raise RuntimeError("nobody has thought of this")
        return sound(*arguments)

    steps = {"open": [], "activate": [CONFIGURE], "deactivate": [CONFIGURE, ACTIVATE]}[broken]
    for move in steps:
        assert life.change(move)
    if broken == "deactivate":
        life.until(lambda: life.highest > 0.5 * MOST)
    monkeypatch.setattr(owner, broken, break_once)
    trips = life.emulator.registers.trips
    assert not life.change({"open": CONFIGURE}.get(broken, broken))
    assert calls
    assert life.state == "unconfigured"
    assert life.highest == 0.0
    assert life.emulator.registers.trips == trips, "the driver has vented, not the watchdog"
    assert not life.driver._cycle.connected
    assert life.change(CONFIGURE), "and can begin anew"
    assert life.change(ACTIVATE)
    life.until(lambda: life.highest > 0.5 * MOST)


def test_a_clock_that_was_set_back_is_taken_on_by_configuring_again(
    make_life: Callable[[], Life], monkeypatch: pytest.MonkeyPatch
) -> None:
    life = make_life()
    for move in (CONFIGURE, ACTIVATE):
        assert life.change(move)
    life.until(lambda: life.highest > 0.5 * MOST)
    assert life.change(DEACTIVATE)
    assert life.change(CLEANUP)
    hour = 3600 * 10**9
    monkeypatch.setattr(
        driver_node, "RobotTime", lambda: RobotTime(system=lambda: time.time_ns() - hour)
    )
    for move in (CONFIGURE, ACTIVATE):
        assert life.change(move)
    life.until(lambda: life.highest > 0.5 * MOST)
    assert abs(life.driver._now - (time.time_ns() - hour)) < 10**9
    life.emulator.begin("cut")
    life.until(lambda: life.driver._safety.stopped and life.driver._cycle.connected)


def test_lengths_that_cannot_be_are_not_published(
    make_life: Callable[[], Life], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody learns from them; pressures go on, and so do lengths when they can be true."""
    life = make_life()
    for move in (CONFIGURE, ACTIVATE):
        assert life.change(move)
    life.until(lambda: life.highest > 0.5 * MOST)
    lengths, pressures = [], []
    monkeypatch.setattr(life.driver, "_lengths", SimpleNamespace(publish=lengths.append))
    monkeypatch.setattr(life.driver, "_pressures", SimpleNamespace(publish=pressures.append))
    wrong = MAP.bellows[4].length
    life.emulator.begin("freeze")
    life.emulator.registers.write(wrong.register, [wrong.word(0.02)])
    life.until(lambda: len(pressures) > 10)
    assert not lengths
    life.emulator.end("freeze")
    life.until(lambda: len(lengths) > 3)
    assert life.driver._safety.faults[0].which == "length out of range"


def test_what_is_wrong_is_told_while_inactive(make_life: Callable[[], Life]) -> None:
    """Nothing is latched then, but who is to activate it must know."""
    life = make_life()

    def told() -> tuple[bytes, str]:
        return life.driver.diagnose()[:2]

    assert told() == (WARN, "unconfigured: drives nothing")
    assert life.change(CONFIGURE)
    life.until(lambda: told() == (WARN, "inactive: drives nothing"))
    wrong = MAP.bellows[4].length
    life.emulator.begin("freeze")
    life.emulator.registers.write(wrong.register, [wrong.word(0.02)])
    life.until(lambda: told()[1].startswith("inactive: drives nothing; bellows_2_2 is 0.0200 m"))
    assert told()[0] == ERROR
    life.emulator.end("freeze")
    life.until(lambda: told() == (WARN, "inactive: drives nothing"))
    life.emulator.begin("refuse")
    life.until(lambda: told()[1].startswith("inactive: drives nothing; not connected: "))
    assert told()[0] == ERROR
    life.emulator.end("refuse")
    life.until(lambda: told() == (WARN, "inactive: drives nothing"))


def test_a_cycle_writes_once_whatever_is_commanded(make_life: Callable[[], Life]) -> None:
    life = make_life()
    for move in (CONFIGURE, ACTIVATE):
        assert life.change(move)
    life.until(lambda: life.highest > 0.5 * MOST)
    driver, registers = life.driver, life.emulator.registers
    while not driver._schedule.write_owed:
        time.sleep(driver.work())
    count = len(registers.writes)
    for _ in range(3):
        driver._take_command(driver._now, np.full(9, MOST))
    assert len(registers.writes) == count + 1
    driver._take_command(driver._now - 1, np.full(9, MOST))
    assert len(registers.writes) == count + 1, "an older one answers nothing"
