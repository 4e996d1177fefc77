"""What a user types to disturb the simulated robot: words such as `leak.bellows_2_1=0.3`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from bha_common import bellows
from bha_sim.disturbances import Disturbances

FORM = "NAME=VALUE or NAME.BELLOWS=VALUE, such as payload=0.2 leak.bellows_2_1=0.3"


def read_disturbances(words: Sequence[str]) -> Disturbances:
    """Read disturbances; what is not named is sound.

    Parameters
    ----------
    words : Each `NAME=VALUE`, which holds for all bellows, or `NAME.BELLOWS=VALUE`.

    Raises
    ------
    ValueError
        When a word cannot be understood or its value cannot be; the message says why.
    """
    values: dict[str, Any] = {}
    known = {field.name: field.default for field in fields(Disturbances)}
    for word in words:
        name, equals, text = word.partition("=")
        name, dot, one = name.partition(".")
        if not equals:
            raise ValueError(f"{word!r} is not {FORM}")
        if name not in known:
            raise ValueError(f"there is no disturbance {name!r}; there are {', '.join(known)}")
        if dot and not isinstance(known[name], tuple):
            raise ValueError(f"{name} is not one of a bellows: {name}={text}")
        value = _value(word, text)
        if dot:
            earlier = values.setdefault(name, {})
            if not isinstance(earlier, dict):
                earlier = values[name] = dict.fromkeys(bellows.NAMES, earlier)
            earlier[one] = value
        else:
            values[name] = value
    return Disturbances(**values)


def as_parameters(disturbances: Disturbances) -> dict[str, Any]:
    """Return the ROS parameters of the simulator that say so."""
    return {
        f"disturbances.{field.name}": getattr(disturbances, field.name)
        for field in fields(disturbances)
    }


def _value(word: str, text: str) -> bool | float:
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{word!r}: {text!r} is no number, true or false") from None
