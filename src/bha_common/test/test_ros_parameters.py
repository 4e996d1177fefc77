"""ROS parameters from frozen settings."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")

from rclpy.context import Context
from rclpy.exceptions import (
    InvalidParameterValueException,
    ParameterException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from bha_common.ros_parameters import declare_settings, refuse_unknown
from bha_common.settings import check_settings, setting


@dataclass(frozen=True)
class Gains:
    proportional: float = setting(3.0, "Gain [1/s]", low=0.0, high=10.0)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True)
class Example:
    rate: float = setting(0.5, "Rate [1/s]", low=0.0)
    count: int = setting(3, "Number of things", low=1, high=9)
    open: float = setting(-7.0, "Without bounds [m]")
    switch: bool = setting(False, "On or off")
    state: str = setting("vent", "What to do", choices=("vent", "hold"))
    gains: Gains = field(default_factory=lambda: Gains(proportional=4.0))
    file: str = setting("", "Where it is written; nowhere if empty")

    def __post_init__(self) -> None:
        check_settings(self)


@pytest.fixture(scope="module")
def context() -> Iterator[Context]:
    """Return a context in a domain of its own."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    made = Context()
    made.init(args=[], domain_id=1 + os.getpid() % 100)
    yield made
    made.try_shutdown()


@pytest.fixture
def declare(context: Context) -> Iterator[Any]:
    """Return a function that makes a node with parameters and reads the settings."""
    nodes: list[Node] = []

    def read(**given: Any) -> tuple[Node, Example]:
        overrides = [
            Parameter(name.replace("__", "."), value=value) for name, value in given.items()
        ]
        node = Node(
            "example",
            context=context,
            parameter_overrides=overrides,
            start_parameter_services=False,
            enable_rosout=False,
        )
        nodes.append(node)
        return node, declare_settings(node, Example)

    yield read
    for node in nodes:
        node.destroy_node()


def test_defaults(declare: Any) -> None:
    """Also those that a group is given by its owner and not by its class."""
    node, settings = declare()
    assert settings == Example()
    assert node.get_parameter("gains.proportional").value == 4.0


def test_values_of_the_user(declare: Any) -> None:
    _, settings = declare(
        rate=2.5, count=7, switch=True, state="hold", open=1e9, gains__proportional=9.0
    )
    assert settings == Example(2.5, 7, 1e9, True, "hold", Gains(9.0))


def test_descriptions_and_ranges_can_be_seen_from_outside(declare: Any) -> None:
    node, _ = declare()
    rate = node.describe_parameter("rate")
    assert rate.description == "Rate [1/s]"
    assert rate.floating_point_range[0].from_value == 0.0
    count = node.describe_parameter("count").integer_range[0]
    assert (count.from_value, count.to_value) == (1, 9)
    assert node.describe_parameter("state").additional_constraints == "vent, hold"
    assert not node.describe_parameter("open").floating_point_range


def test_parameters_hold_from_start_to_end(declare: Any) -> None:
    node, settings = declare()
    (result,) = node.set_parameters([Parameter("rate", value=2.0)])
    assert not result.successful
    assert node.get_parameter("rate").value == settings.rate == 0.5


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"rate": -1.0}, "rate"),
        ({"count": 0}, "count"),
        ({"count": 10}, "count"),
        ({"gains__proportional": 11.0}, r"gains\.proportional"),
        ({"state": "fly"}, "state"),
        ({"open": float("nan")}, "open"),
        ({"rate": float("nan")}, "rate"),
        ({"rate": float("inf")}, "rate"),
    ],
)
def test_values_out_of_range_name_the_parameter(
    declare: Any, given: dict[str, Any], name: str
) -> None:
    with pytest.raises((ValueError, InvalidParameterValueException), match=name):
        declare(**given)


@pytest.mark.parametrize(
    ("given", "right"),
    [
        ({"rate": 1}, "like 0.5"),
        ({"count": 1.0}, "like 3"),
        ({"switch": "on"}, "like False"),
        ({"state": True}, "vent or hold"),
        ({"file": 7}, "like ''"),
    ],
)
def test_values_of_another_type(declare: Any, given: dict[str, Any], right: str) -> None:
    """The message tells what would be right."""
    with pytest.raises(ValueError, match=f"{next(iter(given))}.* It must be {right}"):
        declare(**given)


def test_a_parameter_that_no_one_declares_is_refused(declare: Any) -> None:
    """With those that may be meant; what rclpy declares by itself is none of them."""
    node, _ = declare(rate=1.0, use_sim_time=False, gains__proportional=2.0)
    refuse_unknown(node)
    node, _ = declare(gains__proportionl=2.0, zzz=1)
    with pytest.raises(ValueError, match="example: there is no parameter") as refusal:
        refuse_unknown(node)
    assert str(refusal.value) == (
        "example: there is no parameter 'gains.proportionl' (is gains.proportional meant?); "
        "there is no parameter 'zzz'"
    )


def test_the_errors_are_those_that_end_a_node_with_a_message() -> None:
    """`ros_node.run` catches ValueError and ParameterException."""
    assert issubclass(InvalidParameterValueException, ParameterException)
