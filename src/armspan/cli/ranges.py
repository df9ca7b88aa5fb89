"""Numbers of a command line, each in its range, for argparse."""

import argparse
import math


def number(text: str, what: str, low: float, high: float) -> float:
    """A number in its range, for argparse."""
    value = _value(text)
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f"{text!r} is not {what} from {low:g} to {high:g}")
    return value


def integer(text: str, what: str, low: int, high: int) -> int:
    """A whole number in its range, for argparse."""
    value = _value(text)
    if not (low <= value <= high and value == int(value)):
        raise argparse.ArgumentTypeError(f"{text!r} is not {what} from {low} to {high}")
    return int(value)


def _value(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def port(text: str) -> int:
    """A TCP port."""
    return integer(text, "a port", 0, 65535)


def seed(text: str) -> int:
    """A seed."""
    return integer(text, "a seed", 0, 2**32)


def share(text: str) -> float:
    """A share of one."""
    return number(text, "a share", 0, 1)
