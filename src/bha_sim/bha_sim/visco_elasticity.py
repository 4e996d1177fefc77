"""Memory of the bellows material: creep and hysteresis of every disc's piece of every bellows.

A piece is a spring of stiffness k beside Maxwell branches (a spring c_i k in series with a damper:
slow creep) and Jenkin elements (a spring c_j k in series with a slider: rate-free hysteresis):

    force = k (e - 0) + sum_i c_i k (e - z_i) + sum_j c_j k (e - y_j)
    dz_i/dt = (e - z_i)/tau_i,        |e - y_j| <= slip_j

for an extension e. That is one spring of stiffness k (1 + sum c) about a centre which is the
weighted mean of the states; the dynamics carry the spring, this module moves the centre. States
only ever move towards the extension, so an update takes energy out and never puts any in.
"""

from __future__ import annotations

import numpy as np

from bha_common import bellows
from bha_sim.compiled import compiled
from bha_sim.parameter_checks import Array
from bha_sim.parameter_sections import Hysteresis, Relaxation


class ViscoElasticity:
    """States of all branches and elements, one column a piece.

    Parameters
    ----------
    relaxation, hysteresis : Branches and elements.
    discs : Number of pieces of a bellows.
    period : Time between two updates [s].
    """

    def __init__(
        self, relaxation: Relaxation, hysteresis: Hysteresis, discs: int, period: float
    ) -> None:
        pieces = bellows.COUNT * discs
        branches, elements = len(relaxation.time_constants), len(hysteresis.slips)
        shares = np.vstack([relaxation.shares, hysteresis.shares]).repeat(discs, axis=1)
        self.stiffness_factors: Array = 1.0 + shares.sum(axis=0)
        """Stiffness of the whole piece over that of its lasting spring [-], shape (9 * discs,)."""
        self._weights = shares / self.stiffness_factors
        self._states = np.zeros((branches + elements, pieces))
        # Exact for an extension that rests during the period.
        self._approach = -np.expm1(-period / relaxation.time_constants)
        factors = hysteresis.slip_factors
        slips = hysteresis.slips[:, None] * (np.ones((1, pieces)) if factors is None else factors)
        self._slips = np.ascontiguousarray(slips)

    def update(self, extensions: Array, centres: Array) -> None:
        """Advance all states by one period.

        Parameters
        ----------
        extensions : Extension of every piece now [m], shape (9 * discs,).
        centres : Filled with the extension at which each piece's spring is free [m], same shape.
        """
        _advance(self._states, extensions, self._approach, self._slips, self._weights, centres)

    def relax(self, extensions: Array, centres: Array) -> None:
        """Forget all history, as after resting at `extensions` for ever; fills `centres`."""
        self._states[:] = extensions
        np.add.reduce(self._weights * self._states, axis=0, out=centres)

    @property
    def state(self) -> Array:
        """Copy of all states [m], shape (branches + elements, 9 * discs)."""
        return self._states.copy()

    @state.setter
    def state(self, value: Array) -> None:
        self._states[:] = value


@compiled
def _advance(
    states: Array,
    extensions: Array,
    approach: Array,
    slips: Array,
    weights: Array,
    centres: Array,
) -> None:
    """Move branches and sliders towards the extensions, and take the weighted mean."""
    branches = len(approach)
    for piece in range(len(extensions)):
        extension = extensions[piece]
        centre = 0.0
        for row in range(len(states)):
            state = states[row, piece]
            if row < branches:
                state += approach[row] * (extension - state)
            else:
                slip = slips[row - branches, piece]
                state = min(max(state, extension - slip), extension + slip)
            states[row, piece] = state
            centre += weights[row, piece] * state
        centres[piece] = centre
