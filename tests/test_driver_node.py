"""The driver as a node: life cycle, topics and safety, with a real terminal emulator behind it."""

from __future__ import annotations

import signal
import socket
import threading
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import pytest
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from std_msgs.msg import Bool

from bha_bringup.graph import NodeDescription
from bha_bringup.robot_client import RobotError
from bha_common import bellows
from bha_common.ros_messages import nanoseconds, pressures_message, stamp_message
from bha_common.ros_node import LATCHED_QOS
from bha_driver.scaling import Scaling
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.terminal_file import example_path, parse_terminal
from running_graph import PATIENCE, RunningGraph
from terminal_bench import plant

pytestmark = pytest.mark.graph

TEXT = example_path("emulated").read_text()
PATIENT = TEXT.replace(
    "{request: 0.2, connect: 0.5, link: 1.0,", "{request: 1.0, connect: 1.0, link: 1.5,"
).replace("time: 2.0", "time: 3.0")
"""The emulated terminal, for a machine where every process may have to wait for its turn."""

MAP = parse_terminal(PATIENT)
PERIOD = 0.02
PRESSED = np.full(9, 5e4)


class LivingTerminal:
    """An emulated terminal whose robot lives in real time, in a thread of its own."""

    def __init__(self) -> None:
        self.emulator = TerminalEmulator(MAP, plant())
        self._scaling = Scaling(MAP)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._live, name="robot")

    def __enter__(self) -> LivingTerminal:
        self.emulator.__enter__()
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end.set()
        self._thread.join()
        self.emulator.close()

    def _live(self) -> None:
        while not self._end.wait(PERIOD):
            self.emulator.step()

    @property
    def highest(self) -> float:
        """Highest pressure that the terminal holds [Pa]."""
        words = np.array(self.emulator.registers.outputs)
        return float(self._scaling.commanded(words).max())

    def written(self) -> list[float]:
        """Highest pressure of each write so far [Pa]."""
        return [
            float(self._scaling.commanded(np.array(words)).max())
            for _, words in self.emulator.registers.writes
        ]


class Driver:
    """The node under test, and what its user does."""

    def __init__(self, terminal: LivingTerminal, graph: RunningGraph) -> None:
        self.terminal, self.graph = terminal, graph
        self.stops: list[bool] = []
        node = graph.client.node
        node.create_subscription(
            Bool, "emergency_stop_active", lambda m: self.stops.append(m.data), LATCHED_QOS
        )

    def change(self, transition: int) -> bool:
        request = ChangeState.Request(transition=Transition(id=transition))
        return bool(self.graph.client.call(ChangeState, "driver/change_state", request).success)

    @property
    def state(self) -> str:
        answer = self.graph.client.call(GetState, "driver/get_state", GetState.Request())
        return str(answer.current_state.label)

    def command(self, pressures: np.ndarray = PRESSED) -> None:
        self.graph.publisher("pressure_command").publish(
            pressures_message(self.graph.now(), pressures)
        )

    def commanding(self, condition: Any, what: str, pressures: np.ndarray = PRESSED) -> None:
        """Command ten times a second until a condition holds."""
        self.graph.repeat(lambda: self.command(pressures), condition, what)

    def press(self) -> None:
        self.commanding(lambda: self.terminal.highest > 4e4, "pressure")


@pytest.fixture(scope="module")
def terminal() -> Iterator[LivingTerminal]:
    with LivingTerminal() as running:
        yield running


@pytest.fixture
def make_driver(terminal: LivingTerminal, tmp_path: Path) -> Iterator[Any]:
    graphs = []

    def make(autostart: str = "activate", **parameters: Any) -> Driver:
        (tmp_path / "patient.yaml").write_text(PATIENT)
        settings = {
            "terminal": str(tmp_path / "patient.yaml"),
            "port": terminal.emulator.port,
            "autostart": autostart,
            **parameters,
        }
        graph = RunningGraph([NodeDescription("bha_driver", "driver", settings)], tmp_path)
        graphs.append(graph.__enter__())
        driver = Driver(terminal, graph)
        if autostart == "activate":
            graph.wait(lambda: graph.values("driver").get("life cycle") == "active", "activation")
        return driver

    yield make
    for graph in graphs:
        graph.__exit__(None, None, None)
    terminal.emulator.end_all()


