"""Identification, on a robot of first order: lengths = rest + pressures / stiffness, with a lag."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_pressure_ctrl.bellows_memory import STATES
from bha_pressure_ctrl.equilibrium_model import Array
from bha_pressure_ctrl.identification import Identification, IdentificationSettings
from bha_pressure_ctrl.model_fitting import fit_equilibrium_model

PERIOD = 0.02
MAX_PRESSURE = 1.3e5
STIFFNESS = 5e5  # [Pa/m]


class Robot:
    """Nine bellows that follow their pressures with a lag of first order."""

    def __init__(self, lag: float = 0.3, noise: float = 0.0, seed: int = 0) -> None:
        self._share = 1.0 - np.exp(-PERIOD / lag)
        self._noise, self._rng = noise, np.random.default_rng(seed)
        self._lengths = np.full(9, 0.15)

    def step(self, pressures: Array) -> Array:
        self._lengths += self._share * (0.15 + pressures / STIFFNESS - self._lengths)
        return self._lengths + self._noise * self._rng.standard_normal(9)


def identification(
    samples: int | None = 24, start: Array | None = None, seed: int = 0, **changes: Any
) -> Identification:
    return Identification(
        IdentificationSettings(**{"steps": 0, **changes}),
        max_pressure=MAX_PRESSURE,
        start=np.zeros(9) if start is None else start,
        period=PERIOD,
        seed=seed,
        samples=samples,
    )


def run(running: Identification, robot: Robot, limit: float = 2000.0) -> Array:
    """Run to the end; return all pressures, shape (ticks, 9)."""
    lengths = robot.step(np.zeros(9))
    pressures: list[Array] = []
    for _ in range(round(limit / PERIOD)):
        if running.done:
            return np.array(pressures)
        pressures.append(running.update(lengths).copy())
        lengths = robot.step(pressures[-1])
    raise AssertionError("identification did not end")


def test_samples_are_those_of_the_robot() -> None:
    running = identification()
    run(running, Robot())
    lengths, pressures = running.samples()
    assert lengths.shape == pressures.shape == (24, 9)
    np.testing.assert_allclose(lengths, 0.15 + pressures / STIFFNESS, atol=5e-4)


def test_a_model_can_be_fitted_to_them() -> None:
    running = identification()
    run(running, Robot(noise=5e-4))
    fitted = fit_equilibrium_model(*running.samples())
    slopes = fitted.slopes(running.samples()[0].mean(axis=0))
    np.testing.assert_allclose(slopes, STIFFNESS * np.eye(9), atol=0.03 * STIFFNESS)
    assert fitted.pressure_error < 0.02 * MAX_PRESSURE


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_postures_cover_the_box(seed: int) -> None:
    """Each pressure in each eighth of its range, evenly, and none outside."""
    running = identification(samples=64, seed=seed, rest_window=0.1, rest_speed=1.0)
    run(running, Robot(lag=1e-3))
    _, pressures = running.samples()
    assert (pressures >= 0.0).all()
    assert (pressures <= MAX_PRESSURE).all()
    for chamber in pressures.T:
        counts, _ = np.histogram(chamber, bins=8, range=(0.0, MAX_PRESSURE))
        np.testing.assert_array_equal(counts, 8)
    assert np.abs(np.corrcoef(pressures.T) - np.eye(9)).max() < 0.5


def test_the_seed_draws_the_postures() -> None:
    def postures(seed: int) -> Array:
        running = identification(samples=20, seed=seed, rest_window=0.1, rest_speed=1.0)
        run(running, Robot(lag=1e-3))
        return running.samples()[1]

    np.testing.assert_array_equal(postures(4), postures(4))
    assert not np.array_equal(postures(4), postures(5))


@settings(max_examples=8, deadline=None)
@given(
    rate=st.floats(1e4, 1e6),
    start=st.lists(st.floats(0.0, MAX_PRESSURE), min_size=9, max_size=9),
)
def test_pressures_change_at_a_limited_rate(rate: float, start: list[float]) -> None:
    """From the pressures at the start on, and never beyond the range."""
    first = np.array(start)
    running = identification(samples=3, start=first, pressure_rate=rate, rest_window=0.1)
    pressures = np.vstack([first, run(running, Robot())])
    assert np.abs(np.diff(pressures, axis=0)).max() <= rate * PERIOD * (1 + 1e-9)
    assert (pressures >= 0.0).all()
    assert (pressures <= MAX_PRESSURE).all()


def test_waits_for_the_robot_to_rest() -> None:
    """A slower robot takes longer, and is at rest all the same."""
    durations = []
    for lag in (0.1, 0.5, 2.0):
        running = identification(samples=20, max_settling=600.0)
        run(running, Robot(lag=lag))
        lengths, pressures = running.samples()
        # At rest: slower than rest_speed, so no further off than that times the lag.
        assert np.abs(lengths - 0.15 - pressures / STIFFNESS).max() < 4e-4 * (lag + 0.5) * 2
        durations.append(running.elapsed)
    assert durations == sorted(durations)


def test_does_not_wait_for_ever() -> None:
    """With lengths that never rest each posture takes the way there and the time to settle."""
    running = identification(samples=20, max_settling=5.0)
    ticks = len(run(running, Robot(noise=0.05)))
    way = MAX_PRESSURE / 6e4
    assert ticks * PERIOD >= 20 * (5.0 - PERIOD)
    assert ticks * PERIOD <= 20 * (5.0 + way + 2 * PERIOD)


def test_the_pressures_stand_still_while_it_waits() -> None:
    """What is averaged belongs to the pressures it is noted with."""
    running = identification(samples=20)
    robot, lengths = Robot(), np.full(9, 0.15)
    before, settled = running.update(lengths), 0
    while not running.done:
        lengths = robot.step(before)
        collected, after = running.collected, running.update(lengths).copy()
        if running.collected > collected:
            np.testing.assert_array_equal(after, running.samples()[1][-1])
            np.testing.assert_array_equal(after, before)
            settled += 1
        before = after
    assert settled == 20


def test_lengths_are_averaged_over_the_window() -> None:
    """Noise of a potentiometer falls with the root of the number of readings."""
    errors = {}
    for window in (0.1, 1.6):
        running = identification(samples=30, rest_window=window, rest_speed=1.0)
        run(running, Robot(lag=1e-3, noise=1e-3))
        lengths, pressures = running.samples()
        errors[window] = float(np.std(lengths - 0.15 - pressures / STIFFNESS))
    assert errors[0.1] == pytest.approx(1e-3 / np.sqrt(5), rel=0.25)
    assert errors[1.6] == pytest.approx(1e-3 / np.sqrt(80), rel=0.25)


def test_counts_and_ends() -> None:
    running = identification(samples=20)
    assert (running.requested, running.collected, running.done) == (20, 0, False)
    assert running.samples()[0].shape == running.samples()[1].shape == (0, 9)
    pressures = run(running, Robot())
    assert (running.collected, running.done) == (20, True)
    assert running.elapsed == pytest.approx(len(pressures) * PERIOD)
    for _ in range(100):  # the last pressures hold until somebody takes over
        np.testing.assert_array_equal(running.update(np.full(9, 0.2)), pressures[-1])
    assert running.collected == 20


def test_steps_follow_when_the_samples_are_collected() -> None:
    """And change nothing of the samples."""
    without, running = identification(), identification(steps=4)
    before, pressures = run(without, Robot()), run(running, Robot())
    np.testing.assert_array_equal(pressures[: len(before)], before)
    jumps = np.flatnonzero(np.abs(np.diff(pressures[:, 0])) > 6e4 * PERIOD * 1.01)
    assert len(jumps) == 4
    assert jumps[0] > len(before)
    assert running.steps is not None
    assert running.steps.done
    for one, other in zip(running.samples(), without.samples(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_what_it_saw_on_the_way_is_kept_with_what_was_remembered() -> None:
    """A row for every second at rest from the second on, the last of them the settled one."""
    running = identification(samples=20)
    run(running, Robot(lag=0.8))
    records = running.records()
    assert records.settled.sum() == 20
    assert len(records.lengths) > 40
    assert (np.diff(records.times) > 0.0).all()
    assert records.states.shape == (len(records.lengths), STATES, 9)
    # The slower the creep, the more of the way since the posture before is still remembered.
    creep = np.abs(records.states[records.settled][:, :3]).mean(axis=(0, 2))
    assert (np.diff(creep) > 0.0).all()
    rows = np.flatnonzero(records.settled)
    moving = records.lengths[rows[:-1] + 1] - 0.15 - records.pressures[rows[:-1] + 1] / STIFFNESS
    resting = records.lengths[rows] - 0.15 - records.pressures[rows] / STIFFNESS
    assert np.abs(resting).mean() < 0.5 * np.abs(moving).mean()


def test_takes_the_number_of_the_settings() -> None:
    running = Identification(
        IdentificationSettings(samples=33),
        max_pressure=MAX_PRESSURE,
        start=np.zeros(9),
        period=PERIOD,
        seed=0,
    )
    assert running.requested == 33


@pytest.mark.parametrize(
    "wrong",
    [
        {"samples": 19},
        {"pressure_rate": 0.0},
        {"rest_speed": 0.0},
        {"rest_window": 0.0},
        {"max_settling": float("inf")},
        {"steps": -1},
    ],
)
def test_settings_out_of_range(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        IdentificationSettings(**wrong)
