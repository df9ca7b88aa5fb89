"""The bytes that a host sends to a MetaWear board, without I/O; and `decode` for what the board says.

Every function returns one write (bytes) or several in their order (tuple of bytes). Those whose bytes depend on the
board's chips or revisions take a `boards.Board` first. Names::

    subscribe(board, stream)   unsubscribe(board, stream)      stream of STREAMS: acc acc_packed gyro ... quaternion
    enable_sampling(sensor)    disable_sampling(sensor)        sensor of SENSORS: acc gyro mag
    start(sensor)              stop(sensor)
    configure_acc(board, rate_hz, range_g)                     configure_gyro(board, rate_hz, range_dps)
    configure_mag(board, xy, z, rate_hz)                       preset_mag(board, preset)       suspend_mag(board)
    configure_fusion(board, mode, range_g, range_dps)          start_fusion(mode, outputs)     stop_fusion(mode)
    read(what) of READS        enable_taps(...)                write_calibration(mode, acc, gyro, mag)
    decode(notification, board, ranges) -> notifications.Notification

LED, motor and buzzer are in `signals`; on-board programs (the fused packet too), logging and cleaning in `programs`;
connection parameters, name and supply in `settings`; the frames of the USB cable in `usb_frames`; the structs that
`decode` returns in `notifications`.

Every encoder raises DeviceError, in one sentence that names what exists, for what must not reach the wire.

Sources: MbientLab MetaWear-API (docs/protocol-reference.md, api-specification.md, usb-transport.md) and the bytes
that the tests of MetaWear-SDK-Cpp 0.30.0 assert.
"""

from collections.abc import Iterable, Mapping
from typing import Final

from armspan.devices.metawear.boards import ACC, DEBUG, FUSION, GYRO, MAG, SETTINGS, SWITCH, Board
from armspan.devices.metawear.decoding import decode as decode
from armspan.devices.metawear.notifications import Notification as Notification
from armspan.devices.metawear.notifications import Ranges as Ranges
from armspan.devices.metawear.quantities import (
    ACC_CODES,
    ACC_RATES_HZ,
    GYRO_RANGES_DPS,
    GYRO_RATES_HZ,
    MAG_RATES_HZ,
    MODES,
    OUTPUTS,
    code_of,
    counts,
    named,
)
from armspan.errors import DeviceError

SERVICE: Final = "326a9000-85cb-9195-d9dd-464cfbbae75a"
COMMAND: Final = "326a9001-85cb-9195-d9dd-464cfbbae75a"
NOTIFY: Final = "326a9006-85cb-9195-d9dd-464cfbbae75a"
BOOTLOADER_SERVICE: Final = "00001530-1212-efde-1523-785feabcd123"
PACKET_BYTES: Final = 20
"""The longest packet of the default ATT MTU."""

