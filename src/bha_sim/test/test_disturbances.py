"""What can be wrong with a robot: what is accepted, and how it is kept."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_common import bellows
from bha_sim.disturbances import Disturbances


def given_as(**values: Any) -> Disturbances:
    """Give disturbances what a user may give them."""
    return Disturbances(**values)


def test_by_default_nothing_is_given_as():
    assert str(Disturbances()) == "none"
    for field in dataclasses.fields(Disturbances):
        assert not np.any(getattr(Disturbances(), field.name)), field.name


@given(st.floats(0.0, 0.5))
def test_one_value_three_nine_and_names_are_all_kept_as_nine(value):
    assert given_as(softening=value).softening == (value,) * 9
    assert given_as(softening=[value, 0, 0.5]).softening == (value,) * 3 + (0.0,) * 3 + (0.5,) * 3
    nine = np.linspace(0.0, value, 9)
    assert given_as(softening=nine).softening == tuple(nine)
    named = given_as(softening={bellows.NAMES[4]: value})
    assert named.softening == (0.0,) * 4 + (value,) + (0.0,) * 4


def test_stuck_valves_by_name():
    stuck = given_as(stuck_valves={"bellows_3_3": True}).stuck_valves
    assert stuck == (False,) * 8 + (True,)


def test_it_can_be_compared_and_goes_through_a_mapping():
    ill = given_as(payload=0.2, leak=[0.1, 0.2, 0.3])
    assert Disturbances(**dataclasses.asdict(ill)) == ill != Disturbances(payload=0.2)


def test_it_tells_what_is_given_as():
    ill = given_as(payload=0.2, leak={"bellows_2_1": 0.3}, stuck_valves=[True] + [False] * 8)
    assert str(ill) == "payload 0.2; leak bellows_2_1 0.3; stuck_valves bellows_1_1"


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"payload": -0.1}, r"payload is -0\.1; valid is 0\.0 to 1\.0: Mass"),
        ({"payload": float("nan")}, "payload is nan"),
        ({"payload": True}, "payload must be a number, got True"),
        ({"payload": "heavy"}, "payload must be a number, got 'heavy'"),
        ({"softening": 0.6}, r"softening holds 0\.6; valid is 0\.0 to 0\.5"),
        ({"leak": [0.0] * 8 + [-1.0]}, r"leak holds -1\.0"),
        ({"leak": [1.0, 2.0]}, r"leak must be one value, 3 .* or 9 .*, got \[1\.0, 2\.0\]"),
        ({"leak": "much"}, "leak must be one value"),
        ({"leak": None}, "leak must be one value"),
        ({"leak": [True] * 9}, "leak must hold a finite number, got True"),
        ({"leak": ["a"] * 9}, "leak must hold a finite number, got 'a'"),
        ({"leak": {"bellows_4_1": 1.0}}, "there is no bellows_4_1; the bellows are bellows_1_1"),
        ({"sensor_shift": 0.06}, r"sensor_shift holds 0\.06"),
        ({"sensor_drift": [float("inf")] * 9}, "sensor_drift holds inf"),
        ({"range_lost_above": 0.5}, r"range_lost_above holds 0\.5"),
        ({"stuck_valves": [1] * 9}, "stuck_valves must hold true or false, got 1"),
    ],
)
def test_what_cannot_be_is_named(wrong: dict[str, Any], message: str):
    with pytest.raises(ValueError, match=message):
        Disturbances(**wrong)
