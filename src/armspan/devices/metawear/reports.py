"""A MetaWear notification in plain values, under the names and units of the vendor's library."""

from dataclasses import asdict
from typing import Any, Final

from armspan.devices.metawear import notifications as n

_UNITS: Final = {"acc": ("acc_xyz_g", "g"), "gyro": ("gyro_xyz_dps", "deg/s"), "mag": ("mag_xyz_uT", "uT")}
_CORRECTED_UNITS: Final = {"corrected_acc": "g", "corrected_gyro": "deg/s", "corrected_mag": "uT"}
GESTURES: Final = ("unknown", "push arm down", "pivot up", "shake", "flick in", "flick out")
ACTIVITIES: Final = ("still", "walking", "running", "unknown")


def report(notification: n.Notification) -> dict[str, Any]:
    """What a notification says: ``kind``, ``decoded`` (numbers, text, lists, dicts), ``units`` where it has some."""
    kind, decoded, units = _told(notification)
    of = {"of": notification.what} if isinstance(notification, n.Status) else {}
    return {"kind": kind, **of, "decoded": decoded} | ({"units": units} if units else {})


def _told(said: n.Notification) -> tuple[str, Any, str]:
    match said:
        case n.Samples(sensor, samples):
            kind, units = _UNITS[sensor]
            several = len(samples) > 1
            vectors = [_xyz(sample) for sample in samples]
            return (f"{kind} x{len(samples)}" if several else kind), (vectors if several else vectors[0]), units
        case n.Corrected(output, vector, accuracy):
            return output, _xyz(vector) | {"accuracy": accuracy}, _CORRECTED_UNITS[output]
        case n.Acceleration(output, vector):
            return output, _xyz(vector), "g"
        case n.Quaternion():
            return "quaternion", asdict(said), "unit quaternion w,x,y,z"
        case n.Euler():
            return "euler", asdict(said), "deg"
        case n.Fused(processor, tick, acc, gyro):
            both = {"acc": _xyz(acc), "gyro": _xyz(gyro)}
            return "fused", {"processor": processor, "tick": tick} | both, "g, deg/s"
        case n.Timed(processor, tick, sensor, vector):
            return f"timed_{sensor}", {"processor": processor, "tick": tick} | _xyz(vector), _UNITS[sensor][1]
    return _state(said)


def _state(said: n.Notification) -> tuple[str, Any, str]:
    """Of what the board is, rather than of what it measures."""
    match said:
        case n.CalibrationState(acc, gyro, mag):
            return "calibration_state", {"accelerometer": acc, "gyroscope": gyro, "magnetometer": mag}, ""
        case n.Switch(state):
            return "switch", state, ""
        case n.Tap(kind, sign):
            return "tap", {"type": kind, "sign_bit": sign}, ""
        case n.Gesture(kind, code):
            return "gesture", {"type": kind, "gesture_code": code, "gesture": _word(GESTURES, code)}, ""
        case n.Activity(code):
            return "activity", {"activity": code, "name": _word(ACTIVITIES, code)}, ""
        case n.Battery(percent, millivolts):
            return "battery", {"voltage_mV": millivolts, "charge_percent": percent}, ""
        case n.Mac(address):
            return "mac", address, ""
        case n.Status(_, value):
            return "status", value, ""
        case n.Temperature(channel, celsius):
            return "temperature", {"channel": channel, "celsius": celsius}, "deg C"
        case n.LogEntries(entries):
            return "log_entries", [asdict(entry) for entry in entries], ""
    return _kind_of(said), {key: _plain(value) for key, value in asdict(said).items()}, ""


def _kind_of(said: n.Notification) -> str:
    name = type(said).__name__
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")


def _plain(value: Any) -> Any:
    return value.hex() if isinstance(value, bytes) else value


def _word(words: tuple[str, ...], code: int) -> str:
    return words[code] if code < len(words) else f"number {code}"


def _xyz(vector: n.Vector) -> dict[str, float]:
    x, y, z = vector
    return {"x": x, "y": y, "z": z}