T = Transition
MOVES = {
    ("unconfigured", T.TRANSITION_CONFIGURE): "inactive",
    ("inactive", T.TRANSITION_CLEANUP): "unconfigured",
    ("inactive", T.TRANSITION_ACTIVATE): "active",
    ("active", T.TRANSITION_DEACTIVATE): "inactive",
}


def test_transitions_in_every_order(make_driver: Any) -> None:
    """All pairs of state and transition; what is impossible is refused, and never ends the node."""
    driver = make_driver("none")
    wanted = {
        (state, move)
        for state in ("unconfigured", "inactive", "active")
        for move in (
            T.TRANSITION_CONFIGURE,
            T.TRANSITION_CLEANUP,
            T.TRANSITION_ACTIVATE,
            T.TRANSITION_DEACTIVATE,
        )
    }
    rng, state, tried = np.random.default_rng(0), "unconfigured", set()
    registers = driver.terminal.emulator.registers
    registers.forget_writes()
    while tried != wanted:
        possible = [move for name, move in sorted(wanted) if name == state]
        fresh = [move for move in possible if (state, move) not in tried]
        move = int(rng.choice(fresh or possible))
        tried.add((state, move))
        expected = MOVES.get((state, move))
        assert driver.change(move) == (expected is not None), (state, move)
        state = expected or state
        assert driver.state == state
        if not any(name == "active" for name, _ in tried) and state != "active":
            assert not registers.writes, "nothing is driven before activation"
    if state == "unconfigured":
        assert driver.change(T.TRANSITION_CONFIGURE)
    if driver.state == "inactive":
        assert driver.change(T.TRANSITION_ACTIVATE)
    driver.press()
    assert driver.change(T.TRANSITION_ACTIVE_SHUTDOWN)
    assert driver.state == "finalized"
    driver.graph.wait(lambda: driver.terminal.highest == 0.0, "shutdown vents")
    assert not driver.change(T.TRANSITION_CONFIGURE)


def test_pressing_deactivating_and_the_old_command(make_driver: Any) -> None:
    driver = make_driver()
    graph, terminal = driver.graph, driver.terminal
    driver.press()
    assert driver.change(T.TRANSITION_DEACTIVATE)
    graph.wait(lambda: terminal.highest == 0.0, "deactivation vents")
    count = len(terminal.written())
    graph.wait(lambda: graph.values("driver")["summary"] == "inactive: drives nothing", "summary")
    driver.commanding(lambda: len(driver.graph.listen("lengths").messages) > 50, "lengths flow on")
    assert terminal.highest == 0.0, "commands do not count while inactive"
    assert len(terminal.written()) - count < 5, "nothing is driven"
    assert driver.change(T.TRANSITION_ACTIVATE)
    graph.wait_robot(0.5)
    assert terminal.highest == 0.0, "only a command newer than the activation counts"
    driver.press()

    begin = time.monotonic()
    graph.wait(lambda: graph.values("driver").get("state") == "silent", "the watchdog")
    graph.wait(lambda: terminal.highest == 0.0, "silence vents")
    assert time.monotonic() - begin < 20.0
    assert driver.stops == [False], "silence is no emergency stop"


def test_what_it_publishes_is_what_the_simulator_publishes(make_driver: Any) -> None:
    driver = make_driver()
    graph = driver.graph
    lengths, pressures = graph.listen("lengths"), graph.listen("pressures")
    driver.press()
    graph.wait(lambda: len(lengths.messages) > 60, "lengths")
    first, last = lengths.messages[0], lengths.last
    assert list(last.name) == list(pressures.last.name) == list(bellows.NAMES)
    assert last.header.frame_id == pressures.last.header.frame_id == bellows.BASE_FRAME
    assert (np.abs(np.array(last.position) - 0.2) < 0.1).all()
    assert np.array(pressures.last.pressure).max() > 1e4
    stamps = np.array([nanoseconds(message.header.stamp) for message in lengths.messages])
    assert (np.diff(stamps) > 0).all()
    assert (stamps % 20_000_000 == 0).all()
    assert abs(stamps[-1] - time.time_ns()) < 5e9, "the system's time, as a tracker's"
    assert np.median(np.diff(stamps)) == 20_000_000
    assert len(first.velocity) == len(first.effort) == 0


