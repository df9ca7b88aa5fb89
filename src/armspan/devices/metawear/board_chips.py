"""The chips of an emulated board: what they feel, their switches and ranges, and the counts that they give."""

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from armspan.devices.metawear.board_models import MAG_RATES_HZ, Registers, Traits
from armspan.records import Quaternion, Vec3

GRAVITY = 9.80665
FULL = 32767
MAG_COUNTS_PER_UT = 16.0
GYRO_COUNTS_PER_DPS = 16.4
"""At ±2000 deg/s."""


@dataclass(frozen=True, slots=True)
class Felt:
    """What a band feels at ``t`` [s]: specific force [m/s²], rate [rad/s], field [µT], in ``sensor``.

    ``quat`` is ``earth_from_sensor`` as (w, x, y, z), where it is known.
    """

    t: float
    acc: Vec3
    gyr: Vec3
    mag: Vec3 = (20.0, 0.0, -40.0)
    quat: Quaternion | None = None


class Feeling:
    """What the board feels at any time: interpolated between what it was fed; lying still with noise before that."""

    def __init__(self, traits: Traits, generator: np.random.Generator) -> None:
        self._traits, self._generator = traits, generator
        self._fed: deque[Felt] = deque(maxlen=16)

    def feed(self, felt: Felt) -> None:
        """Take one more; times rise."""
        self._fed.append(felt)

    def at(self, t: float) -> Felt:
        """What is felt at ``t``; after the last that was fed, that one still."""
        if not self._fed:
            return self._still(t)
        later = next((each for each in self._fed if each.t >= t), self._fed[-1])
        earlier = next((each for each in reversed(self._fed) if each.t <= t), self._fed[0])
        if later.t <= earlier.t:
            return later
        return _between(earlier, later, (t - earlier.t) / (later.t - earlier.t), t)

    def _still(self, t: float) -> Felt:
        traits, draw = self._traits, self._generator.normal(size=9)
        acc, gyr, mag = draw[:3] * traits.acc_noise, draw[3:6] * traits.gyr_noise, draw[6:] * traits.mag_noise
        return Felt(
            t,
            (float(acc[0]), float(acc[1]), GRAVITY + float(acc[2])),
            (float(gyr[0]), float(gyr[1]), float(gyr[2])),
            (20.0 + float(mag[0]), float(mag[1]), -40.0 + float(mag[2])),
            None,
        )


def _between(a: Felt, b: Felt, share: float, t: float) -> Felt:
    def mixed(u: Vec3, v: Vec3) -> Vec3:
        x, y, z = (p + share * (q - p) for p, q in zip(u, v, strict=True))
        return x, y, z

    return Felt(
        t, mixed(a.acc, b.acc), mixed(a.gyr, b.gyr), mixed(a.mag, b.mag), _turned_between(a.quat, b.quat, share)
    )


def _turned_between(a: Quaternion | None, b: Quaternion | None, share: float) -> Quaternion | None:
    if a is None or b is None:
        return b
    sign = 1.0 if sum(p * q for p, q in zip(a, b, strict=True)) >= 0.0 else -1.0
    w, x, y, z = ((1.0 - share) * p + share * sign * q for p, q in zip(a, b, strict=True))
    size = math.sqrt(w * w + x * x + y * y + z * z)
    return w / size, x / size, y / size, z / size


@dataclass(slots=True)
class Chip:
    """A chip: its three switches are power, interrupt and (elsewhere) a subscription."""

    registers: Registers
    config: bytes = b""
    powered: bool = False
    interrupt: bool = False
    pack: list[bytes] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.config = self.config or self.registers.first

    @property
    def running(self) -> bool:
        """Samples are taken."""
        return self.powered and self.interrupt

    def switch(self, register: int, data: bytes) -> None:
        """A write to 01 (power), 02 (interrupt: enable mask, disable mask) or 03 (configuration)."""
        if register == 0x01 and data:
            self.powered = data[0] == 1
        elif register == 0x02 and len(data) >= 2:
            self.interrupt = bool(data[0] & 1) or (self.interrupt and not data[1] & 1)
        elif register == 0x03 and data:
            self.config = data[: len(self.registers.first)]
        if not self.running:
            self.pack.clear()

    @property
    def range(self) -> float:
        """Full scale [g or deg/s]; a code that there is not leaves the smallest sensitivity."""
        return self.registers.ranges.get(self.config[-1], max(self.registers.ranges.values()))

    def three(self, counts: bytes) -> bytes | None:
        """Gather three samples for one packet; None until there are three."""
        self.pack.append(counts)
        if len(self.pack) < 3:
            return None
        packet = b"".join(self.pack)
        self.pack.clear()
        return packet


def acc_rate_hz(chip: Chip) -> float:
    """0.78125 Hz at 1, twice as much with each step."""
    return 0.78125 * 2.0 ** ((chip.config[0] & 0x0F) - 1)


def gyro_rate_hz(chip: Chip) -> float:
    """25 Hz at 6, twice as much with each step."""
    return 25.0 * 2.0 ** ((chip.config[0] & 0x0F) - 6)


def mag_rate_hz(chip: Chip) -> float:
    """By table."""
    return MAG_RATES_HZ[chip.config[0] & 0x07]


def acc_counts(chip: Chip, acc: Vec3) -> tuple[int, int, int]:
    """Specific force [m/s²] in counts, saturated at the range."""
    return _counts(acc, 32768.0 / chip.range / GRAVITY)


def gyro_counts(chip: Chip, gyr: Vec3) -> tuple[int, int, int]:
    """Rate [rad/s] in counts, saturated at the range."""
    return _counts(gyr, math.degrees(1.0) * GYRO_COUNTS_PER_DPS * 2000.0 / chip.range)


def mag_counts(mag: Vec3) -> tuple[int, int, int]:
    """Field [µT] in counts."""
    return _counts(mag, MAG_COUNTS_PER_UT)


def _counts(vector: Vec3, per_unit: float) -> tuple[int, int, int]:
    x, y, z = (max(-FULL - 1, min(FULL, round(each * per_unit))) for each in vector)
    return x, y, z
