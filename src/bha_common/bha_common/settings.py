"""Fields of frozen settings that describe themselves and check their own range.

A dataclass whose fields are made with `setting` is the single place where a value's name, default,
meaning, unit and range stand: `check_settings` holds the range, and `ros_parameters` declares ROS
parameters from the same fields.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any


def setting(
    default: Any,
    description: str,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    choices: tuple[str, ...] = (),
) -> Any:
    """Make a dataclass field with a description and a valid range.

    Parameters
    ----------
    default : The value when none is given; its type is the type of the setting. A tuple stands for
        a list, each entry of which is within the range.
    description : One sentence with the unit in brackets.
    low, high : Smallest and largest valid value, for numbers.
    choices : The valid values, for text.
    """
    return dataclasses.field(
        default=default,
        metadata={"description": description, "low": low, "high": high, "choices": choices},
    )


def check_settings(settings: Any) -> None:
    """Hold every field made with `setting` against its range.

    Parameters
    ----------
    settings : A dataclass instance; call this from its ``__post_init__``.

    Raises
    ------
    ValueError
        Naming the field, its value and what would be valid.
    """
    owner = type(settings).__name__
    for field in dataclasses.fields(settings):
        if "description" not in field.metadata:
            continue
        value = getattr(settings, field.name)
        choices = field.metadata["choices"]
        if choices and value not in choices:
            raise ValueError(f"{owner}.{field.name} is {value!r}; valid are {', '.join(choices)}")
        low, high = field.metadata["low"], field.metadata["high"]
        for one in value if isinstance(value, tuple) else (value,):
            if isinstance(one, bool) or not isinstance(one, int | float):
                continue
            if not (math.isfinite(one) and low <= one <= high):
                raise ValueError(
                    f"{owner}.{field.name} {'holds' if isinstance(value, tuple) else 'is'} {one}; "
                    f"valid is {low} to {high}: {field.metadata['description']}"
                )
