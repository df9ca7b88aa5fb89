"""What the emulated boards say of themselves: module tables, device information, registers of their chips.

Tables: the module answers of the vendor's public tests and of a trace of a real board. The emulator keeps its own
reading of every byte, apart from the client's codec, so that a mistake of one shows against the other.
"""

from dataclasses import dataclass, field
from typing import Literal

TICK_S = 48 / 32768
"""Length of a tick of the reference clock [s]."""

(
    SWITCH,
    LED,
    ACC,
    TEMPERATURE,
    HAPTIC,
    PROCESSOR,
    EVENT,
    LOGGING,
    TIMER,
    MACRO,
    SETTINGS,
    GYRO,
    MAG,
    FUSION,
    DEBUG,
) = (0x01, 0x02, 0x03, 0x04, 0x08, 0x09, 0x0A, 0x0B, 0x0C, 0x0F, 0x11, 0x13, 0x15, 0x19, 0xFE)


@dataclass(frozen=True)
class Model:
    """A kind of board: what follows ``[module, 80]`` for each module, and its strings of the device information."""

    modules: dict[int, bytes]
    number: str
    hardware: str
    firmware: str

    def implementation(self, module: int) -> int:
        """Which chip or variant a module is."""
        return self.modules[module][0]

    def revision(self, module: int) -> int:
        """How recent a module is; -1 where there is none."""
        known = self.modules.get(module, b"")
        return known[1] if len(known) > 1 else -1


@dataclass(frozen=True)
class Traits:
    """What differs from one board to the next, and what a real one may do to its client.

    ``absent``: a module that is not there is answered with two bytes ("short") or not at all ("silent"). ``drift`` of
    the board's crystal [s/s], noise per sample [m/s², rad/s, µT], ``boot_s``: out of reach after a reset [s];
    ``mag_settle_s``: a magnetometer that was just booted streams zeros unless it was stopped for so long.
    """

    absent: Literal["short", "silent"] = "short"
    drift: float = 20e-6
    first_tick: int = 1045
    reset_uid: int = 5
    battery: int = 87
    millivolts: int = 4012
    typed_mac: bool = True
    acc_noise: float = 0.02
    gyr_noise: float = 0.002
    mag_noise: float = 0.5
    boot_s: float = 2.0
    mag_settle_s: float = 0.2
    ignores_collection_reset: bool = False
    serial: str = "047D22"
    bootloader: bool = False
    calibrated_after_s: tuple[float, float, float] = (8.0, 3.0, 20.0)


def _table(text: str) -> dict[int, bytes]:
    pairs = (pair.split(":") for pair in text.split())
    return {int(module, 16): bytes.fromhex(rest) for module, rest in pairs}


_MOTION_R = _table(
    "01:0000 02:0000 03:0101 04:010000030102 05:00010303030301 07:0000 08:0000 09:00001c 0a:00001c 0b:000208802b0000 "
    "0c:000008 0d:0001 0f:000108 11:0003 12:0000 13:0001 14:0000 15:0001 19:00000300060002000100 fe:0002"
)
_MOTION_R_TRACED = _table(
    "01:0000 02:00010300 03:0102 04:010000030102 05:000203030303010101 06:0000 07:0000 08:0000 09:00031c 0a:00001c "
    "0b:00020800001000 0c:000008 0d:0001 0f:00020800 11:000a0000 12:0000 13:0001 14:0000 15:0002 "
    "19:00030300060002000100 fe:000603"
)
_MOTION_RL = {module: said for module, said in (_MOTION_R | {ACC: b"\x01\x02"}).items() if module not in (0x12, 0x14)}
_MOTION_RL_CURRENT = _table(
    "01:0000 02:00010300 03:0102 04:010000030102 05:000203030303030301 07:0000 08:0000 09:00031c 0a:00001c "
    "0b:0003080000fb030002 0c:000008 0d:0001 0f:00020800 11:000a0000 13:0001 15:0002 19:00030300060002000100 fe:000603"
)
_MOTION_S = _table(
    "01:0000 02:00010300 03:0400 04:010000030102 05:000203030303030301 07:0000 08:0000 09:00001c 0a:00001c "
    "0b:0003080000fb030002 0c:000008 0d:0001 0f:00020800 11:000a0700 12:0000 13:0100 14:0000 15:0002 "
    "19:00030300060002000100 fe:000503"
)

MODELS: dict[str, Model] = {
    "mmr_fw113": Model(_MOTION_R, "5", "0.2", "1.1.3"),
    "mmr_fw150": Model(_MOTION_R_TRACED, "5", "0.4", "1.5.0"),
    "mmrl_fw113": Model(_MOTION_RL, "5", "0.5", "1.1.3"),
    "mmrl_current": Model(_MOTION_RL_CURRENT, "5", "0.5", "1.7.2"),
    "mms": Model(_MOTION_S, "8", "0.1", "1.5.0"),
    "mms_current": Model(_MOTION_S | {PROCESSOR: b"\x00\x03\x1c", DEBUG: b"\x00\x06\x03"}, "8", "0.1", "1.7.2"),
}
"""The boards that can be emulated, by name."""


@dataclass(frozen=True)
class Registers:
    """Where a chip's data are: plain and in threes; ranges by what is written for them; conf and range at power-on."""

    plain: int
    packed: int
    ranges: dict[int, float]
    first: bytes
    conf_mask: int = field(default=0x0F)


ACC_REGISTERS = {
    1: Registers(0x04, 0x1C, {0x03: 2.0, 0x05: 4.0, 0x08: 8.0, 0x0C: 16.0}, b"\x28\x03"),
    4: Registers(0x04, 0x05, {0: 2.0, 1: 4.0, 2: 8.0, 3: 16.0}, b"\xa8\x02"),
}
"""By implementation: BMI160, BMI270; ranges in g."""
_TURNS = {index: 2000.0 / 2**index for index in range(5)}
GYRO_REGISTERS = {0: Registers(0x05, 0x07, _TURNS, b"\x28\x00"), 1: Registers(0x04, 0x05, _TURNS, b"\x28\x00")}
"""By implementation: BMI160, BMI270; ranges in deg/s."""
MAG_REGISTERS = Registers(0x05, 0x09, {}, b"\x00")
MAG_RATES_HZ = (10.0, 2.0, 6.0, 8.0, 15.0, 20.0, 25.0, 30.0)
