"""Why a simulated motion diverged, in words that help."""

from __future__ import annotations

import mujoco
import numpy as np

_HINT = (
    "a trunk does so when its springs (stiffness, hardening) are too stiff for max_time_step and "
    "trunk.damping_time, or when its bellows push (areas x max_pressure) more than stiffness and "
    "torsion_stiffness hold straight"
)


def why_diverged(model: mujoco.MjModel, data: mujoco.MjData) -> str:
    """Tell which joints are not finite, what MuJoCo warned of, and which parameters lead there."""
    bad = np.flatnonzero(~(np.isfinite(data.qpos) & np.isfinite(data.qvel)))
    names = [model.joint(int(index)).name for index in bad[:3]]
    if len(bad) > len(names):
        names.append(f"and {len(bad) - len(names)} more")
    warnings = [
        mujoco.mjtWarning(index).name
        for index, warning in enumerate(data.warning)
        if warning.number
    ]
    return (
        f"joints not finite: {', '.join(names) or 'none'}; "
        f"MuJoCo warnings: {', '.join(warnings) or 'none'}; {_HINT}"
    )
