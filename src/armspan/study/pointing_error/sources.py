"""Where the error of a pointing user comes from: one draw of everything that goes wrong in many set-ups at once.

Sizes are of a straight arm with one band; each source says whether it was measured, and on whom, or assumed.
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from armspan.body.anthropometry import prior
from armspan.body.told import Told
from armspan.errors import ConfigError, known_names
from armspan.frames import Array


@dataclass(frozen=True, slots=True)
class Source:
    """One cause of error: its ``name``, its ``size`` (one standard deviation) in words, and where that is from."""

    name: str
    size: str
    basis: str


SOURCES = (
    Source("aim: bias", "az 2, el 1.3 deg, one for a person", "13 people in virtual reality (TorSalve)"),
    Source("aim: by place", "0.7 deg per axis, one for a place", "six of these people"),
    Source("aim: gesture", "0.65 deg per axis, one for a gesture", "13 people in virtual reality (TorSalve)"),
    Source(
        "aim: tremble", "az 0.45, el 0.16 deg; 3 s at a stop, 0.5 s in use", "holds of 5 s (ICRA 2019 feedback study)"
    ),
    Source("elbow: bias", "az 1.2, el 1.0 deg about 2.6 deg, one for a person", "assumed: an arm asked to be straight"),
    Source("elbow: gesture", "az 0.6, el 0.5 deg, one for a gesture", "assumed: an arm asked to be straight"),
    Source("band: heading", "4 deg, one for a set-up", "assumed: one stretch to the front"),
    Source("band: pitch", "3 deg, one for a set-up", "assumed: one stretch to the level"),
    Source("band: drift", "2 deg/min; stops 8 s apart, in use for a minute", "1 to 3.5 deg/min (IROS 2018 sessions)"),
    Source("band: slip", "0.5 deg of pitch after the calibration", "assumed"),
    Source("body: measures", "8 to 29 mm each", "ANSUR II, from height and sex; forward and pivot assumed"),
    Source("light's height", "5 mm", "assumed: a ruler"),
    Source("sway", "17, 14, 6 mm, one for a gesture", "standing heads in virtual reality (TorSalve)"),
)
NAMES = tuple(source.name for source in SOURCES)

_DEGREE = float(np.radians(1.0))
_STOP_S, _USE_S = 8.0, 60.0
_TREMBLE_CORRELATION_S = 0.6
"""A held arm wavers at 0.15 to 2.5 Hz: averaged over this long [s], a tremble is a new one."""

_STOP_HELD_S, _USE_HELD_S = 3.0, 0.5

_ELBOW_MEAN = np.radians([2.5, -0.8])
"""What an arm that was asked to be straight keeps of its bend [rad, left and up], for a right arm."""

USUAL = prior(Told(height_m=1.75, sex="man", sole_m=0.025))
"""The measures believed of everybody in the study, and how far they may lie off."""

_BODY_ROOT = np.linalg.cholesky(USUAL.covariance)


@dataclass(frozen=True, slots=True, eq=False)
class Wrongs:
    """What goes wrong in ``m`` set-ups of ``n`` gestures, the calibration's stops first.

    ``aim`` (m, n, 2) [rad] turns the line eye to fingertip to the left and up, ``elbow`` (m, n, 2) the forearm
    against the line shoulder to fingertip; ``yaw`` and ``pitch`` (m, n) [rad] is what the band says too much;
    ``sway`` (m, n, 3) [m] moves the body; ``body`` (m, 5) [m] is the true measures less those believed, in the order
    of `Body.covariance`; ``light`` (m,) [m] how much higher the lights are than believed.
    """

    aim: Array
    elbow: Array
    yaw: Array
    pitch: Array
    sway: Array
    body: Array
    light: Array


def draw_wrongs(
    rng: np.random.Generator, count: int, stops: int, targets: int, sources: Collection[str] = NAMES, gestures: int = 1
) -> Wrongs:
    """Draw ``count`` set-ups; sources that are not named do nothing, and change no other's dice.

    A stop is the mean of so many ``gestures``.

    Raises:
        ConfigError: if a source does not exist.

    """
    for name in sources:
        if name not in NAMES:
            raise ConfigError(known_names("source of error", name, NAMES))
    dice = _Dice(rng, count, stops, targets, frozenset(sources))
    several = np.sqrt(np.where(np.arange(stops + targets) < stops, gestures, 1))[:, None]
    elbow = np.broadcast_to(_ELBOW_MEAN, (count, 1, 2)) if "elbow: bias" in sources else 0.0
    return Wrongs(
        aim=_DEGREE * _aim(dice, several),
        elbow=elbow
        + _DEGREE
        * (dice.constant("elbow: bias", 2) * [1.2, 1.0] + dice.each("elbow: gesture", 2) / several * [0.6, 0.5]),
        yaw=_DEGREE * (4.0 * dice.constant("band: heading", 1) + 2.0 * _drift(dice))[..., 0],
        pitch=_DEGREE * (3.0 * dice.constant("band: pitch", 1) + 0.5 * _slip(dice))[..., 0],
        sway=dice.each("sway", 3) / several * [0.017, 0.014, 0.006],
        body=dice.constant("body: measures", 5)[:, 0] @ _BODY_ROOT.T,
        light=0.005 * dice.constant("light's height", 1)[:, 0, 0],
    )


class _Dice:
    """Standard normal numbers, nothing for sources that are left out."""

    def __init__(self, rng: np.random.Generator, count: int, stops: int, targets: int, sources: frozenset[str]) -> None:
        # One stream for each source: what one of them draws leaves the others as they are.
        self.rngs = dict(zip(NAMES, rng.spawn(len(NAMES)), strict=True))
        self.count, self.stops, self.targets, self.sources = count, stops, targets, sources

    def constant(self, name: str, size: int) -> Array:
        """(m, 1, size), one for a set-up."""
        return self._draw(name, (self.count, 1, size))

    def each(self, name: str, size: int) -> Array:
        """(m, n, size), one for a gesture."""
        return self._draw(name, (self.count, self.stops + self.targets, size))

    def _draw(self, name: str, shape: tuple[int, ...]) -> Array:
        if name not in self.sources:
            return np.zeros((*shape[:1], 1, *shape[2:]))
        return self.rngs[name].standard_normal(shape)


def _aim(dice: _Dice, several: Array) -> Array:
    held = np.where(np.arange(dice.stops + dice.targets) < dice.stops, _STOP_HELD_S, _USE_HELD_S)
    left_of_tremble = 1.0 / np.sqrt(np.maximum(1.0, held / _TREMBLE_CORRELATION_S))[:, None]
    return np.asarray(
        dice.constant("aim: bias", 2) * [2.0, 1.3]
        + 0.7 * dice.each("aim: by place", 2)
        + 0.65 * dice.each("aim: gesture", 2) / several
        + dice.each("aim: tremble", 2) * left_of_tremble / several * [0.45, 0.16]
    )


def _drift(dice: _Dice) -> Array:
    """How far (m, n, 1) the heading has drifted [standard deviations of a minute's drift] by each gesture."""
    rate = dice.constant("band: drift", 1)
    minutes = np.concatenate([np.arange(dice.stops) * _STOP_S, np.zeros(dice.targets)]) / 60.0
    begun = dice.stops * _STOP_S / 60.0
    later = dice.rngs["band: drift"].uniform(0.0, _USE_S / 60.0, (dice.count, dice.targets, 1))
    times = np.broadcast_to(minutes[:, None], (dice.count, len(minutes), 1)).copy()
    times[:, dice.stops :] = begun + later
    return np.asarray(rate * times)


def _slip(dice: _Dice) -> Array:
    """(m, n, 1): nothing at the stops, one slip in all that comes after."""
    after = (np.arange(dice.stops + dice.targets) >= dice.stops).astype(float)
    return np.asarray(dice.constant("band: slip", 1) * after[:, None])
