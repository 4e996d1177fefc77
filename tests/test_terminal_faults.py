"""Everything that can go wrong with a terminal, on the wire, against the driver's core."""

from __future__ import annotations

import dataclasses
import gc
import os
import re
import socket
import threading
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymodbus.constants import ExcCodes

from bha_common.command_gate import SafetySettings
from bha_driver.control_cycle import ControlCycle
from bha_driver.fault_player import FaultPlayer
from bha_driver.safety import Safety
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.wire_faults import FAULTS, random_faults
from terminal_bench import MAP, PERIOD, TerminalBench

LINK, DOG = MAP.timeouts.link, MAP.watchdog.time
BOUND = 0.1  # [s] from when a fault can be known to the safe state


@pytest.fixture
def bench() -> Iterator[TerminalBench]:
    with TerminalBench() as running:
        yield running.start()


# When the driver can know of a fault [s] after its begin, and what it then says.
DETECTABLE = {
    "delay": (LINK, "connection lost"),
    "drop": (LINK, "connection lost"),
    "exception": (LINK, "connection lost"),
    "refuse": (0.0, "connection lost"),
    "cut": (0.0, "connection lost"),
    "restart": (0.0, "connection lost"),
    "swap": (0.0, "length"),
    "freeze": (MAP.limits.frozen_time, "length frozen"),
}


def test_every_fault_is_tested() -> None:
    assert DETECTABLE.keys() == FAULTS.keys()


def never_rises(bench: TerminalBench, since: float) -> None:
    """Of all writes that reached the terminal, none has pressed again."""
    late = [words for time, words in bench.emulator.registers.writes if time > since]
    for words, after in pairwise(late):
        assert (np.array(after) <= np.array(words)).all(), "pressed again without a reset"


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_leads_to_the_safe_state_and_stays_there(
    bench: TerminalBench, fault: str
) -> None:
    bench.run(2.0)
    safety, registers = bench.safety, bench.emulator.registers
    assert safety.state == "running"
    assert bench.outputs.max() > 2e4
    begin, last_write = bench.time, registers.writes[-1][0]
    bench.emulator.begin(fault)
    bench.command = np.minimum(bench.command + 2e4, 1.2e5)  # moves: frozen values can be known
    falls = bench.falls() if fault not in ("freeze", "swap") else None
    detectable, says = DETECTABLE[fault]
    bench.until(lambda: safety.stopped, detectable + BOUND)
    assert bench.time - begin <= detectable + BOUND
    assert str(safety.faults[0]).startswith(says)

    # At the terminal: the pressure falls as soon as it is known, by writes or by the watchdog.
    known = bench.time
    if fault in ("cut", "swap", "freeze"):
        falls = falls or bench.falls()
        bench.until(falls, begin + detectable + BOUND - known)
    else:
        last_write = max(last_write, registers.writes[-1][0])
        bench.until(falls, last_write + DOG + BOUND - known)
        if fault != "restart":
            assert registers.trips == 1, "out of reach it is the watchdog that vents"

    bench.run(2.5)
    bench.emulator.end(fault)
    bench.run(4.0)
    assert not bench.outputs.any(), "vented"
    assert bench.emulator.connections == 1, "it has connected again"
    never_rises(bench, known)

    assert safety.reset(bench.time) == ""
    bench.until(lambda: bench.outputs.max() > 2e4, 1.0)


@pytest.mark.parametrize("row", ["emergency stop", "out of range", "jump", "swap", "overslept"])
def test_each_other_cause_leads_to_the_safe_state_in_time(bench: TerminalBench, row: str) -> None:
    bench.run(2.0)
    begin, falls = bench.time, bench.falls()
    if row == "emergency stop":
        bench.safety.stop(bench.time)
    elif row == "out of range":
        bench.measure_wrong(0.02)
    elif row == "jump":
        bench.measure_wrong(0.39)
    elif row == "swap":
        bench.emulator.begin("swap")
    else:  # the process is halted, and goes on just before the terminal vents
        bench.time += DOG - MAP.timeouts.request
    known = begin if row != "overslept" else bench.time
    bench.until(falls, BOUND)
    assert bench.time - known <= BOUND
    assert len(bench.safety.faults) == 1
    bench.emulator.end_all()
    bench.run(5.0)
    assert not bench.outputs.any(), "vented"
    never_rises(bench, known)
    old = bench.time
    assert bench.safety.reset(bench.time) == ""
    bench.commanding = False
    bench.safety.offer(old, bench.command)
    bench.run(1.0)
    assert not bench.outputs.any(), "the old command came back"
    bench.commanding = True
    bench.until(lambda: bench.outputs.max() > 2e4, 1.0)


