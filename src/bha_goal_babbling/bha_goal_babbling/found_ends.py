"""Ends of bellows' ranges that are found on the way to a goal."""

from collections import deque

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.stuck_watch import BoolArray, StuckWatch

_MARGIN = 0.002
"""How far short of its command a length that keeps still has come to an end [m]."""
_TRAIL = 3
"""Commands over which the speed of a length is taken."""
_PATIENCE = 30.0
"""Commands in which a length would come to its command at its speed, if it is not at an end: 15 s.
Bellows that vent sink for seconds, ever slower, and are still many millimetres above their end when
a step of theirs has become small."""
_NEAR = 0.1
"""How far from the goal on whose way they were found ends still count [m]."""
_CORRECTED = 0.01
"""How far from its goal a target is whose feedback has made up for an end by itself [m]."""


class FoundEnds:
    """Lowest and highest lengths that can be had where the robot is.

    A length that stays short of its command, and would not come there in a while either, shows an
    end that learning has not found yet, or one that moved since. The others can make up for it,
    see `GoalBabbler.inverse`. Lengths and commands tell it alone, so the movement stays
    feed-forward: nothing is corrected by the tip.

    Where feedback has moved the target by more than a little, it has made up for such an end by
    itself. Then the end is taken to be where the command is, not where the length is: what is
    commanded does not jump, and the others do what is still to come.

    A robot of which more than half of the lengths stay short is not at its ends, it is not driven:
    then all ends are given up until at least half of the lengths are where they should be.

    Parameters
    ----------
    size : int
        Number m of lengths.
    """

    def __init__(self, size: int) -> None:
        self._watch = StuckWatch(size, _MARGIN)
        self._trail: deque[FloatArray] = deque(maxlen=_TRAIL)
        self._goal: FloatArray | None = None
        self._corrected = False
        self.given_up = False
        self.low: FloatArray = np.full(size, -np.inf)
        self.high: FloatArray = np.full(size, np.inf)

    def see(self, command: FloatArray, lengths: FloatArray) -> bool:
        """Take commanded and measured lengths (m,) [m]; whether they change what is known."""
        at_low, at_high = self._watch.see(command, lengths)
        stays = ~self._coming(command, lengths)
        at_low, at_high = at_low & stays, at_high & stays
        if self.given_up:
            short = np.abs(lengths - command) > _MARGIN
            self.given_up = bool(2 * np.count_nonzero(short) > short.size)
            return False
        ends = command if self._corrected else lengths
        # A length that went further has shown that the end is not there.
        self.low = np.where(at_low, ends, np.minimum(self.low, lengths))
        self.high = np.where(at_high, ends, np.maximum(self.high, lengths))
        known = np.isfinite(self.low) | np.isfinite(self.high)
        if 2 * np.count_nonzero(known) > known.size:
            self._forget()
            self.given_up = True
        return self.given_up or bool(at_low.any() or at_high.any())

    def begin(self, goal: FloatArray) -> None:
        """Forget what was found: the robot is to go to a goal (n,) [m]."""
        self._goal = goal
        self._corrected = False
        self._watch.pause()
        self._trail.clear()
        self._forget()
        self.given_up = False

    def follow(self, goal: FloatArray) -> None:
        """Keep what was found if a goal (n,) [m] is near the one at which it began."""
        moved = np.inf if self._goal is None else float(np.linalg.norm(goal - self._goal))
        if moved > _NEAR:
            self.begin(goal)
        else:
            self._corrected = moved > _CORRECTED

    def _coming(self, command: FloatArray, lengths: FloatArray) -> BoolArray:
        """Tell which lengths would come to their commands at the speed that they have."""
        self._trail.append(lengths)
        steps = max(len(self._trail) - 1, 1)
        speed = np.abs(lengths - self._trail[0]) / steps  # [m] a command
        coming: BoolArray = np.abs(lengths - command) < _PATIENCE * speed
        return coming

    def _forget(self) -> None:
        self.low = np.full_like(self.low, -np.inf)
        self.high = np.full_like(self.high, np.inf)
