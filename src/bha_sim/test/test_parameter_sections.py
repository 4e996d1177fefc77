"""What the sections make of the values they are given."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bha_sim.errors import RobotParameterError
from bha_sim.parameter_sections import Bellows, Relaxation
from bha_sim.robot_parameters import load_parameters


def test_one_share_a_branch_holds_for_all_bellows():
    relaxation = Relaxation(time_constants=[1.0, 10.0], shares=[0.1, 0.2])  # type: ignore[arg-type]
    np.testing.assert_array_equal(relaxation.shares, [[0.1] * 9, [0.2] * 9])


def test_as_many_branches_as_segments_are_not_taken_for_segments():
    relaxation = load_parameters().relaxation
    assert len(relaxation.time_constants) == 3
    np.testing.assert_array_equal(relaxation.shares, relaxation.shares[:, :1].repeat(9, axis=1))


def test_shares_a_segment_are_a_row_of_three():
    relaxation = Relaxation(time_constants=[1.0], shares=[[0.1, 0.2, 0.3]])  # type: ignore[arg-type]
    np.testing.assert_array_equal(relaxation.shares, [np.repeat([0.1, 0.2, 0.3], 3)])


def test_a_section_copies_what_it_is_given():
    stiffness = np.full(9, 500.0)
    bellows = Bellows(
        stiffness=stiffness,
        areas=stiffness,
        hardening=stiffness,
        hardening_extension=stiffness,
        disc_profile=np.ones(3),
    )
    stiffness[0] = 0.0
    assert bellows.stiffness[0] == 500.0


def test_lists_must_fit_the_number_of_discs():
    parameters = load_parameters()
    four = replace(parameters.bellows, disc_profile=np.ones(4))
    with pytest.raises(RobotParameterError, match=r"bellows\.disc_profile must have 3 entries"):
        replace(parameters, bellows=four)
    with pytest.raises(RobotParameterError, match=r"bellows\.disc_factors must be .*\(9, 3\)"):
        replace(parameters.bellows, disc_factors=np.ones((9, 4)))
    slips = replace(parameters.hysteresis, slip_factors=np.ones((3, 36)))
    with pytest.raises(RobotParameterError, match=r"slip_factors must have 27 columns"):
        replace(parameters, hysteresis=slips)


def test_pieces_follow_the_profile():
    parameters = load_parameters().bellows
    pieces = replace(parameters, disc_profile=[1.0, 1.0, 2.0], stiffness=100.0).piece_stiffness
    # 1/(1/250 + 1/250 + 1/500) = 100
    np.testing.assert_allclose(pieces, np.tile([250.0, 250.0, 500.0], (9, 1)))
