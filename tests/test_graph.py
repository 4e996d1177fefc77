"""The whole chain over ROS: identify, explore, reach, save and load, as its users do."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from bha_interfaces.action import Babble, Identify, ReachGoal
from bha_interfaces.msg import LearningStatus
from bha_interfaces.srv import SetGoal
from geometry_msgs.msg import Point, PointStamped

from bha_bringup.robot_connection import RobotError
from bha_common.files import ModelFileError
from bha_goal_babbling.checkpoint import load_checkpoint
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from running_graph import GOAL, ROBOT, RunningGraph, StartGraph

pytestmark = pytest.mark.graph


def distance_aside(tip: np.ndarray, goal: np.ndarray) -> float:
    return float(np.linalg.norm(tip[:2] - goal[:2]))


@pytest.fixture(scope="class")
def new_graph(start_shared_graph: StartGraph) -> RunningGraph:
    return start_shared_graph(models=())


@pytest.fixture(scope="class")
def trained_graph(start_shared_graph: StartGraph) -> RunningGraph:
    return start_shared_graph()


def drops(graph: RunningGraph) -> dict[str, str]:
    """What each node has dropped on each topic, targets left out.

    A target may be on its way while babbling begins.
    """
    return {
        f"{name}: {key}": value
        for name in graph.names
        for key, value in graph.fresh(name).items()
        if key.endswith("dropped") and key != "target dropped"
    }


@pytest.fixture(scope="class")
def drops_at_start(trained_graph: RunningGraph) -> dict[str, str]:
    """Of messages that came while the nodes were finding one another."""
    return drops(trained_graph)


class TestFromNothing:
    """A robot of which nothing is known yet; the tests go on where the one before ended."""

    def test_each_node_says_what_it_lacks(self, new_graph: RunningGraph) -> None:
        new_graph.wait_robot(1.0)
        assert "call ~/identify" in new_graph.fresh("pressure_ctrl")["summary"]
        assert new_graph.fresh("learner")["mode"] == LearningStatus.IDLE
        assert new_graph.pressures().max() < 1e3
        with pytest.raises(RobotError, match="nothing is learned yet"):
            new_graph.client.set_goal(GOAL)
        for node in ("pressure_ctrl", "learner"):
            with pytest.raises(RobotError, match=r"identify|babble"):
                new_graph.client.save(node)

    def test_it_does_not_babble_without_an_equilibrium_model(self, new_graph: RunningGraph) -> None:
        with pytest.raises(RobotError, match="from the command on average"):
            new_graph.client.babble(60.0)
        assert "identify" in new_graph.fresh("learner")["summary"]

    def test_identify_learns_the_equilibrium_model(self, new_graph: RunningGraph) -> None:
        seen = []
        result = new_graph.client.identify(20, seen.append)
        assert result.success
        assert result.samples == 20
        assert result.pressure_error < 2e4
        counts = [feedback.collected for feedback in seen]
        assert counts == sorted(counts)
        assert {feedback.requested for feedback in seen} == {20}
        assert new_graph.fresh("pressure_ctrl")["model"] == "20 samples"

    def test_babble_explores_for_the_time_asked_for(self, new_graph: RunningGraph) -> None:
        seen: list[Babble.Feedback] = []
        result = new_graph.client.babble(60.0, progress=seen.append)
        assert result.success
        assert result.status.exploration_time == 60.0
        assert result.status.samples == 120 - 30 - 1  # after 15 s of homing; the first one starts
        assert result.status.movements > 5
        assert result.status.local_models >= 2
        modes = [feedback.status.mode for feedback in seen]
        assert modes[0] == LearningStatus.HOMING
        assert LearningStatus.BABBLING in modes
        assert seen[-1].elapsed <= 60.0

    def test_both_models_are_saved_and_can_be_loaded(
        self, new_graph: RunningGraph, tmp_path: Path
    ) -> None:
        model_file, checkpoint_file = tmp_path / "model.npz", tmp_path / "checkpoint.npz"
        assert new_graph.client.save("pressure_ctrl", str(model_file)) == str(model_file)
        assert new_graph.client.save("learner", str(checkpoint_file)) == str(checkpoint_file)
        assert EquilibriumModel.load(model_file, ROBOT).samples == 20
        stored = load_checkpoint(checkpoint_file, robot=ROBOT, task="2d")
        assert stored.exploration_time == 60.0
        assert stored.babbler.samples == 89
        with pytest.raises(ModelFileError, match="belongs to robot"):
            load_checkpoint(checkpoint_file, robot="bha_sim_1")
        assert "loaded" in new_graph.client.load("pressure_ctrl", str(model_file))
        assert "loaded" in new_graph.client.load("learner", str(checkpoint_file))

    def test_more_babbling_goes_on_from_what_is_learned(self, new_graph: RunningGraph) -> None:
        result = new_graph.client.babble(30.0)
        assert result.status.exploration_time == 90.0
        assert result.status.samples > 89

    def test_restart_forgets_what_is_learned(self, new_graph: RunningGraph) -> None:
        result = new_graph.client.babble(20.0, restart=True)
        assert result.status.exploration_time == 20.0
        assert result.status.samples < 12


class TestTrained:
    """A robot that was identified and has explored; every test leaves it ready for the next."""

    @pytest.fixture
    def graph(self, trained_graph: RunningGraph) -> Iterator[RunningGraph]:
        yield trained_graph
        trained_graph.wait(
            lambda: (
                trained_graph.client.status.mode in (LearningStatus.IDLE, LearningStatus.HOLDING)
            ),
            "the learner at rest",
        )

    @pytest.mark.usefixtures("drops_at_start")
    def test_what_was_learned_is_there_from_the_start(self, graph: RunningGraph) -> None:
        graph.wait(lambda: graph.client.status is not None, "a learning_status")
        assert graph.client.status.exploration_time == 180.0
        assert graph.client.status.task == "2d"
        assert graph.client.status.samples > 300

    def test_reach_goes_to_the_goal(self, graph: RunningGraph) -> None:
        seen: list[ReachGoal.Feedback] = []
        result = graph.client.reach(GOAL, timeout=60.0, progress=seen.append)
        assert result.success
        assert result.message == "at rest"
        assert result.error == pytest.approx(distance_aside(graph.tip(), GOAL), abs=2e-3)
        assert result.error < 0.05  # 3 minutes of exploration
        assert 3.0 <= result.duration < 60.0
        assert [f.elapsed for f in seen] == sorted(f.elapsed for f in seen)

    def test_feedback_reaches_more_exactly(self, graph: RunningGraph) -> None:
        goal = np.array([-0.12, 0.08, 0.78])
        result = graph.client.reach(goal, feedback=True, timeout=60.0)
        assert result.error < 0.01
        assert distance_aside(graph.tip(), goal) < 0.01

    def test_a_tolerance_that_is_not_met_is_no_success(self, graph: RunningGraph) -> None:
        result = graph.client.reach(np.array([0.2, -0.2, 0.7]), tolerance=1e-6, timeout=5.0)
        assert not result.success
        assert result.message == "not at rest within the time"
        assert result.duration == 5.0

    @pytest.mark.parametrize("node", ["learner", "cartesian_feedback"])
    def test_a_service_call_alone_moves_the_robot(self, graph: RunningGraph, node: str) -> None:
        goal = np.array([0.0, 0.2, 0.75]) if node == "learner" else np.array([0.15, 0.0, 0.77])
        # What `ros2 service call` sends: neither stamp nor frame are filled in.
        request = SetGoal.Request(goal=PointStamped(point=Point(x=goal[0], y=goal[1], z=goal[2])))
        assert distance_aside(graph.tip(), goal) > 0.06
        response = graph.client.call(SetGoal, f"{node}/set_goal", request)
        assert response.accepted, response.message
        assert "on the way" in response.message
        graph.wait(lambda: distance_aside(graph.tip(), goal) < 0.05, "the tip at the goal")

    def test_a_goal_overtakes_the_one_before(self, graph: RunningGraph) -> None:
        first = ReachGoal.Goal(goal=PointStamped(point=Point(x=-0.2, y=0.0, z=0.7)), timeout=30.0)
        handle = graph.begin_reach("learner", first)
        assert handle.accepted
        graph.client.set_goal(GOAL)
        assert "ended by another goal" in graph.result(handle).message

    def test_a_goal_of_the_learner_overtakes_feedback(self, graph: RunningGraph) -> None:
        goal = np.array([0.0, 0.2, 0.75])
        first = ReachGoal.Goal(
            goal=PointStamped(point=Point(x=-0.2, y=0.0, z=0.7)), tolerance=1e-6, timeout=600.0
        )
        for wait in (0.5, 8.0):  # before feedback counts, and after
            handle = graph.begin_reach("cartesian_feedback", first)
            graph.wait_robot(wait)
            graph.client.set_goal(goal)
            assert "ended by another goal" in graph.result(handle).message
            graph.wait(lambda: distance_aside(graph.tip(), goal) < 0.05, "the tip at the goal")
            assert graph.fresh("cartesian_feedback")["summary"] == "idle"

    def test_reaching_can_be_cancelled(self, graph: RunningGraph) -> None:
        for node in ("learner", "cartesian_feedback"):
            goal = ReachGoal.Goal(
                goal=PointStamped(point=Point(x=0.0, y=-0.2, z=0.7)), tolerance=1e-6, timeout=600.0
            )
            handle = graph.begin_reach(node, goal)
            graph.wait_robot(1.0)
            handle.cancel_goal_async()
            assert graph.result(handle).message == "cancelled; holding"

    def test_identification_can_be_cancelled_and_the_model_in_use_stays(
        self, graph: RunningGraph
    ) -> None:
        model = graph.fresh("pressure_ctrl")["model"]
        handle = graph.begin(Identify, "pressure_ctrl/identify", Identify.Goal(samples=50))
        graph.wait_robot(1.0)
        handle.cancel_goal_async()
        assert graph.result(handle).message == "cancelled; the model in use stays"
        seen = graph.fresh("pressure_ctrl")
        assert seen["mode"] != "identify"
        assert seen["model"] == model

    def test_babbling_can_be_cancelled_and_keeps_what_it_learned(self, graph: RunningGraph) -> None:
        before = graph.client.status.samples
        handle = graph.begin(Babble, "learner/babble", Babble.Goal(duration=3600.0))
        graph.wait(lambda: graph.client.status.samples > before + 10, "some samples")
        handle.cancel_goal_async()
        result = graph.result(handle)
        assert "kept" in result.message
        assert result.status.samples > before + 10
        assert graph.fresh("learner")["mode"] == LearningStatus.HOLDING

    def test_pause_stops_the_robots_time(self, graph: RunningGraph) -> None:
        assert graph.client.pause(True) == "paused"
        assert graph.fresh("simulator")["summary"] == "paused"
        before = graph.fresh("simulator")["simulated time [s]"]
        assert graph.fresh("simulator")["simulated time [s]"] == before
        assert graph.client.pause(False) == "running"
        graph.wait_robot(1.0)

    def test_reset_puts_a_fresh_robot_there_and_time_goes_on(self, graph: RunningGraph) -> None:
        graph.client.set_goal(GOAL)
        graph.wait(lambda: graph.pressures().max() > 2e4, "pressures")
        before = graph.now()
        graph.client.reset(seed=5)
        assert graph.now() >= before
        graph.client.reach(GOAL)
        assert distance_aside(graph.tip(), GOAL) < 0.06
        # As docs/graph.md says: to the others it is the same robot still.
        for name in ("learner", "pressure_ctrl"):
            assert "begun anew" not in graph.log(name, 1000)

    def test_everything_is_well_in_the_end(
        self, graph: RunningGraph, drops_at_start: dict[str, str]
    ) -> None:
        graph.client.set_goal(GOAL)
        graph.wait_robot(3.0)
        for name in graph.names:
            values = graph.fresh(name)
            assert graph.client.diagnostics[name].level == b"\x00", values
        assert drops(graph) == drops_at_start
        assert graph.fresh("simulator")["lockstep"] == "True"
        assert graph.values("simulator")["lockstep timeouts"] == "0"

    def test_feedback_that_slept_is_overtaken_too(self, graph: RunningGraph) -> None:
        """The last one here: tips that it does not see count as dropped."""
        goal = np.array([0.0, 0.2, 0.75])
        first = ReachGoal.Goal(
            goal=PointStamped(point=Point(x=-0.2, y=0.0, z=0.7)), tolerance=1e-6, timeout=600.0
        )
        handle = graph.begin_reach("cartesian_feedback", first)
        graph.wait_robot(8.0)
        with graph.asleep("cartesian_feedback"):
            graph.client.set_goal(goal)
            graph.wait(lambda: graph.client.status.mode == LearningStatus.HOLDING, "holding")
            graph.wait_robot(60.0)  # no status that waits for it tells of the movement any more
        assert "ended by another goal" in graph.result(handle).message
        graph.wait(lambda: distance_aside(graph.tip(), goal) < 0.05, "the tip at the goal")
