"""What can go wrong with a robot while it runs; `Plant.disturb` switches it on and off.

    plant.disturb(Disturbances(payload=0.2, leak={"bellows_2_1": 0.3}))
    plant.disturb(Disturbances())

Nobody but the plant knows of it: the robot's parameters stay those of the sound robot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from bha_common import bellows
from bha_common.settings import check_settings, setting

BellowsValues = tuple[float, ...]
"""One number a bellows, in the order of `bha_common.bellows.NAMES`."""

_NONE = (0.0,) * bellows.COUNT


@dataclass(frozen=True)
class Disturbances:
    """Everything that is wrong with the robot; by default nothing.

    A field a bellows takes nine values, three (one a segment), one for all, or a mapping from the
    names of some bellows to their values, the others being sound. It is kept as nine.

    Raises
    ------
    ValueError
        When a value is of the wrong kind or out of its range; the message names the field.
    """

    payload: float = setting(0.0, "Mass that hangs at the tip, a point [kg]", low=0.0, high=1.0)
    softening: BellowsValues = setting(
        _NONE, "Share of its stiffness that a bellows has lost [-]", low=0.0, high=0.5
    )
    leak: BellowsValues = setting(
        _NONE,
        "Conductance of the leak over that of the valve [-]: the pressure settles at "
        "set-point/(1 + leak)",
        low=0.0,
        high=4.0,
    )
    sensor_shift: BellowsValues = setting(
        _NONE, "Added to what a potentiometer reads [m]", low=-0.05, high=0.05
    )
    sensor_drift: BellowsValues = setting(
        _NONE,
        "Speed at which a reading departs from the moment it is set [m/s]; at 0 it comes back",
        low=-1e-3,
        high=1e-3,
    )
    range_lost_below: BellowsValues = setting(
        _NONE, "Share of the pressure range that is lost at its lower end [-]", low=0.0, high=0.45
    )
    range_lost_above: BellowsValues = setting(
        _NONE, "Share of the pressure range that is lost at its upper end [-]", low=0.0, high=0.45
    )
    stuck_valves: tuple[bool, ...] = setting(
        (False,) * bellows.COUNT, "Whether a valve stays at the set-point that it has now"
    )

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(field.default, tuple):
                kind = type(field.default[0])
                object.__setattr__(self, field.name, _expanded(field.name, value, kind))
            elif isinstance(value, bool) or not isinstance(value, int | float):
                raise ValueError(f"Disturbances.{field.name} must be a number, got {value!r}")
        check_settings(self)

    def __str__(self) -> str:
        """Tell what is disturbed, such as "payload 0.2; leak bellows_2_1 0.3"."""
        parts = []
        for field in fields(self):
            value = getattr(self, field.name)
            if not isinstance(value, tuple):
                value = (value,)
                names: tuple[str, ...] = ("",)
            else:
                names = tuple(f" {name}" for name in bellows.NAMES)
            for name, one in zip(names, value, strict=True):
                if one:
                    parts.append(f"{field.name}{name}" + ("" if one is True else f" {one:g}"))
        return "; ".join(parts) or "none"


def _expanded(name: str, value: Any, kind: type[Any]) -> tuple[Any, ...]:
    """Make one value a bellows of what a user gives."""
    if isinstance(value, Mapping):
        unknown = [str(key) for key in value if key not in bellows.NAMES]
        if unknown:
            raise ValueError(
                f"Disturbances.{name}: there is no {', '.join(unknown)}; the bellows are "
                f"{', '.join(bellows.NAMES)}"
            )
        given = [value.get(each, kind()) for each in bellows.NAMES]
    elif isinstance(value, bool | int | float):
        given = [value]
    else:
        try:
            given = list(value)
        except TypeError:
            given = []
    if len(given) not in (1, bellows.SEGMENTS, bellows.COUNT) or isinstance(value, str):
        raise ValueError(
            f"Disturbances.{name} must be one value, {bellows.SEGMENTS} (one a segment) or "
            f"{bellows.COUNT} (one a bellows), got {value!r}"
        )
    for one in given:
        # numpy's own numbers are taken as well; true is no number, and 1 is no switch.
        whole = bool if kind is bool else float
        try:
            right = (type(one).__name__.startswith("bool") == (kind is bool)) and whole(one) == one
        except (TypeError, ValueError):
            right = False
        if not right:
            wanted = "true or false" if kind is bool else "a finite number"
            raise ValueError(f"Disturbances.{name} must hold {wanted}, got {one!r}")
    times = bellows.COUNT // len(given)
    return tuple(kind(one) for one in given for _ in range(times))
