"""The trunk as a MuJoCo model: a chain of discs that nine pushing tendons drive.

Every disc stretches (slide), bends (two hinges) and twists (hinge) against the one before. The
world frame of the model is `bha_base`: z along the hanging trunk, away from the base, so gravity
points along +z; x towards bellows 1 of every segment.

A tendon over a whole segment holds only the sum of its discs, which would leave the inner discs
floating. So each disc's piece of each bellows has its elasticity on a fixed tendon of its own, the
length of which is the piece's extension e = s + b (sin(a) rx - cos(a) ry) for slide s, hinges rx
and ry, and a bellows at angle a on a circle of radius b. The spatial tendons, through the rims of
all discs, only push (pressure x area), harden (cubic) and measure.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from bha_common import bellows
from bha_sim.parameter_checks import Array
from bha_sim.robot_parameters import RobotParameters

_ANGLES = np.arange(bellows.CHAMBERS) * 2.0 * np.pi / bellows.CHAMBERS


@dataclass(frozen=True)
class TrunkModel:
    """A compiled model, and where in it to find what the plant needs.

    Attributes
    ----------
    model : The compiled model.
    pieces : Which tendons are the pieces of the bellows; those of a bellows side by side.
    bellows : Which tendons are the bellows, in order.
    tip_body : Index of the body whose origin is the tip.
    """

    model: mujoco.MjModel
    pieces: slice
    bellows: slice
    tip_body: int


def build_model(
    parameters: RobotParameters, stiffness_factors: Array, time_step: float
) -> TrunkModel:
    """Compile the trunk.

    Parameters
    ----------
    parameters : The robot.
    stiffness_factors : Stiffness of each piece with all its creep and hysteresis springs over that
        of its lasting spring [-], shape (9 * discs,).
    time_step : Integration step [s].
    """
    trunk = parameters.trunk
    spec = mujoco.MjSpec()
    spec.modelname = "bionic_handling_assistant"
    spec.compiler.degree = False
    _set_options(spec, trunk.gravity, time_step)
    _add_chain(spec, parameters)
    for index, name in enumerate(bellows.NAMES):
        _add_pieces(spec, parameters, index, name, stiffness_factors)
    for index, name in enumerate(bellows.NAMES):
        _add_bellows(spec, parameters, index, name)
    model = spec.compile()
    pieces = bellows.COUNT * trunk.discs_per_segment
    return TrunkModel(
        model=model,
        pieces=slice(0, pieces),
        bellows=slice(pieces, pieces + bellows.COUNT),
        tip_body=model.body("tip").id,
    )


def _set_options(spec: mujoco.MjSpec, gravity: float, time_step: float) -> None:
    """Write every option that matters; nothing is left to defaults that versions change."""
    disable = mujoco.mjtDisableBit
    option = spec.option
    option.timestep = time_step
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.gravity = [0.0, 0.0, gravity]
    option.density = option.viscosity = 0.0
    option.wind = [0.0, 0.0, 0.0]
    # Without auto-reset a diverged motion stays visible instead of jumping back to time zero. The
    # trunk has no contacts, limits or dry friction: the constraint solver has nothing to do.
    option.disableflags = int(
        disable.mjDSBL_AUTORESET
        | disable.mjDSBL_CONSTRAINT
        | disable.mjDSBL_CONTACT
        | disable.mjDSBL_SENSOR
        | disable.mjDSBL_WARMSTART
    )
    option.enableflags = 0


def _add_chain(spec: mujoco.MjSpec, parameters: RobotParameters) -> None:
    """Add discs, tool and tip."""
    trunk, n = parameters.trunk, parameters.trunk.discs_per_segment
    stretch = parameters.bellows.hardening_extension.reshape(bellows.SEGMENTS, -1).mean(axis=1)
    parent = spec.worldbody
    for segment in range(bellows.SEGMENTS):
        radius = trunk.bellows_radii[segment]
        height = trunk.segment_rest_lengths[segment] / n
        torsion = n * trunk.torsion_stiffness[segment]
        _add_rim(parent, segment, 0, radius)
        for disc in range(n):
            name = f"{segment + 1}_{disc + 1}"
            body = parent.add_body(name=f"disc_{name}", pos=[0.0, 0.0, height])
            # Bending turns about the middle of the gap, as an arc does, at a typical stretch.
            middle = [0.0, 0.0, -0.5 * (height + stretch[segment] / n)]
            hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
            body.add_joint(name=f"stretch_{name}", type=slide, axis=[0.0, 0.0, 1.0])
            body.add_joint(name=f"bend_x_{name}", type=hinge, axis=[1.0, 0.0, 0.0], pos=middle)
            body.add_joint(name=f"bend_y_{name}", type=hinge, axis=[0.0, 1.0, 0.0], pos=middle)
            body.add_joint(
                name=f"twist_{name}",
                type=hinge,
                axis=[0.0, 0.0, 1.0],
                stiffness=[torsion, 0.0, 0.0],
                damping=[trunk.damping_time * torsion, 0.0, 0.0],
            )
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_CYLINDER,
                size=[radius, 0.5 * trunk.disc_thickness, 0.0],
                mass=trunk.segment_masses[segment] / n,
                contype=0,
                conaffinity=0,
            )
            _add_rim(body, segment, disc + 1, radius)
            parent = body
    parent.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[trunk.tool_radius, 0.5 * trunk.tool_length, 0.0],
        pos=[0.0, 0.0, 0.5 * trunk.tool_length],
        mass=trunk.tool_mass,
        contype=0,
        conaffinity=0,
    )
    parent.add_body(name="tip", pos=[0.0, 0.0, trunk.tool_length])


def _add_rim(body: mujoco.MjsBody, segment: int, disc: int, radius: float) -> None:
    """Add the sites at which the bellows of a segment pass a disc; disc 0 is the segment's base."""
    for chamber, angle in enumerate(_ANGLES):
        body.add_site(
            name=f"rim_{segment + 1}_{disc}_{chamber + 1}",
            pos=[radius * np.cos(angle), radius * np.sin(angle), 0.0],
        )


