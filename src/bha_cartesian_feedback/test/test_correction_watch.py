"""What the watch says of corrections whose effect is known."""

import numpy as np

from bha_cartesian_feedback.correction_watch import CorrectionWatch


def test_goes_back_to_what_the_least_error_came_of() -> None:
    """The tip is three looks late: the error that is least at 5 s came of what was tried at 2 s."""
    watch = CorrectionWatch(gain=0.2, tolerance=0.002, first_check=0.0)
    for second in range(7):
        error = np.array([0.020 - 0.001 * min(second, 5), 0.0, 0.0])
        watch.look(float(second), error, np.array([0.01 * second, 0.0, 0.0]), error)
        assert watch.back_to is None
        assert watch.gain == 0.2
    # 5 cm beyond: more than twice 20 mm and the tolerance.
    error = np.array([0.015, 0.0, 0.0])
    watch.look(7.0, error, np.array([0.07, 0.0, 0.0]), error)
    np.testing.assert_array_equal(watch.back_to, [0.02, 0.0, 0.0])
    assert watch.gain == 0.1


def gain_of_an_error_that_goes_round(correctable: float, looks: int) -> float:
    """Gain after looks at an error that turns by 40 degrees between them."""
    watch = CorrectionWatch(gain=0.2, tolerance=0.002, first_check=0.0)
    for second in range(looks):
        angle = np.radians(40.0 * second)
        error = 0.02 * np.array([np.cos(angle), np.sin(angle), 0.0])
        watch.look(float(second), error, np.zeros(3), correctable * error)
    return watch.gain


def test_an_error_that_goes_round_the_goal_has_turned() -> None:
    """At no look is it against the one before, but every third is against where it last turned."""
    assert gain_of_an_error_that_goes_round(1.0, looks=6) == 0.2  # it may turn once
    assert gain_of_an_error_that_goes_round(1.0, looks=7) == 0.1
    assert gain_of_an_error_that_goes_round(1.0, looks=10) == 0.05


def test_what_cannot_be_corrected_does_not_slow_down() -> None:
    """Of an error of 20 mm 1.8 mm could be corrected: within the tolerance."""
    assert gain_of_an_error_that_goes_round(0.09, looks=40) == 0.2


def test_going_back_is_no_turn() -> None:
    """The error may point elsewhere after it; the gain was halved for what was taken back."""
    watch = CorrectionWatch(gain=0.2, tolerance=0.002, first_check=0.0)
    ahead, behind = np.array([0.02, 0.0, 0.0]), np.array([-0.02, 0.0, 0.0])
    for second, error in enumerate([ahead, behind]):  # the turn that costs nothing
        watch.look(float(second), error, np.zeros(3), error)
    watch.look(2.0, behind, 5.0 * ahead, behind)
    np.testing.assert_array_equal(watch.back_to, np.zeros(3))
    watch.look(3.0, behind, np.zeros(3), behind)
    watch.look(6.0, ahead, np.zeros(3), ahead)
    assert watch.gain == 0.1
