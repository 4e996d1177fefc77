"""Speed of goal babbling on an arm with 20 joints.

./bha shell python -m pytest benchmarks/speed
"""

import time

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.speed.learners import ARM, SMALL, USUAL, compiled_babbler, numpy_babbler

SAMPLES = 20_000


def test_numpy(benchmark: BenchmarkFixture) -> None:
    """A hundred samples of the reference, after the first thousand."""
    babbler = numpy_babbler(0)

    def run(samples: int) -> None:
        for _ in range(samples):
            action = babbler.ask()
            babbler.tell(action, ARM.forward(action))

    run(1000)
    benchmark(run, 100)


def test_compiled(benchmark: BenchmarkFixture) -> None:
    """20,000 samples from the first on."""
    compiled_babbler(0).run(100)

    def fresh() -> tuple[tuple[object, ...], dict[str, object]]:
        return (compiled_babbler(0),), {}

    def run(babbler: object) -> None:
        babbler.run(SAMPLES)  # type: ignore[attr-defined]

    benchmark.pedantic(run, setup=fresh, rounds=10)
    benchmark.extra_info["samples per second"] = SAMPLES / benchmark.stats.stats.min


@pytest.mark.parametrize("distance", [USUAL, SMALL], ids=["150 maps", "10,000 maps"])
def test_maps(benchmark: BenchmarkFixture, distance: float) -> None:
    """20,000 samples with few and with many maps."""
    babbler = compiled_babbler(0, distance)
    babbler.run(SAMPLES)
    benchmark.pedantic(babbler.run, args=(SAMPLES,), rounds=10)
    benchmark.extra_info["maps"] = babbler.local_maps


def test_cost_of_many_maps() -> None:
    """A sample with 10,000 maps costs at most 1.3 times one with 150; measured in turns."""
    few, many = compiled_babbler(0, USUAL), compiled_babbler(0, SMALL)
    few.run(200_000)
    while many.local_maps < 10_000:
        many.run(SAMPLES)
    times = np.empty((15, 2))
    for row in times:
        for column, babbler in enumerate((few, many)):
            began = time.process_time()
            babbler.run(SAMPLES)
            row[column] = time.process_time() - began
    ratio = float(np.median(times[:, 1] / times[:, 0]))
    assert few.local_maps < 200
    assert ratio <= 1.3, f"{ratio:.2f} times"
