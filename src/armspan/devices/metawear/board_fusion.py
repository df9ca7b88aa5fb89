"""The sensor fusion of an emulated board: what it puts out, when, and how well it is calibrated.

The attitude is what the board is fed; the board adds what its modes do to it. Without the magnetometer (IMU+) the
heading at each start is a new one.
"""

import math
import struct
from dataclasses import dataclass, field

import numpy as np

from armspan.devices.metawear.board_chips import GRAVITY, GYRO_COUNTS_PER_DPS, MAG_COUNTS_PER_UT, Felt
from armspan.devices.metawear.board_models import ACC, GYRO, MAG, Traits
from armspan.records import Quaternion, Vec3

NDOF, IMU_PLUS, COMPASS, M4G = 1, 2, 3, 4
NEEDED: dict[int, tuple[int, ...]] = {
    NDOF: (ACC, GYRO, MAG),
    IMU_PLUS: (ACC, GYRO),
    COMPASS: (ACC, MAG),
    M4G: (ACC, MAG),
}
RATES_HZ = {NDOF: 100.0, IMU_PLUS: 100.0, COMPASS: 25.0, M4G: 50.0}
OUTPUTS = {0x01: 0x04, 0x02: 0x05, 0x04: 0x06, 0x08: 0x07, 0x10: 0x08, 0x20: 0x09, 0x40: 0x0A}
"""Register of each bit of the mask: corrected acc, gyro, mag, quaternion, Euler, gravity, linear acc."""
CALIBRATION = {ACC: 0x0C, GYRO: 0x0D, MAG: 0x0E}
GOOD = 3


