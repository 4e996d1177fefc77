"""The state of a random generator as plain settings, and back."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bha_goal_babbling.errors import InvalidConfigError

_BIT_GENERATORS = {"PCG64": np.random.PCG64, "PCG64DXSM": np.random.PCG64DXSM}


def generator_settings(rng: np.random.Generator) -> dict[str, Any]:
    """Return the generator's state as nested settings of names and whole numbers.

    Raises
    ------
    InvalidConfigError
        If its bit generator is none of PCG64 (numpy's default) and PCG64DXSM.
    """
    state = dict(rng.bit_generator.state)
    _check_name(state.get("bit_generator"))
    # Whole numbers of 128 bits go as text: not every reader of JSON keeps them exact.
    state["state"] = {name: str(value) for name, value in state["state"].items()}
    return state


def restored_generator(settings: Mapping[str, Any]) -> np.random.Generator:
    """Return a generator that continues where the one with these settings was.

    Raises
    ------
    InvalidConfigError
        If the settings are not those of a known bit generator.
    """
    name = settings.get("bit_generator")
    _check_name(name)
    bit_generator = _BIT_GENERATORS[str(name)]()
    try:
        numbers = {key: int(value) for key, value in settings["state"].items()}
        bit_generator.state = {**settings, "state": numbers}
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise InvalidConfigError(f"the state of the generator is not complete: {error!r}") from None
    return np.random.Generator(bit_generator)


def _check_name(name: Any) -> None:
    if name not in _BIT_GENERATORS:
        raise InvalidConfigError(
            f"bit generator must be one of {', '.join(_BIT_GENERATORS)}, got {name!r}; "
            "use numpy.random.default_rng(seed)"
        )
