"""What the watch says of corrections whose effect is known."""

import numpy as np

from bha_cartesian_feedback.correction_watch import CorrectionWatch


def test_goes_back_to_what_the_least_error_came_of() -> None:
    """The tip is three looks late: the error that is least at 5 s came of what was tried at 2 s."""
    watch = CorrectionWatch(gain=0.2, tolerance=0.002, first_check=0.0)
    for second in range(7):
        error = np.array([0.020 - 0.001 * min(second, 5), 0.0, 0.0])
        watch.look(float(second), error, np.array([0.01 * second, 0.0, 0.0]))
        assert watch.back_to is None
        assert watch.gain == 0.2
    # 5 cm beyond: more than twice 20 mm and the tolerance.
    watch.look(7.0, np.array([0.015, 0.0, 0.0]), np.array([0.07, 0.0, 0.0]))
    np.testing.assert_array_equal(watch.back_to, [0.02, 0.0, 0.0])
    assert watch.gain == 0.1
