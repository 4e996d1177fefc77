"""Names and order of the bellows: every array of shape (9,) and every message relies on them."""

from bha_common import bellows


def test_names_count_segments_first() -> None:
    """The order is a contract: users' scripts index arrays by it."""
    assert bellows.NAMES == (
        "bellows_1_1", "bellows_1_2", "bellows_1_3",
        "bellows_2_1", "bellows_2_2", "bellows_2_3",
        "bellows_3_1", "bellows_3_2", "bellows_3_3",
    )  # fmt: skip


def test_count_is_that_of_the_names() -> None:
    assert bellows.COUNT == len(set(bellows.NAMES)) == bellows.SEGMENTS * bellows.CHAMBERS == 9


def test_ranges_are_those_of_the_robot() -> None:
    """The robot is driven with gauge pressures of at most 1.5 bar, and is 0.7 to 1.1 m long."""
    assert 0.0 < bellows.MAX_PRESSURE < 1.5e5
    assert 0.0 < bellows.MIN_LENGTH < 0.7 / bellows.SEGMENTS
    assert bellows.MAX_LENGTH > 1.1 / bellows.SEGMENTS
    assert bellows.BASE_FRAME == "bha_base"
