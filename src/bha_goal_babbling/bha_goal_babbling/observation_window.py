"""What the learner sees of the robot: lengths and tip, averaged over a short time."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from bha_goal_babbling.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Observation:
    """Lengths and tip around one time.

    Attributes
    ----------
    lengths : array
        Mean bellows lengths [m], shape (9,).
    tip : array or None
        Mean position of the tip [m], shape (3,); None when none was seen lately.
    """

    lengths: FloatArray
    tip: FloatArray | None


LONGEST_WAIT = 2.0
"""How long after a time its average may be asked for [s]."""


class ObservationWindow:
    """Keeps the newest lengths and tips, and averages them over the last moments.

    Both are averaged over the same time, so that they belong to the same posture while the robot
    moves, and their noise falls with the root of their number. Times are those of the messages:
    the average does not depend on when a message arrived.

    Parameters
    ----------
    span : int
        Time over which is averaged [ns].
    """

    def __init__(self, span: int) -> None:
        self._span = max(span, 1)
        self._lengths: deque[tuple[int, FloatArray]] = deque()
        self._tips: deque[tuple[int, FloatArray]] = deque()

    def clear(self) -> None:
        """Forget everything, as when the robot was started anew."""
        self._lengths.clear()
        self._tips.clear()

    def add_lengths(self, time: int, lengths: FloatArray) -> None:
        """Take measured lengths [m], shape (9,), of time [ns]."""
        self._lengths.append((time, lengths))
        self._forget(self._lengths, time)

    def add_tip(self, time: int, tip: FloatArray) -> None:
        """Take a measured tip [m], shape (3,), of time [ns]."""
        self._tips.append((time, tip))
        self._forget(self._tips, time)

    @property
    def newest_tip(self) -> int | None:
        """Time of the newest tip [ns]; None when there is none."""
        return self._tips[-1][0] if self._tips else None

    def at(self, time: int) -> Observation | None:
        """Average what was seen in the span that ends at `time` [ns]; None without lengths."""
        lengths = self._mean(self._lengths, time)
        return None if lengths is None else Observation(lengths, self._mean(self._tips, time))

    def _mean(self, seen: deque[tuple[int, FloatArray]], time: int) -> FloatArray | None:
        inside = [value for stamp, value in seen if time - self._span < stamp <= time]
        return np.mean(inside, axis=0) if inside else None

    def _forget(self, seen: deque[tuple[int, FloatArray]], now: int) -> None:
        while seen[0][0] <= now - self._span - round(LONGEST_WAIT * 1e9):
            seen.popleft()
