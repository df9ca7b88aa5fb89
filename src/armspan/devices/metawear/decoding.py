"""What the bytes on a MetaWear board's notify characteristic mean, without I/O.

Sources: MbientLab MetaWear-API, docs/protocol-reference.md; tests of MetaWear-SDK-Cpp 0.30.0.
"""

import math
import struct
from collections.abc import Callable, Mapping
from typing import Final, Literal, TypeAlias

from armspan.devices.metawear import quantities as q
from armspan.devices.metawear.boards import (
    ACC,
    EVENT,
    FUSION,
    GYRO,
    LOGGING,
    MACRO,
    MAG,
    MODULES,
    PROCESSOR,
    SETTINGS,
    SWITCH,
    TEMPERATURE,
    TIMER,
    Board,
)
from armspan.devices.metawear.notifications import (
    DEFAULTS,
    Acceleration,
    Activity,
    Battery,
    CalibrationData,
    CalibrationState,
    ChipConfig,
    Corrected,
    Created,
    Euler,
    Fused,
    FusionConfig,
    Gesture,
    LogEntries,
    LogEntry,
    LogLength,
    LogProgress,
    LogTime,
    Mac,
    ModuleInfo,
    Notification,
    Output,
    Quaternion,
    Ranges,
    Samples,
    Status,
    Switch,
    Tap,
    Temperature,
    Timed,
    TimerFired,
    Vector,
)
from armspan.errors import DeviceError

STANDARD_GRAVITY: Final = 9.80665
MG_PER_G: Final = 1000.0

_SENSORS: Final[tuple[Literal["acc"], Literal["gyro"], Literal["mag"]]] = ("acc", "gyro", "mag")
_CREATIONS: Final[Mapping[int, Literal["processor", "event", "logger", "timer", "macro"]]] = {
    PROCESSOR: "processor",
    EVENT: "event",
    LOGGING: "logger",
    TIMER: "timer",
    MACRO: "macro",
}


def decode(notification: bytes, board: Board, ranges: Ranges = DEFAULTS) -> Notification:
    """What a notification of this board means.

    Raises:
        DeviceError: where it means nothing to Armspan, or carries a number that cannot be.

    """
    if len(notification) < 2:
        raise DeviceError(f"{notification.hex() or 'nothing'} is no MetaWear notification: [module, register, ...]")
    module, register, payload = notification[0], notification[1], bytes(notification[2:])
    if register == 0x80:
        return _module_info(module, payload)
    if register == 0x02 and module in _CREATIONS:
        return Created(_CREATIONS[module], *_whole("B", payload, "a reply to a creation"))
    reader = _READERS.get(module)
    meaning = reader(register, payload, board, ranges) if reader else None
    if meaning is None:
        known = f"{MODULES.get(module, 'an unknown module')}'s register {register:#04x}"
        raise DeviceError(f"{notification[:20].hex()} means nothing to Armspan: it is of {known}")
    return meaning


def _module_info(module: int, payload: bytes) -> ModuleInfo:
    if not payload:
        return ModuleInfo(module, None, None, b"")
    if len(payload) == 1:
        raise DeviceError(f"{module:02x}80{payload.hex()} tells an implementation without a revision")
    return ModuleInfo(module, payload[0], payload[1], payload[2:])


