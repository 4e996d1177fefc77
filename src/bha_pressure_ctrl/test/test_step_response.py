"""Dead time and lag, read from steps whose answer is known."""

import numpy as np
import pytest

from bha_pressure_ctrl.step_response import fit_step_response

PERIOD = 0.02


def steps(
    dead_time: float, lag: float, noise: float = 0.0, share: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Two steps of a lag of first order with a dead time, as shares of the step."""
    rng = np.random.default_rng(0)
    time = PERIOD * np.arange(100)
    response = share * -np.expm1(-np.maximum(time - dead_time, 0.0) / lag)
    start = rng.uniform(-1.0, 1.0, (2, 9))
    after = start[:, None] + response[:, None] + noise * rng.standard_normal((2, 100, 9))
    return start, after


@pytest.mark.parametrize("dead_time", [0.0, 0.05, 0.2])
@pytest.mark.parametrize("lag", [0.05, 0.3, 0.7])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_known_answers(dead_time: float, lag: float, noise: float) -> None:
    """The noise is what readings off by 0.5 mm make of a step of 39 kPa, at 1.3e6 Pa/m."""
    found = fit_step_response(*steps(dead_time, lag, noise), PERIOD)
    assert found is not None
    assert found == pytest.approx((dead_time, lag), abs=1e-3 if not noise else 0.02)


def test_the_size_of_the_response_does_not_matter() -> None:
    """A model that is off in its slope tells the times all the same."""
    found = fit_step_response(*steps(0.1, 0.3, share=0.8), PERIOD)
    assert found == pytest.approx((0.1, 0.3), abs=1e-3)


@pytest.mark.parametrize("share", [0.0, 0.2, -1.0, 3.0])
def test_a_step_that_does_not_show_is_not_believed(share: float) -> None:
    assert fit_step_response(*steps(0.1, 0.3, noise=0.02, share=share), PERIOD) is None


def test_no_steps_tell_nothing() -> None:
    assert fit_step_response(np.empty((0, 9)), np.empty((0, 100, 9)), PERIOD) is None
