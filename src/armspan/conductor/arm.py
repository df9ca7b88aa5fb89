"""The pointing arm as its bands feel it, between two ticks."""

from dataclasses import dataclass, field

import numpy as np

from armspan.conductor.settings import BandSettings
from armspan.frames import Array
from armspan.orientation import MOVING, Attitude, Mount
from armspan.records import ImuSample, Quaternion

STALE = 0.25
"""Silence [s] after which a band is taken to be lost."""


@dataclass(slots=True)
class Band:
    """One band: its attitude, its fastest rate since the last tick, and its mounting once known."""

    settings: BandSettings
    attitude: Attitude
    mount: Mount | None = None
    heard: float = -np.inf
    _squared_rate: float = 0.0
    rate: float = np.inf

    @classmethod
    def from_settings(cls, settings: BandSettings) -> "Band":
        """A band that has not been heard yet."""
        return cls(settings, Attitude(settings.rate_hz))

    def feel(self, sample: ImuSample) -> None:
        """Take a sample."""
        self.attitude.update(sample)
        self.heard = max(self.heard, sample.t)
        x, y, z = sample.gyr
        self._squared_rate = max(self._squared_rate, x * x + y * y + z * z)

    def tick(self) -> None:
        """Close the interval since the last tick."""
        self.rate = float(np.sqrt(self._squared_rate))
        self._squared_rate = 0.0

    def stale(self, t: float) -> bool:
        """Whether the band has been silent for too long."""
        return t - self.heard > STALE

    @property
    def raw(self) -> bool:
        """Whether the band sends raw samples only, so that its gyroscope's offset must be found here."""
        return self.attitude.integrates

    def quaternion(self) -> Quaternion | None:
        """``earth_from_sensor`` now."""
        return self.attitude.quaternion

    def in_user(self) -> Array | None:
        """``user_from_wrist`` (3, 3) now, or None before the set-up."""
        quaternion = self.attitude.quaternion
        if self.mount is None or quaternion is None:
            return None
        return self.mount.user_from_wrist(quaternion)


@dataclass(slots=True)
class Arm:
    """The pointing arm: the band on the forearm, and the one on the upper arm where there is one."""

    forearm: Band
    upperarm: Band | None = None
    by_name: dict[str, Band] = field(default_factory=dict)

    @classmethod
    def from_settings(cls, settings: tuple[BandSettings, ...]) -> "Arm":
        """The bands of a room."""
        bands = [Band.from_settings(band) for band in settings]
        on = {band.settings.segment: band for band in bands}
        return cls(on["forearm"], on.get("upperarm"), {band.settings.name: band for band in bands})

    @property
    def bands(self) -> list[Band]:
        """All bands."""
        return list(self.by_name.values())

    @property
    def wrists(self) -> dict[str, Band]:
        """The bands on the wrists, as ``right`` and ``left``."""
        return {}

    @property
    def moving(self) -> bool:
        """Whether any part of the arm moved since the last tick."""
        return self.rate > MOVING

    @property
    def rate(self) -> float:
        """The fastest rate [rad/s] of any part since the last tick."""
        return max(band.rate for band in self.bands)

    def silent(self, t: float) -> list[str]:
        """Names of the bands that are silent."""
        return [name for name, band in self.by_name.items() if band.stale(t)]
