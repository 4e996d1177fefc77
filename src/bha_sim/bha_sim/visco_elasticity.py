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

from bha_sim.parameter_sections import Array, Hysteresis, Relaxation


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
        self._creep = self._states[:branches]
        self._sliders = self._states[branches:]
        # Exact for an extension that rests during the period.
        self._approach = -np.expm1(-period / relaxation.time_constants)[:, None]
        factors = hysteresis.slip_factors
        slips = hysteresis.slips[:, None] * (np.ones((1, pieces)) if factors is None else factors)
        self._slips = np.ascontiguousarray(slips)
        self._step = np.empty_like(self._creep)
        self._bound = np.empty_like(self._sliders)
        self._weighted = np.empty_like(self._states)

    def update(self, extensions: Array, centres: Array) -> None:
        """Advance all states by one period.

        Parameters
        ----------
        extensions : Extension of every piece now [m], shape (9 * discs,).
        centres : Filled with the extension at which each piece's spring is free [m], same shape.
        """
        creep, sliders = self._creep, self._sliders
        np.subtract(extensions, creep, out=self._step)
        np.multiply(self._step, self._approach, out=self._step)
        np.add(creep, self._step, out=creep)
        np.subtract(extensions, self._slips, out=self._bound)
        np.maximum(sliders, self._bound, out=sliders)
        np.add(extensions, self._slips, out=self._bound)
        np.minimum(sliders, self._bound, out=sliders)
        np.multiply(self._weights, self._states, out=self._weighted)
        np.add.reduce(self._weighted, axis=0, out=centres)

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
