"""The terminal over real sockets; the plant behind it is not of interest here."""

from __future__ import annotations

import contextlib
import dataclasses
import socket
import threading
import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pymodbus.constants import ExcCodes

from bha_driver.errors import AddressError, TerminalError
from bha_driver.scaling import Scaling
from bha_driver.terminal import Terminal
from bha_driver.terminal_check import survey
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.terminal_file import example_path, load_terminal
from bha_driver.terminal_map import Identity, TerminalMap


class Bench:
    """Bellows of fixed lengths."""

    def __init__(self) -> None:
        self.state = SimpleNamespace(lengths=np.linspace(0.15, 0.31, 9), pressures=np.zeros(9))

    def step(self, pressures: np.ndarray) -> SimpleNamespace:
        self.state.pressures = pressures
        return self.state


@pytest.fixture(params=["cpx_e", "cpx_mpa", "emulated"])
def emulator(request: pytest.FixtureRequest) -> Iterator[TerminalEmulator]:
    with TerminalEmulator(load_terminal(example_path(request.param)), Bench()) as running:
        yield running


def reached(emulator: TerminalEmulator, **changes: object) -> TerminalMap:
    """The emulator's map with its address, and patience for a busy machine."""
    terminal = emulator._map
    return dataclasses.replace(
        terminal,
        host="127.0.0.1",
        port=emulator.port,
        watchdog=dataclasses.replace(terminal.watchdog, time=2.0),
        timeouts=dataclasses.replace(terminal.timeouts, request=0.3, link=0.5),
        **changes,
    )


def test_lengths_and_pressures_arrive_as_they_are(emulator: TerminalEmulator) -> None:
    terminal = reached(emulator)
    link, scaling = Terminal(terminal), Scaling(terminal)
    link.connect()
    assert scaling.lengths(link.read()) == pytest.approx(np.linspace(0.15, 0.31, 9), abs=2e-5)
    wanted = np.linspace(0.0, 1.3e5, 9)
    link.write(scaling.set_points(wanted))
    emulator.step()
    assert scaling.pressures(link.read()) == pytest.approx(wanted, abs=101.0)
    assert emulator.requests == 3 + (terminal.identity is not None), "one request for each"
    link.close()


def test_the_watchdog_is_armed_and_checked(emulator: TerminalEmulator) -> None:
    link = Terminal(reached(emulator))
    link.connect()
    assert link.watchdog() == 0
    link.arm_watchdog()
    assert link.watchdog() == 2000
    link.close()


def test_another_identity_is_told_with_the_words_that_are_there() -> None:
    """So a lab finds out which words to write into its map."""
    with TerminalEmulator(load_terminal(), Bench()) as emulator:
        wanted = reached(emulator, identity=Identity(45367, (0, 0, 0)))
        with pytest.raises(TerminalError, match=r"hold \[20565, 193, 12\] instead of \[0, 0, 0\]"):
            survey(wanted)


@pytest.mark.parametrize(("inputs", "function"), [("holding", 3), ("input", 4)])
def test_unit_and_kind_of_registers_are_those_of_the_map(
    monkeypatch: pytest.MonkeyPatch, inputs: str, function: int
) -> None:
    asked, distort = [], TerminalEmulator._distort

    def listen(self: TerminalEmulator, sending: bool, packet: bytes) -> bytes:
        if not sending:
            asked.append((packet[6], packet[7]))
        return distort(self, sending, packet)

    monkeypatch.setattr(TerminalEmulator, "_distort", listen)
    changed = dataclasses.replace(load_terminal(), unit=7, inputs=inputs)
    with TerminalEmulator(changed, Bench()) as emulator:
        link = Terminal(reached(emulator))
        link.connect()
        asked.clear()
        lengths = Scaling(changed).lengths(link.read())
        assert lengths == pytest.approx(np.linspace(0.15, 0.31, 9), abs=2e-5)
        link.write(np.zeros(9, dtype=np.int64))
        held = link.set_points()
        assert held is not None
        assert not held.any()
        link.arm_watchdog()
        link.close()
        assert asked == [(7, function), (7, 16), (7, 3), (7, 6), (7, 3)]
        with pytest.raises(TerminalError):
            Terminal(reached(emulator, unit=8)).connect()


def test_a_watchdog_that_is_refused(emulator: TerminalEmulator) -> None:
    link = Terminal(reached(emulator))
    link.connect()
    emulator.begin("exception")
    with pytest.raises(TerminalError, match=r"refused with exception 6 \(write_register at 46100"):
        link.arm_watchdog()
    emulator.end("exception")
    assert not link.connected
    assert not emulator.registers.armed


