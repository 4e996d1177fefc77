"""When the terminal counts as lost, and when it may have vented."""

import pytest

from bha_driver.link_watch import LinkWatch
from bha_driver.terminal_file import example_path, load_terminal

LAB = load_terminal(example_path("cpx_e"))
PERIOD = 0.02


@pytest.fixture
def link() -> LinkWatch:
    watch = LinkWatch(LAB, PERIOD)
    watch.linked = True
    watch.begin(100.0)
    return watch


def test_it_is_lost_after_the_link_time(link: LinkWatch) -> None:
    assert not link.lost(100.0 + LAB.timeouts.link - PERIOD)
    assert link.lost(100.0 + LAB.timeouts.link)


@pytest.mark.parametrize("only", ["read", "written"])
def test_reads_or_writes_alone_do_not_keep_it(link: LinkWatch, only: str) -> None:
    getattr(link, only)(101.0)
    assert link.lost(101.0)
    link.read(101.0)
    link.written(101.0)
    assert not link.lost(101.0)


def test_writes_are_overdue_before_the_watchdog_has_acted(link: LinkWatch) -> None:
    """What is decided on then reaches the terminal before its watchdog has vented, if in time."""
    limit = LAB.watchdog.time - LAB.timeouts.request
    assert link.overdue(100.0 + limit - 1e-6) == 0.0
    assert link.overdue(100.0 + limit + 1e-6) == pytest.approx(limit, abs=1e-5)
    link.read(100.1)
    assert link.overdue(100.0 + limit + 1e-6), "reads do not feed the watchdog"
    link.written(100.1)
    assert not link.overdue(100.0 + limit + 1e-6)


def test_the_first_trouble_is_kept_until_there_is_other(link: LinkWatch) -> None:
    link.failed("the cable is out")
    link.failed("")
    assert not link.linked
    assert link.trouble == "the cable is out"
