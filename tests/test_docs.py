"""The documentation says what the code does: parameters, names, messages, commands, examples."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

from bha_bringup.cli import app
from bha_bringup.graph import NAMESPACE, GraphSettings, describe_graph
from bha_common import ros_goals, ros_model_files, ros_node
from bha_common.ros_parameters import declare_settings
from bha_goal_babbling import task as task_module
from bha_goal_babbling.babbler_config import GoalBabblerConfig

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.glob("*.md"), *ROOT.glob("*.md"), *ROOT.glob("docker/*.md")])
GRAPH = (DOCS / "graph.md").read_text(encoding="utf-8")
PARAMS_FILE = ROOT / "src" / "bha_bringup" / "config" / "params.yaml"
EVERY_NODE = "every node"
DESCRIBED = {
    node.executable: node.parameters
    for robot in ("sim", "hardware-emulated")
    for node in describe_graph(GraphSettings(robot=robot))
}


def page_name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


# --- reading the pages -----------------------------------------------------------------------


def section(text: str, title: str) -> str:
    """The text under a heading, up to the next heading of any level."""
    match = re.search(rf"^#+ {re.escape(title)}\n(.*?)(?=^#|\Z)", text, re.MULTILINE | re.DOTALL)
    assert match, f"there is no section {title!r}"
    return match[1]


def rows(text: str) -> list[list[str]]:
    """The cells of the first table in a text, its header left out, without code marks."""
    cells = []
    for line in text.splitlines():
        if line.startswith("|"):
            parts = re.split(r"(?<!\\)\|", line.strip())[1:-1]
            cells.append([part.strip().replace("`", "") for part in parts])
        elif cells:
            break
    assert len(cells) > 2, "there is no table"
    return cells[2:]


def blocks(text: str, language: str) -> list[str]:
    """The fenced blocks of a language, indented ones too."""
    pattern = rf"^( *)```{language}\n(.*?)^ *```$"
    return [inspect.cleandoc("\n" + m[2]) for m in re.finditer(pattern, text, re.M | re.S)]


def calls_of_bha(text: str) -> set[str]:
    """The first words behind `./bha` wherever the text calls it as code."""
    code = re.findall(r"`([^`\n]+)`", text) + re.findall(r"^```\w*\n(.*?)^```", text, re.M | re.S)
    return {verb for part in code for verb in re.findall(r"\./bha\s+([a-z][\w-]*)", part)}


# --- reading the code ------------------------------------------------------------------------


def node_modules() -> dict[str, ModuleType]:
    """The modules of the nodes, by the node's name."""
    found = {}
    for path in sorted(ROOT.glob("src/*/*/*_node.py")):
        if path.name == "ros_node.py":
            continue
        module = importlib.import_module(f"{path.parent.name}.{path.stem}")
        found[path.stem.removesuffix("_node")] = module
    return found


NODES = node_modules()


def calls(module: ModuleType, function: str) -> list[ast.Call]:
    """All calls of a function or a method in a module."""
    tree = ast.parse(inspect.getsource(module))
    return [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and getattr(node.func, "attr", getattr(node.func, "id", "")) == function
    ]


class Parameters:
    """Takes the place of a node and keeps what is declared."""

    def __init__(self) -> None:
        self.default: dict[str, Any] = {}
        self.unit: dict[str, str] = {}

    def declare_parameter(self, name: str, default: Any, descriptor: Any) -> Any:
        unit = re.search(r"\[([^\]]+)\]", descriptor.description)
        self.default[name], self.unit[name] = default, unit[1] if unit else ""
        return type("Parameter", (), {"value": default})


def declared(module: ModuleType) -> Parameters:
    parameters = Parameters()
    for call in calls(module, "declare_settings"):
        assert isinstance(call.args[1], ast.Name)
        prefix = ast.literal_eval(call.args[2]) if len(call.args) > 2 else ""
        settings = getattr(module, call.args[1].id)
        declare_settings(parameters, settings, prefix)  # type: ignore[arg-type]
    return parameters


def endpoints(functions: dict[str, tuple[int, int]]) -> dict[tuple[str, str], set[str]]:
    """Names and types that nodes give to some functions, and which nodes do.

    `functions` tells for each function which arguments are type and name.
    """
    users: dict[tuple[str, str], set[str]] = defaultdict(set)
    shared = [
        (node, server)
        for node, module in NODES.items()
        for used, server in (("ModelFiles", ros_model_files), ("GoalServer", ros_goals))
        if calls(module, used)
    ]
    for node, module in [*NODES.items(), (EVERY_NODE, ros_node), *shared]:
        for function, (kind, name) in functions.items():
            for call in calls(module, function):
                if isinstance(call.args[name], ast.Constant):
                    topic = call.args[name].value.replace("~", node)
                    users[topic, ast.unparse(call.args[kind])].add(node)
    return dict(users)