def test_commands_that_cannot_be_meant(make_driver: Any) -> None:
    driver = make_driver()
    graph = driver.graph
    good = pressures_message(graph.now(), PRESSED)
    publisher = graph.publisher("pressure_command")
    for change in ("nan", "inf", "count", "name", "doubled", "no stamp", "old", "future"):
        message = pressures_message(graph.now(), PRESSED)
        if change == "nan":
            message.pressure[3] = float("nan")
        elif change == "inf":
            message.pressure[3] = float("inf")
        elif change == "count":
            message.pressure = message.pressure[:8]
        elif change == "name":
            message.name[0] = "bellows_0_0"
        elif change == "doubled":
            message.name[0] = message.name[1]
        elif change == "no stamp":
            message.header.stamp = stamp_message(0)
        else:
            shift = 10**10 if change == "future" else -(10**10)
            message.header.stamp = stamp_message(graph.now() + shift)
        before = graph.dropped("driver", "pressure_command")
        graph.repeat(
            lambda message=message: publisher.publish(message),
            lambda before=before: graph.dropped("driver", "pressure_command") > before,
            f"{change} to be refused",
        )
    assert driver.terminal.highest == 0.0
    good.pressure = [-1e9, 1e9, 5e5, *good.pressure[3:]]
    driver.commanding(
        lambda: driver.terminal.highest > 4e4, "clipped, not refused", np.array(good.pressure)
    )
    words = np.array(driver.terminal.emulator.registers.outputs)
    assert Scaling(MAP).commanded(words).min() == 0.0
    assert driver.terminal.highest <= 1.3e5


def test_the_emergency_stop(make_driver: Any) -> None:
    driver = make_driver()
    graph, terminal = driver.graph, driver.terminal
    driver.press()
    assert graph.client.emergency_stop().startswith("stopped")
    count = len(terminal.written())
    driver.commanding(lambda: driver.stops[-1:] == [True], "the others are told")
    driver.commanding(lambda: terminal.highest == 0.0, "the stop vents, whatever is commanded")
    after = terminal.written()[count:]
    assert all(b <= a for a, b in pairwise(after))
    assert graph.fresh("driver")["summary"] == "safe state: emergency stop"
    assert graph.client.emergency_stop_reset().startswith("the stop has ended")
    graph.wait(lambda: driver.stops[-1] is False, "the others are told")
    graph.wait_robot(0.3)
    assert terminal.highest == 0.0, "the old command does not come back"
    driver.press()


def test_one_bellows_is_pressed_by_hand_and_vents_by_itself(make_driver: Any) -> None:
    """The way of the first power-up, for one who has no controller yet."""
    driver = make_driver()
    wanted = np.zeros(9)
    wanted[3] = 2e4
    registers = driver.terminal.emulator.registers
    count = len(registers.writes)
    lengths = driver.graph.client.press(wanted, 2.0)
    assert (np.abs(lengths - 0.2) < 0.1).all()
    written = np.array([Scaling(MAP).commanded(np.array(w)) for _, w in registers.writes[count:]])
    assert written[:, 3].max() == pytest.approx(2e4, abs=5.0)
    assert np.delete(written, 3, axis=1).max() == 0.0, "no other is pressed"
    driver.graph.wait(lambda: driver.terminal.highest == 0.0, "it vents when nobody commands")
    driver.press()
    with pytest.raises(RobotError, match="start the driver alone"):
        driver.graph.client.press(wanted, 1.0)


