"""Checkpoints: the same continuation bit for bit, and no file that is not whole."""

from pathlib import Path

import numpy as np
import pytest

from bha_common.files import ModelFileError, load_versioned, save_versioned
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.checkpoint import KIND, VERSION, Checkpoint, load_checkpoint, save_checkpoint
from bha_goal_babbling.direction_sampling import DirectionTargets
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm

ARM = PlanarArm(4)
BODY = {"forward_model": "polynomial", "offset_spread": 0.03}


def babbler(directions: bool = False, **settings: object) -> GoalBabbler:
    """Return a learner on the arm."""
    home, limits = ARM.home(), np.full(4, 3.0)
    return GoalBabbler(
        GoalBabblerConfig.from_mapping({"path_steps": 7, "home_probability": 0.4, **settings}),
        DirectionTargets(0.03, 2) if directions else ARM.goal_grid(),
        home,
        ARM.forward(home),
        -limits,
        limits,
        np.random.default_rng(5),
    )


def run(learner: GoalBabbler, samples: int) -> np.ndarray:
    """Return the actions of the next samples, shape (samples, 4)."""
    actions = []
    for _ in range(samples):
        action = learner.ask()
        learner.tell(action, ARM.forward(action))
        actions.append(action)
    return np.array(actions)


@pytest.mark.parametrize("directions", [False, True])
@pytest.mark.parametrize("samples", [0, 1, 13, 14, 15, 100, 613])
@pytest.mark.parametrize("asked", [False, True])
def test_continues_bit_for_bit(tmp_path: Path, directions: bool, samples: int, asked: bool) -> None:
    """Wherever it is interrupted, also between question and answer, on the way home, or at once."""
    learner = babbler(directions)
    run(learner, samples)
    if asked:
        learner.ask()
    save_checkpoint(tmp_path / "a.npz", Checkpoint(learner, "arm", 3.5), robot="arm")
    twin = load_checkpoint(tmp_path / "a.npz", robot="arm").babbler
    np.testing.assert_array_equal(run(twin, 200), run(learner, 200))
    for name in ("movements", "samples", "local_maps"):
        assert getattr(twin, name) == getattr(learner, name)
    np.testing.assert_equal(twin.recent_error, learner.recent_error)
    assert twin.config == learner.config
    goals = ARM.goal_grid()
    np.testing.assert_array_equal(twin.inverse(goals), learner.inverse(goals))


def test_relative_weights_continue(tmp_path: Path) -> None:
    """The running mean of the efficiency is part of the state."""
    learner = babbler(efficiency="relative", efficiency_limit=2.0, noise_origin="home")
    run(learner, 50)
    save_checkpoint(tmp_path / "a.npz", Checkpoint(learner, "arm", 3.5), robot="arm")
    twin = load_checkpoint(tmp_path / "a.npz", robot=None).babbler
    np.testing.assert_array_equal(run(twin, 300), run(learner, 300))


@pytest.mark.parametrize("samples", [0, 3, 100, 1100])
@pytest.mark.parametrize("asked", [False, True])
def test_recursive_maps_continue(tmp_path: Path, samples: int, asked: bool) -> None:
    """Covariances, errors of goals, paths that were given up: all of it."""
    home, limits = ARM.home(), np.full(4, 3.0)
    learner = GoalBabbler(
        GoalBabblerConfig.rls(),
        ARM.goal_grid(),
        home,
        ARM.forward(home),
        -limits,
        limits,
        np.random.default_rng(5),
    )
    run(learner, samples)
    if asked:
        learner.ask()
    save_checkpoint(tmp_path / "a.npz", Checkpoint(learner), robot="arm")
    twin = load_checkpoint(tmp_path / "a.npz", robot="arm").babbler
    np.testing.assert_array_equal(run(twin, 200), run(learner, 200))
    goals = ARM.goal_grid()
    np.testing.assert_array_equal(twin.inverse(goals), learner.inverse(goals))


@pytest.mark.parametrize("samples", [0, 3, 200])
@pytest.mark.parametrize("asked", [False, True])
def test_body_models_continue(tmp_path: Path, samples: int, asked: bool) -> None:
    """Forward model, offsets and ends of ranges too, with what they remember of the way."""
    learner = babbler(**BODY)
    run(learner, samples)
    if asked:
        learner.ask()
    save_checkpoint(tmp_path / "a.npz", Checkpoint(learner), robot="arm")
    twin = load_checkpoint(tmp_path / "a.npz", robot="arm").babbler
    np.testing.assert_array_equal(run(twin, 200), run(learner, 200))
    goals = ARM.goal_grid()
    np.testing.assert_array_equal(twin.inverse(goals), learner.inverse(goals))


