"""Errors of this package."""


class DriverError(Exception):
    """Something is wrong with the terminal or with what is known of it; the message says what."""


class TerminalMapError(DriverError, ValueError):
    """A terminal map that cannot be used; the message names the field and what would be valid."""


class TerminalError(DriverError):
    """The terminal did not do what it was asked; the message says what it did instead."""


class FaultScheduleError(DriverError, ValueError):
    """A schedule of faults that cannot be read; the message names the entry and the choices."""
