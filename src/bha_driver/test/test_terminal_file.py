import copy
from typing import Any

import pytest
import yaml

from bha_common import bellows
from bha_driver.driver_settings import DriverSettings
from bha_driver.errors import TerminalMapError
from bha_driver.terminal_file import example_path, load_terminal, parse_terminal

EXAMPLES = ("cpx_e", "cpx_mpa", "emulated")
GOOD = yaml.safe_load(example_path("cpx_e").read_text())


def changed(path: str, value: Any) -> str:
    """The example with one field set, or taken out when the value is `...`."""
    data = copy.deepcopy(GOOD)
    *parents, last = path.split(".")
    place = data
    for name in parents:
        place = place[name]
    if value is ...:
        del place[last]
    else:
        place[last] = value
    return yaml.safe_dump(data)


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_examples_are_good(name: str) -> None:
    terminal = load_terminal(example_path(name))
    assert len(terminal.bellows) == bellows.COUNT
    assert terminal.output_block[1] == bellows.COUNT


def test_the_registers_are_those_that_festo_names() -> None:
    """As festo-cpx-io counts: those of the bus module first, then those of each module."""
    lab = load_terminal(example_path("cpx_e"))
    assert lab.output_block == (40001 + 2, 9)
    analog_inputs = 45392 + 3 + 3 * 5  # behind the bus module and three output modules
    for kind, first in (("length", analog_inputs), ("pressure", analog_inputs + 3 * 5)):
        registers = [getattr(item, kind).register for item in lab.bellows]
        assert registers == [first + 5 * (index // 4) + index % 4 for index in range(9)]
    classic = load_terminal(example_path("cpx_mpa"))
    assert classic.output_block[0] == 40001
    assert classic.input_block[0] == 45392
    registers = [item.pressure.register for item in classic.bellows]
    assert registers == list(range(45392, 45392 + 27, 3)), "three words a valve"


def test_without_a_file_it_is_the_emulated_one() -> None:
    assert load_terminal().name == "bha_emulated"


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("hosts", "x", "hosts is unknown; valid are name, host, port"),
        ("host", ..., "host is missing"),
        ("host", 5, "host is 5; it must be text"),
        ("port", "502", "port is '502'; it must be a whole number"),
        ("port", 70000, "port is 70000; valid is 1 to 65535"),
        ("port", True, "port is True; it must be a whole number"),
        ("unit", 300, "unit is 300; valid is 0 to 255"),
        ("inputs", "coils", "inputs is 'coils'; valid are holding, input"),
        ("read_back", "no", "read_back is 'no'; it must be true or false"),
        ("identity", {"register": 1}, "identity.words is missing"),
        ("identity", {"register": 1, "words": [-1]}, "identity.words is"),
        ("timeouts", None, "timeouts must hold request, connect, link, reconnect"),
        ("timeouts.reqest", 0.1, "timeouts.reqest is unknown; valid are request, connect"),
        ("timeouts.request", 0.08, "timeouts.request is 0.08; it must be at most timeouts.link"),
        ("timeouts.link", 0.15, "timeouts.link is 0.15; it must be at most half of watchdog.time"),
        ("watchdog.time", 0.05, "watchdog.time is 0.05; valid is 0.1 to 10"),
        ("watchdog.time", 0.20037, None),
        ("watchdog.step", 0.15, "watchdog.time is 0.2; it must be a multiple of watchdog.step"),
        ("limits.pressure", "1e5", "limits.pressure is '1e5'; it must be a number, such as"),
        ("limits.pressure", float("nan"), "limits.pressure is nan; valid is 1.0 to"),
        ("limits.pressure", 3e5, "limits.pressure is 300000.0; valid is 1.0 to 200000.0"),
        ("limits.shortest", 0.5, "limits.longest is 0.4; it must be above shortest, 0.5 m"),
        ("bellows.bellows_4_1", {}, "bellows.bellows_4_1 is unknown; valid are bellows_1_1"),
        ("bellows.bellows_2_3", ..., "bellows.bellows_2_3 is missing; all nine"),
        ("bellows.bellows_1_1.set_point", ..., "bellows.bellows_1_1.set_point is missing"),
        ("bellows.bellows_1_1.length.sclae", 1.0, "bellows_1_1.length.sclae is unknown; valid are"),
        ("bellows.bellows_1_1.length.scale", 0.0, "bellows_1_1.length.scale is 0"),
        ("bellows.bellows_1_1.set_point.scale", 1.0e-320, "set_point.scale is 9.99989e-321; one"),
        ("bellows.bellows_1_1.set_point.offset", -1.0e300, "set_point.offset is -1e+300; valid"),
        ("bellows.bellows_1_1.length.scale", 10**400, "length.scale is too large a number"),
        ("port", 10**400, "port is too large a number; it has 401 digits"),
        ("bellows.bellows_1_1.length.register", 65536, "length.register is 65536; valid is 0 to"),
        (
            "bellows.bellows_1_1.length.format",
            "int32",
            "format is 'int32'; valid are int16, uint16",
        ),
        (
            "bellows.bellows_1_1.length.register",
            45411,
            "bellows_1_2.length.register is 45411, which",
        ),
        ("bellows.bellows_1_1.length.register", 45000, "one read covers 125 at most"),
        (
            "bellows.bellows_1_1.set_point.register",
            40004,
            "set_point.register is 40004, which is that of bellows.bellows_1_1.set_point already",
        ),
        (
            "watchdog.register",
            40011,
            "watchdog.register is 40011, which is that of bellows.bellows_3_3.set_point already",
        ),
        (
            "watchdog.register",
            45425,
            "watchdog.register is 45425, which is that of bellows.bellows_1_1.pressure already",
        ),
        (
            "bellows.bellows_2_1.length.register",
            40006,
            "bellows_2_1.length.register is 40006, which is that of bellows.bellows_2_1.set_point",
        ),
        (
            "identity",
            {"register": 45408, "words": [1, 2, 3]},
            "the register of identity.words[2] is 45410, which is that of bellows.bellows_1_1.len",
        ),
        ("bellows.bellows_1_1.set_point.register", 39990, "would overwrite 39991, 39992"),
        ("bellows.bellows_1_1.set_point.scale", -7.0, "set_point.scale must be above 0"),
        ("bellows.bellows_1_1.set_point.scale", 1.0, "would be the raw set-point 130000; at most"),
        ("bellows.bellows_1_1.set_point.offset", 500.0, "a negative set-point makes a valve"),
        ("bellows.bellows_1_1.set_point.offset", -5e4, None),
    ],
)
def test_what_is_wrong_is_named(path: str, value: Any, message: str | None) -> None:
    text = changed(path, value)
    if message is None:
        parse_terminal(text)
        return
    with pytest.raises(TerminalMapError) as caught:
        parse_terminal(text)
    assert message in str(caught.value)