@dataclass(slots=True)
class Fusion:
    """The fusion's switches and its state."""

    traits: Traits
    generator: np.random.Generator
    config: bytes = b"\x00\x13"
    enabled: bool = False
    mask: int = 0
    heading: float = 0.0
    crashed: bool = False
    ran: dict[int, float] = field(default_factory=lambda: {ACC: 0.0, GYRO: 0.0, MAG: 0.0})
    _yaw: float = 0.0

    @property
    def mode(self) -> int:
        """0 sleeps."""
        return self.config[0]

    def configure(self, data: bytes) -> None:
        """A write to 02: mode and ranges; another mode begins anew."""
        if len(data) >= 2:
            changed = data[0] != self.mode
            self.config = data[:2]
            if changed:
                self._begin()

    def enable(self, on: bool) -> None:
        """A write to 01."""
        self.enabled = on
        if on:
            self._begin()

    def choose(self, data: bytes) -> None:
        """A write to 03: outputs to enable, outputs to disable."""
        if len(data) >= 2:
            self.mask = (self.mask | data[0]) & ~data[1] & 0x7F

    def level(self) -> None:
        """A write to 0f: the heading of now becomes zero."""
        self.heading = -self._yaw

    def _begin(self) -> None:
        """The filter begins anew, and without a magnetometer towards anywhere."""
        self._yaw = 0.0
        self.heading = float(self.generator.uniform(-math.pi, math.pi)) if self.mode == IMU_PLUS else 0.0

    # --- calibration --------------------------------------------------------------------------------------

    def accuracy(self, module: int) -> int:
        """How well a chip is calibrated, 0 to 3: it rises while the fusion runs on it."""
        needed = dict(zip((ACC, GYRO, MAG), self.traits.calibrated_after_s, strict=True))[module]
        return min(GOOD, int(GOOD * self.ran[module] / needed + 1e-6)) if needed > 0.0 else GOOD

    def state(self) -> bytes:
        """The three accuracies."""
        return bytes(self.accuracy(module) for module in (ACC, GYRO, MAG))

    def data(self, module: int) -> bytes:
        """Ten bytes of calibration; the last tells their accuracy, as this emulator keeps it."""
        numbers = self.traits.serial.encode().ljust(8, b"\0")[:8]
        return bytes([module]) + numbers + bytes([self.accuracy(module)])

    def load(self, module: int, data: bytes) -> None:
        """Calibration that is written back; poor data of the magnetometer crash the fusion, as on real boards."""
        if len(data) != 10:
            return
        good = data[-1] >= GOOD
        if good:
            self.ran[module] = max(self.traits.calibrated_after_s)
        elif module == MAG:
            self.crashed = True

    # --- output -------------------------------------------------------------------------------------------

    def run(self, seconds: float) -> None:
        """The fusion has run for so long."""
        for module in NEEDED.get(self.mode, ()):
            self.ran[module] += seconds

    def attitude(self, felt: Felt, seconds: float) -> Quaternion:
        """``earth_from_sensor`` as the board takes it to be."""
        if felt.quat is None:
            up = _unit(felt.acc)
            self._yaw += seconds * sum(rate * axis for rate, axis in zip(felt.gyr, up, strict=True))
            return turned(self.heading + self._yaw, _levelled(up))
        w, x, y, z = felt.quat
        self._yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        return turned(self.heading, felt.quat)

    def output(self, register: int, quat: Quaternion, acc: Vec3, gyr: Vec3, mag: Vec3) -> bytes:
        """The payload of an output: counts of acc and gyro are read in the ranges that the fusion was told."""
        up = _up(quat)
        force_g = [each / (32768.0 / self.acc_range_g) for each in acc]
        if register == 0x04:
            return _floats(*(1000.0 * each for each in force_g)) + bytes([self.accuracy(ACC)])
        if register == 0x05:
            scale = GYRO_COUNTS_PER_DPS * 2000.0 / self.gyro_range_dps
            return _floats(*(each / scale for each in gyr)) + bytes([self.accuracy(GYRO)])
        if register == 0x06:
            return _floats(*(each / MAG_COUNTS_PER_UT for each in mag)) + bytes([self.accuracy(MAG)])
        if register == 0x07:
            return _floats(*quat)
        if register == 0x08:
            return _floats(*_euler(quat))
        gravity = [GRAVITY * each for each in up]
        if register == 0x09:
            return _floats(*gravity)
        return _floats(*(GRAVITY * force - down for force, down in zip(force_g, gravity, strict=True)))

    @property
    def acc_range_g(self) -> float:
        """As written to 02."""
        return 2.0 ** (1 + (self.config[1] & 0x03))

    @property
    def gyro_range_dps(self) -> float:
        """As written to 02, where it is told plus one."""
        return 2000.0 / 2.0 ** max(0, (self.config[1] >> 4) - 1)


def turned(angle: float, quat: Quaternion) -> Quaternion:
    """Turned about the vertical of ``earth`` by ``angle`` [rad]."""
    c, s = math.cos(angle / 2.0), math.sin(angle / 2.0)
    w, x, y, z = quat
    return c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w


def _levelled(up: Vec3) -> Quaternion:
    """The shortest turn that brings ``up_sensor`` to the vertical."""
    x, y, z = up
    if z < -0.999999:
        return 0.0, 1.0, 0.0, 0.0
    w = math.sqrt((1.0 + z) / 2.0)
    return w, y / (2.0 * w), -x / (2.0 * w), 0.0


def _up(quat: Quaternion) -> Vec3:
    """The vertical of ``earth`` in ``sensor``."""
    w, x, y, z = quat
    return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z


def _euler(quat: Quaternion) -> tuple[float, float, float, float]:
    """Heading (0 to 360), pitch, roll, yaw [deg]."""
    w, x, y, z = quat
    yaw = math.degrees(math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
    pitch = math.degrees(math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)))
    roll = math.degrees(math.asin(max(-1.0, min(1.0, 2.0 * (w * y - x * z)))))
    return yaw % 360.0, pitch, roll, yaw % 360.0


def _unit(vector: Vec3) -> Vec3:
    size = math.sqrt(sum(each * each for each in vector)) or 1.0
    x, y, z = (each / size for each in vector)
    return x, y, z


def _floats(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}f", *values)
