"""What can go wrong with the simulated robot."""

from __future__ import annotations


class BhaSimError(Exception):
    """Base of every error of this package."""


class RobotParameterError(BhaSimError, ValueError):
    """A physical number that cannot be; the message names the field and what would be right."""


class PlantDivergedError(BhaSimError, RuntimeError):
    """The simulated motion left what a robot can do; the message names what diverged."""