def test_command_silence_vents_in_time_until_there_is_a_newer_command(
    bench: TerminalBench,
) -> None:
    bench.run(2.0)
    bench.commanding = False
    known = bench.time + SafetySettings().command_timeout
    falls = bench.falls()
    bench.until(falls, known + BOUND - bench.time)
    assert bench.time >= known
    bench.run(4.0)
    assert not bench.outputs.any()
    assert not bench.safety.stopped, "silence is not latched"
    bench.commanding = True
    bench.until(lambda: bench.outputs.max() > 2e4, 1.0)


def test_a_cycle_is_one_read_and_one_write(bench: TerminalBench) -> None:
    before = bench.emulator.requests
    bench.run(1.0)
    assert bench.emulator.requests - before == 2 * round(1.0 / PERIOD)
    timing = bench.emulator.registers.timing
    assert (timing.stale, timing.skipped, timing.late) == (0, 0, 0)


@pytest.mark.parametrize("away", [0.0, 1.0])
def test_a_terminal_that_restarts_is_armed_again_and_begins_at_nothing(
    bench: TerminalBench, away: float
) -> None:
    bench.run(2.0)
    registers = bench.emulator.registers
    bench.emulator.begin("restart")
    bench.run(away)
    bench.emulator.end("restart")
    assert not registers.armed
    count = len(registers.writes)
    bench.run(1.0)
    assert registers.armed
    for _, words in registers.writes[count:]:
        assert not any(words), "what was lost with the restart was not pressed again"


def test_a_single_late_answer_is_no_fault(bench: TerminalBench) -> None:
    bench.run(1.0)
    bench.emulator.begin("drop")
    bench.cycle()
    bench.emulator.end("drop")
    bench.run(0.5)
    assert not bench.safety.stopped
    assert bench.driver.failures == 1
    assert bench.safety.state == "running"


