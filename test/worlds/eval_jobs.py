"""Jobs that other processes can find."""

import os

from safe_passage.core.errors import ParameterError


def square(number):
    return number * number


def fail_at_three(number):
    if number == 3:
        raise ParameterError("three")
    return number


def die(number):
    os._exit(1)
