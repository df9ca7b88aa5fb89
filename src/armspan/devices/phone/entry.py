"""A phone or a watch in the room file."""

import math
from typing import Literal
from urllib.parse import urlsplit

import msgspec

from armspan.errors import ConfigError
from armspan.links.http import Guard, host_and_port
from armspan.records import Arm, Quaternion

LISTEN = "127.0.0.1:8443"
STRAPPED: Quaternion = (0.5**0.5, 0.0, 0.0, -(0.5**0.5))
"""``wrist_from_sensor`` of a phone on the back of the forearm: screen up, its top edge to the hand."""
_OFF_UNIT = 1e-3


class PhoneEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", tag="phone"):
    """A phone or a watch that is worn as a band.

    ``app`` is what runs on it: our page in its "browser", "sensor-logger" (which pushes to us) or "sensor-server"
    (which we ask, at ``url``). The first two come in at ``listen``, guarded by ``token`` and ``allow``; ``device``
    is the deviceId that Sensor Logger shows, needed where two phones push to one door; ``stream`` is "watch" where
    the watch is the band. ``rate_hz`` is what the app sends, 60 from browsers. After ``stale_s`` [s] without a sample
    the robots stop: Wi-Fi holds packets up for longer than Bluetooth, and Sensor Logger's batches are longer still.

    Raises:
        ConfigError: one sentence for what cannot be used.

    """

    name: str
    app: Literal["browser", "sensor-logger", "sensor-server"] = "browser"
    listen: str = LISTEN
    url: str | None = None
    device: str | None = None
    stream: Literal["phone", "watch"] = "phone"
    token: str | None = None
    allow: tuple[str, ...] = ()
    segment: Literal["forearm", "upperarm"] = "forearm"
    arm: Arm | None = None
    rate_hz: float = 60.0
    wrist_from_sensor: Quaternion | None = None
    stale_s: float = 0.4

    def __post_init__(self) -> None:
        try:
            self._check()
        except ConfigError as error:
            raise ConfigError(f"band {self.name!r}: {error}") from None

    def _check(self) -> None:
        if not 1 <= self.rate_hz <= 2000:
            raise ConfigError(f"rate_hz is {self.rate_hz}; expected 1 to 2000 samples a second, 60 from a browser")
        turn = self.wrist_from_sensor
        if turn is not None and not abs(math.hypot(*turn) - 1.0) <= _OFF_UNIT:
            raise ConfigError(
                f"wrist_from_sensor is {list(turn)} of length {math.hypot(*turn):.3f}; a unit quaternion (w, x, y, z) "
                "has length 1"
            )
        if self.app != "sensor-logger" and (self.device is not None or self.stream != "phone"):
            raise ConfigError(f"device and stream are for app = 'sensor-logger', not for {self.app!r}; leave them out")
        if self.app == "sensor-server":
            _check_url(self.url)
            return
        if self.url is not None:
            raise ConfigError(f"url is for app = 'sensor-server'; a {self.app} comes to us: set listen instead")
        host, _ = host_and_port(self.listen)
        self.guard().check(host)

    @property
    def address(self) -> tuple[str, int]:
        """Host and port of the door."""
        return host_and_port(self.listen)

    def guard(self) -> Guard:
        """Who may come in at the door."""
        return Guard(self.token, self.allow)


def _check_url(url: str | None) -> None:
    example = "'ws://192.168.1.23:8080', as SensorServer shows it"
    if url is None:
        raise ConfigError(f"url is missing; expected {example}")
    try:
        parts = urlsplit(url)
        right = parts.scheme in ("ws", "wss") and bool(parts.hostname) and (parts.port or 8080) > 0
    except ValueError:
        right = False
    if not right or parts.path.strip("/") or parts.query:
        raise ConfigError(f"url is {url!r}; expected {example}")
