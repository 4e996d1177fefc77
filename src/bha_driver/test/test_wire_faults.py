import pytest

from bha_driver.errors import FaultScheduleError
from bha_driver.wire_faults import FAULTS, parse_faults, random_faults


def test_a_schedule_is_read() -> None:
    faults = parse_faults("delay@20+0.5, cut@10, restart@1.5+2")
    assert [(fault.name, fault.at, fault.duration) for fault in faults] == [
        ("restart", 1.5, 2.0),
        ("cut", 10.0, 0.5),
        ("delay", 20.0, 0.5),
    ]
    assert parse_faults("") == []


@pytest.mark.parametrize("text", ["melt@3", "cut", "cut@", "cut@1+0", "cut@1+-1", "cut@1.2.3"])
def test_what_is_no_schedule_is_refused_with_the_choices(text: str) -> None:
    with pytest.raises(FaultScheduleError, match=r"delay|last longer"):
        parse_faults(text)


def test_random_schedules_are_those_of_their_seed() -> None:
    first, again, other = (random_faults(seed, 600.0, 5.0) for seed in (1, 1, 2))
    assert first == again != other
    assert {fault.name for fault in first} == set(FAULTS)
    ends = [fault.at + fault.duration for fault in first]
    assert all(end <= fault.at for end, fault in zip(ends, first[1:], strict=False))
