"""The ends of the range: reached by nothing, and nothing stands still before them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_pressure_ctrl.soft_ends import MARGIN, bend, bend_slopes

TOP = 1.3e5


def test_the_inner_range_is_as_it_was() -> None:
    values = np.linspace(MARGIN * TOP, (1.0 - MARGIN) * TOP, 99)
    np.testing.assert_allclose(bend(values, TOP), values, rtol=1e-12)
    np.testing.assert_allclose(bend_slopes(values, TOP), 1.0)


def test_known_values() -> None:
    """One margin beyond the end, half of the margin is left."""
    np.testing.assert_allclose(bend(np.array([0.0, TOP]), TOP), [0.01 * TOP, 0.99 * TOP])


@given(st.floats(-1e7, 1e7), st.floats(1e-2, 1e6))
def test_it_stays_inside_and_rises(value: float, step: float) -> None:
    low, high = bend(np.array([value, value + step]), TOP)
    assert 0.0 < low < high < TOP


@pytest.mark.parametrize("value", [-3e5, -100.0, 1000.0, 6e4, 1.29e5, 1.31e5, 5e5])
def test_slope_is_the_numerical_one(value: float) -> None:
    around = bend(np.array([value - 1.0, value + 1.0]), TOP)
    assert bend_slopes(np.array(value), TOP) == pytest.approx(np.diff(around)[0] / 2.0, rel=1e-4)
