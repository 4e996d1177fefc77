"""The description of the graph against what the packages really hold, without starting anything."""

import ast
import dataclasses
import importlib
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from bha_bringup.graph import NAMESPACE, ROBOTS, GraphSettings, NodeDescription, describe_graph
from bha_driver.errors import TerminalMapError
from bha_goal_babbling.errors import InvalidTaskError

SOURCES = Path(__file__).parents[2]
SIMULATED = describe_graph(GraphSettings(models=Path("/models")))
EMULATED = describe_graph(GraphSettings(robot="hardware-emulated", models=Path("/models")))
ALL = [*SIMULATED, *EMULATED[:2]]
NAMES = [node.executable for node in ALL]
LAB = SOURCES / "bha_driver/config/cpx_e.yaml"


def entry_points(package: str) -> dict[str, str]:
    """Return the executables of a package and where they begin, from its setup.py."""
    tree = ast.parse((SOURCES / package / "setup.py").read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.keyword) and node.arg == "entry_points":
            scripts = ast.literal_eval(node.value)["console_scripts"]
            return dict(script.replace(" ", "").split("=") for script in scripts)
    raise AssertionError(f"{package}/setup.py has no entry points")


def node_tree(node: NodeDescription) -> ast.Module:
    """Return the syntax of the module that a node's executable begins in."""
    module, _ = entry_points(node.package)[node.executable].split(":")
    return ast.parse((SOURCES / node.package / f"{module.replace('.', '/')}.py").read_text())


def declared(node: NodeDescription) -> dict[str, Any]:
    """Return the parameters that a node declares with their defaults, without importing ROS."""
    tree = node_tree(node)
    classes = {item.name: item for item in tree.body if isinstance(item, ast.ClassDef)}
    homes = {
        alias.name: item.module
        for item in tree.body
        if isinstance(item, ast.ImportFrom) and item.module
        for alias in item.names
    }
    found: dict[str, Any] = {}
    for call in ast.walk(tree):
        if not isinstance(call, ast.Call) or getattr(call.func, "id", "") != "declare_settings":
            continue
        name = call.args[1]
        assert isinstance(name, ast.Name)
        prefix = ast.literal_eval(call.args[2]) if len(call.args) > 2 else ""
        if name.id in classes:
            for field in classes[name.id].body:
                if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
                    assert isinstance(field.value, ast.Call)
                    found[field.target.id] = ast.literal_eval(field.value.args[0])
        else:
            settings = getattr(importlib.import_module(homes[name.id]), name.id)
            found.update(flat(dataclasses.asdict(settings()), prefix))
    assert found
    return found