def _add_pieces(
    spec: mujoco.MjSpec, parameters: RobotParameters, index: int, name: str, factors: Array
) -> None:
    """Add a fixed tendon for each disc's piece of one bellows: spring and damper."""
    trunk, n = parameters.trunk, parameters.trunk.discs_per_segment
    segment, chamber = divmod(index, bellows.CHAMBERS)
    radius, angle = trunk.bellows_radii[segment], _ANGLES[chamber]
    for disc in range(n):
        lasting = parameters.bellows.piece_stiffness[index, disc]
        tendon = spec.add_tendon(
            name=f"piece_{disc + 1}_of_{name}",
            stiffness=[lasting * factors[index * n + disc], 0.0, 0.0],
            damping=[trunk.damping_time * lasting, 0.0, 0.0],
            springlength=[0.0, 0.0],
        )
        at = f"{segment + 1}_{disc + 1}"
        tendon.wrap_joint(f"stretch_{at}", 1.0)
        tendon.wrap_joint(f"bend_x_{at}", radius * np.sin(angle))
        tendon.wrap_joint(f"bend_y_{at}", -radius * np.cos(angle))


def _add_bellows(spec: mujoco.MjSpec, parameters: RobotParameters, index: int, name: str) -> None:
    """Add the spatial tendon of one bellows, and the actuator by which pressure pushes it."""
    trunk, elastic = parameters.trunk, parameters.bellows
    segment, chamber = divmod(index, bellows.CHAMBERS)
    centre = trunk.segment_rest_lengths[segment] + elastic.hardening_extension[index]
    tendon = spec.add_tendon(
        name=name,
        stiffness=[0.0, 0.0, elastic.hardening[index]],
        springlength=[centre, centre],
    )
    for disc in range(trunk.discs_per_segment + 1):
        tendon.wrap_site(f"rim_{segment + 1}_{disc}_{chamber + 1}")
    actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_TENDON)
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.biastype = mujoco.mjtBias.mjBIAS_NONE
    actuator.dyntype = mujoco.mjtDyn.mjDYN_NONE
    actuator.gainprm[0] = elastic.areas[index]
