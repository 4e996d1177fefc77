"""How far runs of one robot lie apart by chance."""

from benchmarks.scripts.swap_spread import error


def test_a_run_differs_by_its_draws_and_by_when_it_begins() -> None:
    settings = {"minutes": 0.5, "goals": 1, "samples": 20}
    own = error(0, 0, **settings)
    assert own == error(0, 0, **settings)
    assert own != error(0, 0, **settings, late=1.0)
    assert own != error(0, 1000, **settings)
