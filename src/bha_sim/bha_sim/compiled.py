"""Compilation of the few functions that run at every tick.

Nine bellows make arrays so small that calling numpy costs more than the arithmetic: compiled, a
tick takes half the time. The machine code is cached on disk, so only the first start compiles.

The cache notices a change in the file of a compiled function, but not in other files: a compiled
function calls only what stands in its own file.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile a function of arrays and numbers, with the rounding that numpy has."""
    result: Function = numba.njit(cache=True, fastmath=False)(function)
    return result