def test_checkpoints_from_before_newer_settings_still_load(tmp_path: Path) -> None:
    """What a file does not say is as it was then: the defaults."""
    learner = babbler()
    run(learner, 30)
    save_checkpoint(tmp_path / "a.npz", Checkpoint(learner, "arm", 3.5), robot="arm")
    file = load_versioned(tmp_path / "a.npz", kind=KIND, version=VERSION, robot="arm")
    config = file.settings["babbler"]["config"]
    config = {name: config[name] for name in ("path_steps", "home_probability", "noise_spread")}
    settings = {**file.settings, "babbler": {**file.settings["babbler"], "config": config}}
    save_versioned(
        tmp_path / "b.npz",
        kind=KIND,
        version=VERSION,
        robot="arm",
        arrays=file.arrays,
        settings=settings,
    )
    twin = load_checkpoint(tmp_path / "b.npz", robot="arm").babbler
    assert twin.config.forward_model == "none"
    np.testing.assert_array_equal(run(twin, 100), run(learner, 100))


def test_snapshot_does_not_change_with_the_learner() -> None:
    """What was taken is a copy."""
    learner = babbler()
    run(learner, 40)
    state = learner.state()
    expected = run(learner, 60)
    np.testing.assert_array_equal(run(GoalBabbler.restore(state), 60), expected)
    np.testing.assert_array_equal(run(GoalBabbler.restore(state), 60), expected)


def test_refuses_another_robot(tmp_path: Path) -> None:
    """What one robot has learned is not for another."""
    save_checkpoint(tmp_path / "a.npz", Checkpoint(babbler()), robot="arm")
    with pytest.raises(ModelFileError, match="arm"):
        load_checkpoint(tmp_path / "a.npz", robot="trunk")


@pytest.mark.parametrize("part", [0.0, 0.1, 0.5, 0.99])
def test_refuses_cut_files(tmp_path: Path, part: float) -> None:
    """A copy that did not finish is not read."""
    path = tmp_path / "a.npz"
    save_checkpoint(path, Checkpoint(babbler()), robot="arm")
    data = path.read_bytes()
    path.write_bytes(data[: int(part * len(data))])
    with pytest.raises(ModelFileError):
        load_checkpoint(path, robot="arm")


def test_refuses_altered_files(tmp_path: Path) -> None:
    """A flipped bit anywhere in the numbers is noticed."""
    learner = babbler()
    run(learner, 300)
    path = tmp_path / "a.npz"
    save_checkpoint(path, Checkpoint(learner), robot="arm")
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))
    with pytest.raises(ModelFileError):
        load_checkpoint(path, robot="arm")


def test_refuses_missing_files(tmp_path: Path) -> None:
    """The message names the file."""
    with pytest.raises(ModelFileError, match="nowhere"):
        load_checkpoint(tmp_path / "nowhere.npz", robot="arm")


@pytest.mark.parametrize("more", [{}, BODY], ids=["plain", "body"])
def test_refuses_files_that_hold_no_whole_learner(tmp_path: Path, more: dict[str, object]) -> None:
    """A well-formed file from which any one part is missing, or is of a wrong shape."""
    learner = babbler(**more)
    run(learner, 30)
    save_checkpoint(tmp_path / "a.npz", Checkpoint(learner, "arm", 3.5), robot="arm")
    whole = load_versioned(tmp_path / "a.npz", kind=KIND, version=VERSION, robot="arm")

    def refused(arrays: dict, settings: dict) -> None:
        path = tmp_path / "b.npz"
        save_versioned(
            path, kind=KIND, version=VERSION, robot="arm", arrays=arrays, settings=settings
        )
        with pytest.raises(ModelFileError, match="whole learner"):
            load_checkpoint(path, robot="arm")

    for name in whole.arrays:
        arrays = {key: array for key, array in whole.arrays.items() if key != name}
        refused(arrays, whole.settings)
        refused({**arrays, name: np.zeros((2, 3, 4))}, whole.settings)
    for name in [name for name, value in whole.settings.items() if value != {}]:
        settings = {key: value for key, value in whole.settings.items() if key != name}
        refused(whole.arrays, settings)
