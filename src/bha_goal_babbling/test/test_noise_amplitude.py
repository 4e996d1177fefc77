"""The amplitude of noise: in proportion to the error, between a floor and a ceiling."""

import math

import pytest

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.noise_amplitude import NoiseAmplitude


@pytest.mark.parametrize(
    ("error", "amplitude"),
    [(0.0, 0.005), (0.01, 0.005), (0.05, 0.015), (0.1, 0.03), (7.0, 0.03), (math.inf, 0.03)],
)
def test_follows_the_error_between_floor_and_spread(error: float, amplitude: float) -> None:
    rule = NoiseAmplitude(0.03, 0.005, 0.3)
    assert rule.at(error) == pytest.approx(amplitude)
    assert rule.share(error) == pytest.approx(amplitude / 0.03)


@pytest.mark.parametrize("error", [0.0, 1.0, math.inf])
def test_without_a_rule_it_is_the_spread(error: float) -> None:
    """Exactly: noise times the share is the noise, bit for bit."""
    rule = NoiseAmplitude(0.03, 0.005, None)
    assert (rule.at(error), rule.share(error)) == (0.03, 1.0)


def test_no_spread_is_no_noise() -> None:
    rule = NoiseAmplitude(0.0, 0.0, 0.3)
    assert (rule.at(1.0), rule.share(1.0)) == (0.0, 1.0)


@pytest.mark.parametrize("wrong", [(-1.0, 0.0, None), (1.0, -1.0, None), (1.0, 0.0, -1.0)])
def test_refuses_negative_settings(wrong: tuple) -> None:
    with pytest.raises(InvalidConfigError, match="negative"):
        NoiseAmplitude(*wrong)
