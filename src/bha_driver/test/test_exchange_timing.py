"""What comes between a read and its write."""

import math

from bha_driver.exchange_timing import ExchangeTiming


def test_a_chain_without_loss() -> None:
    timing = ExchangeTiming()
    for cycle in range(5):
        timing.stepped()
        timing.read(cycle + 0.0)
        timing.written(cycle + 0.25)
    assert (timing.cycles, timing.stale, timing.skipped, timing.late) == (5, 0, 0, 0)
    assert timing.median == timing.longest == 0.25


def test_what_is_lost_is_counted() -> None:
    timing = ExchangeTiming()
    timing.read(0.0)
    timing.stepped()
    timing.written(0.1)
    assert timing.late == 1
    timing.read(1.0)
    timing.written(1.1)
    timing.read(2.0)
    assert timing.stale == 1
    for _ in range(3):
        timing.stepped()
    timing.read(3.0)
    assert timing.skipped == 2
    timing.written(3.1)
    timing.written(3.2)
    assert timing.cycles == 3, "a write more than one a read answers nothing"


def test_nothing_was_seen() -> None:
    assert math.isnan(ExchangeTiming().median)
    assert math.isnan(ExchangeTiming().longest)