# --- parameters ------------------------------------------------------------------------------


def test_every_node_has_a_section() -> None:
    assert len(NODES) == 6
    assert {row[0] for row in rows(section(GRAPH, "The graph"))} == set(DESCRIBED) == set(NODES)


@pytest.mark.parametrize("node", NODES)
def test_parameters_are_those_that_the_node_declares(node: str) -> None:
    expected = declared(NODES[node])
    table = rows(section(GRAPH, node))
    assert sorted(row[0] for row in table) == sorted(expected.default)
    for name, default, unit, meaning in table:
        value = expected.default[name]
        if isinstance(value, bool):
            assert default == str(value).lower(), name
        elif isinstance(value, str):
            assert default == value, name
        elif isinstance(value, list):
            assert default == f"{len(value)} x {str(value[0]).lower()}", name
        else:
            assert float(default) == value, name
        assert unit == expected.unit[name], name
        assert meaning, name


def test_settings_of_the_babbler_are_those_of_its_config() -> None:
    text = (DOCS / "learner.md").read_text(encoding="utf-8")
    table = rows(text[text.index("| setting of `babbler`") :])
    expected = {
        name: "none" if value is None else str(value)
        for name, value in GoalBabblerConfig().as_mapping().items()
    }
    assert {row[0]: row[1] for row in table} == expected


def test_entries_of_a_task_file_are_those_that_are_read() -> None:
    text = (DOCS / "learner.md").read_text(encoding="utf-8")
    named = {name for row in rows(text[text.index("| entry |") :]) for name in row[0].split(", ")}
    goals = {f"goals.{name}" for name in task_module._GOAL_ENTRIES}
    assert named == goals | set(task_module._ENTRIES) - {"goals"}


def test_the_example_of_a_parameter_file_holds_defaults() -> None:
    content = yaml.safe_load(PARAMS_FILE.read_text(encoding="utf-8"))
    assert {key.removeprefix("/**/") for key in content} == set(NODES)

    def flat(values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
        result: dict[str, Any] = {}
        for name, value in values.items():
            nested = isinstance(value, dict)
            result |= flat(value, f"{prefix}{name}.") if nested else {prefix + name: value}
        return result

    for key, value in content.items():
        node = key.removeprefix("/**/")
        defaults = declared(NODES[node]).default
        for name, given in flat(value["ros__parameters"]).items():
            assert given == defaults[name], f"{node}: {name}"
            assert type(given) is type(defaults[name]), f"{node}: {name}"
            assert name not in DESCRIBED[node], f"{node}: {name} would undo what `up` sets"


# --- topics, services, actions ----------------------------------------------------------------


def names(cell: str) -> set[str]:
    return {name.strip() for name in cell.split(",") if name.strip()}


def test_topics_are_those_of_the_nodes() -> None:
    table = rows(section(GRAPH, "Topics"))
    published = endpoints({"create_publisher": (0, 1)})
    read = endpoints({"subscribe_stream": (0, 1), "create_subscription": (0, 1)})
    assert {(row[0], row[1]): names(row[2]) for row in table} == published
    assert {(row[0], row[1]): names(row[3]) for row in table if row[3]} == read


def test_qualities_of_service_are_those_of_the_nodes() -> None:
    latched = ros_node.LATCHED_QOS.depth
    assert f"*control* is reliable, keep last {ros_node.CONTROL_QOS.depth}," in GRAPH
    assert f"*Latched* is reliable, keep last {latched}, transient local" in GRAPH
    own = (DOCS / "your_robot.md").read_text(encoding="utf-8")
    assert f"reliable, transient local, depth {latched} " in own


def test_services_and_actions_are_those_of_the_nodes() -> None:
    table = rows(section(GRAPH, "Services and actions"))
    expected = {**endpoints({"create_service": (0, 1)}), **endpoints({"ActionServer": (1, 2)})}
    found = {(row[0], row[1].removesuffix(" (action)")): names(row[2]) for row in table}
    assert found == expected
    actions = {name for name, _ in endpoints({"ActionServer": (1, 2)})}
    assert {row[0] for row in table if row[1].endswith(" (action)")} == actions


@pytest.mark.parametrize("node", NODES)
def test_values_of_the_diagnostics_are_named(node: str) -> None:
    tree = ast.parse(inspect.getsource(NODES[node]))
    diagnose = next(
        item
        for item in ast.walk(tree)
        if isinstance(item, ast.FunctionDef) and item.name == "diagnose"
    )
    keys = {
        key.value
        for item in ast.walk(diagnose)
        if isinstance(item, ast.Dict)
        for key in item.keys
        if isinstance(key, ast.Constant)
    }
    table = {row[0]: names(row[1]) for row in rows(section(GRAPH, "Diagnostics"))}
    assert table[node] == keys


CALL = re.compile(
    r"^ros2 (service call|action send_goal)(?: -f| --feedback)? "
    r"(\S+) (\w+)/(srv|action)/(\w+) \"(.*)\"$"
)


def test_calls_typed_out_fit_their_types() -> None:
    services = endpoints({"create_service": (0, 1)})
    actions = endpoints({"ActionServer": (1, 2)})
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    typed = re.findall(r"^ros2 (?:service|action) .*", text.replace("\\\n", ""), re.MULTILINE)
    assert len(typed) >= 10
    for line in typed:
        match = CALL.match(re.sub(r"  +", " ", line))
        assert match, f"not understood: {line}"
        verb, name, package, kind, message, values = match.groups()
        assert (verb == "service call") == (kind == "srv"), line
        served = services if kind == "srv" else actions
        assert (name.removeprefix(f"{NAMESPACE}/"), message) in served, line
        interface = getattr(importlib.import_module(f"{package}.{kind}"), message)
        filled = interface.Request() if kind == "srv" else interface.Goal()
        fill(filled, yaml.safe_load(values))


def fill(message: Any, values: dict[str, Any]) -> None:
    """Set fields as `ros2` does; a wrong name or type raises."""
    fields = message.get_fields_and_field_types()
    for name, value in values.items():
        assert name in fields, f"{type(message).__name__} has no field {name}: {sorted(fields)}"
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        else:
            setattr(message, name, value)


# --- what a reader does ------------------------------------------------------------------------


PYTHON = [
    pytest.param(block, id=f"{page_name(page)}-{number}")
    for page in PAGES
    for number, block in enumerate(blocks(page.read_text(encoding="utf-8"), "python"), 1)
]


@pytest.mark.slow
@pytest.mark.parametrize("block", PYTHON)
def test_python_examples_run(block: str, tmp_path: Path) -> None:
    result = subprocess.run(
        [sys.executable, "-c", block], cwd=tmp_path, capture_output=True, text=True, timeout=240
    )
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_other_python_and_yaml_is_well_formed(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for block in blocks(text, "py"):
        compile(block, page.name, "exec")
    for block in blocks(text, "yaml"):
        for key, value in yaml.safe_load(block).items():
            node = key.removeprefix("/**/")
            if node in NODES:
                given = value["ros__parameters"]
                known = {name.split(".")[0] for name in declared(NODES[node]).default}
                assert set(given) <= known, f"{node}: {set(given) - known} is unknown"


def anchors(text: str) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in headings}


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_links_resolve(page: Path) -> None:
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"\w+://|mailto:", link):
            continue
        target, _, anchor = link.partition("#")
        path = (page.parent / target) if target else page
        assert path.exists(), f"{page_name(page)} links to {link}"
        if anchor and path.suffix == ".md":
            assert anchor in anchors(path.read_text(encoding="utf-8")), link


