"""The terminal at the other end of Modbus TCP: one request at a time, none of them for long."""

from __future__ import annotations

import inspect
import math
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ModbusException

from bha_driver import modbus_log
from bha_driver.errors import TerminalError
from bha_driver.terminal_map import TerminalMap

Words = NDArray[np.int64]

modbus_log.silence()

# The name of the unit in requests: `slave` until pymodbus 3.9, `device_id` since 3.10.
_UNIT = (
    "device_id"
    if "device_id" in inspect.signature(ModbusTcpClient.read_holding_registers).parameters
    else "slave"
)


class _Client(ModbusTcpClient):
    """A client whose reply must be whole in time; pymodbus by itself waits anew for each part."""

    deadline = math.inf
    """Until when to wait for the reply [s], by the steady clock."""

    def recv(self, size: int | None) -> bytes:
        """Wait for the next part of the reply; none is what pymodbus takes for no answer."""
        left = self.deadline - time.monotonic()
        if left <= 0.0:
            return b""
        self.comm_params.timeout_connect = left
        return bytes(super().recv(size))


class Terminal:
    """A connection to a terminal.

    A request that fails in any way closes the connection: what comes late is never taken for the
    answer to something else, and nobody reconnects but `connect`. pymodbus by itself would connect
    again for the next request, to a terminal that may have been restarted in between.

    Parameters
    ----------
    terminal : The terminal's map.
    """

    def __init__(self, terminal: TerminalMap) -> None:
        self._map = terminal
        self._address = terminal.host
        self._client: _Client | None = None

    @property
    def connected(self) -> bool:
        """Whether a connection is open, as far as is known."""
        return self._client is not None

    def connect(self) -> None:
        """Open a connection, and make sure that it is this terminal.

        Looking up the name of a host may take long, whatever `timeouts.connect` says.

        Raises
        ------
        TerminalError
            When there is no connection in time, or the terminal shows another identity.
        """
        self._address = self._map.host
        self.reconnect()

    def reconnect(self) -> None:
        """Do as `connect`, but at the address that the host had then: no name is looked up.

        Raises
        ------
        TerminalError
            As `connect` does.
        """
        self.close()
        where = f"{self._map.host}:{self._map.port}"
        client = _Client(
            self._address, port=self._map.port, timeout=self._map.timeouts.connect, retries=0
        )
        try:
            client.connect()
            if client.socket is None:
                raise OSError(f"refused, no such host, or none in {self._map.timeouts.connect:g} s")
            self._address = client.socket.getpeername()[0]
        except (OSError, ModbusException) as error:
            client.close()
            raise TerminalError(f"{where}: no connection ({error})", gone=True) from None
        self._client = client
        self._check_identity()

    def close(self) -> None:
        """Close the connection, if there is one."""
        if self._client is not None:
            self._client.close()
            self._client = None

    def read(self) -> Words:
        """Read the block of all inputs, in one request.

        Raises
        ------
        TerminalError
            When there is no whole answer in time.
        """
        return self._read(*self._map.input_block, inputs=self._map.inputs == "input")

    def write(self, set_points: Words) -> None:
        """Write the block of all set-points, in one request; this feeds the terminal's watchdog.

        Parameters
        ----------
        set_points : Raw words, shape (9,).

        Raises
        ------
        TerminalError
            When the terminal did not confirm in time: it may have taken them or not.
        """
        self._request("write_registers", self._map.output_block[0], values=set_points.tolist())

    def set_points(self) -> Words | None:
        """Read the block of the set-points that the terminal holds, shape (9,).

        None when the map says that they cannot be read.

        Raises
        ------
        TerminalError
            When there is no whole answer in time, or the terminal refuses.
        """
        if not self._map.read_back:
            return None
        try:
            return self._read(*self._map.output_block)
        except TerminalError as error:
            raise TerminalError(
                f"the set-points were not read back: {error}; if this terminal never lets them be "
                "read, its map must say read_back: false",
                gone=error.gone,
            ) from None

    def watchdog(self) -> int | None:
        """Read what the watchdog's register holds; None when the map names no register.

        Raises
        ------
        TerminalError
            When there is no answer in time.
        """
        register = self._map.watchdog.register
        return None if register is None else int(self._read(register, 1)[0])

    def arm_watchdog(self) -> None:
        """Set the watchdog's time, where the map names a register for it.

        Raises
        ------
        TerminalError
            When the terminal refuses, or does not take the time.
        """
        register, word = self._map.watchdog.register, self._map.watchdog.word
        if register is None:
            return
        # A CPX-E takes this register from single writes only (festo-cpx-io).
        self._request("write_register", register, value=word)
        found = self.watchdog()
        if found != word:
            self.close()
            raise TerminalError(
                f"the watchdog was not armed: register {register} holds {found} instead of {word}"
            )

    def _check_identity(self) -> None:
        identity = self._map.identity
        if identity is None:
            return
        found = tuple(self._read(identity.register, len(identity.words)).tolist())
        if found != identity.words:
            self.close()
            raise TerminalError(
                f"this is another terminal, or its words come in another order: the registers from "
                f"{identity.register} on hold {list(found)} instead of {list(identity.words)}"
            )

    def _read(self, register: int, count: int, *, inputs: bool = False) -> Words:
        kind = "read_input_registers" if inputs else "read_holding_registers"
        words = self._request(kind, register, count=count).registers
        if len(words) != count:
            self.close()
            raise TerminalError(f"{len(words)} words came from register {register}, not {count}")
        return np.array(words, dtype=np.int64)

    def _request(self, kind: str, register: int, **arguments: Any) -> Any:
        client = self._client
        if client is None or not client.is_socket_open():
            self.close()
            raise TerminalError("not connected")
        client.deadline = time.monotonic() + self._map.timeouts.request
        try:
            answer = getattr(client, kind)(register, **arguments, **{_UNIT: self._map.unit})
        except (OSError, ModbusException) as error:
            cut = not client.is_socket_open() or isinstance(error, OSError)
            self.close()
            what = "the connection was cut" if cut else "no answer in time"
            raise TerminalError(f"{what} ({kind} at {register})", gone=cut) from error
        if answer.isError():
            self.close()
            code = getattr(answer, "exception_code", None)
            raise TerminalError(f"refused with exception {code} ({kind} at {register})")
        return answer
