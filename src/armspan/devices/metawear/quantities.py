"""The rates, ranges, modes and outputs of a MetaWear board by their numbers, and what a number may be.

Sources: MbientLab MetaWear-API, docs/protocol-reference.md; Bosch BMI160, BMI270, BMM150 registers.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from armspan.errors import DeviceError, known_names

ACC_RATES_HZ: Final = tuple(0.78125 * 2**k for k in range(12))
"""0.78125 to 1600."""
ACC_RANGES_G: Final = (2, 4, 8, 16)
ACC_CODES: Final[Mapping[str, tuple[int, int, int, int]]] = {"bmi160": (3, 5, 8, 12), "bmi270": (0, 1, 2, 3)}
GYRO_RATES_HZ: Final = tuple(25.0 * 2**k for k in range(8))
"""25 to 3200."""
GYRO_RANGES_DPS: Final = (2000, 1000, 500, 250, 125)
MAG_RATES_HZ: Final = (10.0, 2.0, 6.0, 8.0, 15.0, 20.0, 25.0, 30.0)
MODES: Final[Mapping[str, int]] = {"sleep": 0, "ndof": 1, "imu_plus": 2, "compass": 3, "m4g": 4}
OUTPUTS: Final = ("corrected_acc", "corrected_gyro", "corrected_mag", "quaternion", "euler", "gravity", "linear_acc")
"""The fusion's, by the bit of their mask; their register is 4 more than that."""


def code_of(what: str, value: float, choices: Sequence[float], unit: str) -> int:
    """The place of a number among those that exist.

    Raises:
        DeviceError: where it is none of them.

    """
    number = within(what, value, 0, 1e6)
    for code, choice in enumerate(choices):
        if math.isclose(number, choice, rel_tol=1e-6):
            return code
    known = ", ".join(f"{choice:g}" for choice in sorted(choices))
    raise DeviceError(f"{what} of {value:g} {unit} does not exist; there are: {known} {unit}")


def chosen(what: str, code: int, choices: Sequence[float]) -> float:
    """The number that a code means.

    Raises:
        DeviceError: for a code beyond them.

    """
    if not 0 <= code < len(choices):
        raise DeviceError(f"{what} has the code {code:#x}; known are {len(choices)} of them")
    return choices[code]


def within(what: str, value: float, low: float, high: float) -> float:
    """A number between two bounds, as it is.

    Raises:
        DeviceError: where it is not.

    """
    if not isinstance(value, int | float) or not low <= value <= high:
        raise DeviceError(f"{what} is {value}; expected a number from {low:g} to {high:g}")
    return value


def counts(what: str, value: float, low: int, high: int) -> int:
    """A whole number between two bounds, as it is.

    Raises:
        DeviceError: where it is not.

    """
    if not isinstance(value, int | float) or not low <= value <= high or value != int(value):
        raise DeviceError(f"{what} is {value}; expected a whole number from {low} to {high}")
    return int(value)


def named(what: str, name: str, known: Iterable[str]) -> str:
    """A name that exists, as it is.

    Raises:
        DeviceError: where it does not.

    """
    names = list(known)
    if name not in names:
        raise DeviceError(known_names(what, name, names))
    return name