SENSORS: Final[Mapping[str, int]] = {"acc": ACC, "gyro": GYRO, "mag": MAG}
MODE_SENSORS: Final[Mapping[str, tuple[str, ...]]] = {
    "ndof": ("acc", "gyro", "mag"),
    "imu_plus": ("acc", "gyro"),
    "compass": ("acc", "mag"),
    "m4g": ("acc", "mag"),
}
"""The chips that a fusion mode lives on."""
MODE_RATES_HZ: Final[Mapping[str, float]] = {"ndof": 100.0, "imu_plus": 100.0, "compass": 25.0, "m4g": 50.0}
"""The accelerometer's (and gyro's) rate in a fusion mode; the outputs come as often."""
FUSION_MAG: Final = (9, 15, 25.0)
"""Repetitions in plane and across, and rate [Hz], of the magnetometer in fusion."""
MAG_PRESETS: Final[Mapping[str, tuple[int, int, float]]] = {
    "low_power": (3, 3, 10.0),
    "regular": (9, 15, 10.0),
    "enhanced_regular": (15, 27, 10.0),
    "high_accuracy": (47, 83, 20.0),
}
"""Bosch's own for the BMM150: repetitions in plane and across, rate [Hz]."""
_FIXED_STREAMS: Final[Mapping[str, tuple[int, int]]] = {
    "switch": (SWITCH, 0x01),
    "acc": (ACC, 0x04),
    "tap": (ACC, 0x0E),
    "gesture": (ACC, 0x0A),
    "activity": (ACC, 0x0C),
    "mag": (MAG, 0x05),
    "mag_packed": (MAG, 0x09),
    "power_status": (SETTINGS, 0x11),
    "charge_status": (SETTINGS, 0x12),
    **{output: (FUSION, 0x04 + bit) for bit, output in enumerate(OUTPUTS)},
}
STREAMS: Final = (*_FIXED_STREAMS, "acc_packed", "gyro", "gyro_packed")
READS: Final[Mapping[str, bytes]] = {
    "acc_config": b"\x03\x83",
    "gyro_config": b"\x13\x83",
    "fusion_config": b"\x19\x82",
    "calibration_state": b"\x19\x8b",
    "calibration_acc": b"\x19\x8c",
    "calibration_gyro": b"\x19\x8d",
    "calibration_mag": b"\x19\x8e",
    "battery": b"\x11\x8c",
    "mac": b"\x11\x8b",
    "power_status": b"\x11\x91",
    "charge_status": b"\x11\x92",
    "switch": b"\x01\x81",
    "log_time": b"\x0b\x84",
    "log_length": b"\x0b\x85",
}
RESET: Final = b"\xfe\x01"
BOOTLOADER: Final = b"\xfe\x02"
RESET_AFTER_GC: Final = b"\xfe\x05"
DISCONNECT: Final = b"\xfe\x06"
POWER_SAVE: Final = b"\xfe\x07"
ADVERTISE: Final = b"\x11\x05"
FEATURES: Final[Mapping[str, int]] = {
    "significant_motion": 0x01,
    "step_counter": 0x02,
    "activity": 0x04,
    "wrist_wakeup": 0x08,
    "gesture": 0x10,
    "no_motion": 0x20,
    "any_motion": 0x40,
    "step_detector": 0x80,
}
"""What a BMI270 notices by itself, as the chip's own interrupt map (Bosch BMI270 data sheet, INT1_MAP_FEAT)."""
CALIBRATION_BYTES: Final = 10


def stream_register(board: Board, stream: str) -> tuple[int, int]:
    """The module and the register that a stream of STREAMS comes from on this board."""
    if stream == "acc_packed":
        return ACC, 0x1C if board.acc_chip == "bmi160" else 0x05
    if stream == "gyro":
        return GYRO, 0x05 if board.gyro_chip == "bmi160" else 0x04
    if stream == "gyro_packed":
        return GYRO, 0x07 if board.gyro_chip == "bmi160" else 0x05
    named("the MetaWear stream", stream, STREAMS)
    if stream == "mag_packed" and not board.has(MAG, 1):
        raise DeviceError(f"the {board.name} packs no magnetometer samples: that needs its module's revision 1")
    return _FIXED_STREAMS[stream]


def subscribe(board: Board, stream: str) -> bytes:
    """Let a stream of STREAMS come."""
    return bytes((*stream_register(board, stream), 1))


def unsubscribe(board: Board, stream: str) -> bytes:
    """Let a stream of STREAMS come no more."""
    return bytes((*stream_register(board, stream), 0))


def enable_sampling(sensor: str) -> bytes:
    """Let a chip's samples reach the streams."""
    return bytes((_sensor(sensor), 2, 1, 0))


def disable_sampling(sensor: str) -> bytes:
    """Let a chip's samples reach nothing."""
    return bytes((_sensor(sensor), 2, 0, 1))


def start(sensor: str) -> bytes:
    """Power a chip on."""
    return bytes((_sensor(sensor), 1, 1))


def stop(sensor: str) -> bytes:
    """Power a chip off."""
    return bytes((_sensor(sensor), 1, 0))


