"""The sections of the robot's parameters: frozen, checked, every array read-only.

Arrays a bellows have shape (9,) in the order of `bha_common.bellows.NAMES`; they accept one number
for all, or one a segment, and are expanded.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from bha_common import bellows
from bha_sim.parameter_checks import Array, Section

_SEGMENTS = bellows.SEGMENTS
_COUNT = bellows.COUNT


@dataclass(frozen=True, eq=False)
class Trunk(Section):
    """Geometry, masses and torsion of the chain of discs.

    Attributes
    ----------
    segment_rest_lengths : Length of each segment without load [m], shape (3,).
    bellows_radii : Radius of the circle on which a segment's bellows stand [m], shape (3,).
    segment_masses : Mass of each segment [kg], shape (3,).
    tool_length : Distance from the last disc to the tip [m].
    tool_mass, tool_radius : Mass [kg] and radius [m] of the tool, a solid cylinder.
    disc_thickness : Thickness of a disc, a solid cylinder [m].
    discs_per_segment : Number of discs that stand for a segment.
    torsion_stiffness : Torsion stiffness of each whole segment [N m/rad], shape (3,).
    damping_time : Damping over stiffness, of bellows and torsion [s].
    gravity : Acceleration along the axis of the hanging trunk [m/s^2].
    """

    segment_rest_lengths: Array
    bellows_radii: Array
    segment_masses: Array
    tool_length: float
    tool_mass: float
    tool_radius: float
    disc_thickness: float
    discs_per_segment: int
    torsion_stiffness: Array
    damping_time: float
    gravity: float
    _name = "trunk"

    def __post_init__(self) -> None:
        for field in ("segment_rest_lengths", "bellows_radii", "segment_masses"):
            self._array(field, (_SEGMENTS,))
        self._array("torsion_stiffness", (_SEGMENTS,))
        for field in ("tool_length", "tool_mass", "tool_radius", "disc_thickness", "damping_time"):
            self._number(field)
        self._number("gravity", above=False)
        discs: Any = self.discs_per_segment
        if isinstance(discs, bool) or not isinstance(discs, int) or not 1 <= discs <= 10:
            self._fail("discs_per_segment", "a whole number from 1 to 10")


@dataclass(frozen=True, eq=False)
class Bellows(Section):
    """Elasticity of the nine bellows.

    Attributes
    ----------
    stiffness : Stiffness of a whole bellows when all creep is over [N/m], shape (9,).
    areas : Effective area, force over pressure [m^2], shape (9,).
    hardening : Cubic stiffness of a whole bellows [N/m^3], shape (9,).
    hardening_extension : Extension about which the cubic term acts [m], shape (9,).
    disc_profile : Stiffness of the pieces from the base of a segment to its end, in proportion to
        each other [-], shape (discs,).
    disc_factors : Stiffness of each piece over that of the profile, in proportion to the others of
        its bellows [-], shape (9, discs); None stands for ones.
    """

    stiffness: Array
    areas: Array
    hardening: Array
    hardening_extension: Array
    disc_profile: Array
    disc_factors: Array | None = None
    _name = "bellows"

    def __post_init__(self) -> None:
        self._array("stiffness", (_COUNT,))
        self._array("areas", (_COUNT,))
        self._array("hardening", (_COUNT,), above=False)
        self._array("hardening_extension", (_COUNT,), above=False)
        discs = self._rows("disc_profile")
        self._array("disc_profile", (discs,))
        if self.disc_factors is not None:
            self._array("disc_factors", (_COUNT, discs))

    @property
    def piece_stiffness(self) -> Array:
        """Stiffness of each disc's piece [N/m], shape (9, discs).

        The pieces of a bellows, in series, have the stiffness of the bellows.
        """
        proportions = np.tile(self.disc_profile, (_COUNT, 1))
        if self.disc_factors is not None:
            proportions = proportions * self.disc_factors
        in_series: Array = 1.0 / np.sum(1.0 / proportions, axis=1)
        return proportions * (self.stiffness / in_series)[:, None]


@dataclass(frozen=True, eq=False)
class Relaxation(Section):
    """Branches of a generalised Maxwell solid.

    Attributes
    ----------
    time_constants : Time constant of each branch [s], shape (branches,).
    shares : Stiffness over that of the bellows [-], shape (branches, 9).
    """

    time_constants: Array
    shares: Array
    _name = "relaxation"

    def __post_init__(self) -> None:
        branches = self._rows("time_constants")
        self._array("time_constants", (branches,))
        self._array("shares", (branches, _COUNT), above=False)


@dataclass(frozen=True, eq=False)
class Hysteresis(Section):
    """Jenkin elements: springs with sliders.

    Attributes
    ----------
    slips : Stretch of a disc's piece at which an element slips [m], shape (elements,).
    shares : Stiffness over that of the bellows [-], shape (elements, 9).
    slip_factors : Slip of each piece over the one above [-], shape (elements, 9 * discs), pieces
        of a bellows side by side; None stands for ones.
    """

    slips: Array
    shares: Array
    slip_factors: Array | None = None
    _name = "hysteresis"

    def __post_init__(self) -> None:
        elements = self._rows("slips")
        self._array("slips", (elements,))
        self._array("shares", (elements, _COUNT), above=False)
        if self.slip_factors is not None:
            self._array("slip_factors", (elements, np.shape(self.slip_factors)[-1]))


@dataclass(frozen=True, eq=False)
class PneumaticParameters(Section):
    """Valves, hoses and pressure sensors.

    Attributes
    ----------
    max_pressure : Highest set-point [Pa].
    dead_time : Time until a command begins to act [s].
    fill_time_constant, vent_time_constant : First-order lags [s], shape (9,).
    regulator_play : Full width of the set-points that a regulator ignores [Pa].
    sensor_noise : Standard deviation of a measured pressure [Pa].
    sensor_resolution : Step of a measured pressure [Pa].
    """

    max_pressure: float
    dead_time: float
    fill_time_constant: Array
    vent_time_constant: Array
    regulator_play: float
    sensor_noise: float
    sensor_resolution: float
    _name = "pneumatics"

    def __post_init__(self) -> None:
        self._number("max_pressure")
        self._number("dead_time", above=False)
        self._array("fill_time_constant", (_COUNT,))
        self._array("vent_time_constant", (_COUNT,))
        for field in ("regulator_play", "sensor_noise", "sensor_resolution"):
            self._number(field, above=False)
        if self.regulator_play >= self.max_pressure:
            self._fail("regulator_play", f"below max_pressure, {self.max_pressure:g}")


@dataclass(frozen=True, eq=False)
class PotentiometerParameters(Section):
    """Cable potentiometers that measure the bellows lengths.

    Attributes
    ----------
    noise : Standard deviation of a reading [m].
    resolution : Step of a reading [m]; 0 for none.
    play : Full width of the cable's lost motion [m].
    drift_spread, drift_time : Standard deviation [m] and correlation time [s] of the slow drift.
    offsets : Reading minus length [m], shape (9,).
    gains : Reading over length [-], shape (9,).
    """

    noise: float
    resolution: float
    play: float
    drift_spread: float
    drift_time: float
    offsets: Array
    gains: Array
    _name = "potentiometers"

    def __post_init__(self) -> None:
        for field in ("noise", "resolution", "play", "drift_spread"):
            self._number(field, above=False)
        self._number("drift_time")
        self._array("offsets", (_COUNT,), low=-math.inf)
        self._array("gains", (_COUNT,))


@dataclass(frozen=True)
class Variation(Section):
    """How far robots differ: each value is drawn uniformly within plus or minus these.

    All are relative [-], but `sensor_offset` [m].
    """

    stiffness: float
    area: float
    hardening: float
    disc_stiffness: float
    relaxation: float
    hysteresis: float
    slip: float
    mass: float
    torsion: float
    lag: float
    sensor_offset: float
    sensor_gain: float
    _name = "variation"

    def __post_init__(self) -> None:
        for field in fields(self):
            self._number(field.name, above=False)
            if getattr(self, field.name) >= 1.0:
                self._fail(field.name, "below 1")