def test_a_terminal_that_takes_words_in_another_order_is_found_by_its_watchdog(
    emulator: TerminalEmulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    registers, write = emulator.registers, emulator.registers.write

    def swapped(register: int, words: list[int]) -> None:
        write(register, [(word & 0xFF) << 8 | word >> 8 for word in words])

    monkeypatch.setattr(registers, "write", swapped)
    link = Terminal(reached(emulator))
    link.connect()
    with pytest.raises(TerminalError, match="register 46100 holds 53255 instead of 2000"):
        link.arm_watchdog()
    assert not link.connected


def test_a_request_that_fails_ends_the_connection(emulator: TerminalEmulator) -> None:
    """So nobody writes to a terminal that was restarted in between."""
    link = Terminal(reached(emulator))
    for fault, message, gone in (
        ("drop", "no answer in time", False),
        ("exception", "refused with exception 6", False),
        ("cut", "the connection was cut", True),
    ):
        link.connect()
        link.read()
        emulator.begin(fault)
        with pytest.raises(TerminalError, match=message) as caught:
            link.read()
        emulator.end(fault)
        assert caught.value.gone == gone
        assert not link.connected
        with pytest.raises(TerminalError, match="not connected"):
            link.write(np.zeros(9, dtype=np.int64))
    assert not any(any(words) for _, words in emulator.registers.writes)


def test_an_answer_that_is_late_is_never_taken_for_the_next(emulator: TerminalEmulator) -> None:
    terminal = reached(emulator)
    link, scaling = Terminal(terminal), Scaling(terminal)
    link.connect()
    emulator.delay = 0.5
    emulator.begin("delay")
    with pytest.raises(TerminalError, match="no answer in time"):
        link.read()
    emulator.end("delay")
    link.connect()
    assert scaling.lengths(link.read())[0] == pytest.approx(0.15, abs=2e-5)
    link.close()


def test_a_late_answer_is_one_to_what_was_done_in_time(emulator: TerminalEmulator) -> None:
    terminal = reached(emulator)
    link, scaling = Terminal(terminal), Scaling(terminal)
    link.connect()
    emulator.delay = 10.0
    emulator.begin("delay")
    wanted = scaling.set_points(np.full(9, 5e4))
    with pytest.raises(TerminalError, match="no answer in time"):
        link.write(wanted)
    assert emulator.registers.outputs == tuple(wanted.tolist())
    emulator.end("delay")


def test_an_answer_that_trickles_in_is_late() -> None:
    """The time for a request is that for the whole of its answer."""
    loaded = load_terminal(example_path("cpx_e"))
    timeouts = dataclasses.replace(loaded.timeouts, request=0.06, connect=5.0)
    words = 2 * loaded.input_block[1]
    with socket.create_server(("127.0.0.1", 0)) as server:

        def trickle() -> None:
            connection, _ = server.accept()
            with connection, contextlib.suppress(OSError):
                request = connection.recv(100)
                head = request[:5] + bytes([words + 3, request[6], request[7], words])
                for byte in head + bytes(words):
                    connection.sendall(bytes([byte]))
                    time.sleep(0.05)

        thread = threading.Thread(target=trickle)
        thread.start()
        port = server.getsockname()[1]
        link = Terminal(dataclasses.replace(loaded, host="127.0.0.1", port=port, timeouts=timeouts))
        link.connect()
        begin = time.monotonic()
        with pytest.raises(TerminalError, match="no answer in time"):
            link.read()
        took = time.monotonic() - begin
        thread.join()
    assert took < 1.0, "all of it would take 2.2 s"


def test_nobody_there() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        terminal = dataclasses.replace(load_terminal(), port=port)
        with pytest.raises(TerminalError, match=rf"127.0.0.1:{port}: no connection") as caught:
            Terminal(terminal).connect()
    assert caught.value.gone


def test_a_port_that_is_taken_is_told() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(AddressError, match="cannot listen there; is it in use"):
            TerminalEmulator(load_terminal(), Bench(), port=port).__enter__()


class TestSurvey:
    def test_it_tells_of_set_points_that_cannot_be_read(
        self, emulator: TerminalEmulator, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        first, act = emulator._map.output_block[0], emulator._act

        async def answer(function: int, start: int, address: int, *rest: Any) -> ExcCodes | None:
            if function == 3 and address == first:
                return ExcCodes.ILLEGAL_ADDRESS
            return await act(function, start, address, *rest)

        monkeypatch.setattr(emulator, "_act", answer)
        emulator.begin("refuse")  # it listens anew, with that answer
        emulator.end("refuse")
        with pytest.raises(TerminalError, match=f"exception 2 .* at {first}.* read_back: false"):
            survey(reached(emulator), readings=2)
        assert survey(reached(emulator, read_back=False), readings=2).problems == []

    def test_it_reads_and_never_writes(self, emulator: TerminalEmulator) -> None:
        before = dict(emulator.registers._registers)
        found = survey(reached(emulator), readings=5)
        assert found.problems == []
        assert found.lengths == pytest.approx(np.linspace(0.15, 0.31, 9), abs=2e-5)
        assert not emulator.registers.writes
        assert emulator.registers._registers == before
        assert not emulator.registers.armed

    def test_it_names_what_is_wrong(self, emulator: TerminalEmulator) -> None:
        state = emulator.registers._plant.state
        state.lengths = np.full(9, 0.2)
        state.lengths[4] = 0.05
        state.pressures = np.zeros(9)
        state.pressures[8] = 5e4
        emulator.registers.boot()
        first, second = survey(reached(emulator), readings=5).problems
        assert "bellows_2_2 seems to be 0.0500 m long" in first
        assert "bellows_3_3 seems to hold 50000 Pa" in second

    def test_it_leaves_no_connection(self, emulator: TerminalEmulator) -> None:
        emulator.begin("drop")
        with pytest.raises(TerminalError):
            survey(reached(emulator), readings=5)
        emulator.end("drop")
        found = survey(reached(emulator), readings=2)
        assert found.watchdog == 0
