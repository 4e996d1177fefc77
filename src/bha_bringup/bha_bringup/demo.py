"""The demonstration: starts the graph, learns, reaches held-out goals, first without feedback.

It uses the graph as any user would: through services and actions.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from bha_bringup.demo_record import DemoRecord, GoalRecord
from bha_bringup.graph import MODEL_FILES, SIM, GraphSettings, NodeDescription, describe_graph
from bha_bringup.graph_lock import owning_graph
from bha_bringup.graph_processes import GraphProcesses
from bha_bringup.robot_client import (
    CONTROLLER,
    LEARNER,
    BabbleFeedback,
    IdentifyFeedback,
    RobotClient,
)
from bha_bringup.robot_connection import refuse_second_graph
from bha_goal_babbling.checkpoint import load_checkpoint
from bha_goal_babbling.task import Task, find_task


def run_demo(record: DemoRecord, console: Console) -> None:
    """Run the demonstration; what was measured until its end or its interruption is written.

    Parameters
    ----------
    record : What to do; takes up what is measured.
    console : Where progress is shown.

    Raises
    ------
    RobotError, GraphError
        When the graph cannot be started, or a node refuses or ends.
    """
    # Before anything is written: models and process number may be those of the graph that runs.
    refuse_second_graph()
    settings = record.settings
    models = settings.out / "models"
    models.mkdir(parents=True, exist_ok=True)
    # A demonstration learns from nothing; an older run's models would be gone on with.
    for name in MODEL_FILES.values():
        (models / name).unlink(missing_ok=True)
    task = find_task(settings.space)
    record.axes = task.axes
    nodes = describe_graph(
        GraphSettings(
            robot=settings.robot,
            space=settings.space,
            real_time_factor=0.0 if settings.robot == SIM else 1.0,
            seed=settings.seed,
            models=models,
        )
    )
    try:
        with (
            owning_graph(),
            GraphProcesses(nodes, settings.out / "logs") as processes,
            RobotClient(processes.check) as robot,
        ):
            _Demo(task, record, robot, console).run(nodes)
        record.complete = True
    finally:
        record.write(settings.out)


class _Demo:
    """The phases, one after the other."""

    def __init__(
        self,
        task: Task,
        record: DemoRecord,
        robot: RobotClient,
        console: Console,
    ) -> None:
        self._settings = record.settings
        self._task = task
        self._record = record
        self._robot = robot
        self._console = console

    def run(self, nodes: list[NodeDescription]) -> None:
        pace = " in lockstep" if self._settings.robot == SIM else " in real time"
        with self._progress("start", "{task.fields[note]}") as (bar, line):
            bar.update(line, total=1, note=f"{len(nodes)} nodes{pace}")
            self._robot.wait_for_graph({node.executable for node in nodes})
            bar.update(line, completed=1)
        if self._settings.robot == SIM:
            # In lockstep minutes pass while nodes find one another, and its sensors drift on: the
            # robot of a seed is to be the same one each time, and the one behind the terminal.
            self._robot.reset()
        self._identify()
        self._babble()
        self._reach_goals()

    def _identify(self) -> None:
        with self._phase("identify") as (bar, line):
            bar.update(line, total=self._settings.identification_samples)

            def tell(feedback: IdentifyFeedback) -> None:
                bar.update(
                    line,
                    completed=feedback.collected,
                    note=f"settled postures in {feedback.elapsed / 60:.1f} robot min",
                )

            result = self._robot.identify(self._settings.identification_samples, tell)
            self._record.pressure_error = result.pressure_error
            self._robot.save(CONTROLLER)
            bar.update(
                line,
                completed=result.samples,
                note=f"settled postures, fit to {result.pressure_error / 1e3:.1f} kPa",
            )

    def _babble(self) -> None:
        record, duration = self._record, self._settings.minutes * 60.0
        with self._phase("babble") as (bar, line):
            bar.update(line, total=self._settings.minutes)
            start = time.monotonic()

            def tell(feedback: BabbleFeedback) -> None:
                status = feedback.status
                factor = feedback.elapsed / max(time.monotonic() - start, 1e-6)
                record.exploration_minutes = status.exploration_time / 60.0
                record.movements, record.samples = int(status.movements), int(status.samples)
                record.local_models = int(status.local_models)
                record.real_time_factor = factor
                record.learning_curve.append((record.exploration_minutes, status.recent_error))
                bar.update(
                    line,
                    completed=feedback.elapsed / 60.0,
                    note=f"min, {status.movements} movements, {status.local_models} maps, "
                    f"{status.recent_error * 1e3:.0f} mm, {factor:.0f}x",
                )

            result = self._robot.babble(duration, progress=tell)
            tell(BabbleFeedback(status=result.status, elapsed=duration))
            self._robot.save(LEARNER)

    def _reach_goals(self) -> None:
        record, settings = self._record, self._settings
        rng = np.random.default_rng([settings.seed, 1])
        positions = self._task.held_out_positions(settings.goals, rng)
        record.goals = [GoalRecord(goal=position) for position in positions]
        with self._phase("reach") as (bar, line):
            bar.update(line, total=2 * len(positions) + 1)
            self._reach_home()
            bar.advance(line)
            for number, goal in enumerate(record.goals):
                end_recording = self._robot.record(record.reach) if number == 0 else None
                result = self._robot.reach(goal.goal)
                if end_recording is not None:
                    end_recording()
                    record.reach_goal = goal.goal
                goal.feedforward_tip, goal.feedforward_error = result.tip, result.error
                bar.update(line, advance=1, note=self._reach_note("feedforward", "feed-forward"))
            for goal in record.goals:
                result = self._robot.reach(goal.goal, feedback=True)
                goal.feedback_tip, goal.feedback_error = result.tip, result.error
                goal.feedback_time = result.duration
                bar.update(line, advance=1, note=self._reach_note("feedback", "with feedback"))

    def _reach_home(self) -> None:
        file = self._settings.out / "models" / MODEL_FILES[LEARNER]
        home = load_checkpoint(file, robot=None).babbler.home_outcome
        position = np.zeros(3)
        position[: len(home)] = home
        self._record.home_error = self._robot.reach(position).error

    def _reach_note(self, kind: str, words: str) -> str:
        errors = self._record.errors(kind)
        return f"reached, {words} {np.mean(errors) * 1e3:.1f} mm on average"

    @contextmanager
    def _phase(self, name: str) -> Iterator[tuple[Progress, TaskID]]:
        start = time.monotonic()
        columns = "{task.completed:.0f}/{task.total:.0f} {task.fields[note]}"
        try:
            with self._progress(name, columns) as shown:
                yield shown
        finally:
            self._record.wall[name] = time.monotonic() - start

    @contextmanager
    def _progress(self, name: str, columns: str) -> Iterator[tuple[Progress, TaskID]]:
        with Progress(
            TextColumn("{task.description:<9}"),
            BarColumn(bar_width=12),
            TimeElapsedColumn(),
            TextColumn(columns),
            console=self._console,
            refresh_per_second=4,
        ) as bar:
            yield bar, bar.add_task(name, total=1, note="")
