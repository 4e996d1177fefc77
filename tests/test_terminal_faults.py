"""Everything that can go wrong with a terminal, on the wire, against the driver's core."""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from bha_driver.fault_player import FaultPlayer
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
    "freeze": (MAP.limits.frozen_time + 1.0, "length frozen"),
}


def test_every_fault_is_tested() -> None:
    assert DETECTABLE.keys() == FAULTS.keys()


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_leads_to_the_safe_state_and_stays_there(
    bench: TerminalBench, fault: str
) -> None:
    bench.run(2.0)
    safety, registers = bench.safety, bench.emulator.registers
    assert safety.state == "running"
    assert bench.outputs.max() > 2e4
    begin = bench.time
    bench.emulator.begin(fault)
    detectable, says = DETECTABLE[fault]
    bench.until(lambda: safety.stopped, detectable + BOUND)
    assert str(safety.faults[0]).startswith(says)

    # At the terminal: the pressure falls as soon as it is known, by writes or by the watchdog.
    known, before = bench.time, bench.outputs.max()
    reachable = fault in ("cut", "swap", "freeze")
    bench.until(lambda: bench.outputs.max() < before, BOUND if reachable else DOG + BOUND)
    if not reachable and fault != "restart":
        assert registers.trips == 1, "out of reach it is the watchdog that vents"

    bench.run(2.5)
    bench.emulator.end(fault)
    bench.run(4.0)
    assert not bench.outputs.any(), "vented"
    assert bench.emulator.connections == 1, "it has connected again"
    late = [words for time, words in registers.writes if time > known]
    for words, after in pairwise(late):
        assert (np.array(after) <= np.array(words)).all(), "pressed again without a reset"

    assert safety.reset(bench.time) == ""
    bench.until(lambda: bench.outputs.max() > 2e4, 1.0)
    assert begin < known


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


def test_another_terminal_is_not_driven() -> None:
    from bha_driver.errors import TerminalError

    with TerminalBench() as bench:
        bench.emulator.begin("swap")  # the identity comes in the wrong order
        with pytest.raises(TerminalError, match="another terminal, or its words come in another"):
            bench.driver.open(bench.time)
        assert not bench.driver.connected


def test_the_end_vents(bench: TerminalBench) -> None:
    bench.run(2.0)
    begin = bench.time
    bench.driver.close(lambda: bench.time, bench._pass)
    assert not bench.outputs.any()
    assert bench.time - begin < 1.2


def _leaks() -> tuple[int, int, int]:
    gc.collect()  # what earlier tests left behind does not count
    files = len(list(Path("/proc/self/fd").iterdir()))
    return files, threading.active_count(), len(gc.get_objects())


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_ten_minutes_with_faults_at_random() -> None:
    """No stuck state, no write that is not allowed, no leak of sockets, threads or memory."""
    with TerminalBench() as bench:
        bench.start()
        registers, safety = bench.emulator.registers, bench.safety
        player = FaultPlayer(bench.emulator, random_faults(5, 590.0, 6.0))
        bench.run(5.0)
        registers.forget_writes()
        first, seen = _leaks(), set()
        start, end = bench.time, bench.time + 600.0
        previous, well = registers.outputs, bench.time
        while bench.time < end:
            seen.update(player.advance(bench.time - start))
            bench.cycle()
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
        files, threads, memory = _leaks()
        assert files <= first[0]
        assert threads <= first[1]
        assert memory - first[2] < 2_000, "objects that nobody needs any more"
