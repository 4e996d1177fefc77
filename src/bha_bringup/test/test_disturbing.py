"""Words on the command line that disturb the simulated robot."""

from __future__ import annotations

import pytest

from bha_bringup.disturbing import as_parameters, read_disturbances
from bha_sim.disturbances import Disturbances


def test_no_word_is_a_sound_robot():
    assert read_disturbances([]) == Disturbances()


def test_words_for_all_bellows_and_for_one():
    found = read_disturbances(
        [
            *("payload=0.2", "softening=0.1", "softening.bellows_3_3=0.4", "leak.bellows_2_1=0.3"),
            *("stuck_valves.bellows_1_1=true", "sensor_shift=-2e-3"),
        ]
    )
    assert found == Disturbances(
        payload=0.2,
        softening=(0.1,) * 8 + (0.4,),
        leak=(0.0,) * 3 + (0.3,) + (0.0,) * 5,
        stuck_valves=(True,) + (False,) * 8,
        sensor_shift=(-0.002,) * 9,
    )
    parameters = as_parameters(found)
    assert parameters["disturbances.payload"] == 0.2
    assert len(parameters) == 8


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("payload", r"'payload' is not NAME=VALUE"),
        ("weight=1", "there is no disturbance 'weight'; there are payload, softening"),
        ("payload.bellows_1_1=1", "payload is not one of a bellows"),
        ("payload=heavy", "'heavy' is no number"),
        ("payload=5", r"payload is 5\.0; valid is 0\.0 to 1\.0"),
        ("leak.bellows_9_9=1", "there is no bellows_9_9"),
        ("leak=true", "leak must hold a finite number, got True"),
        ("stuck_valves=1", r"stuck_valves must hold true or false, got 1\.0"),
    ],
)
def test_a_wrong_word_is_explained(word: str, message: str):
    with pytest.raises(ValueError, match=message):
        read_disturbances([word])
