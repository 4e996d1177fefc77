"""Keeps pymodbus quiet: every failure reaches the user as an error of this package, once."""

from __future__ import annotations

import logging


def silence() -> None:
    """Let pymodbus log nothing; it would even dump the last packets after each late answer."""
    for name in ("pymodbus", "pymodbus.logging"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
