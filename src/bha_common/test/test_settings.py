"""Settings that describe and check themselves."""

import dataclasses
import math
from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_common.settings import check_settings, setting


@dataclass(frozen=True)
class Inner:
    gain: float = setting(1.0, "Gain [1]", low=0.0, high=2.0)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True)
class Example:
    rate: float = setting(0.5, "Rate [1/s]", low=0.0, high=1.0)
    count: int = setting(3, "Number of things", low=1)
    open: float = setting(-7.0, "Without bounds [m]")
    switch: bool = setting(True, "On or off")
    state: str = setting("vent", "What to do", choices=("vent", "hold"))
    name: str = setting("", "Any text")
    plain: float = math.nan
    inner: Inner = field(default_factory=Inner)

    def __post_init__(self) -> None:
        check_settings(self)


def test_defaults_are_valid() -> None:
    assert Example().rate == 0.5


@given(st.floats(0.0, 1.0))
def test_takes_all_of_the_range(rate: float) -> None:
    assert Example(rate=rate).rate == rate


@given(st.floats().filter(lambda value: not 0.0 <= value <= 1.0))
def test_refuses_all_else(rate: float) -> None:
    """Below, above, infinite, not a number."""
    with pytest.raises(ValueError, match=r"Example\.rate is .*; valid is 0\.0 to 1\.0: Rate"):
        Example(rate=rate)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_without_bounds_it_must_still_be_finite(value: float) -> None:
    with pytest.raises(ValueError, match=r"Example\.open"):
        Example(open=value)


def test_whole_numbers() -> None:
    assert Example(count=10**12).count == 10**12
    with pytest.raises(ValueError, match=r"Example\.count is 0; valid is 1"):
        Example(count=0)


def test_choices_are_listed() -> None:
    assert Example(state="hold").state == "hold"
    with pytest.raises(ValueError, match=r"Example\.state is 'fly'; valid are vent, hold"):
        Example(state="fly")


def test_a_switch_has_no_range() -> None:
    assert Example(switch=False).switch is False


def test_fields_made_otherwise_are_left_alone() -> None:
    assert math.isnan(Example().plain)


def test_groups_check_themselves() -> None:
    with pytest.raises(ValueError, match=r"Inner\.gain is 3\.0"):
        Example(inner=Inner(gain=3.0))


def test_a_changed_copy_is_checked_too() -> None:
    with pytest.raises(ValueError, match=r"Example\.rate is 2\.0"):
        dataclasses.replace(Example(), rate=2.0)


def test_a_setting_keeps_its_description() -> None:
    """`ros_parameters` declares ROS parameters from it."""
    metadata = {f.name: f.metadata for f in dataclasses.fields(Example)}
    assert metadata["rate"] == {"description": "Rate [1/s]", "low": 0.0, "high": 1.0, "choices": ()}
    assert metadata["state"]["choices"] == ("vent", "hold")
