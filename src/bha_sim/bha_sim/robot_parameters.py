"""One robot's physical parameters: read from YAML, checked, and varied from robot to robot."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from bha_common.share import share_file
from bha_sim.errors import RobotParameterError
from bha_sim.parameter_checks import Array, Section
from bha_sim.parameter_sections import (
    Bellows,
    Hysteresis,
    PneumaticParameters,
    PotentiometerParameters,
    Relaxation,
    Trunk,
    Variation,
)

_SECTIONS: dict[str, type[Any]] = {
    "trunk": Trunk,
    "bellows": Bellows,
    "relaxation": Relaxation,
    "hysteresis": Hysteresis,
    "pneumatics": PneumaticParameters,
    "potentiometers": PotentiometerParameters,
    "variation": Variation,
}


@dataclass(frozen=True, eq=False)
class RobotParameters(Section):
    """Everything physical about one robot.

    Attributes
    ----------
    max_time_step : Longest integration step [s].
    trunk, bellows, relaxation, hysteresis, pneumatics, potentiometers, variation : The sections;
        see `parameter_sections`.
    """

    max_time_step: float
    trunk: Trunk
    bellows: Bellows
    relaxation: Relaxation
    hysteresis: Hysteresis
    pneumatics: PneumaticParameters
    potentiometers: PotentiometerParameters
    variation: Variation

    def __post_init__(self) -> None:
        self._number("max_time_step")
        for name, kind in _SECTIONS.items():
            if not isinstance(getattr(self, name), kind):
                self._fail(name, f"a {kind.__name__}")
        discs = self.trunk.discs_per_segment
        if len(self.bellows.disc_profile) != discs:
            raise RobotParameterError(
                f"bellows.disc_profile must have {discs} entries for {discs} discs a segment, "
                f"got {len(self.bellows.disc_profile)}"
            )
        factors = self.hysteresis.slip_factors
        if factors is not None and factors.shape[1] != 9 * discs:
            raise RobotParameterError(
                f"hysteresis.slip_factors must have {9 * discs} columns for {discs} discs a "
                f"segment, got {factors.shape[1]}"
            )

    @classmethod
    def from_mapping(cls, data: Any) -> RobotParameters:
        """Build the parameters from nested mappings, as YAML gives them.

        Raises
        ------
        RobotParameterError
            When a section or field is missing, unknown or invalid; the message names it.
        """
        values = _checked_keys(data, cls, "")
        for name, kind in _SECTIONS.items():
            values[name] = kind(**_checked_keys(values[name], kind, name))
        return cls(**values)


def load_parameters(path: str | os.PathLike[str] | None = None) -> RobotParameters:
    """Read a robot's parameters.

    Parameters
    ----------
    path : A YAML file like ``config/robot.yaml``; None takes that file itself.

    Raises
    ------
    RobotParameterError
        When the file cannot be read, or a number in it cannot be.
    """
    source = share_file(__file__, "config", "robot.yaml") if path is None else Path(path)
    try:
        data = yaml.safe_load(source.read_text(encoding="utf-8"))
    except OSError as error:
        raise RobotParameterError(f"{source}: cannot be read ({error.strerror})") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise RobotParameterError(f"{source}: not YAML ({error})") from None
    try:
        return RobotParameters.from_mapping(data)
    except RobotParameterError as error:
        raise RobotParameterError(f"{source}: {error}") from None


def draw_robot(parameters: RobotParameters, seed: int) -> RobotParameters:
    """Draw one robot of the kind that `parameters` describe.

    Parameters
    ----------
    parameters : The kind, with the width of its `variation`.
    seed : Names the robot: the same seed gives the same robot, on every machine.
    """
    # The key keeps this stream apart from that of a noise generator with the same seed.
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0xB0D1,)))
    width, discs = parameters.variation, parameters.trunk.discs_per_segment

    def factors(spread: float, *shape: int) -> Array:
        return rng.uniform(1.0 - spread, 1.0 + spread, shape)

    trunk, bellows = parameters.trunk, parameters.bellows
    relaxation, hysteresis = parameters.relaxation, parameters.hysteresis
    pneumatics, potentiometers = parameters.pneumatics, parameters.potentiometers
    lag = factors(width.lag, 9)
    return replace(
        parameters,
        trunk=replace(
            trunk,
            segment_masses=trunk.segment_masses * factors(width.mass, 3),
            tool_mass=trunk.tool_mass * float(factors(width.mass, 1)[0]),
            torsion_stiffness=trunk.torsion_stiffness * factors(width.torsion, 3),
        ),
        bellows=replace(
            bellows,
            stiffness=bellows.stiffness * factors(width.stiffness, 9),
            areas=bellows.areas * factors(width.area, 9),
            hardening=bellows.hardening * factors(width.hardening, 9),
            hardening_extension=bellows.hardening_extension * factors(width.hardening, 9),
            disc_factors=factors(width.disc_stiffness, 9, discs),
        ),
        relaxation=replace(
            relaxation,
            time_constants=relaxation.time_constants
            * factors(width.relaxation, len(relaxation.time_constants)),
            shares=relaxation.shares * factors(width.relaxation, *relaxation.shares.shape),
        ),
        hysteresis=replace(
            hysteresis,
            shares=hysteresis.shares * factors(width.hysteresis, *hysteresis.shares.shape),
            slip_factors=factors(width.slip, len(hysteresis.slips), 9 * discs),
        ),
        pneumatics=replace(
            pneumatics,
            fill_time_constant=pneumatics.fill_time_constant * lag,
            vent_time_constant=pneumatics.vent_time_constant * lag,
        ),
        potentiometers=replace(
            potentiometers,
            offsets=potentiometers.offsets
            + rng.uniform(-width.sensor_offset, width.sensor_offset, 9),
            gains=potentiometers.gains * factors(width.sensor_gain, 9),
        ),
    )


def _checked_keys(data: Any, kind: type[Any], section: str) -> dict[str, Any]:
    """Hold the keys of one mapping against the fields of its dataclass."""
    prefix = f"{section}." if section else ""
    if not isinstance(data, Mapping):
        raise RobotParameterError(f"{section or 'the file'} must map names to values")
    known = {field.name: field for field in fields(kind)}
    for name in data:
        if name not in known:
            raise RobotParameterError(
                f"{prefix}{name} is unknown; valid here are {', '.join(sorted(known))}"
            )
    for name, field in known.items():
        if name not in data and field.default is MISSING:
            raise RobotParameterError(f"{prefix}{name} is missing")
    return dict(data)
