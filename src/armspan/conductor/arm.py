"""The arms as their bands feel them, between two ticks."""

from dataclasses import dataclass, field

import numpy as np

from armspan import records
from armspan.conductor.settings import BandSettings
from armspan.frames import Array
from armspan.orientation import MOVING, Attitude, Mount
from armspan.records import ImuSample, Quaternion

LATE = 0.6
"""Share of the silence after which a band counts as lost from which it counts as late."""


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
        return t - self.heard > self.settings.stale_s

    def late(self, t: float) -> bool:
        """Whether a band that was heard has been silent for so long that it may be lost."""
        return self.heard > -np.inf and t - self.heard > LATE * self.settings.stale_s

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
    """The pointing arm: the band on the forearm, the one on the upper arm where there is one, and the other arm's.

    ``by_name`` are all bands, ``pointing`` those of the arm that points, ``wrists`` those on wrists, as ``right`` and
    ``left``.
    """

    forearm: Band
    upperarm: Band | None = None
    by_name: dict[str, Band] = field(default_factory=dict)
    pointing: dict[str, Band] = field(default_factory=dict)
    wrists: dict[str, Band] = field(default_factory=dict)

    @classmethod
    def from_settings(cls, settings: tuple[BandSettings, ...], points: records.Arm = "right") -> "Arm":
        """The bands of a room whose user points with this arm."""
        bands = [Band.from_settings(band) for band in settings]
        pointing = [band for band in bands if (band.settings.arm or points) == points]
        on = {band.settings.segment: band for band in pointing}
        wrists: dict[str, Band] = {
            str(band.settings.arm or points): band for band in bands if band.settings.segment == "forearm"
        }
        named = {band.settings.name: band for band in bands}
        return cls(on["forearm"], on.get("upperarm"), named, {b.settings.name: b for b in pointing}, wrists)

    @property
    def bands(self) -> list[Band]:
        """All bands."""
        return list(self.by_name.values())

    @property
    def both(self) -> bool:
        """Whether there is a band on either wrist."""
        return len(self.wrists) == 2

    @property
    def moving(self) -> bool:
        """Whether any part of the pointing arm moved since the last tick."""
        return self.rate > MOVING

    @property
    def any_moving(self) -> bool:
        """Whether any part of any arm moved since the last tick."""
        return max(band.rate for band in self.bands) > MOVING

    @property
    def rate(self) -> float:
        """The fastest rate [rad/s] of any part of the pointing arm since the last tick."""
        return max(band.rate for band in self.pointing.values())

    def silent(self, t: float) -> list[str]:
        """Names of the pointing arm's bands that are silent."""
        return [name for name, band in self.pointing.items() if band.stale(t)]

    def any_silent(self, t: float) -> list[str]:
        """Names of all bands that are silent."""
        return [name for name, band in self.by_name.items() if band.stale(t)]
