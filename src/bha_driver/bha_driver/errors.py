"""Errors of this package."""


class DriverError(Exception):
    """Something is wrong with the terminal or with what is known of it; the message says what."""


class TerminalMapError(DriverError, ValueError):
    """A terminal map that cannot be used; the message names the field and what would be valid."""


class TerminalError(DriverError):
    """The terminal did not do what it was asked; the message says what it did instead.

    Parameters
    ----------
    message : What happened.
    gone : Whether the terminal has ended the connection, or is not there; an answer that is late
        does not tell that.
    """

    def __init__(self, message: str, *, gone: bool = False) -> None:
        super().__init__(message)
        self.gone = gone


class AddressError(DriverError, ValueError):
    """An address that nobody can listen at; the message names it."""


class FaultScheduleError(DriverError, ValueError):
    """A schedule of faults that cannot be read; the message names the entry and the choices."""
