"""The state of a generator as settings."""

import json

import numpy as np
import pytest

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.random_state import generator_settings, restored_generator


@pytest.mark.parametrize("bits", [np.random.PCG64, np.random.PCG64DXSM])
def test_continues_through_json(bits: type[np.random.BitGenerator]) -> None:
    """After a trip through JSON the same numbers come, also from half-used words."""
    rng = np.random.Generator(bits(7))
    rng.integers(10, dtype=np.uint32)  # leaves half a word in the generator's buffer
    twin = restored_generator(json.loads(json.dumps(generator_settings(rng))))
    np.testing.assert_array_equal(
        twin.integers(9, size=5, dtype=np.uint32), rng.integers(9, size=5, dtype=np.uint32)
    )
    np.testing.assert_array_equal(twin.standard_normal(100), rng.standard_normal(100))


def test_refuses_other_generators() -> None:
    """The message says which are known."""
    with pytest.raises(InvalidConfigError, match="PCG64"):
        generator_settings(np.random.Generator(np.random.MT19937(0)))


@pytest.mark.parametrize("spoil", ["bit_generator", "state", "has_uint32"])
def test_refuses_incomplete_settings(spoil: str) -> None:
    """Nothing is guessed."""
    settings = generator_settings(np.random.default_rng(0))
    del settings[spoil]
    with pytest.raises(InvalidConfigError):
        restored_generator(settings)
