"""A terminal to test with: a Modbus TCP server, a plant behind it, and faults on the wire."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Coroutine
from types import TracebackType
from typing import Any

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from bha_driver import modbus_log
from bha_driver.emulated_registers import EmulatedPlant, EmulatedRegisters
from bha_driver.errors import AddressError
from bha_driver.terminal_map import TerminalMap
from bha_driver.wire_faults import FAULTS, Fault

modbus_log.silence()

_READS, _WRITES = (3, 4), (6, 16)
_HEADER = 9  # bytes of a reply before its words: MBAP header, function, byte count
_PATIENCE = 5.0  # [s]


class TerminalEmulator:
    """The server, in a thread of its own; a context manager.

    The owner lets time pass with `step`; requests are answered all the time.

    Parameters
    ----------
    terminal : The terminal's map; its host is not used.
    plant : Any robot that takes pressures, such as `bha_sim.plant.Plant`.
    host, port : Where to listen; port 0 takes a free one, see `port`.
    clock : Tells the time of the terminal's watchdog [s].
    """

    def __init__(
        self,
        terminal: TerminalMap,
        plant: EmulatedPlant,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._map, self._host, self.port = terminal, host, port
        self.registers = EmulatedRegisters(terminal, plant, clock)
        self.delay = 0.1
        """How late replies come under the fault ``delay`` [s]."""
        self.requests = 0
        """How many requests came."""
        self._faults: set[str] = set()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="terminal emulator")
        self._server: ModbusTcpServer | None = None

    def __enter__(self) -> TerminalEmulator:
        self._thread.start()
        try:
            self._call(self._listen())
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the server and its thread."""
        if self._thread.is_alive():
            self._call(self._deafen())
            self._call(self._drop_answers())
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(_PATIENCE)
        if not self._loop.is_closed():
            self._loop.close()

    @property
    def faults(self) -> frozenset[str]:
        """The faults that are there now."""
        return frozenset(self._faults)

    @property
    def connections(self) -> int:
        """How many clients are connected."""
        server = self._server
        return 0 if server is None else len(server.active_connections)

    def step(self) -> None:
        """Let the terminal and the plant live for one period of the plant."""
        self.registers.step()

    def begin(self, fault: str) -> None:
        """Begin a fault, one of `wire_faults.FAULTS`."""
        Fault(fault, 0.0, 1.0)  # names the choices when there is no such fault
        self._faults.add(fault)
        if fault == "cut":
            self._call(self._cut())
            self._faults.discard(fault)
        elif fault in ("refuse", "restart"):
            self._call(self._deafen())
        elif fault == "freeze":
            self.registers.frozen = True

    def end(self, fault: str) -> None:
        """End a fault."""
        if fault not in self._faults:
            return
        self._faults.discard(fault)
        if fault == "restart":
            self.registers.boot()
        elif fault == "freeze":
            self.registers.frozen = False
        if not self._faults & {"refuse", "restart"} and self._server is None:
            self._call(self._listen())

    def end_all(self) -> None:
        """End every fault."""
        for fault in FAULTS:
            self.end(fault)

    # --- in the thread of the server -------------------------------------------------------

    def _call(self, work: Coroutine[Any, Any, None]) -> None:
        asyncio.run_coroutine_threadsafe(work, self._loop).result(_PATIENCE)

    async def _listen(self) -> None:
        # A register that no one knows is answered with an exception, as a terminal does.
        addresses = sorted(self.registers.addresses)
        device = SimDevice(
            id=self._map.unit,
            simdata=[SimData(at, datatype=DataType.REGISTERS, values=0) for at in addresses],
            action=self._act,
        )
        server = ModbusTcpServer(
            device, address=(self._host, self.port), trace_packet=self._distort
        )
        if not await server.listen():
            raise AddressError(f"{self._host}:{self.port}: cannot listen there; is it in use?")
        listener: Any = server.transport
        self.port = listener.sockets[0].getsockname()[1]
        self._server = server

    async def _deafen(self) -> None:
        server, self._server = self._server, None
        if server is not None:
            await server.shutdown()

    async def _drop_answers(self) -> None:
        """End the answers that are still to come late."""
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)

    async def _cut(self) -> None:
        if self._server is not None:
            for connection in list(self._server.active_connections.values()):
                connection.close()

    async def _act(
        self,
        function: int,
        start: int,
        address: int,
        count: int,
        registers: list[int],
        values: list[int] | list[bool] | None,
    ) -> ExcCodes | None:
        """Answer a request; called by pymodbus before it looks into its own registers."""
        self.requests += 1
        if "exception" in self._faults:
            return ExcCodes.DEVICE_BUSY
        if function in _WRITES and values is not None:
            self.registers.write(address, [int(value) for value in values])
        elif function in _READS:
            self.registers.watch()
            registers[address - start : address - start + count] = self.registers.read(
                address, count
            )
        if "delay" in self._faults:  # the request is done at once, only its reply is late
            await asyncio.sleep(self.delay)
        return None

    def _distort(self, sending: bool, packet: bytes) -> bytes:
        """Change what goes over the wire."""
        if not sending:
            return packet
        if "drop" in self._faults:
            return b""
        if "swap" in self._faults and packet[7] in _READS:
            words = packet[_HEADER:]
            swapped = bytes(b for at in range(0, len(words), 2) for b in words[at : at + 2][::-1])
            return packet[:_HEADER] + swapped
        return packet
