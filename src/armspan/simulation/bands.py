"""Virtual wristbands: what the sensor on a virtual arm would send, when it would arrive, and what gets lost."""

import numpy as np

from armspan.frames import Array, rotation_from_quaternion
from armspan.records import ImuSample, Quaternion
from armspan.simulation.band_traits import BandTraits, Fusion, draw_band
from armspan.simulation.fluctuation import Band, Fluctuation
from armspan.simulation.fusion import OnboardFusion
from armspan.simulation.inertial import GRAVITY, Motion, Segment, Wearer, motion

__all__ = ["BandTraits", "Fusion", "Segment", "VirtualBand", "Wearer", "draw_band"]

# 16 bits over 16 g and 2000 deg/s: the ranges and digits of the six channels, acceleration first.
_CHANNELS = 6
_RANGE: Array = np.repeat([16.0 * GRAVITY, np.radians(2000.0)], 3)
_DIGIT: Array = np.repeat([GRAVITY / 2048.0, np.radians(1.0 / 16.4)], 3)

# The rows of what drifts slowly in a band, after its channels.
_TILT, _YAW, _CLOCK, _ROWS = slice(6, 8), 8, 9, 10


class VirtualBand:
    """One band on a virtual arm.

    Its samples depend on the traits, on ``rng`` and on how the wearer moves, not on how often it is asked.
    """

    def __init__(
        self,
        name: str,
        segment: Segment,
        traits: BandTraits,
        rng: np.random.Generator,
        start: float = 0.0,
    ) -> None:
        self.name, self.segment, self.traits = name, segment, traits
        self._segment_from_sensor = rotation_from_quaternion(traits.segment_from_sensor)
        self._lever = np.array(traits.lever)
        self._noise, self._radio, self._bursts = rng.spawn(3)
        self._slow = Fluctuation(_drifts(traits), _ROWS, rng)
        self._gain: Array = 1.0 + np.array([*traits.acc_scale, *traits.gyr_scale])
        self._bias: Array = np.array([*traits.acc_bias, *traits.gyr_bias])
        # White up to half the rate.
        self._scatter = np.sqrt(traits.rate_hz / 2.0) * np.repeat([traits.acc_noise, traits.gyr_noise], 3)
        self._period = (1.0 + traits.clock_rate) / traits.rate_hz
        self._first = start + float(rng.uniform(0.0, self._period))
        self._phase = start + float(rng.uniform(0.0, traits.burst))
        self._count = 0
        self._fusion = OnboardFusion(traits, self._period, start)
        self._burst, self._arrival, self._losing = -1, start, False

    def advance(self, t: float, person: Wearer) -> list[tuple[float, ImuSample]]:
        """What was measured up to ``t`` [s] and not told before, each with its time of arrival [s], in order."""
        upto = int(np.floor((t - self._first) / self._period)) + 1
        if upto <= self._count:
            return []
        ticks: Array = self._first + self._period * np.arange(self._count, upto, dtype=float)
        self._count = upto
        noise = self._noise.standard_normal((len(ticks), 7))
        felt = motion(
            person,
            self.segment,
            ticks + self.traits.jitter * noise[:, 6],
            self._segment_from_sensor,
            self._lever,
        )
        slow = self._slow.at(ticks)
        quaternions: list[Quaternion] | list[None] = [None] * len(ticks)
        if self.traits.fusion == "onboard":
            quaternions = self._fusion.quaternions(felt, slow[_YAW], slow[_TILT], ticks)
        told = (ticks + self.traits.late + slow[_CLOCK]).tolist()
        measured = self._measured(felt, slow[:_CHANNELS].T, noise[:, :_CHANNELS])
        samples = [
            ImuSample(t, self.name, (ax, ay, az), (gx, gy, gz), None, quaternion)
            for t, (ax, ay, az, gx, gy, gz), quaternion in zip(told, measured, quaternions, strict=True)
        ]
        return self._sent(ticks.tolist(), samples)

    def _measured(self, felt: Motion, slow: Array, noise: Array) -> list[list[float]]:
        """Acceleration and rate as the chip tells them, (m, 6)."""
        true = np.concatenate([felt.force, felt.rate], axis=1)
        values = true * self._gain + self._bias + slow + self._scatter * noise
        digits = np.round(np.minimum(np.maximum(values, -_RANGE), _RANGE) / _DIGIT)
        digital: list[list[float]] = (digits * _DIGIT).tolist()
        return digital

    def _sent(self, ticks: list[float], samples: list[ImuSample]) -> list[tuple[float, ImuSample]]:
        draws = self._radio.uniform(size=len(ticks)).tolist()
        return [
            (self._arrived(tick), sample)
            for tick, sample, draw in zip(ticks, samples, draws, strict=True)
            if not self._lost(draw)
        ]

    def _lost(self, draw: float) -> bool:
        # Losses come in runs (Gilbert): the chance to begin one is such that the shares come out right.
        loss, run = self.traits.loss, self.traits.loss_run
        self._losing = draw < (1.0 - 1.0 / run if self._losing else loss / (1.0 - loss) / run)
        return self._losing

    def _arrived(self, tick: float) -> float:
        traits = self.traits
        burst = int(np.floor((tick - self._phase) / traits.burst)) + 1
        if burst != self._burst:
            missed = float(self._bursts.uniform()) < traits.missed
            at = self._phase + (burst + missed) * traits.burst
            at += traits.delay * (0.5 + 0.5 * float(self._bursts.exponential()))
            self._burst, self._arrival = burst, max(self._arrival, at)
        return self._arrival


def _drifts(traits: BandTraits) -> list[Band]:
    wander, tilt = [traits.acc_wander] * 3 + [traits.gyr_wander] * 3, traits.tilt / np.sqrt(2.0)
    return [
        *[Band(row, sd, 0.001, 0.02, 4) for row, sd in enumerate(wander)],
        *[Band(row, tilt, 0.005, 0.05, 4) for row in range(_TILT.start, _TILT.stop)],
        Band(_YAW, traits.yaw_wander, 0.0008, 0.003, 3),
        Band(_CLOCK, traits.late_wander, 0.01, 0.1, 3),
    ]
