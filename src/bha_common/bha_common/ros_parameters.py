"""ROS parameters from frozen settings: one declaration for name, default, unit and range."""

from __future__ import annotations

import dataclasses
import math
from array import array
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any, TypeVar, get_type_hints

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.node import Node
from rclpy.parameter import Parameter

Settings = TypeVar("Settings")


def declare_settings(
    node: Node,
    cls: type[Settings],
    prefix: str = "",
    *,
    on_change: Callable[[Settings], None] | None = None,
) -> Settings:
    """Declare a parameter for each field of a dataclass and read the dataclass from them.

    A field that is itself a dataclass becomes a group, its parameters named with a dot. A tuple
    becomes a list. Without `on_change` all parameters are read-only: they hold from the start of
    the node to its end.

    Parameters
    ----------
    node : Where to declare.
    cls : A dataclass whose plain fields are made with `bha_common.settings.setting`.
    prefix : What stands before the names.
    on_change : Takes the new settings whenever a parameter has been set from outside. What the
        dataclass does not accept is refused with its reason and changes nothing. Groups cannot
        change.

    Raises
    ------
    ValueError
        When a value is out of its range or of another type; the message names the parameter.
    """
    read_only = on_change is None
    default = cls()
    hints = get_type_hints(cls)
    values: dict[str, Any] = {}
    for field in dataclasses.fields(cls):  # type: ignore[arg-type]
        name = prefix + field.name
        if dataclasses.is_dataclass(hints[field.name]):
            current = getattr(default, field.name)
            nested = type(current)
            values[field.name] = _declare_group(node, nested, current, f"{name}.")
        else:
            default_value = getattr(default, field.name)
            values[field.name] = _declare(node, name, field, default_value, read_only)
    settings = cls(**values)
    if on_change is not None:
        _follow(node, cls, prefix, list(values), on_change)
    return settings


def refuse_unknown(node: Node) -> None:
    """Refuse what a user has given to a parameter that no one declares, once all are declared.

    rclpy leaves such a value out without a word: a limit with a letter amiss would not hold.

    Raises
    ------
    ValueError
        Naming each unknown parameter, and those that may be meant.
    """
    known = node.get_parameters_by_prefix("")
    complaints = []
    for name in node._parameter_overrides:  # rclpy tells nowhere else what was given
        if name not in known:
            near = get_close_matches(name, known)
            meant = f" (is {' or '.join(near)} meant?)" if near else ""
            complaints.append(f"there is no parameter {name!r}{meant}")
    if complaints:
        raise ValueError(f"{node.get_name()}: {'; '.join(complaints)}")


def _follow(
    node: Node,
    cls: type[Settings],
    prefix: str,
    fields: Sequence[str],
    on_change: Callable[[Settings], None],
) -> None:
    """Check what is set from outside, and hand it on once it is set."""
    names = {prefix + field: field for field in fields}

    def settings(changes: Sequence[Parameter]) -> Settings:
        values = {field: _plain(node.get_parameter(name).value) for name, field in names.items()}
        values |= {names[one.name]: _plain(one.value) for one in changes if one.name in names}
        return cls(**values)

    def check(changes: Sequence[Parameter]) -> SetParametersResult:
        try:
            settings(changes)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def apply(changes: Sequence[Parameter]) -> None:
        if any(one.name in names for one in changes):
            on_change(settings(()))

    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(apply)


def _plain(value: Any) -> Any:
    """Return a parameter's value as settings hold it."""
    return tuple(value) if isinstance(value, list | array) else value


def _declare_group(node: Node, cls: type[Settings], default: Settings, prefix: str) -> Settings:
    values = {
        field.name: _declare(node, prefix + field.name, field, getattr(default, field.name), True)
        for field in dataclasses.fields(cls)  # type: ignore[arg-type]
    }
    return cls(**values)


def _declare(
    node: Node, name: str, field: dataclasses.Field[Any], default: Any, read_only: bool
) -> Any:
    low, high = field.metadata["low"], field.metadata["high"]
    descriptor = ParameterDescriptor(
        name=name,
        description=field.metadata["description"],
        read_only=read_only,
        additional_constraints=", ".join(field.metadata["choices"]),
    )
    bounded = math.isfinite(low) or math.isfinite(high)
    if isinstance(default, bool) or not bounded:
        pass
    elif isinstance(default, int):
        descriptor.integer_range = [
            IntegerRange(
                from_value=int(low) if math.isfinite(low) else -(2**63),
                to_value=int(high) if math.isfinite(high) else 2**63 - 1,
            )
        ]
    elif isinstance(default, float):
        largest = 1.7e308
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=max(low, -largest), to_value=min(high, largest))
        ]
    elif isinstance(default, tuple):
        descriptor.additional_constraints = f"each {low:g} to {high:g}"
    value = list(default) if isinstance(default, tuple) else default
    try:
        return _plain(node.declare_parameter(name, value, descriptor).value)
    except InvalidParameterTypeException as error:
        wanted = " or ".join(field.metadata["choices"]) or f"like {value!r}"
        raise ValueError(f"{error}. It must be {wanted}") from error
