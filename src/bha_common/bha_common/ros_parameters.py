"""ROS parameters from frozen settings: one declaration for name, default, unit and range."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, TypeVar, get_type_hints

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

Settings = TypeVar("Settings")


def declare_settings(node: Node, cls: type[Settings], prefix: str = "") -> Settings:
    """Declare a parameter for each field of a dataclass and read the dataclass from them.

    A field that is itself a dataclass becomes a group, its parameters named with a dot. All
    parameters are read-only: they hold from the start of the node to its end.

    Parameters
    ----------
    node : Where to declare.
    cls : A dataclass whose plain fields are made with `bha_common.settings.setting`.
    prefix : What stands before the names.

    Raises
    ------
    ValueError
        When a value is out of its range; the message names the parameter.
    """
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
            values[field.name] = _declare(node, name, field, getattr(default, field.name))
    return cls(**values)


def _declare_group(node: Node, cls: type[Settings], default: Settings, prefix: str) -> Settings:
    values = {
        field.name: _declare(node, prefix + field.name, field, getattr(default, field.name))
        for field in dataclasses.fields(cls)  # type: ignore[arg-type]
    }
    return cls(**values)


def _declare(node: Node, name: str, field: dataclasses.Field[Any], default: Any) -> Any:
    low, high = field.metadata["low"], field.metadata["high"]
    descriptor = ParameterDescriptor(
        name=name,
        description=field.metadata["description"],
        read_only=True,
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
    return node.declare_parameter(name, default, descriptor).value
