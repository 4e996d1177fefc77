"""What tables share: picking runs by their settings."""

from benchmarks.engine.experiment import Run, runs_with


def test_runs_are_picked_by_settings() -> None:
    """All that are asked for must fit, in the order of the runs; others and the seed are free."""
    runs = [
        Run(seed, {"joints": joints, "method": method, "samples": [1, 2]}, {})
        for seed in (0, 1)
        for joints in (2, 5)
        for method in ("a", "b")
    ]
    assert runs_with(runs) == runs
    assert runs_with(runs, joints=5, method="b") == [runs[3], runs[7]]
    assert runs_with(runs, samples=[1, 2], joints=2) == [*runs[:2], *runs[4:6]]
    assert runs_with(runs, branch=1) == []