def configure_acc(board: Board, rate_hz: float, range_g: float) -> bytes:
    """The accelerometer's rate, of ACC_RATES_HZ, and range: 2, 4, 8 or 16 g."""
    odr = 1 + code_of("an accelerometer rate", rate_hz, ACC_RATES_HZ, "Hz")
    code = ACC_CODES[board.acc_chip][code_of("an accelerometer range", range_g, (2, 4, 8, 16), "g")]
    fast = odr >= 5  # from 12.5 Hz up
    if board.acc_chip == "bmi160":
        return bytes((ACC, 3, odr | (0x20 if fast else 0x80), code))
    return bytes((ACC, 3, odr | (0xA0 if fast else 0x20), code))


def configure_gyro(board: Board, rate_hz: float, range_dps: float) -> bytes:
    """The gyro's rate, of GYRO_RATES_HZ, and range, of GYRO_RANGES_DPS."""
    board.implementation(GYRO)
    odr = 6 + code_of("a gyro rate", rate_hz, GYRO_RATES_HZ, "Hz")
    return bytes((GYRO, 3, 0x20 | odr, code_of("a gyro range", range_dps, GYRO_RANGES_DPS, "deg/s")))


def gyro_offsets(x: int, y: int, z: int) -> bytes:
    """The BMI270 gyro's offsets, each a byte of the chip's own."""
    return bytes((GYRO, 6, *(counts("a gyro offset", value, 0, 0xFF) for value in (x, y, z))))


