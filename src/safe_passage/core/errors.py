"""What can go wrong, by name."""


class SafePassageError(Exception):
    """Base of this package's errors: the message names the topic, frame, file or parameter."""


class ParameterError(SafePassageError):
    """A parameter is unknown, of the wrong type, or out of its range."""


class InputError(SafePassageError):
    """A file or message cannot be used: the message says which and why."""