def flat(values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested values under names with dots."""
    result: dict[str, Any] = {}
    for name, value in values.items():
        if isinstance(value, dict):
            result.update(flat(value, f"{prefix}{name}."))
        else:
            result[prefix + name] = value
    return result


def launch_arguments() -> dict[str, tuple[str, str, Any]]:
    """Return the arguments of the launch file: default, description, choices."""
    tree = ast.parse((SOURCES / "bha_bringup/launch/bha.launch.py").read_text())
    for item in tree.body:
        if isinstance(item, ast.Assign) and getattr(item.targets[0], "id", "") == "ARGUMENTS":
            scope = {"ROBOTS": ROBOTS}
            return dict(eval(compile(ast.Expression(item.value), "launch", "eval"), scope))
    raise AssertionError("the launch file has no ARGUMENTS")


class TestNodes:
    @pytest.mark.parametrize("node", ALL, ids=NAMES)
    def test_the_executable_is_installed_by_its_package(self, node: NodeDescription) -> None:
        assert node.executable in entry_points(node.package)

    @pytest.mark.parametrize("node", ALL, ids=NAMES)
    def test_the_executable_begins_in_a_function_that_exists(self, node: NodeDescription) -> None:
        _, function = entry_points(node.package)[node.executable].split(":")
        functions = [f.name for f in node_tree(node).body if isinstance(f, ast.FunctionDef)]
        assert function in functions

    @pytest.mark.parametrize("node", ALL, ids=NAMES)
    def test_the_node_has_the_name_of_its_executable(self, node: NodeDescription) -> None:
        """Parameter files and services go by it."""
        calls = [call for call in ast.walk(node_tree(node)) if isinstance(call, ast.Call)]
        names = [
            ast.literal_eval(call.args[0])
            for call in calls
            if isinstance(call.func, ast.Attribute) and call.func.attr == "__init__"
        ]
        assert names == [node.executable]

    @pytest.mark.parametrize("node", ALL, ids=NAMES)
    def test_its_parameters_are_declared_and_of_the_same_type(self, node: NodeDescription) -> None:
        """ROS refuses a whole number for one with a point."""
        parameters = declared(node)
        for name, value in node.parameters.items():
            assert name in parameters
            assert type(value) is type(parameters[name])

    def test_the_package_depends_on_all_it_starts(self) -> None:
        manifest = (SOURCES / "bha_bringup/package.xml").read_text()
        for package in {node.package for node in ALL} - {"bha_bringup"}:
            assert f"<depend>{package}</depend>" in manifest


class TestChoices:
    def parameters(self, **settings: Any) -> dict[str, dict[str, Any]]:
        nodes = describe_graph(GraphSettings(**settings))
        return {node.executable: node.parameters for node in nodes}

    def test_the_whole_graph(self) -> None:
        names = [node.executable for node in SIMULATED]
        assert names == ["simulator", "pressure_ctrl", "learner", "cartesian_feedback"]
        assert [node.in_loop for node in SIMULATED] == [True, True, False, False]
        assert NAMESPACE == "/bha"

    def test_feedback_is_optional(self) -> None:
        assert "cartesian_feedback" not in self.parameters(feedback=False)

    @pytest.mark.parametrize(("factor", "lockstep"), [(0.0, True), (1.0, False), (20, False)])
    def test_lockstep(self, factor: float, lockstep: bool) -> None:
        """Simulator and controller must agree on it."""
        parameters = self.parameters(real_time_factor=factor)
        assert parameters["simulator"]["real_time_factor"] == factor
        assert isinstance(parameters["simulator"]["real_time_factor"], float)
        assert parameters["pressure_ctrl"]["lockstep"] is lockstep

    def test_the_seed_goes_to_all_who_draw(self) -> None:
        parameters = self.parameters(seed=7)
        assert parameters["simulator"]["robot_seed"] == 7
        assert parameters["pressure_ctrl"]["seed"] == parameters["learner"]["seed"] == 7

    def test_models_of_one_simulated_robot_are_not_for_another(self) -> None:
        robots = []
        for seed in (0, 1):
            parameters = self.parameters(seed=seed)
            assert parameters["pressure_ctrl"]["robot"] == parameters["learner"]["robot"]
            robots.append(parameters["learner"]["robot"])
        assert robots[0] != robots[1]

    def test_models_lie_in_one_folder(self) -> None:
        parameters = self.parameters(models=Path("/models"))
        files = [parameters[name]["model_file"] for name in ("pressure_ctrl", "learner")]
        assert [Path(file).parent for file in files] == 2 * [Path("/models")]
        assert len(set(files)) == 2

    def test_no_models_are_kept_without_a_folder(self) -> None:
        parameters = self.parameters()
        assert parameters["pressure_ctrl"]["model_file"] == ""
        assert parameters["learner"]["model_file"] == ""

    @pytest.mark.parametrize(("space", "axes"), [("2d", 2), ("3d", 3)])
    def test_feedback_counts_the_coordinates_of_the_task(self, space: str, axes: int) -> None:
        parameters = self.parameters(space=space)
        assert parameters["learner"]["task"] == space
        assert parameters["cartesian_feedback"]["axes"] == axes

    @pytest.mark.parametrize(("like", "axes"), [("2d", 2), ("3d", 3)])
    def test_also_of_a_task_file(self, tmp_path: Path, like: str, axes: int) -> None:
        """Else feedback would integrate an error that the learner cannot do anything about."""
        file = tmp_path / "mine.yaml"
        file.write_text((SOURCES / f"bha_goal_babbling/config/task_{like}.yaml").read_text())
        assert self.parameters(space=str(file))["cartesian_feedback"]["axes"] == axes

    def test_a_task_that_is_not_there(self) -> None:
        with pytest.raises(InvalidTaskError, match="4d"):
            self.parameters(space="4d")

    @pytest.mark.parametrize(
        ("wrong", "message"),
        [
            ({"robot": "real"}, "robot is 'real'; valid are sim, hardware, hardware-emulated"),
            ({"robot": "hardware"}, "name its terminal map, such as my_lab.yaml"),
            ({"terminal": LAB}, "the simulator has no terminal"),
            ({"robot": "hardware", "terminal": LAB, "real_time_factor": 0.0}, "in real time, 1"),
            ({"real_time_factor": -1.0}, "real_time_factor must be 0 or above"),
            ({"real_time_factor": float("nan")}, "real_time_factor must be 0 or above"),
            ({"real_time_factor": float("inf")}, "real_time_factor must be 0 or above"),
        ],
    )
    def test_refuses_what_is_no_choice(self, wrong: dict[str, Any], message: str) -> None:
        with pytest.raises(ValueError, match=message):
            GraphSettings(**wrong)


class TestHardware:
    """The swap: all nodes but those that are the robot stay what they are."""

    def test_a_driver_takes_the_place_of_the_simulator(self) -> None:
        hardware = describe_graph(GraphSettings(robot="hardware", terminal=LAB))
        assert [node.executable for node in hardware] == ["driver", *NAMES[1:4]]
        assert [node.executable for node in EMULATED] == [
            "terminal_emulator",
            "driver",
            *NAMES[1:4],
        ]

    def test_every_other_node_is_unchanged(self) -> None:
        simulated = describe_graph(GraphSettings(models=Path("/models"), seed=3))
        emulated = describe_graph(
            GraphSettings(robot="hardware-emulated", models=Path("/models"), seed=3)
        )
        assert [(n.executable, n.parameters) for n in simulated[1:]] == [
            (n.executable, n.parameters) for n in emulated[2:]
        ]

    def test_nodes_in_real_time_are_not_bound_to_cores(self) -> None:
        assert {node.in_loop for node in EMULATED} == {None}

    def test_driver_and_emulator_meet(self, monkeypatch: pytest.MonkeyPatch) -> None:
        ports = set()
        for domain in ("", "7"):
            monkeypatch.setenv("ROS_DOMAIN_ID", domain)
            emulator, driver, *_ = describe_graph(GraphSettings(robot="hardware-emulated"))
            assert emulator.parameters["port"] == driver.parameters["port"]
            ports.add(driver.parameters["port"])
        assert len(ports) == 2, "graphs in two ROS domains must not meet"

    def test_only_an_emulated_robot_is_pressed_without_a_word(self) -> None:
        (driver,) = [n for n in EMULATED if n.executable == "driver"]
        assert driver.parameters["autostart"] == "activate"
        driver = describe_graph(GraphSettings(robot="hardware", terminal=LAB))[0]
        assert driver.parameters["autostart"] == "configure"
        assert driver.parameters["terminal"] == str(LAB)

    def test_models_bear_the_name_of_the_terminal(self) -> None:
        nodes = describe_graph(GraphSettings(robot="hardware", terminal=LAB))
        assert {n.parameters["robot"] for n in nodes if "robot" in n.parameters} == {"cpx_e_lab"}

    def test_a_wrong_terminal_map_is_told_before_anything_starts(self, tmp_path: Path) -> None:
        file = tmp_path / "lab.yaml"
        file.write_text(LAB.read_text().replace("port: 502", "port: 0"))
        with pytest.raises(TerminalMapError, match=r"lab\.yaml: port is 0; valid is 1 to 65535"):
            describe_graph(GraphSettings(robot="hardware", terminal=file))


class TestLaunchFile:
    def test_its_arguments_are_the_choices(self) -> None:
        choices = {field.name for field in dataclasses.fields(GraphSettings)}
        assert set(launch_arguments()) - choices == {"params_file"}
        assert choices - set(launch_arguments()) <= {"start_paused"}

    def test_its_defaults_are_those_of_the_choices(self) -> None:
        as_text = {True: "true", False: "false", None: ""}
        for field in dataclasses.fields(GraphSettings):
            if field.name in launch_arguments():
                default = launch_arguments()[field.name][0]
                value = field.default
                assert default == (as_text[value] if isinstance(value, bool | None) else str(value))

    def test_every_argument_is_described(self) -> None:
        for default, description, choices in launch_arguments().values():
            assert len(description) > 10
            assert choices is None or default in choices


class TestCompose:
    """A container a node: together they are the graph that `up` starts."""

    SERVICES = yaml.safe_load((SOURCES.parent / "docker/compose.yaml").read_text())["services"]

    def check(self, nodes: list[NodeDescription], environment: dict[str, str]) -> None:
        for node in nodes:
            command = [
                re.sub(r"\$\{(\w+):-(.*?)\}", lambda m: environment.get(m[1], m[2]), part)
                for part in self.SERVICES[node.executable]["command"]
            ]
            assert command[1:3] == [node.package, node.executable]
            given = dict(part.split(":=") for part in command if ":=" in part)
            values = {**declared(node), **given}
            for name, value in node.parameters.items():
                assert str(values[name]) == str(value), f"{node.executable}: {name}"

    def test_simulated(self) -> None:
        models = Path("/home/bha/models/bha_sim_0")
        self.check(describe_graph(GraphSettings(models=models)), {})

    def test_on_the_pneumatics(self) -> None:
        """Else its models would be taken for those of the simulator, and the other way round."""
        models = Path("/home/bha/models/cpx_e_lab")
        settings = GraphSettings(robot="hardware", terminal=LAB, models=models)
        _, *others = describe_graph(settings)
        self.check(others, {"ROBOT": "cpx_e_lab"})


class TestParameterFile:
    """The example that a lab copies."""

    CONTENT = yaml.safe_load((SOURCES / "bha_bringup/config/params.yaml").read_text())

    def test_it_names_the_nodes(self) -> None:
        assert set(self.CONTENT) == {f"/**/{name}" for name in NAMES}

    @pytest.mark.parametrize("node", ALL, ids=NAMES)
    def test_its_values_are_the_defaults(self, node: NodeDescription) -> None:
        parameters = declared(node)
        values = flat(self.CONTENT[f"/**/{node.executable}"]["ros__parameters"])
        for name, value in values.items():
            assert name in parameters
            assert value == parameters[name]
            assert type(value) is type(parameters[name])