def test_input_registers_have_addresses_of_their_own() -> None:
    data = copy.deepcopy(GOOD)
    data["inputs"] = "input"
    for number, name in enumerate(bellows.NAMES):
        data["bellows"][name]["length"]["register"] = 40001 + number
        data["bellows"][name]["pressure"]["register"] = 40011 + number
    assert parse_terminal(yaml.safe_dump(data)).input_block == (40001, 19)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name: a\nhost: b\nname: c", "line 3: name stands in line 1 already"),
        ("limits:\n  pressure: 5.0e+4\n  pressure: 1.3e+5", "line 3: pressure stands in line 2"),
        ("bellows: {bellows_1_1: {scale: 1.0, scale: 2.0}}", "line 1: scale stands in line 1"),
        (f"port: {'9' * 5000}", "not YAML"),
    ],
)
def test_yaml_that_is_not_what_it_seems(text: str, message: str) -> None:
    with pytest.raises(TerminalMapError, match=message):
        parse_terminal(text)


@pytest.mark.parametrize(("period", "good"), [(0.03, True), (0.031, False), (0.1, False)])
def test_a_control_period_must_suit_the_terminal(period: float, good: bool) -> None:
    chosen = DriverSettings(terminal=str(example_path("cpx_e")), control_period=period)
    if good:
        assert chosen.terminal_map().name == "cpx_e_lab"
        return
    message = rf"control_period is {period:g}; it must be at most half of timeouts.link, 0.06 s"
    with pytest.raises(TerminalMapError, match=message):
        chosen.terminal_map()


def test_files_that_cannot_be_read(tmp_path: Any) -> None:
    with pytest.raises(TerminalMapError, match=r"none\.yaml: cannot be read"):
        load_terminal(tmp_path / "none.yaml")
    (tmp_path / "broken.yaml").write_text("name: [")
    with pytest.raises(TerminalMapError, match=r"broken\.yaml: not YAML"):
        load_terminal(tmp_path / "broken.yaml")
    (tmp_path / "list.yaml").write_text("- 1")
    with pytest.raises(TerminalMapError, match="the file must hold name, host"):
        load_terminal(tmp_path / "list.yaml")
