"""The launch file's own code, run with what it uses of `launch` in small.

The wheels of ROS hold no `launch`. The stand-ins take the arguments that the classes of launch and
launch_ros of Jazzy take, and nothing else.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from bha_bringup.graph import NAMESPACE, GraphSettings, describe_graph
from bha_driver.terminal_file import example_path

FILE = Path(__file__).parents[1] / "launch" / "bha.launch.py"


class LaunchContext:
    def __init__(self, given: dict[str, str]) -> None:
        self.launch_configurations = dict(given)


class LaunchDescription:
    def __init__(self, entities: list[Any]) -> None:
        self.entities = entities


class DeclareLaunchArgument:
    def __init__(
        self, name: str, *, default_value: Any = None, description: Any = None, choices: Any = None
    ) -> None:
        assert isinstance(default_value, str)
        assert isinstance(description, str)
        assert choices is None or (len(choices) and default_value in choices)
        self.name, self.default_value, self.choices = name, default_value, choices

    def execute(self, context: LaunchContext) -> None:
        value = context.launch_configurations.setdefault(self.name, self.default_value)
        if self.choices is not None and value not in self.choices:
            raise RuntimeError(f"valid options are {self.choices}")


class LaunchConfiguration:
    def __init__(self, variable_name: str) -> None:
        self.name = variable_name

    def perform(self, context: LaunchContext) -> str:
        return context.launch_configurations[self.name]


class OpaqueFunction:
    def __init__(self, *, function: Callable[[LaunchContext], list[Any]]) -> None:
        self.function = function

    def execute(self, context: LaunchContext) -> list[Any]:
        return self.function(context)


@dataclasses.dataclass(kw_only=True)
class Node:
    executable: str
    package: str
    namespace: str
    parameters: list[Any]
    output: str


@pytest.fixture
def launch(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Node]]:
    """Do what `ros2 launch` does with the arguments; the nodes that it would start."""
    modules = {
        "launch": [LaunchContext, LaunchDescription],
        "launch.actions": [DeclareLaunchArgument, OpaqueFunction],
        "launch.substitutions": [LaunchConfiguration],
        "launch_ros": [],
        "launch_ros.actions": [Node],
    }
    for name, contents in modules.items():
        module = ModuleType(name)
        for item in contents:
            setattr(module, item.__name__, item)
        monkeypatch.setitem(sys.modules, name, module)

    def run(**arguments: str) -> list[Node]:
        spec = importlib.util.spec_from_file_location("bha_launch", FILE)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        context, nodes = LaunchContext(arguments), []
        for entity in module.generate_launch_description().entities:
            nodes.extend(entity.execute(context) or [])
        return nodes

    return run


def check(nodes: list[Node], settings: GraphSettings) -> None:
    expected = describe_graph(settings)
    assert [(n.package, n.executable, n.parameters[0]) for n in nodes] == [
        (n.package, n.executable, n.parameters) for n in expected
    ]
    assert {node.namespace for node in nodes} == {NAMESPACE}


def test_without_arguments_it_is_the_simulator(launch: Callable[..., list[Node]]) -> None:
    check(launch(), GraphSettings())


def test_one_argument_turns_to_the_pneumatics(launch: Callable[..., list[Node]]) -> None:
    lab = example_path("cpx_e")
    nodes = launch(robot="hardware", terminal=str(lab), models="/models", space="3d")
    check(
        nodes,
        GraphSettings(robot="hardware", terminal=lab, models=Path("/models"), space="3d"),
    )
    assert nodes[0].executable == "driver"


def test_all_arguments_reach_the_graph(launch: Callable[..., list[Node]]) -> None:
    nodes = launch(
        robot="sim", feedback="false", real_time_factor="0", seed="3", params_file="lab.yaml"
    )
    check(nodes, GraphSettings(feedback=False, real_time_factor=0.0, seed=3))
    assert all(node.parameters[1:] == ["lab.yaml"] for node in nodes)


@pytest.mark.parametrize("wrong", [{"robot": "real"}, {"feedback": "yes"}])
def test_what_is_no_choice_is_refused(
    launch: Callable[..., list[Node]], wrong: dict[str, str]
) -> None:
    with pytest.raises(RuntimeError, match="valid options are"):
        launch(**wrong)


def test_values_survive_the_way_through_yaml() -> None:
    """launch_ros writes each text as YAML and reads it again."""
    import yaml

    for settings in (
        GraphSettings(models=Path("/a folder/of models " * 8)),
        GraphSettings(robot="hardware", terminal=example_path("cpx_mpa")),
        GraphSettings(robot="hardware-emulated"),
    ):
        for node in describe_graph(settings):
            for value in node.parameters.values():
                back = yaml.safe_load(yaml.dump(value))
                assert back == value
                assert type(back) is type(value)
