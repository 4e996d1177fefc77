"""What can be set about the driver, apart from what the terminal map holds."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from bha_common.settings import check_settings, setting
from bha_driver.autostart import CHOICES
from bha_driver.errors import TerminalMapError
from bha_driver.terminal_file import load_terminal
from bha_driver.terminal_map import TerminalMap


@dataclass(frozen=True)
class DriverSettings:
    """Which terminal is driven, and how often."""

    terminal: str = setting("", "YAML of the terminal; empty: the emulated one")
    host: str = setting("", "Address of the terminal; empty: as the YAML says")
    port: int = setting(0, "TCP port of the terminal; 0: as the YAML says", low=0, high=65535)
    control_period: float = setting(0.02, "Time between two cycles [s]", low=5e-3, high=0.1)
    max_command_age: float = setting(
        0.5, "Age at which a pressure command is dropped [s]", low=0.02
    )
    autostart: str = setting("none", "What it does by itself", choices=CHOICES)

    def __post_init__(self) -> None:
        check_settings(self)

    def terminal_map(self) -> TerminalMap:
        """Read the terminal map, and put host and port in where they are set here.

        Raises
        ------
        TerminalMapError
            When the file cannot be used, or the control period is too long for its times; the
            message names the field.
        """
        terminal = load_terminal(self.terminal or None)
        # Within `link` there must be a second try, and the terminal must not act in between.
        if self.control_period > 0.5 * terminal.timeouts.link:
            raise TerminalMapError(
                f"control_period is {self.control_period:g}; it must be at most half of "
                f"timeouts.link, {terminal.timeouts.link:g} s"
            )
        return dataclasses.replace(
            terminal, host=self.host or terminal.host, port=self.port or terminal.port
        )
