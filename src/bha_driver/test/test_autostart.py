"""What the driver does by itself, and what it leaves to a person."""

import pytest

from bha_driver.autostart import Autostart


def test_none_does_nothing() -> None:
    auto = Autostart("none")
    assert [auto.next_step("unconfigured", now) for now in (0.0, 10.0)] == ["", ""]


def test_one_step_after_the_other_without_a_pause() -> None:
    auto = Autostart("activate")
    assert auto.next_step("unconfigured", 5.0) == "configure"
    assert auto.next_step("inactive", 5.0) == "activate"
    assert auto.next_step("active", 5.0) == ""


def test_a_step_that_failed_is_tried_again_once_a_second() -> None:
    auto = Autostart("configure")
    tried = [now for now in range(30) if auto.next_step("unconfigured", now * 0.1)]
    assert tried == [0, 10, 20]


@pytest.mark.parametrize("wanted", ["configure", "activate"])
def test_what_a_person_undoes_stays_undone(wanted: str) -> None:
    auto = Autostart(wanted)
    auto.next_step({"configure": "inactive", "activate": "active"}[wanted], 0.0)
    assert auto.next_step("inactive", 10.0) == ""
    assert auto.next_step("unconfigured", 20.0) == ""


def test_configure_never_activates() -> None:
    auto = Autostart("configure")
    assert auto.next_step("unconfigured", 0.0) == "configure"
    assert auto.next_step("inactive", 10.0) == ""


def test_nothing_is_tried_in_the_midst_of_a_transition_or_at_the_end() -> None:
    auto = Autostart("activate")
    assert auto.next_step("activating", 0.0) == auto.next_step("finalized", 10.0) == ""