def verbs() -> set[str]:
    script = (ROOT / "bha").read_text(encoding="utf-8")
    dispatch = script[script.index('case "$verb" in') :]
    own = {
        word
        for line in re.findall(r"^ +([a-z |-]+)\)", dispatch, re.M)
        for word in line.split(" | ")
    }
    groups = {group.name for group in app.registered_groups if group.name}
    return (
        own
        | groups
        | {
            command.name or command.callback.__name__
            for command in app.registered_commands
            if command.callback
        }
    )


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_verbs_of_bha_exist(page: Path) -> None:
    unknown = calls_of_bha(page.read_text(encoding="utf-8")) - verbs()
    assert not unknown, f"{page_name(page)}: ./bha has no {unknown}; it has {sorted(verbs())}"


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_options_of_bha_exist(page: Path) -> None:
    known = {
        command.name or command.callback.__name__: inspect.getsource(command.callback)
        for command in app.registered_commands
        if command.callback
    }
    code = re.findall(r"`\./bha ([^`\n]+)`", page.read_text(encoding="utf-8"))
    for call in code:
        verb, *rest = call.split()
        for option in (word for word in rest if word.startswith("--")):
            if verb in known:
                name = option.removeprefix("--").replace("-", "_")
                alias = name == "feedback" and "Feedback" in known[verb]
                assert re.search(rf"\b{name}: ", known[verb]) or alias, f"./bha {call}"


@pytest.mark.parametrize("page", PAGES, ids=page_name)
def test_files_that_are_named_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for name in re.findall(r"`((?:src|docs|tests|benchmarks|docker|tools)/[\w./-]+)`", text):
        assert (ROOT / name).exists(), f"{page_name(page)} names {name}"
    folders = ("src", "tests", "benchmarks", "tools")
    modules = {path.name for folder in folders for path in ROOT.glob(f"{folder}/**/*.py")}
    for name in re.findall(r"`(\w+\.py)`", text):
        assert name in modules, f"{page_name(page)} names {name}"
