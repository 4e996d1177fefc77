"""Nested mappings, as YAML gives them, to frozen dataclasses; errors name the field."""

from __future__ import annotations

import dataclasses
import functools
import math
import sys
from collections.abc import Mapping
from typing import Any, TypeVar, get_type_hints

from bha_driver.errors import TerminalMapError

Section = TypeVar("Section")


def required(
    description: str,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    choices: tuple[str, ...] = (),
) -> Any:
    """Make a field like `bha_common.settings.setting`, but without a default."""
    return dataclasses.field(
        metadata={"description": description, "low": low, "high": high, "choices": choices}
    )


def build(cls: type[Section], data: Any, where: str) -> Section:
    """Build a dataclass from a mapping.

    Parameters
    ----------
    cls : A dataclass whose fields are numbers, text, or dataclasses of the same kind; a field may
        be optional, and then None.
    data : What YAML gave.
    where : What stands before the names in messages, such as ``"limits"``; empty at the top.

    Raises
    ------
    TerminalMapError
        Naming the field that is missing, unknown or wrong, and what would be valid.
    """
    fields = {field.name: field for field in dataclasses.fields(cls)}  # type: ignore[arg-type]
    if not isinstance(data, Mapping):
        raise TerminalMapError(f"{where or 'the file'} must hold {', '.join(fields)}, not {data!r}")
    unknown = [str(name) for name in data if name not in fields]
    if unknown:
        raise TerminalMapError(
            f"{join(where, unknown[0])} is unknown; valid are {', '.join(fields)}"
        )
    hints = _hints(cls)  # type: ignore[arg-type]
    values = {}
    for name, field in fields.items():
        if name in data:
            values[name] = convert(hints[name], data[name], join(where, name))
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise TerminalMapError(
                f"{join(where, name)} is missing{_meaning(field.metadata.get('description', ''))}"
            )
    try:
        return cls(**values)
    except TerminalMapError as error:
        raise TerminalMapError(join(where, str(error))) from None
    except ValueError as error:  # of `check_settings`, which names the class
        message = str(error).removeprefix(f"{cls.__name__}.")
        raise TerminalMapError(join(where, message)) from None


def convert(kind: Any, value: Any, where: str) -> Any:
    """Hold one value of YAML against the type it must have.

    Raises
    ------
    TerminalMapError
        Naming the field, and how such a value is written.
    """
    if dataclasses.is_dataclass(kind) and isinstance(kind, type):
        return build(kind, value, where)
    if isinstance(value, int) and abs(value) > sys.float_info.max:
        raise TerminalMapError(f"{where} is too large a number; it has {len(str(value))} digits")
    if value is None and kind == (int | None):
        return None
    if kind in (int, int | None):
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        raise TerminalMapError(f"{where} is {value!r}; it must be a whole number")
    if kind is float:
        if isinstance(value, int | float) and not isinstance(value, bool):
            return float(value)
        raise TerminalMapError(
            f"{where} is {value!r}; it must be a number, such as 0.02 or 1.3e+5 "
            "(YAML takes 1e5 for text)"
        )
    if kind is bool:
        if isinstance(value, bool):
            return value
        raise TerminalMapError(f"{where} is {value!r}; it must be true or false")
    if kind is str:
        if isinstance(value, str):
            return value
        raise TerminalMapError(f"{where} is {value!r}; it must be text")
    return value


def join(where: str, name: str) -> str:
    """Give the full name of a field."""
    return f"{where}.{name}" if where else name


@functools.cache
def _hints(cls: type) -> dict[str, Any]:
    # Compiles every annotation: for each of 27 channels that would take most of a map's loading.
    return get_type_hints(cls)


def _meaning(description: str) -> str:
    return f": {description}" if description else ""
