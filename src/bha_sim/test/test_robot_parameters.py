"""The parameter file, its messages, and the drawing of robots."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_sim.errors import RobotParameterError
from bha_sim.robot_parameters import RobotParameters, draw_robot, load_parameters

FILE = Path(__file__).resolve().parents[1] / "config" / "robot.yaml"


@pytest.fixture
def data() -> dict[str, Any]:
    return copy.deepcopy(yaml.safe_load(FILE.read_text(encoding="utf-8")))


def test_default_file_is_the_one_of_the_package():
    default, named = load_parameters(), load_parameters(FILE)
    np.testing.assert_array_equal(default.bellows.stiffness, named.bellows.stiffness)
    assert default.max_time_step == named.max_time_step


def test_every_number_in_the_file_has_a_unit_and_a_source():
    for number, line in enumerate(FILE.read_text(encoding="utf-8").splitlines(), 1):
        key, _, rest = line.partition(":")
        if line.lstrip().startswith("#") or not rest.split("#")[0].strip():
            continue
        _, hash_sign, comment = rest.partition("#")
        assert hash_sign, f"line {number}: {key.strip()} has no comment"
        assert comment.strip().startswith("["), f"line {number}: {key.strip()} has no unit"
        assert comment.rstrip().endswith(")"), f"line {number}: {key.strip()} has no source"


def test_one_number_a_segment_is_expanded_to_its_bellows(data):
    data["bellows"]["stiffness"] = [100.0, 200.0, 300.0]
    stiffness = RobotParameters.from_mapping(data).bellows.stiffness
    np.testing.assert_array_equal(stiffness, np.repeat([100.0, 200.0, 300.0], 3))


def test_arrays_are_read_only():
    parameters = load_parameters()
    for array in (
        parameters.trunk.bellows_radii,
        parameters.bellows.areas,
        parameters.relaxation.shares,
        parameters.hysteresis.slips,
        parameters.potentiometers.gains,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


@pytest.mark.parametrize(
    ("section", "field", "value", "message"),
    [
        ("trunk", "segment_masses", -1.0, r"trunk\.segment_masses must be above 0"),
        ("trunk", "tool_length", "long", r"trunk\.tool_length must be a number"),
        ("trunk", "discs_per_segment", 2.5, r"trunk\.discs_per_segment must be a whole number"),
        ("trunk", "discs_per_segment", True, r"trunk\.discs_per_segment must be a whole number"),
        ("bellows", "areas", float("nan"), r"bellows\.areas must be above 0"),
        ("bellows", "stiffness", [1.0, 2.0], r"bellows\.stiffness must be one number or .*\(9,\)"),
        ("bellows", "stiffness", {"a": 1}, r"bellows\.stiffness must be numbers of shape"),
        ("relaxation", "time_constants", 3.0, r"relaxation\.time_constants must be a list"),
        ("relaxation", "shares", [0.1, 0.2], r"relaxation\.shares must be .*\(3, 9\)"),
        ("hysteresis", "slips", [0.001, 0.0, 0.1], r"hysteresis\.slips must be above 0 everywhere"),
        ("pneumatics", "dead_time", -0.1, r"pneumatics\.dead_time must be at least 0"),
        ("pneumatics", "regulator_play", 2e5, r"regulator_play must be below max_pressure, 130000"),
        ("bellows", "stiffness", True, r"bellows\.stiffness must be numbers"),
        ("bellows", "stiffness", "soft", r"bellows\.stiffness must be numbers"),
        ("pneumatics", "max_pressure", float("inf"), r"pneumatics\.max_pressure must be above 0"),
        ("potentiometers", "noise", None, r"potentiometers\.noise must be a number"),
        ("potentiometers", "drift_time", 0.0, r"potentiometers\.drift_time must be above 0"),
        ("variation", "slip", 1.0, r"variation\.slip must be below 1"),
    ],
)
def test_an_invalid_number_is_named(data, section, field, value, message):
    data[section][field] = value
    with pytest.raises(RobotParameterError, match=message):
        RobotParameters.from_mapping(data)


def test_a_missing_field_is_named(data):
    del data["bellows"]["areas"]
    with pytest.raises(RobotParameterError, match=r"bellows\.areas is missing"):
        RobotParameters.from_mapping(data)


def test_an_unknown_field_is_named_beside_the_valid_ones(data):
    data["bellows"]["area"] = 1e-3
    with pytest.raises(RobotParameterError, match=r"bellows\.area is unknown; valid .* areas"):
        RobotParameters.from_mapping(data)


def test_a_section_that_is_no_mapping_is_named(data):
    data["trunk"] = 3
    with pytest.raises(RobotParameterError, match="trunk must map names to values"):
        RobotParameters.from_mapping(data)


def test_messages_about_a_file_begin_with_its_name(tmp_path):
    with pytest.raises(RobotParameterError, match=r"nothing\.yaml: cannot be read"):
        load_parameters(tmp_path / "nothing.yaml")
    broken = tmp_path / "broken.yaml"
    broken.write_text("trunk: [1, 2", encoding="utf-8")
    with pytest.raises(RobotParameterError, match=r"broken\.yaml: not YAML"):
        load_parameters(broken)
    broken.write_text("", encoding="utf-8")
    with pytest.raises(RobotParameterError, match=r"broken\.yaml: the file must map"):
        load_parameters(broken)


@given(st.integers(0, 2**32))
@settings(max_examples=30, deadline=None)
def test_a_drawn_robot_lies_within_the_variation(seed):
    mean = load_parameters()
    robot, width = draw_robot(mean, seed), mean.variation
    for drawn, nominal, spread in (
        (robot.bellows.stiffness, mean.bellows.stiffness, width.stiffness),
        (robot.bellows.areas, mean.bellows.areas, width.area),
        (robot.relaxation.shares, mean.relaxation.shares, width.relaxation),
        (robot.hysteresis.shares, mean.hysteresis.shares, width.hysteresis),
        (robot.trunk.segment_masses, mean.trunk.segment_masses, width.mass),
        (robot.trunk.torsion_stiffness, mean.trunk.torsion_stiffness, width.torsion),
        (robot.trunk.tool_mass, mean.trunk.tool_mass, width.mass),
        (robot.bellows.hardening, mean.bellows.hardening, width.hardening),
        (robot.relaxation.time_constants, mean.relaxation.time_constants, width.relaxation),
        (robot.hysteresis.slip_factors, 1.0, width.slip),
        (robot.pneumatics.fill_time_constant, mean.pneumatics.fill_time_constant, width.lag),
        (robot.pneumatics.vent_time_constant, mean.pneumatics.vent_time_constant, width.lag),
        (robot.potentiometers.gains, mean.potentiometers.gains, width.sensor_gain),
    ):
        assert np.all(np.abs(drawn / nominal - 1.0) <= spread)
    assert np.all(np.abs(robot.potentiometers.offsets) <= width.sensor_offset)


def test_robots_differ_in_all_that_makes_a_robot_by_up_to_15_percent():
    """Stiffnesses, areas, friction, creep, masses: each drawn, and the width of it made use of."""
    mean = load_parameters()
    robots = [draw_robot(mean, seed) for seed in range(1000, 1040)]

    def factors(read: Callable[[RobotParameters], Any]) -> np.ndarray:
        return np.array([read(robot) / read(mean) for robot in robots]) - 1.0

    reads: dict[str, Callable[[RobotParameters], Any]] = {
        "stiffness": lambda robot: robot.bellows.stiffness,
        "area": lambda robot: robot.bellows.areas,
        "friction": lambda robot: robot.hysteresis.shares,
        "creep": lambda robot: robot.relaxation.shares,
        "creep times": lambda robot: robot.relaxation.time_constants,
        "segment masses": lambda robot: robot.trunk.segment_masses,
        "tool mass": lambda robot: robot.trunk.tool_mass,
    }
    for name, read in reads.items():
        drawn = factors(read).reshape(len(robots), -1)
        assert 0.09 < np.abs(drawn).max() <= 0.15, name
        # Uniform about the mean: every bellows, branch and segment by itself.
        assert np.all(drawn.std(axis=0) > 0.03), name
        assert np.abs(drawn.mean()) < 0.04, name
        across = np.corrcoef(drawn.T) if drawn.shape[1] > 1 else np.eye(1)
        assert np.abs(across - np.eye(len(across))).max() < 0.7, name
    offsets = np.array([robot.potentiometers.offsets for robot in robots])
    assert 0.0025 < np.abs(offsets).max() <= mean.variation.sensor_offset
    assert np.all(offsets.std(axis=0) > 0.001)


def test_the_pieces_of_a_drawn_bellows_keep_its_stiffness():
    bellows = draw_robot(load_parameters(), 5).bellows
    pieces = bellows.piece_stiffness
    assert pieces.shape == (9, 3)
    assert np.ptp(pieces / bellows.stiffness[:, None]) > 0.1
    np.testing.assert_allclose(1.0 / np.sum(1.0 / pieces, axis=1), bellows.stiffness, rtol=1e-14)


def test_a_seed_names_a_robot():
    mean = load_parameters()
    first, again, other = draw_robot(mean, 3), draw_robot(mean, 3), draw_robot(mean, 4)
    np.testing.assert_array_equal(first.bellows.stiffness, again.bellows.stiffness)
    np.testing.assert_array_equal(first.hysteresis.slip_factors, again.hysteresis.slip_factors)
    assert not np.any(first.bellows.stiffness == other.bellows.stiffness)
