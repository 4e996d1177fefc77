"""No write ever leaves the allowed set, and what is latched stays so until it is reset."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_common.command_gate import SafetySettings
from bha_driver.latched_faults import EMERGENCY_STOP, LINK_LOST, OVERSLEPT, RESTARTED
from bha_driver.safety import Safety
from bha_driver.scaling import Scaling
from bha_driver.terminal_file import example_path, load_terminal

PERIOD = 0.02
BASE = load_terminal(example_path("cpx_e"))
MAP = dataclasses.replace(BASE, limits=dataclasses.replace(BASE.limits, pressure_rate=2e5))
SCALING = Scaling(MAP)
FULL = np.full(9, 1.3e5)
PLACES = np.array([item.length.register - MAP.input_block[0] for item in MAP.bellows])


def inputs(length: float = 0.2, index: int | None = None, other: float = 0.0) -> np.ndarray:
    """A block as the terminal sends it: all bellows of one length, but one."""
    lengths = np.full(9, length)
    if index is not None:
        lengths[index] = other
    block = np.zeros(MAP.input_block[1], dtype=np.int64)
    block[PLACES] = [
        item.length.word(value) for item, value in zip(MAP.bellows, lengths, strict=True)
    ]
    return block


class Robot:
    """Drives the safety logic as the cycle does, and keeps what would go over the wire."""

    def __init__(self, settings: SafetySettings | None = None) -> None:
        self.safety = Safety(MAP, settings or SafetySettings(), PERIOD)
        self.time = 1000.0
        self.written: list[tuple[float, np.ndarray]] = []
        self.rng = np.random.default_rng(0)

    def ready(self) -> Robot:
        self.safety.link_made(self.time, intact=False)
        self.see()
        assert self.safety.activate(self.time) == ""
        return self

    def see(self, length: float = 0.2) -> None:
        """Read lengths with a little noise, so that none is frozen."""
        block = inputs(length)
        block[PLACES] += self.rng.integers(0, 3, 9)
        self.safety.see(self.time, block)

    def write(self) -> np.ndarray | None:
        """Decide and write; the pressures that go out [Pa]."""
        words = self.safety.set_points(self.time)
        if words is None:
            return None
        self.written.append((self.time, words))
        self.safety.confirmed(self.time)
        return SCALING.commanded(words)

    def cycle(self, command: np.ndarray | None = None, dt: float = PERIOD) -> np.ndarray | None:
        self.time += dt
        self.see()
        if command is not None:
            self.safety.offer(self.time, command)
        return self.write()

    def press(self) -> Robot:
        for _ in range(50):
            self.cycle(FULL)
        assert (self.safety.applied == MAP.limits.pressure).all()
        return self

    def vented(self, limit: float = 5.0) -> float:
        """Go on with full commands until nothing is applied; how long that took [s]."""
        begin = self.time
        while self.time < begin + limit:
            out = self.cycle(FULL)
            if out is None or not out.any():
                return self.time - begin
        raise AssertionError(f"not vented within {limit} s: {self.safety.applied}")


NUMBERS = st.floats()  # not a number and infinite ones among them
EVENTS = st.one_of(
    st.tuples(st.just("cycle"), st.lists(NUMBERS, min_size=9, max_size=9)),
    st.tuples(st.just("silence"), st.integers(1, 80)),
    st.tuples(st.just("late"), st.floats(0.0, 3.0)),
    st.tuples(st.just("stop"), st.none()),
    st.tuples(st.just("reset"), st.none()),
    st.tuples(st.just("activate"), st.none()),
    st.tuples(st.just("deactivate"), st.none()),
    st.tuples(st.just("link"), st.tuples(st.booleans(), st.floats(0.0, 1.0))),
    st.tuples(st.just("unconfirmed"), st.lists(NUMBERS, min_size=9, max_size=9)),
    st.tuples(st.just("length"), st.floats(-1.0, 1.0)),
)


@settings(max_examples=300, deadline=None)
@given(st.lists(EVENTS, max_size=60))
def test_whatever_happens_each_write_is_allowed(events: list[tuple[str, object]]) -> None:
    """In range, never negative, and never faster up than the rate; down too, unless to nothing."""
    robot = Robot().ready()
    safety = robot.safety
    for kind, value in events:
        if kind == "cycle":
            robot.cycle(np.array(value))
        elif kind == "silence":
            for _ in range(value):
                robot.cycle()
        elif kind == "late":
            robot.time += value
        elif kind == "stop":
            safety.stop(robot.time)
        elif kind == "reset":
            safety.reset(robot.time)
        elif kind == "activate":
            safety.activate(robot.time)
        elif kind == "deactivate":
            safety.deactivate(robot.time)
        elif kind == "link":
            intact, gap = value
            safety.link_failed(robot.time, "test")
            robot.time += gap
            safety.link_failed(robot.time, "test")
            safety.link_made(robot.time, intact=intact)
        elif kind == "unconfirmed":
            robot.time += PERIOD
            safety.offer(robot.time, np.array(value))
            words = safety.set_points(robot.time)
            if words is not None:  # taken, although the answer was lost
                robot.written.append((robot.time, words))
        elif kind == "length":
            robot.time += PERIOD
            safety.see(robot.time, inputs(0.2, 4, value))
            robot.write()
        if safety.stopped:
            stopped_at = len(robot.written)
            robot.cycle(FULL)
            for (_, before), (_, after) in zip(
                robot.written[stopped_at - 1 : stopped_at], robot.written[stopped_at:], strict=False
            ):
                assert (after <= before).all(), "pressed although stopped"
    before, time = SCALING.vented, robot.written[0][0] if robot.written else 0.0
    for now, words in robot.written:
        assert words.min() >= 0
        pressures = SCALING.commanded(words)
        assert (pressures <= MAP.limits.pressure + 1e-6).all()
        assert (pressures >= -1e-6).all()
        if now - time > MAP.watchdog.time:
            before = SCALING.vented  # by the terminal itself
        allowed = MAP.limits.pressure_rate * min(now - time, PERIOD) + SCALING.count_worth * 1.001
        change = pressures - SCALING.commanded(before)
        assert (change <= allowed).all()
        assert ((change >= -allowed) | (words == SCALING.vented)).all()
        before, time = words, now


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_command_that_is_no_number_is_none(value: float) -> None:
    robot = Robot().ready()
    command = FULL.copy()
    command[3] = value
    while robot.safety.state != "running":
        robot.cycle(np.full(9, 5e4))
    before = robot.cycle(np.full(9, 5e4))
    for _ in range(100):
        robot.cycle(command)
    assert robot.safety.state == "silent", "the last valid one stands until the watchdog ends it"
    assert (robot.safety.applied < before + 5e4).all()


def test_a_command_arrives_at_the_limited_rate() -> None:
    robot = Robot().ready()
    seen = [robot.cycle(FULL).max() for _ in range(40)]
    steps = np.diff(seen)
    assert seen[0] == 0.0, "the first write has no time to rise in"
    assert steps.max() == pytest.approx(MAP.limits.pressure_rate * PERIOD, abs=8.0)
    assert seen[-1] == pytest.approx(1.3e5, abs=8.0)


def test_nothing_is_written_before_activation() -> None:
    robot = Robot()
    robot.safety.link_made(robot.time, intact=False)
    for _ in range(100):
        assert robot.cycle(FULL) is None
    assert robot.safety.state == "inactive"


def test_a_command_from_before_activation_does_not_count() -> None:
    robot = Robot()
    robot.safety.link_made(robot.time, intact=False)
    robot.see()
    robot.safety.activate(robot.time)
    robot.safety.offer(robot.time - 0.01, FULL)
    robot.time += PERIOD
    assert not robot.write().any()
    assert robot.safety.state == "silent"


def test_silence_vents_at_the_limited_rate() -> None:
    robot = Robot().ready().press()
    safety, begin = robot.safety, robot.time
    while safety.state == "running":
        robot.cycle()
    assert robot.time - begin == pytest.approx(1.0, abs=1.6 * PERIOD)
    first = safety.applied.max()
    robot.cycle()
    assert first - safety.applied.max() == pytest.approx(4e4 * PERIOD, rel=1e-6)
    assert not safety.stopped, "silence is not latched"
    assert robot.cycle(FULL).max() > first - 4e4 * PERIOD


def test_hold_keeps_the_pressure_when_the_controller_is_silent() -> None:
    robot = Robot(SafetySettings(safe_state="hold")).ready().press()
    for _ in range(200):
        robot.cycle()
    assert (robot.safety.applied == 1.3e5).all()
    robot.safety.deactivate(robot.time)
    assert robot.vented() < 3.5, "no activity, no pressure"


@pytest.mark.parametrize("way", ["stop", "range", "jump", "link"])
def test_hold_keeps_the_pressure_under_a_stop_and_faults(way: str) -> None:
    robot = Robot(SafetySettings(safe_state="hold")).ready().press()
    safety = robot.safety
    robot.time += PERIOD
    if way == "stop":
        safety.stop(robot.time)
    elif way == "link":
        safety.link_failed(robot.time, "cut", gone=True)
        safety.link_made(robot.time, intact=True)
    else:
        safety.see(robot.time, inputs(0.2, 3, {"range": 0.45, "jump": 0.25}[way]))
    robot.write()
    for _ in range(200):
        assert (robot.cycle(np.zeros(9)) > 1.29e5).all()
    assert safety.stopped
    assert safety.reset(robot.time) == ""
    assert (robot.cycle() > 1.29e5).all(), "until there is a new command"
    assert (robot.cycle(np.zeros(9)) < 1.27e5).all()
    safety.stop(robot.time)
    safety.deactivate(robot.time)
    assert robot.vented() < 3.5, "no activity, no pressure"


@pytest.mark.parametrize("way", ["restart", "late"])
def test_hold_begins_at_nothing_when_the_terminal_has_vented(way: str) -> None:
    robot = Robot(SafetySettings(safe_state="hold")).ready().press()
    if way == "restart":
        robot.safety.link_failed(robot.time, "cut")
        robot.safety.link_made(robot.time, intact=False)
    else:
        robot.time += 0.5
    for _ in range(10):
        assert not robot.cycle(FULL).any()


@pytest.mark.parametrize("way", ["stop", "range", "jump", "link", "restart", "late"])
def test_a_fault_is_latched_and_the_old_command_never_comes_back(way: str) -> None:
    robot = Robot().ready().press()
    safety = robot.safety
    which = {
        "stop": EMERGENCY_STOP,
        "range": "length out of range",
        "jump": "length jumped",
        "link": LINK_LOST,
        "restart": RESTARTED,
        "late": OVERSLEPT,
    }[way]
    before = safety.applied.max()
    robot.time += PERIOD
    if way == "stop":
        safety.stop(robot.time)
    elif way == "range":
        assert not safety.see(robot.time, inputs(0.2, 3, 0.45))
    elif way == "jump":
        assert not safety.see(robot.time, inputs(0.2, 3, 0.25))
    elif way == "link":
        for _ in range(10):
            robot.time += PERIOD
            safety.link_failed(robot.time, "no answer")
        safety.link_made(robot.time, intact=True)
    elif way == "restart":
        safety.link_failed(robot.time, "cut")
        safety.link_made(robot.time, intact=False)
    elif way == "late":
        robot.time += 0.5
    safety.offer(robot.time, FULL)
    first = robot.write()
    assert first.max() < before, "the next write vents already"
    if way in ("restart", "late", "link"):
        assert not first.any(), "the terminal has vented: that must not be pressed again"
    assert safety.faults[0].which == which
    assert safety.state == "stopped"
    robot.vented()
    for _ in range(100):
        robot.cycle(FULL)
    assert not robot.written[-1][1].any(), "pressed again without a reset"

    robot.see()
    old = robot.time
    assert safety.reset(robot.time) == ""
    safety.offer(old, FULL)
    robot.time += PERIOD
    robot.see()
    assert not robot.write().any(), "the old command came back"
    assert robot.cycle(FULL).any(), "a newer command counts again"


def test_a_fault_is_named_with_bellows_and_numbers() -> None:
    robot = Robot().ready()
    robot.time += PERIOD
    robot.safety.see(robot.time, inputs(0.2, 3, 0.45))
    assert "bellows_2_1 is 0.45" in str(robot.safety.faults[0])


def test_a_lost_connection_is_known_within_its_time() -> None:
    robot = Robot().ready().press()
    begin = robot.time
    while not robot.safety.stopped:
        robot.time += PERIOD
        robot.safety.link_failed(robot.time, "no answer")
    assert robot.time - begin <= MAP.timeouts.link + 1e-9


def test_a_connection_that_the_terminal_cuts_is_lost_at_once() -> None:
    robot = Robot().ready().press()
    robot.time += PERIOD
    robot.safety.link_failed(robot.time, "cut", gone=True)
    robot.safety.link_made(robot.time, intact=True)
    assert robot.safety.faults[0].which == LINK_LOST
    assert robot.cycle(FULL).max() < 1.3e5


def test_an_answer_that_is_late_once_is_no_fault() -> None:
    robot = Robot().ready().press()
    robot.time += PERIOD
    robot.safety.link_failed(robot.time, "no answer")
    robot.safety.link_made(robot.time, intact=True)
    assert robot.cycle(FULL).max() == pytest.approx(1.3e5, abs=8.0)
    assert not robot.safety.stopped


def test_reads_alone_do_not_keep_the_connection_alive() -> None:
    """A terminal that refuses every write holds the old pressures."""
    robot = Robot().ready().press()
    for _ in range(5):
        robot.time += PERIOD
        robot.see()
        robot.safety.set_points(robot.time)
        robot.safety.link_failed(robot.time, "refused")
        robot.safety.link_made(robot.time, intact=True)
    assert robot.safety.faults[0].which == LINK_LOST


def test_a_connection_that_opens_and_never_answers_is_lost() -> None:
    robot = Robot().ready().press()
    for _ in range(5):
        robot.time += PERIOD
        robot.safety.link_made(robot.time, intact=True)
        robot.safety.link_failed(robot.time, "no answer")
    assert robot.safety.faults[0].which == LINK_LOST


def test_a_reset_is_refused_while_the_cause_is_there() -> None:
    robot = Robot().ready()
    safety = robot.safety
    robot.time += PERIOD
    safety.see(robot.time, inputs(0.2, 8, 0.05))
    assert "bellows_3_3 is 0.05" in safety.reset(robot.time)
    assert safety.stopped
    robot.see()
    assert safety.reset(robot.time) == ""
    for _ in range(10):
        robot.time += PERIOD
        safety.link_failed(robot.time, "the cable is out")
    assert "the cable is out" in safety.reset(robot.time)
    assert safety.stopped


def test_no_activation_while_something_is_latched() -> None:
    robot = Robot()
    safety = robot.safety
    assert "not connected" in safety.activate(robot.time)
    safety.link_made(robot.time, intact=False)
    safety.stop(robot.time)
    assert "reset first: emergency stop" in safety.activate(robot.time)
    assert safety.reset(robot.time) == ""
    safety.see(robot.time, inputs(0.05))
    assert "bellows_1_1 is 0.05" in safety.activate(robot.time)
    robot.see()
    assert safety.activate(robot.time) == ""


def test_an_activation_while_it_vents_forgets_no_missing_write() -> None:
    """The process stalls while it vents: the terminal has vented by itself meanwhile."""
    robot = Robot().ready().press()
    robot.safety.deactivate(robot.time)
    robot.cycle()
    robot.time += 1.0
    assert robot.safety.activate(robot.time) == ""
    assert not robot.cycle(FULL).any(), "what the terminal has vented was pressed again"
    assert robot.safety.faults[0].which == OVERSLEPT


def test_an_activation_while_it_vents_goes_on_from_what_is_applied() -> None:
    robot = Robot().ready().press()
    robot.safety.deactivate(robot.time)
    before = robot.cycle()
    assert robot.safety.activate(robot.time) == ""
    allowed = MAP.limits.pressure_rate * PERIOD + SCALING.count_worth
    assert (np.abs(robot.cycle(FULL) - before) <= allowed).all()
    assert not robot.safety.stopped


def test_deactivation_vents_to_the_last_confirmed_count() -> None:
    robot = Robot().ready().press()
    robot.safety.deactivate(robot.time)
    while robot.safety.applied.any():
        robot.time += PERIOD
        words = robot.safety.set_points(robot.time)  # never confirmed
        assert words is not None
        robot.safety.confirmed(robot.time) if words.any() else None
    assert robot.safety.pressing, "the last write was not confirmed"
    assert robot.cycle() is not None
    assert not robot.safety.pressing
    assert robot.cycle() is None, "after that nothing is driven"


def test_a_driver_that_ends_vents_within_a_second() -> None:
    robot = Robot().ready().press()
    begin = robot.time
    while robot.safety.pressing:
        robot.time += PERIOD
        robot.safety.set_points(robot.time, ending=True)
        robot.safety.confirmed(robot.time)
    assert robot.time - begin <= 1.0 + 2 * PERIOD


class TestFrozen:
    def run(self, *, moving: bool, pressed: bool, seconds: float) -> Robot:
        robot = Robot().ready()
        block = inputs(0.2)
        for step in range(round(seconds / PERIOD)):
            robot.time += PERIOD
            if moving:
                block = inputs(0.2)
                block[PLACES] += step % 2
            robot.safety.see(robot.time, block)
            robot.safety.offer(robot.time, np.full(9, 3e4 if pressed else 0.0))
            robot.write()
        return robot

    def test_a_frozen_reading_is_found_when_it_can_be(self) -> None:
        robot = self.run(moving=False, pressed=True, seconds=2.0)
        (fault,) = robot.safety.faults
        assert fault.which == "length frozen"
        assert "has kept to the raw value" in fault.why
        begin = 1000.0  # the pressure has moved enough long before the time is over
        assert fault.time - begin <= MAP.limits.frozen_time + 2 * PERIOD

    def test_a_robot_at_rest_is_not_frozen(self) -> None:
        assert not self.run(moving=False, pressed=False, seconds=3.0).safety.stopped

    def test_a_reading_that_moves_by_a_count_is_not_frozen(self) -> None:
        assert not self.run(moving=True, pressed=True, seconds=3.0).safety.stopped

    def test_no_reset_before_it_has_moved(self) -> None:
        """Venting moves a sound potentiometer; a person can move it by hand."""
        robot = self.run(moving=False, pressed=True, seconds=2.0)
        block = inputs(0.2)
        for _ in range(300):  # vented long ago
            robot.time += PERIOD
            robot.safety.see(robot.time, block)
            robot.write()
        assert "bellows_1_1 has kept to the raw value" in robot.safety.reset(robot.time)
        assert robot.safety.stopped
        robot.time += PERIOD
        block[PLACES[:8]] += 1
        robot.safety.see(robot.time, block)
        assert "bellows_3_3 has kept to the raw value" in robot.safety.reset(robot.time)
        robot.time += PERIOD
        block[PLACES[8]] += 1
        robot.safety.see(robot.time, block)
        assert robot.safety.reset(robot.time) == ""

    def test_no_activation_before_it_has_moved(self) -> None:
        robot = self.run(moving=False, pressed=True, seconds=2.0)
        robot.safety.deactivate(robot.time)
        robot.safety.see(robot.time, inputs(0.2))
        assert robot.safety.reset(robot.time) == "", "nothing is driven"
        robot.safety.see(robot.time, inputs(0.2))
        assert "has kept to the raw value" in robot.safety.activate(robot.time)
        robot.safety.see(robot.time, inputs(0.201))
        assert robot.safety.activate(robot.time) == ""

    def test_after_a_reset_it_is_found_again(self) -> None:
        robot = self.run(moving=False, pressed=True, seconds=2.0)
        block = inputs(0.201)
        robot.safety.see(robot.time, block)
        assert robot.safety.reset(robot.time) == ""
        for _ in range(100):
            robot.time += PERIOD
            robot.safety.see(robot.time, block)
            robot.safety.offer(robot.time, np.full(9, 6e4))
            robot.write()
        assert robot.safety.stopped