def test_a_name_server_that_is_gone_does_not_hold_the_cycle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The name of the host is looked up when the driver is configured, and not again."""
    look_up, names = socket.getaddrinfo, []

    def counting(host: str, *rest: Any, **more: Any) -> Any:
        names.append(host)
        return look_up(host, *rest, **more)

    monkeypatch.setattr(socket, "getaddrinfo", counting)
    with TerminalBench(dataclasses.replace(MAP, host="localhost")) as bench:
        bench.start()
        assert names == ["localhost"]
        bench.run(0.5)
        bench.emulator.begin("cut")
        bench.run(0.5)
        assert bench.driver.connected
        assert len(names) > 1
        assert "localhost" not in names[1:]
        names.clear()
        bench.driver.open(bench.time)
        assert names == ["localhost"], "its address may be another now"


def test_without_a_register_of_the_watchdog_a_late_answer_is_latched() -> None:
    """Whether the terminal was restarted meanwhile cannot be known."""
    watchdog = dataclasses.replace(MAP.watchdog, register=None)
    with TerminalBench(dataclasses.replace(MAP, watchdog=watchdog, read_back=False)) as bench:
        bench.start()
        bench.run(2.0)
        registers = bench.emulator.registers
        assert bench.outputs.max() > 2e4
        assert registers.armed, "on the terminal itself"
        bench.emulator.begin("drop")
        bench.cycle()
        bench.emulator.end("drop")
        count = len(registers.writes)
        bench.run(0.5)
        (fault,) = bench.safety.faults
        assert fault.which == "terminal restarted"
        assert not any(any(words) for _, words in registers.writes[count:])
        assert bench.safety.reset(bench.time) == ""
        bench.until(lambda: bench.outputs.max() > 2e4, 1.0)
        bench.driver.close(lambda: bench.time, bench._pass)
        assert not bench.outputs.any()


def test_the_watchdog_is_armed_by_activation_and_fed_by_writes_alone() -> None:
    with TerminalBench() as bench:
        bench.driver.open(bench.time)
        registers = bench.emulator.registers
        bench.run(1.0)
        assert not registers.armed
        assert not registers.writes, "an inactive driver drives nothing"
        bench.driver.activate(bench.time)
        assert registers.armed
        bench.run(1.0)
        assert bench.outputs.max() > 0.0
        for _ in range(round((DOG + 2 * PERIOD) / PERIOD)):  # a loop that only reads
            bench.time += PERIOD
            bench.emulator.step()
            bench.driver.read(bench.time)
        assert registers.trips == 1
        assert not bench.outputs.any()
        bench.run(1.0)
        assert bench.safety.faults[0].which == "writes overdue"
        assert not bench.outputs.any(), "what the terminal vented is not pressed again"


def test_a_frozen_length_is_found_when_the_clock_was_set_back(bench: TerminalBench) -> None:
    bench.run(0.5)
    bench.driver.close(lambda: bench.time, bench._pass)
    bench.emulator.begin("freeze")
    bench.time -= 3600.0
    bench.start()
    bench.until(lambda: bench.safety.stopped, MAP.limits.frozen_time + BOUND)
    assert bench.safety.faults[0].which == "length frozen"


def test_no_activation_when_the_watchdog_cannot_be_armed(monkeypatch: pytest.MonkeyPatch) -> None:
    with TerminalBench() as bench:
        bench.driver.open(bench.time)
        registers, write = bench.emulator.registers, bench.emulator.registers.write
        monkeypatch.setattr(registers, "write", lambda at, words: write(at, [w + 1 for w in words]))
        assert "holds 201 instead of 200" in bench.driver.activate(bench.time)
        monkeypatch.undo()
        assert bench.safety.state == "inactive"
        bench.run(0.5)
        assert not registers.writes
        assert bench.driver.activate(bench.time) == "", "it has connected again"


def test_a_terminal_that_takes_no_write_vents_although_reads_feed_its_watchdog(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Then the driver keeps silent for longer than the watchdog's time."""
    refusing, act = [False], TerminalEmulator._act

    async def answer(self: TerminalEmulator, function: int, *request: Any) -> ExcCodes | None:
        if refusing[0] and function == 16:
            return ExcCodes.DEVICE_BUSY
        self.registers._fed = self.registers._clock()
        return await act(self, function, *request)

    monkeypatch.setattr(TerminalEmulator, "_act", answer)
    with TerminalBench() as bench:
        bench.start()
        bench.run(2.0)
        assert bench.outputs.max() > 2e4
        refusing[0] = True
        known = bench.time + LINK
        bench.until(lambda: not bench.outputs.any(), LINK + DOG + BOUND)
        assert bench.emulator.registers.trips == 1
        assert bench.safety.faults[0].which == "connection lost"
        bench.run(2.0)
        refusing[0] = False
        bench.run(2.0)
        never_rises(bench, known)
        assert bench.driver.connected
        assert bench.safety.reset(bench.time) == ""
        bench.until(lambda: bench.outputs.max() > 2e4, 1.0)


def test_nothing_is_armed_when_activation_is_refused() -> None:
    with TerminalBench() as bench:
        bench.driver.open(bench.time)
        bench.safety.stop(bench.time)
        assert bench.driver.activate(bench.time) == "reset first: emergency stop"
        assert not bench.emulator.registers.armed


def test_a_terminal_that_another_driver_presses_is_not_driven(bench: TerminalBench) -> None:
    bench.run(1.0)
    address = dataclasses.replace(bench.terminal, port=bench.emulator.port)
    safety = Safety(address, SafetySettings(), PERIOD)
    second = ControlCycle(address, safety)
    second.open(bench.time)
    count = len(bench.emulator.registers.writes)
    reason = second.activate(bench.time)
    assert re.match(r"the terminal holds \d+ Pa at bellows_\d_\d, which this driver", reason)
    assert safety.state == "inactive"
    bench.run(0.1)
    second.close(lambda: bench.time, bench._pass)
    assert len(bench.emulator.registers.writes) == count + 5, "only the first one has written"
    assert bench.safety.state == "running"
    # Its own pressures are no reason against it.
    bench.safety.deactivate(bench.time)
    bench.run(0.1)
    assert bench.outputs.any()
    assert bench.driver.activate(bench.time) == ""


