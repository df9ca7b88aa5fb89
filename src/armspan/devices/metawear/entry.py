"""A MetaWear band in ROOM.toml."""

import math
import re
from typing import Literal

import msgspec

from armspan.devices.metawear.quantities import ACC_RANGES_G, GYRO_RANGES_DPS
from armspan.errors import ConfigError, known_names
from armspan.records import Arm, Quaternion

MAC = re.compile(r"(?:[0-9A-F]{2}:){5}[0-9A-F]{2}")
UUID = re.compile(r"[0-9A-F]{8}-(?:[0-9A-F]{4}-){3}[0-9A-F]{12}")
USB = "usb:"
RAW_RATES_HZ = (25.0, 50.0, 100.0)
"""A band's radio carries about a hundred packets a second."""
FUSION_RATE_HZ = 100.0

_H = math.sqrt(0.5)
STRAPS: dict[str, Quaternion] = {
    "hand-at-minus-y": (_H, 0.0, 0.0, _H),
    "hand-at-plus-y": (_H, 0.0, 0.0, -_H),
    "hand-at-plus-x": (1.0, 0.0, 0.0, 0.0),
    "hand-at-minus-x": (0.0, 0.0, 0.0, 1.0),
}
"""``wrist_from_sensor`` of a board worn face up on the back of the wrist, by the axis of it that points to the hand."""
Strap = Literal["hand-at-minus-y", "hand-at-plus-y", "hand-at-plus-x", "hand-at-minus-x"]


class MetaWearEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="metawear"):
    """A MetaMotion band, found by its Bluetooth ``address`` (on macOS a UUID) or a cable, ``usb:/dev/ttyACM0``.

    With the profile ``fusion`` it sends its own orientation, found in ``mode``: ``imu_plus`` (no compass: a heading
    that drifts slowly) or ``ndof`` (with one). With ``raw`` it sends samples with its own clock, and the orientation
    is found here. ``outputs`` beyond the quaternion are for radios that carry 300 packets a second. Where neither
    ``strap`` nor ``wrist_from_sensor`` is told, the set-up finds how it is worn. ``radio`` reaches it by another one
    than the room's, such as "hci1". After ``stale_s`` [s] without a sample the robots stop: one of Linux's own
    connection intervals (48.75 ms) may be missed, or a dozen samples where the short interval is granted.
    """

    name: str
    address: str
    segment: Literal["forearm", "upperarm"] = "forearm"
    arm: Arm | None = None
    profile: Literal["fusion", "raw"] = "fusion"
    mode: Literal["imu_plus", "ndof"] = "imu_plus"
    outputs: Literal["quaternion", "all"] = "quaternion"
    rate_hz: float = 100.0
    acc_range_g: int = 16
    gyro_range_dps: int = 2000
    wrist_from_sensor: Quaternion | None = None
    strap: Strap | None = None
    radio: str | None = None
    stale_s: float = 0.13

    def __post_init__(self) -> None:
        if not self.name:
            raise ConfigError("a MetaWear band has no name; expected one, such as 'right'")
        address = self.address if self.address.startswith(USB) else self.address.strip().upper()
        if not (MAC.fullmatch(address) or UUID.fullmatch(address) or (address.startswith(USB) and address[len(USB) :])):
            raise ConfigError(
                f"band {self.name!r} has the address {self.address!r}; expected one such as E8:C9:8F:52:7B:07, on "
                "macOS a UUID, or usb:/dev/ttyACM0 (`armspan check --scan` lists those that are heard)"
            )
        msgspec.structs.force_setattr(self, "address", address)
        self._check_numbers()
        self._check_strap()

    def _check_numbers(self) -> None:
        rates = (FUSION_RATE_HZ,) if self.profile == "fusion" else RAW_RATES_HZ
        dps = GYRO_RANGES_DPS[:4] if self.profile == "fusion" else GYRO_RANGES_DPS
        _one_of(self.name, f"rate_hz with the profile {self.profile}", self.rate_hz, rates)
        _one_of(self.name, "acc_range_g", self.acc_range_g, ACC_RANGES_G)
        _one_of(self.name, f"gyro_range_dps with the profile {self.profile}", self.gyro_range_dps, dps)
        if self.profile == "raw" and (self.mode != "imu_plus" or self.outputs != "quaternion"):
            raise ConfigError(
                f"band {self.name!r} has the profile raw and a mode or outputs of the fusion; leave these out, or "
                "choose the profile fusion"
            )

    def _check_strap(self) -> None:
        if self.strap is not None:
            if self.wrist_from_sensor is not None:
                raise ConfigError(
                    f"band {self.name!r} has a strap and a wrist_from_sensor, which say the same; leave one out"
                )
            if self.strap not in STRAPS:
                raise ConfigError(known_names(f"band {self.name!r}: the strap", self.strap, STRAPS))
            msgspec.structs.force_setattr(self, "wrist_from_sensor", STRAPS[self.strap])
        turn = self.wrist_from_sensor
        if turn is not None and not abs(math.hypot(*turn) - 1.0) < 1e-3:
            raise ConfigError(
                f"band {self.name!r} has the wrist_from_sensor {list(turn)} of length {math.hypot(*turn):g}; expected "
                "a unit quaternion (w, x, y, z)"
            )

    @property
    def port(self) -> str | None:
        """The serial port of a band on a cable."""
        return self.address[len(USB) :] if self.address.startswith(USB) else None


def _one_of(name: str, what: str, value: float, known: tuple[float, ...]) -> None:
    if value not in known:
        there = ", ".join(f"{each:g}" for each in sorted(known))
        raise ConfigError(f"band {name!r} has {what} = {value:g}; expected {there}")