@pytest.mark.parametrize("fault", ["cut", "restart", "freeze", "swap"])
def test_a_fault_is_told_and_stays_until_it_is_reset(make_driver: Any, fault: str) -> None:
    driver = make_driver()
    graph, terminal = driver.graph, driver.terminal
    driver.press()
    terminal.emulator.begin(fault)
    up = [True]

    def moving() -> bool:
        """A set-point that moves, so that a frozen reading can be found."""
        up[0] = not up[0]
        driver.command(PRESSED + (2e4 if up[0] else 0.0))
        graph.client.wait(lambda: False, 0.2)
        return driver.stops[-1:] == [True]

    graph.wait(moving, "the stop")
    terminal.emulator.end(fault)
    values = graph.fresh("driver")
    assert values["summary"].startswith(
        "safe state: " + ("length" if fault in ("freeze", "swap") else "connection lost")
    )
    driver.commanding(lambda: terminal.highest == 0.0, "vented")
    graph.wait(lambda: graph.fresh("driver")["connected"] == "True", "connected again")
    count = len(terminal.written())
    driver.commanding(lambda: len(terminal.written()) > count + 50, "cycles with commands")
    assert max(terminal.written()[count:]) == 0.0, "pressed again without a reset"
    graph.client.emergency_stop_reset()
    driver.press()


def test_a_driver_that_is_killed(make_driver: Any) -> None:
    """The terminal's watchdog vents, for nothing but the driver's cycle feeds it."""
    driver = make_driver()
    driver.press()
    registers = driver.terminal.emulator.registers
    trips = registers.trips
    driver.graph.end("driver", signal.SIGKILL)
    driver.graph.wait(lambda: registers.trips > trips, "the watchdog", PATIENCE)
    assert driver.terminal.highest == 0.0


def test_an_interrupt_vents_before_the_end(make_driver: Any) -> None:
    driver = make_driver()
    driver.press()
    registers = driver.terminal.emulator.registers
    trips = registers.trips
    code, _ = driver.graph.end("driver", signal.SIGINT)
    assert code == 0
    assert driver.terminal.highest == 0.0
    assert registers.trips == trips, "the driver did it, not the watchdog"


def test_without_a_terminal_it_waits_and_says_why(tmp_path: Path) -> None:
    settings = {"port": 1, "autostart": "activate"}
    with RunningGraph([NodeDescription("bha_driver", "driver", settings)], tmp_path) as graph:
        assert graph.values("driver")["summary"] == "unconfigured: drives nothing"
        graph.wait(lambda: "no connection" in graph.log("driver"), "the reason")
        assert graph.client.emergency_stop().startswith("stopped")
        assert graph.client.emergency_stop_reset().startswith("the stop has ended")


def test_a_map_that_is_wrong_ends_it_with_the_field(tmp_path: Path) -> None:
    file = tmp_path / "lab.yaml"
    file.write_text(example_path("cpx_e").read_text().replace("port: 502", "port: many"))
    nodes = [NodeDescription("bha_driver", "driver", {"terminal": str(file)})]
    from bha_bringup.graph_processes import GraphProcesses

    processes = GraphProcesses(nodes, tmp_path)
    with processes:
        assert processes._processes["driver"].wait(PATIENCE) == 2
    log = (tmp_path / "driver.log").read_text()
    assert "port is 'many'; it must be a whole number" in log


def test_the_emulator_is_a_node_with_faults_to_inject(tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    nodes = [
        NodeDescription("bha_bringup", "terminal_emulator", {"port": port, "faults": "cut@8"}),
        NodeDescription("bha_driver", "driver", {"port": port, "autostart": "activate"}),
    ]
    with RunningGraph(nodes, tmp_path) as graph:
        tips = graph.listen("tip")
        graph.wait(lambda: graph.values("driver").get("life cycle") == "active", "activation")
        graph.wait(
            lambda: "connection lost" in graph.values("driver").get("faults", ""), "the fault"
        )
        graph.wait(lambda: len(tips.messages) > 10, "a tip, as the lab's tracker sends it")
        assert abs(tips.last.pose.position.z - 0.65) < 0.1
        stamps = np.array([nanoseconds(message.header.stamp) for message in tips.messages])
        assert (np.diff(stamps) % 100_000_000 == 0).all()
        assert abs(stamps[-1] - time.time_ns()) < 5e9