def test_another_terminal_is_not_driven() -> None:
    from bha_driver.errors import TerminalError

    with TerminalBench() as bench:
        bench.emulator.begin("swap")  # the identity comes in the wrong order
        with pytest.raises(TerminalError, match="another terminal, or its words come in another"):
            bench.driver.open(bench.time)
        assert not bench.driver.connected


@pytest.mark.parametrize(
    ("period", "rate", "takes"),
    [(0.02, 1e6, 1.0), (0.005, 1e6, 1.0), (0.05, 1e6, 1.0), (0.02, 2e4, 2.0)],
)
def test_the_end_vents_in_time(period: float, rate: float, takes: float) -> None:
    """Whatever the period, and although the limited rate would take 5 s."""
    limits = dataclasses.replace(MAP.limits, pressure_rate=rate)
    with TerminalBench(dataclasses.replace(MAP, limits=limits), period) as bench:
        bench.start()
        while bench.outputs.max() < 1e5:
            bench.command = np.full(9, 1e5)
            bench.cycle()
        begin = bench.time
        bench.driver.close(lambda: bench.time, bench._pass)
        assert not bench.outputs.any()
        assert bench.emulator.registers.trips == 0, "the driver did it, not the watchdog"
        assert takes - 0.3 < bench.time - begin < takes + 2 * period


def _leaks() -> tuple[int, int, int, float]:
    """Open files, threads, Python objects, and memory of the process [MB]."""
    gc.collect()  # what earlier tests left behind does not count
    files = len(list(Path("/proc/self/fd").iterdir()))
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    megabytes = pages * os.sysconf("SC_PAGE_SIZE") / 1e6
    return files, threading.active_count(), len(gc.get_objects()), megabytes


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_ten_minutes_with_faults_at_random() -> None:
    """No stuck state, no write that is not allowed, no leak of sockets, threads or memory."""
    with TerminalBench() as bench:
        bench.start()
        registers, safety = bench.emulator.registers, bench.safety
        player = FaultPlayer(bench.emulator, random_faults(5, 590.0, 6.0))
        for fault in FAULTS:  # what is made once, the first time that it is needed, is no leak
            bench.emulator.begin(fault)
            bench.run(0.3)
            bench.emulator.end(fault)
        bench.run(5.0)
        safety.reset(bench.time)
        bench.run(1.0)
        registers.forget_writes()
        first, seen = _leaks(), set()
        start, end = bench.time, bench.time + 600.0
        previous, well = registers.outputs, bench.time
        middle = None
        while bench.time < end:
            if middle is None and bench.time > start + 300.0:
                middle = _leaks()
            seen.update(player.advance(bench.time - start))
            bench.cycle()
            if len(registers.writes) > 500:  # the test's own memory
                registers.forget_writes()
            rise = bench.scaling.commanded(np.array(registers.outputs))
            rise -= bench.scaling.commanded(np.array(previous))
            previous = registers.outputs
            limit = bench.terminal.limits.pressure_rate * PERIOD + bench.scaling.count_worth
            assert (rise <= limit).all()
            assert not safety.stopped or (rise <= 0.0).all(), f"{safety.faults} and it pressed"
            if bench.emulator.faults or bench.outputs.max() > 1e4:
                well = bench.time
            elif safety.stopped and bench.time - well > 1.0:
                safety.reset(bench.time)
            assert bench.time - well < 8.0, f"stuck: {safety.state}, {safety.faults}"
        assert player.done
        assert seen == FAULTS.keys()
        bench.emulator.end_all()
        bench.run(2.0)
        registers.forget_writes()
        files, threads, objects, memory = _leaks()
        assert files <= first[0]
        assert threads <= first[1]
        assert objects - first[2] < 2_000, "objects that nobody needs any more"
        # A leak grows in both halves; a process that ran many tests before takes a step in one.
        assert middle is not None
        grown = min(middle[3] - first[3], memory - middle[3])
        assert grown < 3.0, "memory that is not that of Python's objects"
