"""The errors of this package: all of them are a `GoalBabblingError`."""


class GoalBabblingError(Exception):
    """Base of every error that goal babbling raises; nothing has been changed when it is raised."""


class InvalidConfigError(GoalBabblingError, ValueError):
    """A setting is missing, unknown, of the wrong type, or outside its range."""


class InvalidArrayError(GoalBabblingError, ValueError):
    """An array has the wrong shape, or holds NaN, infinity or absurdly large numbers."""


class WrongOrderError(GoalBabblingError, RuntimeError):
    """`tell` was called although nothing had been asked."""


class InvalidTaskError(GoalBabblingError, ValueError):
    """A task file cannot be read, or an entry of it is missing, unknown or out of range."""
