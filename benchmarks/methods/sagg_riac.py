"""SAGG-RIAC: goals anywhere in a box, most of them where competence is changing.

The box is cut into regions. The interest of a region is the change of its competence over its last
goals; a region with many goals is split where the interests of its two parts differ most. Goals are
drawn from regions by a softmax of their interests, weighted by volume (Baranes and Oudeyer, "Active
learning of inverse models with intrinsically motivated goal exploration in robots", 2013).
"""

from dataclasses import dataclass, field

import numpy as np

from bha_goal_babbling.arrays import FloatArray

_CUTS = 10
"""Random cuts of a region that are compared along each axis."""


@dataclass
class Region:
    """A box of goals.

    Attributes
    ----------
    low, high : array
        Its corners, shape (n,) [outcome unit].
    depth : int
        Number of splits that made it.
    goals, competences : list
        What was tried in it, oldest first: goals, shape (n,), and competences, at most 0.
    """

    low: FloatArray
    high: FloatArray
    depth: int = 0
    goals: list[FloatArray] = field(default_factory=list)
    competences: list[float] = field(default_factory=list)

    @property
    def volume(self) -> float:
        """Volume [outcome unit to the n]."""
        return float(np.prod(self.high - self.low))

    def holds(self, goal: FloatArray) -> bool:
        """Whether a goal, shape (n,), lies in it; its upper faces belong to it too."""
        return bool((self.low <= goal).all() and (goal <= self.high).all())

    def interest(self, window: int) -> float:
        """Return the absolute change of mean competence from the older to the newer half."""
        return competence_progress(np.array(self.competences), window)


def competence_progress(competences: FloatArray, window: int) -> float:
    """Return |mean of the newer half - mean of the older half| of the last ones, shape (N,).

    Below 2 of them it is 0.
    """
    last = competences[-window:]
    half = len(last) // 2
    if half == 0:
        return 0.0
    return float(abs(last[-half:].mean() - last[:half].mean()))


class SaggRiac:
    """Regions of goals, and goals drawn from them.

    Parameters
    ----------
    low, high : array
        Corners of the box of goals, shape (n,) [outcome unit].
    rng : numpy.random.Generator
        Source of the cuts; goals are drawn with the generator passed to `choose`.
    capacity : int
        Number of goals of a region at which it is split.
    max_depth : int
        Largest number of splits that make a region.
    window : int
        Number of last goals whose competence counts.
    temperature : float
        Temperature of the softmax on interests as shares of the largest one.
    random_share : float
        Share of goals drawn anywhere in the box.
    """

    def __init__(
        self,
        low: FloatArray,
        high: FloatArray,
        rng: np.random.Generator,
        *,
        capacity: int = 100,
        max_depth: int = 20,
        window: int = 50,
        temperature: float = 0.2,
        random_share: float = 0.1,
    ) -> None:
        self.regions = [Region(low, high)]
        self._low, self._high = low, high
        self._rng = rng
        self._capacity = capacity
        self._max_depth = max_depth
        self._window = window
        self._temperature = temperature
        self._random_share = random_share

    def report(self, goal: FloatArray, error: float) -> None:
        """Take the error with which a goal, shape (n,), was reached; its negative is competence."""
        index = next(i for i, region in enumerate(self.regions) if region.holds(goal))
        region = self.regions[index]
        region.goals.append(goal)
        region.competences.append(-error)
        if len(region.goals) >= self._capacity and region.depth < self._max_depth:
            self.regions[index : index + 1] = self._split(region)

    def probabilities(self) -> FloatArray:
        """Return how likely each region is chosen, shape (R,)."""
        interests = np.array([region.interest(self._window) for region in self.regions])
        volumes = np.array([region.volume for region in self.regions])
        shares = interests / max(float(interests.max()), 1e-12)
        # Without the subtraction a low temperature would overflow.
        weights = volumes * np.exp((shares - shares.max()) / self._temperature)
        probabilities: FloatArray = weights / weights.sum()
        return probabilities

    def choose(self, rng: np.random.Generator) -> FloatArray:
        """Return the next goal, shape (n,)."""
        if rng.random() < self._random_share:
            return rng.uniform(self._low, self._high)
        region = self.regions[rng.choice(len(self.regions), p=self.probabilities())]
        return rng.uniform(region.low, region.high)

    def _split(self, region: Region) -> list[Region]:
        """Return the two parts of the cut that differ most in interest, by how many they hold."""
        goals, competences = np.array(region.goals), np.array(region.competences)
        best, best_quality = (0, 0.5 * (region.low[0] + region.high[0])), -1.0
        for axis in range(goals.shape[1]):
            for cut in self._rng.uniform(goals[:, axis].min(), goals[:, axis].max(), _CUTS):
                below = goals[:, axis] <= cut
                progress = [
                    competence_progress(competences[part], self._window) for part in (below, ~below)
                ]
                quality = below.sum() * (~below).sum() * abs(progress[0] - progress[1])
                if quality > best_quality:
                    best, best_quality = (axis, cut), quality
        axis, cut = best
        lower = Region(region.low, region.high.copy(), region.depth + 1)
        upper = Region(region.low.copy(), region.high, region.depth + 1)
        lower.high[axis] = upper.low[axis] = cut
        for goal, competence in zip(region.goals, region.competences, strict=True):
            part = lower if goal[axis] <= cut else upper
            part.goals.append(goal)
            part.competences.append(competence)
        return [lower, upper]