def configure_mag(board: Board, xy: int, z: int, rate_hz: float) -> tuple[bytes, ...]:
    """The magnetometer's repetitions in plane (1 to 511, odd) and across (1 to 256), and its rate of MAG_RATES_HZ.

    From revision 2 the chip is stopped first.
    """
    plane = counts("repetitions in plane", xy, 1, 511)
    across = counts("repetitions across", z, 1, 256)
    rate = code_of("a magnetometer rate", rate_hz, MAG_RATES_HZ, "Hz")
    repetitions = bytes((MAG, 4, (plane - 1) // 2, across - 1))
    before = (stop("mag"),) if board.revision(MAG) >= 2 else ()
    return (*before, repetitions, bytes((MAG, 3, rate)))


def preset_mag(board: Board, preset: str) -> tuple[bytes, ...]:
    """The magnetometer as one of MAG_PRESETS."""
    return configure_mag(board, *MAG_PRESETS[named("the magnetometer preset", preset, MAG_PRESETS)])


def suspend_mag(board: Board) -> tuple[bytes, ...]:
    """Let the magnetometer sleep; nothing before revision 2, which cannot."""
    return (bytes((MAG, 1, 2)),) if board.revision(MAG) >= 2 else ()


def enable_taps(board: Board, *, single: bool = True, double: bool = False) -> bytes:
    """Let a BMI160 notice taps; none of both: no more."""
    if board.acc_chip != "bmi160":
        raise DeviceError(f"the {board.name}'s accelerometer is a {board.acc_chip}; only the bmi160 notices taps")
    kinds = single << 1 | double
    return bytes((ACC, 0x0C, kinds, 0 if kinds else 3))


def switch_feature(board: Board, feature: str, *, on: bool) -> tuple[bytes, ...]:
    """Let a BMI270 notice one of FEATURES, or no more."""
    if board.acc_chip != "bmi270":
        raise DeviceError(f"the {board.name}'s accelerometer is a {board.acc_chip}; only the bmi270 notices {feature}")
    mask = FEATURES[named("the BMI270's feature", feature, FEATURES)]
    masks = (mask, 0) if on else (0, mask)
    return bytes((ACC, 7, *masks)), bytes((ACC, 6, *masks))


def configure_fusion(board: Board, mode: str, range_g: float = 16, range_dps: float = 2000) -> tuple[bytes, ...]:
    """The fusion's mode, of MODES, and its chips' ranges; the firmware leaves the chips to the host.

    The ranges are 2, 4, 8, 16 g and 2000, 1000, 500, 250 deg/s, for modes without a gyro too.
    """
    board.implementation(FUSION)
    number = MODES[named("the fusion mode", mode, MODES)]
    g = code_of("an accelerometer range", range_g, (2, 4, 8, 16), "g")
    dps = code_of("a gyro range in fusion", range_dps, GYRO_RANGES_DPS[:4], "deg/s")
    if mode == "sleep":
        return (bytes((FUSION, 2, number, g | (dps + 1) << 4)),)
    writes = [bytes((FUSION, 2, number, g | (dps + 1) << 4)), configure_acc(board, MODE_RATES_HZ[mode], range_g)]
    if "gyro" in MODE_SENSORS[mode]:
        writes.append(configure_gyro(board, MODE_RATES_HZ[mode], range_dps))
    if "mag" in MODE_SENSORS[mode]:
        writes.extend(configure_mag(board, *FUSION_MAG))
    return tuple(writes)


def start_fusion(mode: str, outputs: Iterable[str]) -> tuple[bytes, ...]:
    """Let the chips of a mode and these OUTPUTS run."""
    sensors = MODE_SENSORS[named("the fusion mode", mode, MODE_SENSORS)]
    return (
        *map(enable_sampling, sensors),
        *map(start, sensors),
        bytes((FUSION, 3, output_mask(outputs), 0)),
        bytes((FUSION, 1, 1)),
    )


def stop_fusion(mode: str) -> tuple[bytes, ...]:
    """Stop the fusion, all its outputs, and the chips of its mode."""
    sensors = MODE_SENSORS[named("the fusion mode", mode, MODE_SENSORS)]
    halt = (bytes((FUSION, 1, 0)), bytes((FUSION, 3, 0, 0x7F)))
    return (*halt, *map(stop, sensors), *map(disable_sampling, sensors))


def _sensor(sensor: str) -> int:
    return SENSORS[named("the sensor", sensor, SENSORS)]


def output_mask(outputs: Iterable[str]) -> int:
    """The bits of these OUTPUTS."""
    mask = 0
    for output in outputs:
        mask |= 1 << OUTPUTS.index(named("the fusion output", output, OUTPUTS))
    return mask


def reset_orientation(board: Board) -> bytes:
    """Let the fusion's heading begin anew (revision 3 of the fusion)."""
    if not board.has(FUSION, 3):
        raise DeviceError(f"the {board.name}'s fusion cannot reset its orientation: that needs its revision 3")
    return bytes((FUSION, 0x0F, 1))


def write_calibration(mode: str, acc: bytes, gyro: bytes = b"", mag: bytes = b"") -> tuple[bytes, ...]:
    """Give back calibration data as it was read, ten bytes a chip; of the chips of the mode only.

    Magnetometer data of an accuracy below 3 crashes the firmware (MbientLab MetaWear-API-Swift): check before.
    """
    given = {"acc": acc, "gyro": gyro, "mag": mag}
    sensors = MODE_SENSORS[named("the fusion mode", mode, MODE_SENSORS)]
    for sensor in sensors:
        if len(given[sensor]) != CALIBRATION_BYTES:
            raise DeviceError(
                f"calibration data of {sensor} has {len(given[sensor])} bytes; a board gives and takes 10"
            )
    return tuple(bytes((FUSION, 0x0C + list(given).index(sensor))) + given[sensor] for sensor in sensors)


def read(what: str) -> bytes:
    """Ask for one of READS."""
    return READS[named("the MetaWear reading", what, READS)]


def ask_module(module: int) -> bytes:
    """Ask whether a module is there, and how it is made."""
    return bytes((counts("a module", module, 0, 0xFF), 0x80))


def spoof(module: int, register: int, data: bytes = b"") -> bytes:
    """Let the board send that very notification; a self-test."""
    header = (counts("a module", module, 0, 0xFF), counts("a register", register, 0, 0xFF))
    if len(data) > PACKET_BYTES - 4:
        raise DeviceError(f"a spoofed notification carries {len(data)} bytes; at most {PACKET_BYTES - 4} fit")
    return bytes((DEBUG, 3, *header)) + data
