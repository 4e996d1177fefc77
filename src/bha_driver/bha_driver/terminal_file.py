"""Terminal maps in YAML files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import yaml

from bha_common import bellows
from bha_common.share import share_file
from bha_driver.errors import TerminalMapError
from bha_driver.mapping import build, convert
from bha_driver.terminal_map import (
    BellowsChannels,
    Identity,
    Limits,
    TerminalMap,
    Timeouts,
    Watchdog,
)

_SECTIONS: dict[str, Any] = {
    "name": str,
    "host": str,
    "port": int,
    "unit": int,
    "inputs": str,
    "read_back": bool,
    "identity": Identity,
    "timeouts": Timeouts,
    "watchdog": Watchdog,
    "limits": Limits,
}
_REQUIRED = ("name", "host", "bellows")


class _Loader(yaml.SafeLoader):
    """Refuses a key that stands twice in one mapping; YAML's own loader takes the last."""

    def compose_mapping_node(self, anchor: Any) -> Any:
        node = super().compose_mapping_node(anchor)
        lines: dict[Any, int] = {}
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                continue
            line = key.start_mark.line + 1
            if key.value in lines:
                raise TerminalMapError(
                    f"line {line}: {key.value} stands in line {lines[key.value]} already"
                )
            lines[key.value] = line
        return node


def example_path(name: str) -> Path:
    """Find one of the maps of this package, such as ``emulated``."""
    return share_file(__file__, "config", f"{name}.yaml")


def load_terminal(path: str | os.PathLike[str] | None = None) -> TerminalMap:
    """Read a terminal map.

    Parameters
    ----------
    path : A YAML file like those in ``config``; None takes that of the emulated terminal.

    Raises
    ------
    TerminalMapError
        When the file cannot be read, or a field is wrong; the message names it.
    """
    source = example_path("emulated") if path is None else Path(path).expanduser()
    try:
        return parse_terminal(source.read_text(encoding="utf-8"))
    except OSError as error:
        raise TerminalMapError(f"{source}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise TerminalMapError(f"{source}: not a text in UTF-8 ({error.reason})") from None
    except TerminalMapError as error:
        raise TerminalMapError(f"{source}: {error}") from None


def parse_terminal(text: str) -> TerminalMap:
    """Build a terminal map from the text of a YAML file.

    Raises
    ------
    TerminalMapError
        When it is not YAML, or a field is wrong; the message names it.
    """
    try:
        data = yaml.load(text, Loader=_Loader)
    except TerminalMapError:
        raise
    except (yaml.YAMLError, ValueError) as error:  # ValueError: a number or date that is none
        raise TerminalMapError(f"not YAML ({error})") from None
    choices = [*_SECTIONS, "bellows"]
    if not isinstance(data, dict):
        raise TerminalMapError(f"the file must hold {', '.join(choices)}")
    for name in data:
        if name not in choices:
            raise TerminalMapError(f"{name} is unknown; valid are {', '.join(choices)}")
    for name in _REQUIRED:
        if name not in data:
            raise TerminalMapError(f"{name} is missing; needed are {', '.join(_REQUIRED)}")
    values = {
        name: convert(kind, data[name], name) for name, kind in _SECTIONS.items() if name in data
    }
    try:
        return TerminalMap(bellows=_bellows(data["bellows"]), **values)
    except TerminalMapError:
        raise
    except ValueError as error:
        raise TerminalMapError(str(error).removeprefix("TerminalMap.")) from None


def _bellows(data: Any) -> tuple[BellowsChannels, ...]:
    if not isinstance(data, dict):
        raise TerminalMapError(f"bellows must hold {', '.join(bellows.NAMES)}, not {data!r}")
    for name in data:
        if name not in bellows.NAMES:
            raise TerminalMapError(
                f"bellows.{name} is unknown; valid are {', '.join(bellows.NAMES)}"
            )
    for name in bellows.NAMES:
        if name not in data:
            raise TerminalMapError(f"bellows.{name} is missing; all nine bellows are needed")
    return tuple(build(BellowsChannels, data[name], f"bellows.{name}") for name in bellows.NAMES)
