"""What can go wrong, by name."""

import reprlib
from typing import Any

_short = reprlib.Repr()
_short.maxlevel, _short.maxlist, _short.maxtuple, _short.maxdict = 2, 4, 4, 4
_short.maxstring = _short.maxother = 40


def shown(value: Any) -> str:
    """A wrong value, for a message: a few lines of yaml can stand for a billion entries."""
    return _short.repr(value)


class SafePassageError(Exception):
    """Base of this package's errors: the message names the topic, frame, file or parameter."""


class ParameterError(SafePassageError):
    """A parameter is unknown, of the wrong type, or out of its range."""


class InputError(SafePassageError):
    """A file or message cannot be used: the message says which and why."""
