"""The forward model: least squares where the answer is known, lags, change, snapshots."""

from itertools import combinations_with_replacement

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_goal_babbling import forward_model
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.forward_model import _MEMORY as MEMORY
from bha_goal_babbling.forward_model import _PRIOR as PRIOR
from bha_goal_babbling.forward_model import ForwardModel
from bha_goal_babbling.saved_state import SavedState


def powers(z: FloatArray) -> FloatArray:
    """Return every product of up to three entries of the rows of z, shape (N, number)."""
    columns = [
        np.prod(z[:, list(chosen)], axis=1)
        for degree in range(4)
        for chosen in combinations_with_replacement(range(z.shape[1]), degree)
    ]
    return np.column_stack(columns)


def degrees(size: int) -> list[int]:
    """Return the degree of every one of the columns of `powers`."""
    return [
        degree for degree in range(4) for _ in combinations_with_replacement(range(size), degree)
    ]


class Cubic:
    """A random polynomial of third degree about a random home."""

    def __init__(self, m: int, n: int, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.home = rng.uniform(-1.0, 1.0, m)
        count = powers(np.zeros((1, m))).shape[1]
        self.parameters = rng.standard_normal((count, n))

    def __call__(self, action: FloatArray) -> FloatArray:
        outcome: FloatArray = powers(np.atleast_2d(action - self.home)) @ self.parameters
        return outcome[0] if action.ndim == 1 else outcome


def learn(model: ForwardModel, action: FloatArray, outcome: FloatArray, rest: bool = True) -> None:
    if rest:
        model.pause()
    features, expected, _ = model.expect(action)
    model.learn(features, outcome - expected)


def test_begins_with_home_everywhere() -> None:
    model = ForwardModel(np.array([0.1, 0.2]), np.array([0.3, 0.4, 0.5]), 0.01)
    np.testing.assert_array_equal(model.predict(np.array([5.0, -5.0])), [0.3, 0.4, 0.5])
    np.testing.assert_array_equal(model.jacobian(np.array([5.0, -5.0])), np.zeros((3, 2)))


def test_is_batch_ridge_regression_about_home(monkeypatch: pytest.MonkeyPatch) -> None:
    """(P0^-1 + A'A / r) W = P0^-1 W0 + A'X / r, where process noise does not add up."""
    monkeypatch.setattr(forward_model, "_MEMORY", 1e9)
    rng = np.random.default_rng(1)
    home_action, home_outcome, noise = rng.standard_normal(3), rng.standard_normal(2), 0.3
    model = ForwardModel(home_action, home_outcome, noise)
    actions, outcomes = rng.uniform(-1.5, 1.5, (60, 3)), rng.standard_normal((60, 2))
    for action, outcome in zip(actions, outcomes, strict=True):
        learn(model, action, outcome)
    features = powers(actions - home_action)
    size = features.shape[1]
    prior = np.diag(PRIOR[degrees(3)] ** -2.0)
    information = prior + features.T @ features / noise**2
    first = np.zeros((size, 2))
    first[0] = home_outcome
    expected = np.linalg.solve(information, prior @ first + features.T @ outcomes / noise**2)
    asked = rng.uniform(-1.5, 1.5, (20, 3))
    answers = [model.predict(action) for action in asked]
    np.testing.assert_allclose(answers, powers(asked - home_action) @ expected, atol=1e-9)
    for action, row in zip(asked, powers(asked - home_action), strict=True):
        model.pause()
        assert model.expect(action)[2] == pytest.approx(row @ np.linalg.solve(information, row))


def test_noise_of_a_few_examples_is_not_continued_beyond_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A straight robot seen near home, asked far from it: less bends than with an even prior."""

    def miss() -> float:
        rng = np.random.default_rng(7)
        misses = []
        for _ in range(50):
            model = ForwardModel(np.zeros(2), np.zeros(1), 0.05)
            for action in rng.uniform(-0.4, 0.4, (15, 2)):
                learn(model, action, action[:1] + 0.05 * rng.standard_normal(1))
            misses.append(abs(float(model.predict(np.ones(2))[0]) - 1.0))
        return float(np.mean(misses))

    narrow = miss()
    monkeypatch.setattr(forward_model, "_PRIOR", np.full(4, 2.0))
    assert narrow < 0.7 * miss()


def test_is_a_kalman_filter_of_random_walks() -> None:
    """Step by step, in the plain form of the textbook, process noise and lags included."""
    rng = np.random.default_rng(2)
    noise = 0.1
    model = ForwardModel(np.zeros(2), np.zeros(1), noise)
    size = 10 + 4
    parameters = np.zeros((size, 1))
    covariance = np.diag(PRIOR[[*degrees(2), 1, 1, 1, 1]] ** 2)
    before: list[FloatArray] = []
    for _ in range(400):
        action, outcome = rng.uniform(-1, 1, 2), rng.standard_normal(1)
        step = action - before[-1] if before else np.zeros(2)
        turn = action - 2 * before[-1] + before[-2] if len(before) > 1 else np.zeros(2)
        row = np.concatenate([powers(action[np.newaxis])[0], step, turn])
        features, expected, unknown = model.expect(action)
        np.testing.assert_allclose(expected, row @ parameters, atol=1e-9)
        assert unknown == pytest.approx(row @ covariance @ row)
        gain = covariance @ row / (noise**2 + row @ covariance @ row)
        parameters += np.outer(gain, outcome - row @ parameters)
        covariance -= np.outer(gain, row @ covariance)
        covariance += noise**2 / MEMORY**2 * np.eye(size)
        model.learn(features, outcome - expected)
        before.append(action)
    assert model.variance == pytest.approx(noise**2)


@pytest.mark.parametrize(("m", "n"), [(1, 1), (2, 3), (4, 2)])
def test_finds_a_cubic_exactly(m: int, n: int) -> None:
    robot, rng = Cubic(m, n, 3), np.random.default_rng(4)
    model = ForwardModel(robot.home, np.zeros(n), 1e-4)
    for action in robot.home + rng.uniform(-1, 1, (600, m)):
        learn(model, action, robot(action))
    asked = robot.home + rng.uniform(-1, 1, (50, m))
    answers = np.array([model.predict(action) for action in asked])
    np.testing.assert_allclose(answers, robot(asked), atol=1e-5)


@settings(max_examples=30, deadline=None)
@given(m=st.integers(1, 5), n=st.integers(1, 3), seed=st.integers(0, 1000))
def test_the_slope_is_that_of_the_prediction(m: int, n: int, seed: int) -> None:
    """Against central differences, for whatever parameters."""
    robot, rng = Cubic(m, n, seed), np.random.default_rng(seed)
    model = ForwardModel(robot.home, np.zeros(n), 0.1)
    for action in robot.home + rng.uniform(-1, 1, (30, m)):
        learn(model, action, robot(action), rest=False)
    action, h = robot.home + rng.uniform(-1, 1, m), 1e-5
    numerical = [
        (model.predict(action + h * e) - model.predict(action - h * e)) / (2 * h) for e in np.eye(m)
    ]
    np.testing.assert_allclose(model.jacobian(action), np.transpose(numerical), atol=1e-6)


def test_tells_how_its_variance_changes_nearby() -> None:
    """That of phi' P phi, where phi changes in proportion to the action."""
    rng = np.random.default_rng(3)
    home = rng.standard_normal(3)
    model = ForwardModel(home, np.zeros(2), 0.3)
    for _ in range(30):
        learn(model, home + rng.uniform(-1.0, 1.0, 3), rng.standard_normal(2))
    action = home + rng.uniform(-1.0, 1.0, 3)

    def variance(at: FloatArray) -> float:
        model.pause()
        return model.expect(at)[2]

    rise, curvature = model.variance_near(action)
    small = 1e-6 * np.eye(3)
    slope = [(variance(action + e) - variance(action - e)) / 2e-6 for e in small]
    np.testing.assert_allclose(2.0 * rise, slope, atol=1e-6)
    size = powers(np.zeros((1, 3))).shape[1]
    covariance = model.state().arrays["covariance"][:size, :size]
    z = action - home
    slopes = np.array([(powers((z + e)[None]) - powers((z - e)[None]))[0] / 2e-6 for e in small])
    np.testing.assert_allclose(curvature, slopes @ covariance @ slopes.T, atol=1e-6)
    assert (np.linalg.eigvalsh(curvature) > 0.0).all()


def test_lags_are_told_apart_from_where_the_robot_is() -> None:
    """An outcome that trails velocity and acceleration: at rest the function itself is left."""
    robot, rng = Cubic(2, 2, 5), np.random.default_rng(6)
    slow, bent = rng.standard_normal((2, 2, 2))
    model = ForwardModel(robot.home, np.zeros(2), 1e-3)
    actions = robot.home + np.cumsum(rng.uniform(-0.3, 0.3, (3000, 2)), axis=0)
    actions = robot.home + np.sin(actions - robot.home)  # a walk that turns round
    for t in range(2, len(actions)):
        q, q1, q2 = actions[t], actions[t - 1], actions[t - 2]
        if t == 2:  # where it came from is known to the model as well
            model.expect(q2)
            model.expect(q1)
        learn(model, q, robot(q) + slow @ (q - q1) + bent @ (q - 2 * q1 + q2), rest=False)
    answers = np.array([model.predict(action) for action in actions[::100]])
    np.testing.assert_allclose(answers, robot(actions[::100]), atol=1e-3)
    q, q1, q2 = actions[-1] + 0.2, actions[-1], actions[-2]
    np.testing.assert_allclose(
        model.expect(q)[1], robot(q) + slow @ (q - q1) + bent @ (q - 2 * q1 + q2), atol=1e-2
    )


@pytest.mark.parametrize("held", [3, 5])
def test_lags_vanish_at_rest(held: int) -> None:
    """After three times the same action an example is expected where the action is predicted."""
    rng = np.random.default_rng(7)
    model = ForwardModel(np.zeros(2), np.zeros(2), 0.1)
    for _ in range(50):
        learn(model, rng.uniform(-1, 1, 2), rng.standard_normal(2), rest=False)
    action = np.array([0.4, -0.7])
    features = [model.expect(action)[0] for _ in range(held)]
    assert np.abs(features[0][-4:]).min() > 0.0
    np.testing.assert_array_equal(features[-1][-4:], 0.0)
    np.testing.assert_allclose(model.expect(action)[1], model.predict(action), rtol=1e-12)
    model.pause()
    np.testing.assert_array_equal(model.expect(-action)[0][-4:], 0.0)


def test_follows_a_robot_that_changes() -> None:
    """It would say the mean of both robots, half of the change off, were all examples equal."""
    rng = np.random.default_rng(8)
    old, new = Cubic(2, 1, 9), Cubic(2, 1, 10)
    new.home = old.home
    model = ForwardModel(old.home, np.zeros(1), 0.05)
    asked = old.home + rng.uniform(-1, 1, (200, 2))

    def error(robot: Cubic) -> float:
        answers = np.array([model.predict(action) for action in asked])
        return float(np.sqrt(np.mean((answers - robot(asked)) ** 2)))

    for robot in (old, new):
        for action in old.home + rng.uniform(-1, 1, (15_000, 2)):
            learn(model, action, robot(action) + 0.05 * rng.standard_normal(1))
    assert error(old) > 1.0
    assert error(new) < 0.15 * error(old)


def test_the_covariance_stays_one() -> None:
    """Symmetric to the last bit and positive definite, on a sheet that hides most directions."""
    rng = np.random.default_rng(11)
    model = ForwardModel(np.zeros(9), np.zeros(3), 0.01)
    sheet = rng.standard_normal((3, 9)) / 3.0
    for _ in range(4000):
        action = np.tanh(rng.standard_normal(3) @ sheet) + 0.01 * rng.standard_normal(9)
        learn(model, action, np.tanh(action[:3]), rest=False)
    covariance = model.state().arrays["covariance"]
    np.testing.assert_array_equal(covariance, covariance.T)
    eigenvalues = np.linalg.eigvalsh(covariance)
    assert eigenvalues[0] > 0.0
    assert eigenvalues[-1] < 2.0 * PRIOR.max() ** 2


@pytest.mark.parametrize("examples", [0, 1, 2, 50])
def test_continues_bit_for_bit(examples: int) -> None:
    """Also on the way, which the last two actions belong to."""
    rng = np.random.default_rng(12)
    model = ForwardModel(np.array([0.3, 0.2]), np.zeros(2), 0.0173)
    data = rng.uniform(-1, 1, (examples + 40, 4))
    for row in data[:examples]:
        learn(model, row[:2], row[2:], rest=False)
    twin = ForwardModel.restore(SavedState().joined(model=model.state()).part("model"))
    for row in data[examples:]:
        for each in (model, twin):
            learn(each, row[:2], row[2:], rest=False)
        np.testing.assert_array_equal(model.predict(row[2:]), twin.predict(row[2:]))
    for name, array in model.state().arrays.items():
        np.testing.assert_array_equal(array, twin.state().arrays[name])
    assert model.state().settings == twin.state().settings


def test_a_snapshot_does_not_change_with_the_model() -> None:
    model = ForwardModel(np.zeros(2), np.zeros(2), 0.1)
    state = model.state()
    before = {name: array.copy() for name, array in state.arrays.items()}
    learn(model, np.ones(2), np.ones(2))
    for name, array in before.items():
        np.testing.assert_array_equal(state.arrays[name], array)


@pytest.mark.parametrize(
    "broken",
    [
        {"home": np.zeros((2, 1))},
        {"home": np.zeros(3)},
        {"home": np.array([0.0, np.nan])},
        {"parameters": np.zeros(14)},
        {"parameters": np.zeros((13, 2))},
        {"parameters": np.zeros((0, 2))},
        {"parameters": np.full((14, 2), np.inf)},
        {"covariance": np.eye(13)},
        {"covariance": np.zeros((14, 14, 1))},
        {"covariance": np.full((14, 14), np.nan)},
        {"history": np.zeros((3, 2))},
        {"history": np.zeros((2, 3))},
        {"history": np.zeros(2)},
        {"history": np.full((1, 2), np.nan)},
        {"variance": -1.0},
        {"variance": 0.0},
        {"variance": float("nan")},
    ],
    ids=lambda broken: f"{next(iter(broken))}-{np.shape(next(iter(broken.values())))}",
)
def test_refuses_broken_snapshots(broken: dict[str, FloatArray | float]) -> None:
    whole = ForwardModel(np.zeros(2), np.zeros(2), 0.1).state()
    arrays = {name: broken.get(name, array) for name, array in whole.arrays.items()}
    settings = {name: broken.get(name, value) for name, value in whole.settings.items()}
    with pytest.raises(GoalBabblingError):
        ForwardModel.restore(SavedState(arrays, settings))
    assert ForwardModel.restore(whole).predict(np.zeros(2)).shape == (2,)
