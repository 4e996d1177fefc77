"""What is latched stays, the first of each kind."""

from bha_driver.latched_faults import EMERGENCY_STOP, LINK_LOST, LatchedFaults


def test_the_first_of_a_kind_stays_and_the_order_too() -> None:
    faults = LatchedFaults()
    assert not faults
    faults.latch(LINK_LOST, "the cable", 1.0)
    faults.latch(LINK_LOST, "something else", 2.0)
    faults.latch(EMERGENCY_STOP, "", 3.0)
    assert [str(fault) for fault in faults.all] == ["connection lost: the cable", "emergency stop"]
    assert faults.all[0].time == 1.0
    assert faults
    faults.clear()
    assert not faults
    assert faults.all == ()
