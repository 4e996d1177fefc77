"""The world of compared methods counts what they execute, and lets nothing past the limits."""

import numpy as np
import pytest

from benchmarks.arm.reaching import ReachingTask
from benchmarks.methods.world import World


def test_counts_samples_and_travel() -> None:
    """Travel begins at home; measuring errors costs nothing."""
    world = World(lambda q: q[:1], np.zeros(2), -np.ones(2), np.ones(2), [[0.0], [1.0]])
    world.execute(np.array([0.6, 0.8]))
    world.execute(np.array([0.6, 0.0]))
    assert world.error(np.array([[0.0, 0.5], [0.5, 0.5]])) == pytest.approx(0.25)
    assert (world.samples, world.travel) == (2, pytest.approx(1.8))


def test_refuses_what_exceeds_the_limits() -> None:
    """A method must know what it does."""
    world = World.of_task(ReachingTask(3))
    with pytest.raises(ValueError, match="limits"):
        world.execute(np.full(3, 4.0))
    assert world.samples == 0
