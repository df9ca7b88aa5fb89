"""What the three apps say of a phone's motion, byte for byte, as an emulated phone says it.

Nothing here is shared with the decoders but the names on the wire. Browsers round what they tell to a tenth of a
degree, a degree per second and a metre per second squared (W3C, Device Orientation and Motion, 'Security and
privacy considerations'), and so does the page's voice.
"""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol, TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from armspan.frames import Array, rotation_from_quaternion
from armspan.records import ImuSample, Quaternion

G = 9.80665
EPOCH_NS = 1_790_000_000_000_000_000
"""When emulated phones think that they began, in UTC."""

Platform: TypeAlias = Literal["android", "ios", "apple-watch", "wear-os"]
Samples: TypeAlias = Callable[[float], list[ImuSample]]
"""Everything that was measured up to a time [s] since the phone began, and was not told before."""


class Voice(Protocol):
    """An app."""

    def begin(self) -> list[bytes]:
        """What it says first on a new line."""

    def tell(self, samples: Sequence[ImuSample], t: float) -> list[bytes]:
        """What it says of the samples taken since, at ``t`` [s] of its own."""


def lying_still(rate_hz: float = 60.0, attitude: Quaternion = (1.0, 0.0, 0.0, 0.0)) -> Samples:
    """A phone that lies there."""
    x, y, z = (_up(attitude) * G).tolist()
    count = 0

    def samples(t: float) -> list[ImuSample]:
        nonlocal count
        before, count = count, max(count, int(t * rate_hz + 1e-6) + 1)
        return [
            ImuSample(k / rate_hz, "phone", (x, y, z), (0.0, 0.0, 0.0), None, attitude) for k in range(before, count)
        ]

    return samples


def _up(attitude: Quaternion) -> Array:
    return np.asarray(rotation_from_quaternion(attitude)[2])


@dataclass(slots=True)
class PageVoice:
    """Our page in a phone's browser.

    ``apple`` counts acceleration the other way round; ``attitude`` is what the browser has, the three angles or the
    sensor's quaternion, each a sample old; ``posts`` is a browser that opens no WebSocket.
    """

    page: str = "emulated"
    apple: bool = False
    attitude: Literal["angles", "quaternion", "none"] = "angles"
    posts: bool = False
    number: int = 0
    _before: tuple[float, Quaternion] | None = None

    def begin(self) -> list[bytes]:
        """Who it is."""
        return [_json({"hello": {"page": self.page, "apple": self.apple}})]

    def tell(self, samples: Sequence[ImuSample], t: float) -> list[bytes]:
        """A text of each sample, from the first attitude on."""
        return [text for sample in samples for text in self._texts(sample)]

    def _texts(self, sample: ImuSample) -> list[bytes]:
        if self._before is None and self.attitude != "none" and sample.quat is not None:
            self._before = sample.t, sample.quat
            return []
        sign = -1.0 if self.apple else 1.0
        text: dict[str, object] = {
            "n": self.number,
            "t": round(1000.0 * sample.t, 3),
            "a": [round(sign * value, 1) for value in sample.acc],
            "r": [round(math.degrees(value), 1) for value in sample.gyr],
        }
        if self._before is not None and self.attitude != "none":
            read, attitude = self._before
            angles = [round(angle, 1) for angle in browser_angles(attitude)]
            told = {"o": angles} if self.attitude == "angles" else {"q": _from_angles(angles)}
            text |= {**told, "u": round(1000.0 * read, 3)}
        self.number += 1
        if sample.quat is not None:
            self._before = sample.t, sample.quat
        return [_json(text)]


def browser_angles(attitude: Quaternion) -> tuple[float, float, float]:
    """Alpha from 0 to 360, beta within 180 and gamma within 90 degrees of an attitude."""
    alpha, beta, gamma = Rotation.from_quat(attitude, scalar_first=True).as_euler("ZXY", degrees=True).tolist()
    if abs(gamma) > 90.0:
        alpha, beta, gamma = alpha + 180.0, math.copysign(180.0, beta) - beta, gamma - math.copysign(180.0, gamma)
    return alpha % 360.0, beta, gamma


def _from_angles(angles: Sequence[float]) -> list[float]:
    xyzw: list[float] = Rotation.from_euler("ZXY", angles, degrees=True).as_quat().tolist()
    return [round(value, 6) for value in xyzw]


