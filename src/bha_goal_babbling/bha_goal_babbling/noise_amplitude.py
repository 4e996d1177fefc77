"""How strong exploratory noise is: as strong as the goal under way needs it.

    amplitude = min(s, max(s_floor, r e)),   e the last error of that goal

Noise finds what the model does not know yet, and blurs what it does. By the error of its own goal
a corner that is not reached yet goes on exploring while the middle is already tuned; by an error
over all goals the corners would starve.
"""

from bha_goal_babbling.errors import InvalidConfigError


class NoiseAmplitude:
    """Amplitude of noise as a function of an error.

    Parameters
    ----------
    spread : float
        Largest amplitude s, in the unit of actions.
    floor : float
        Smallest amplitude s_floor, in the unit of actions; not above s counts.
    per_error : float or None
        Amplitude r per error, in units of action per outcome; None for s whatever the error.
    """

    def __init__(self, spread: float, floor: float, per_error: float | None) -> None:
        if not (spread >= 0 and floor >= 0 and (per_error is None or per_error >= 0)):
            raise InvalidConfigError(
                "spread, floor and per_error must not be negative, "
                f"got {spread}, {floor} and {per_error}"
            )
        self._spread = float(spread)
        self._floor = float(floor)
        self._per_error = per_error

    def at(self, error: float) -> float:
        """Return the amplitude, in the unit of actions, at an error in the unit of outcomes."""
        if self._per_error is None:
            return self._spread
        return min(self._spread, max(self._floor, self._per_error * error))

    def share(self, error: float) -> float:
        """Return the amplitude as a share of the largest one, in 0 to 1."""
        return self.at(error) / self._spread if self._spread > 0 else 1.0