def _acc(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    bmi160 = board.acc_chip == "bmi160"
    if register == 0x04 or register == (0x1C if bmi160 else 0x05):
        return Samples("acc", _vectors(payload, _per_unit("acc", ranges), 1 if register == 0x04 else 3))
    if register == 0x83:
        conf, code = _whole("BB", payload, "an accelerometer's settings")
        codes = q.ACC_CODES[board.acc_chip]
        if code not in codes:
            raise DeviceError(f"an accelerometer's range has the code {code:#x}; known are {codes}")
        rate_hz = q.chosen("an accelerometer's rate", (conf & 0x0F) - 1, q.ACC_RATES_HZ)
        return ChipConfig("acc", rate_hz, q.ACC_RANGES_G[codes.index(code)])
    if register == 0x0E and bmi160:
        return _tap(*_whole("B", payload, "a tap"))
    if register == 0x0A and not bmi160:
        (byte,) = _whole("B", payload, "a gesture")
        return Gesture(byte & 3, byte >> 2)
    if register == 0x0C and not bmi160:
        return Activity(_whole("B", payload, "an activity")[0] >> 1)
    return None


def _tap(byte: int) -> Tap:
    if not byte & 3:
        raise DeviceError(f"a tap of {byte:#04x} is neither single (bit 1) nor double (bit 0)")
    return Tap("double" if byte & 1 else "single", byte >> 5 & 1)


def _gyro(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    plain, packed = (0x05, 0x07) if board.gyro_chip == "bmi160" else (0x04, 0x05)
    if register in (plain, packed):
        return Samples("gyro", _vectors(payload, _per_unit("gyro", ranges), 1 if register == plain else 3))
    if register == 0x83:
        conf, code = _whole("BB", payload, "a gyro's settings")
        rate_hz = q.chosen("a gyro's rate", (conf & 0x0F) - 6, q.GYRO_RATES_HZ)
        return ChipConfig("gyro", rate_hz, q.chosen("a gyro's range", code & 7, q.GYRO_RANGES_DPS))
    return None


def _mag(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    if register in (0x05, 0x09):
        return Samples("mag", _vectors(payload, _per_unit("mag", ranges), 1 if register == 0x05 else 3))
    return None


def _fusion(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    match register:
        case 0x04 | 0x05 | 0x06:
            return _corrected(register, payload)
        case 0x07:
            return Quaternion(*_reals(payload, 4, "a quaternion"))
        case 0x08:
            return Euler(*_reals(payload, 4, "Euler angles"))
        case 0x09 | 0x0A:
            x, y, z = _reals(payload, 3, "an acceleration")
            return Acceleration("gravity" if register == 9 else "linear_acc", _divided((x, y, z), STANDARD_GRAVITY))
        case 0x82:
            return _fusion_config(*_whole("BB", payload, "the fusion's settings"))
        case 0x8B:
            return CalibrationState(*_whole("3B", payload, "a calibration state"))
        case 0x8C | 0x8D | 0x8E if len(payload) == 10:
            return CalibrationData(_SENSORS[register - 0x8C], payload)
    return None


def _corrected(register: int, payload: bytes) -> Corrected:
    x, y, z = _reals(payload[:12], 3, "a corrected sample")
    (accuracy,) = _whole("B", payload[12:], "the accuracy of a corrected sample")
    if register == 0x04:
        return Corrected("corrected_acc", _divided((x, y, z), MG_PER_G), accuracy)
    return Corrected("corrected_gyro" if register == 0x05 else "corrected_mag", (x, y, z), accuracy)


def _fusion_config(mode: int, code: int) -> FusionConfig:
    modes = {number: name for name, number in q.MODES.items()}
    if mode not in modes:
        raise DeviceError(f"the fusion's mode is {mode}; known are 0 to {max(modes)}")
    g, dps = code & 0x0F, (code >> 4) - 1
    range_g = q.ACC_RANGES_G[g] if g < len(q.ACC_RANGES_G) else None
    return FusionConfig(modes[mode], range_g, q.GYRO_RANGES_DPS[dps] if 0 <= dps < 4 else None)


def _settings(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    match register:
        case 0x8C:
            return Battery(*_whole("BH", payload, "the battery's state"))
        case 0x8B if len(payload) in (6, 7):  # seven: a byte that tells the type of address goes before
            return Mac(payload[-6:][::-1].hex(":").upper())
        case 0x11 | 0x91:
            return Status("power_status", *_whole("B", payload, "a power status"))
        case 0x12 | 0x92:
            return Status("charge_status", *_whole("B", payload, "a charge status"))
    return None


def _logging(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    match register:
        case 0x84:
            return LogTime(*_whole("IB", payload, "the board's clock"))
        case 0x85:
            return LogLength(*_whole("I", payload, "the log's length"))
        case 0x07 if len(payload) in (9, 18):
            return LogEntries(tuple(_entry(*parts) for parts in struct.iter_unpack("<BII", payload)))
        case 0x08:
            return LogProgress(*_whole("I", payload, "the download's progress"))
        case 0x0D if not payload:
            return LogProgress(None)
    return None


def _entry(head: int, tick: int, data: int) -> LogEntry:
    return LogEntry(head & 0x1F, head >> 5, tick, data)


def _processor(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    if register != 0x03 or not payload:
        return None
    number, data = payload[0], payload[1:]
    kind = ranges.processors.get(number, "fused" if len(data) == 16 else "raw")
    if kind == "raw":
        return Output(number, data)
    if kind == "quaternion":
        return Quaternion(*_reals(data, 4, "a quaternion"))
    (tick,) = _whole("I", data[:4], "a tick")
    if kind != "fused":
        return Timed(number, tick, kind, _vectors(data[4:], _per_unit(kind, ranges), 1)[0])
    (acc,) = _vectors(data[4:10], _per_unit("acc", ranges), 1)
    return Fused(number, tick, acc, *_vectors(data[10:], _per_unit("gyro", ranges), 1))


def _per_unit(sensor: str, ranges: Ranges) -> float:
    """Counts per g, deg/s or microtesla."""
    if sensor == "acc":
        return 32768 / q.ACC_RANGES_G[q.code_of("an accelerometer range", ranges.acc_g, q.ACC_RANGES_G, "g")]
    if sensor == "gyro":
        return 16.4 * 2.0 ** q.code_of("a gyro range", ranges.gyro_dps, q.GYRO_RANGES_DPS, "deg/s")
    return 16.0


def _switch(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    return Switch(*_whole("B", payload, "the button's state")) if register in (0x01, 0x81) else None


def _temperature(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    if register & 0x3F != 0x01:
        return None
    channel, eighths = _whole("Bh", payload, "a temperature")
    return Temperature(channel, eighths / 8)


def _timer(register: int, payload: bytes, board: Board, ranges: Ranges) -> Notification | None:
    return TimerFired(*_whole("B", payload, "a timer's moment")) if register == 0x06 else None


_Reader: TypeAlias = Callable[[int, bytes, Board, Ranges], Notification | None]
_READERS: Final[Mapping[int, _Reader]] = {
    SWITCH: _switch,
    ACC: _acc,
    TEMPERATURE: _temperature,
    PROCESSOR: _processor,
    LOGGING: _logging,
    TIMER: _timer,
    SETTINGS: _settings,
    GYRO: _gyro,
    MAG: _mag,
    FUSION: _fusion,
}


def single(number: float) -> float:
    """The nearest number of single precision, in which the vendor's library computes."""
    return float(struct.unpack("<f", struct.pack("<f", number))[0])


def _divided(vector: Vector, divisor: float) -> Vector:
    by = single(divisor)
    x, y, z = vector
    return single(x / by), single(y / by), single(z / by)


def _vectors(payload: bytes, per_unit: float, expected: int) -> tuple[Vector, ...]:
    if len(payload) != 6 * expected:
        raise DeviceError(f"{expected} sample(s) came in {len(payload)} bytes; expected {6 * expected}")
    return tuple(_divided((x, y, z), per_unit) for x, y, z in struct.iter_unpack("<3h", payload))


def _reals(payload: bytes, expected: int, what: str) -> tuple[float, ...]:
    numbers: tuple[float, ...] = _whole(f"{expected}f", payload, what)
    if not all(map(math.isfinite, numbers)):
        raise DeviceError(f"{what} holds {numbers}; expected finite numbers")
    return numbers


def _whole(form: str, payload: bytes, what: str) -> tuple[int, ...]:
    length = struct.calcsize("<" + form)
    if len(payload) != length:
        raise DeviceError(f"{what} came in {len(payload)} bytes; expected {length}")
    return struct.unpack("<" + form, payload)