@dataclass(slots=True)
class LoggerVoice:
    """Sensor Logger's push, once every ``batch_s`` [s].

    ``standardised`` is the app's setting 'Standardise Units & Frames', which makes Apple's devices speak as Android's.
    The phone's clock began at ``epoch_ns`` and is wrong by ``clock_rate`` [s/s].
    """

    platform: Platform = "android"
    batch_s: float = 0.2
    device: str = "emulated-phone"
    session: str = "emulated-session"
    standardised: bool = False
    epoch_ns: int = EPOCH_NS
    clock_rate: float = 0.0
    number: int = 0
    _batch: list[ImuSample] = field(default_factory=list)
    _due: float | None = None

    def begin(self) -> list[bytes]:
        """Nothing: each push is a request of its own."""
        return []

    def tell(self, samples: Sequence[ImuSample], t: float) -> list[bytes]:
        """A push where one is due."""
        self._batch += samples
        self._due = t + self.batch_s if self._due is None else self._due
        if t < self._due or not self._batch:
            return []
        self._due += self.batch_s
        payload = [reading for sample in self._batch for reading in self._readings(sample)]
        self._batch.clear()
        number, self.number = self.number, self.number + 1
        return [
            _json({"messageId": number, "sessionId": self.session, "deviceId": self.device, "payload": payload}),
        ]

    def _readings(self, sample: ImuSample) -> list[dict[str, object]]:
        time = self.epoch_ns + round(sample.t * (1.0 + self.clock_rate) * 1e9)
        if self.platform in ("apple-watch", "wear-os"):
            return [{"name": "wrist motion", "time": time, "values": self._wrist(sample)}]
        motion, gravity = self._parts(sample)
        sensors: dict[str, object] = {
            "accelerometer": _xyz(motion),
            "gravity": _xyz(gravity),
            "gyroscope": _xyz(np.array(sample.gyr)),
        }
        if self.platform == "android":
            sensors["totalacceleration"] = _xyz(np.array(sample.acc))
        if sample.quat is not None:
            w, x, y, z = sample.quat
            sensors["orientation"] = {"qw": w, "qx": x, "qy": y, "qz": z, "roll": 0.0, "pitch": 0.0, "yaw": 0.0}
        return [{"name": name, "time": time, "values": values} for name, values in sensors.items()]

    def _parts(self, sample: ImuSample) -> tuple[Array, Array]:
        """The acceleration without gravity and gravity, in the platform's own sign [m/s²]."""
        gravity = _up(sample.quat or (1.0, 0.0, 0.0, 0.0)) * G
        apple = self.platform in ("ios", "apple-watch") and not self.standardised
        sign = -1.0 if apple else 1.0
        return sign * (np.array(sample.acc) - gravity), sign * gravity

    def _wrist(self, sample: ImuSample) -> dict[str, float]:
        motion, gravity = self._parts(sample)
        unit = G if self.platform == "apple-watch" and not self.standardised else 1.0
        told = {"rotationRate": np.array(sample.gyr), "gravity": gravity / unit, "acceleration": motion / unit}
        values = {
            f"{name}{axis}": float(v) for name, three in told.items() for axis, v in zip("XYZ", three, strict=True)
        }
        if sample.quat is not None:
            values |= {f"quaternion{axis}": value for axis, value in zip("WXYZ", sample.quat, strict=True)}
        return values


@dataclass(slots=True)
class ServerVoice:
    """SensorServer's texts of the sensors that were asked for, of a phone that began ``boot_ns`` ago."""

    sensors: Sequence[str] = ()
    boot_ns: int = 3_925_657_519_043_709

    def begin(self) -> list[bytes]:
        """Nothing."""
        return []

    def tell(self, samples: Sequence[ImuSample], t: float) -> list[bytes]:
        """A text of each sensor and sample, each at a time of its own."""
        return [text for sample in samples for text in self._texts(sample)]

    def _texts(self, sample: ImuSample) -> list[bytes]:
        w, x, y, z = sample.quat or (1.0, 0.0, 0.0, 0.0)
        values = {
            "accelerometer": list(sample.acc),
            "gyroscope": list(sample.gyr),
            "game_rotation_vector": [x, y, z, w],
            "rotation_vector": [x, y, z, w, 0.05],
        }
        taken = self.boot_ns + round(sample.t * 1e9)
        return [
            _json({"accuracy": 3, "timestamp": taken, "type": f"android.sensor.{name}", "values": told})
            for name, told in values.items()
            if f"android.sensor.{name}" in self.sensors
        ]


def _xyz(values: Array) -> dict[str, float]:
    x, y, z = values.tolist()
    return {"x": x, "y": y, "z": z}


def _json(value: object) -> bytes:
    return json.dumps(value, separators=(",", ":")).encode()
