"""From the arm to what is pointed at: ray, spot, posterior, choice."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from armspan.conductor.arm import Arm
from armspan.conductor.hits import Hits
from armspan.conductor.settings import Settings
from armspan.frames import Array
from armspan.pointing.place import Place
from armspan.pointing.selection import NOTHING, Candidate, Candidates, Dwell
from armspan.pointing.smoothing import SmoothRotation
from armspan.pointing.spots import Spot, spot
from armspan.records import Pointed, RobotState, Selected

Rays: TypeAlias = Callable[[Array, Array | None], tuple[Array, Array]]
"""The rays of an arm whose forearm and upper arm have these attitudes, as the calibration found the arm."""

How: TypeAlias = Literal["dwell", "tap", "hit"]

SURE = 0.85
"""Posterior above which a choice teaches the place."""

CURSOR, CURSOR_SHARE = 0.02, 0.35
"""How well lights tell a cursor's place per axis: 2 cm, and a third of the distance to the nearest robot, whose
one lit light tells a sixth of a turn."""

CORRECTING = 0.8
"""Seconds in which a user who sees the cursor takes away most of what was wrong: 0.2 to see, 0.3 to move, twice."""

EXPIRED_DEG = 15
EXPIRED = math.radians(EXPIRED_DEG)
"""Standard deviation of the heading [rad] beyond which the calibration has expired: 7.5 min without a selection."""

_REACHING = 1.0
"""Rate [rad/s] of a reach; a correction stays below it."""


@dataclass(slots=True)
class Aim:
    """What the arm says at one tick: its ray in ``user`` and the best candidate."""

    ray: tuple[Array, Array]
    best: Candidate
    pointed: Pointed


class Pointer:
    """Follows the calibrated arm from tick to tick."""

    def __init__(self, settings: Settings, arm: Arm, place: Place, rays: Rays, hits: Hits | None = None) -> None:
        self.settings, self.arm, self.place, self.rays, self.hits = settings, arm, place, rays, hits
        self.dwell = Dwell(settings.selection)
        self._zones = Candidates.on_sheet(settings.sheet, settings.zones)
        self._smooth = {name: SmoothRotation() for name in arm.pointing}
        self._aim: Aim | None = None
        self._reached = 0.0

    @property
    def ray(self) -> tuple[Array, Array] | None:
        """Origin and direction of the last ray in ``user``, None where there was none."""
        return self._aim.ray if self._aim is not None else None

    def settle(self, settings: Settings) -> None:
        """Go on with changed zones."""
        self.settings = settings
        self._zones = Candidates.on_sheet(settings.sheet, settings.zones)

    def tick(self, t: float, states: Mapping[str, RobotState], cursor: bool) -> tuple[Pointed, How | None]:
        """Where the arm points at ``t`` [s], and how that makes a choice, if it does; is the cursor shown?"""
        self.place.advance(t)
        self._aim = None
        silent = self.arm.silent(t)
        if silent:
            return self._refuse(t, f"stale: nothing heard of {' and '.join(silent)}"), None
        ray = self._ray(t)
        if ray is None:
            return self._refuse(t, "the band is not set up"), None
        if self.place.covariance[3, 3] > EXPIRED**2:
            why = f"expired: the heading may be off by {EXPIRED_DEG} degrees; set up again"
            return self._by_receptors(t, why, ray, states) if self.hits else (self._refuse(t, why), None)
        meant, noise = self.place.aimed(ray[1])
        place, height = self.place.now(noise), self.settings.light_height_m
        lights, ground = spot(place, ray[0], meant, -height), spot(place, ray[0], meant, 0.0)
        if lights.refused or ground.refused or ground.covariance is None:
            return self._refuse(t, lights.refused or ground.refused or ""), None
        if self.arm.rate > _REACHING:
            self._reached = t
        if cursor and not self.settings.beam:  # who sees the laser's spot does not look at the cursor
            steered = t - self._reached
            lights, ground = (steered_by_cursor(at, steered, states) for at in (lights, ground))
        self._aim = self._judge(t, ray, lights, ground, states)
        return self._aim.pointed, self._choice(t, self._aim)

    def _choice(self, t: float, aim: Aim) -> How | None:
        already = self.dwell.chosen and self.dwell.held == aim.best
        dwelt = self.dwell.step(t, aim.best, aim.pointed.probability, self.arm.moving)
        if self.hits is not None and aim.pointed.decided and self.hits.due(t, aim.best, already=already or dwelt):
            self.dwell.take()
            return "hit"
        return "dwell" if dwelt else None

    def _by_receptors(
        self, t: float, why: str, ray: tuple[Array, Array], states: Mapping[str, RobotState]
    ) -> tuple[Pointed, How | None]:
        """What is hit is meant, where no ray can be believed."""
        hits, gate = self.hits, self.settings.selection.gate
        if hits is None:
            return self._refuse(t, why), None
        best, probability = hits.best(self._zones.with_robots(list(states.values())), self.settings.selection.elsewhere)
        if best.robot is None or probability < gate:
            return self._refuse(t, why), None
        source = self.arm.forearm.settings.name
        pointed = Pointed(t, source, None, None, best.robot, None, probability, True, why)
        self._aim = Aim(ray, best, pointed)
        return pointed, self._choice(t, self._aim)

    def tap(self) -> bool:
        """Choose what is held, without waiting for the dwell."""
        return self._aim is not None and self.dwell.take()

    def selected(self, t: float, how: How) -> Selected:
        """The choice just made, as a record."""
        aim = self._aim
        chosen, probability = (aim.best, aim.pointed.probability) if aim else (NOTHING, 0.0)
        source = self.arm.forearm.settings.name
        return Selected(t, source, chosen.robot, chosen.zone, probability, how)

    def learn(self, chosen: Selected, states: Mapping[str, RobotState]) -> bool:
        """Refine the place by a robot that was surely meant, or a little by a zone."""
        if self._aim is None or chosen.probability < SURE:
            return False
        state = states.get(chosen.robot or "")
        if state is not None:
            point = np.array([*state.xy, -self.settings.light_height_m])
            return self.place.confirm(*self._aim.ray, point)
        if chosen.zone is not None:
            middle, extent = self._zones.extent(chosen.zone)
            return self.place.confirm(*self._aim.ray, np.array([*middle, 0.0]), extent)
        return False

    def _ray(self, t: float) -> tuple[Array, Array] | None:
        attitudes: dict[str, Array] = {}
        for name, band in self.arm.pointing.items():
            attitude = band.in_user()
            if attitude is None:
                return None
            attitudes[band.settings.segment] = self._smooth[name](t, attitude)
        return self.rays(attitudes["forearm"], attitudes.get("upperarm"))

    def _judge(
        self, t: float, ray: tuple[Array, Array], lights: Spot, ground: Spot, states: Mapping[str, RobotState]
    ) -> Aim:
        candidates = self._zones.with_robots(list(states.values()))
        posterior = candidates.posterior(
            np.asarray(lights.xy),
            np.asarray(ground.xy),
            np.asarray(ground.covariance),
            self.settings.selection.elsewhere,
            self.hits.odds(candidates.robots) if self.hits else None,
        )
        index = int(np.argmax(posterior))
        best, probability = candidates.name(index), float(posterior[index])
        return Aim(ray, best, self._pointed(t, lights, ground, best, probability))

    def _pointed(self, t: float, lights: Spot, ground: Spot, best: Candidate, probability: float) -> Pointed:
        at = lights if best.robot is not None else ground
        (x, y), ((a, b), (_, c)) = np.asarray(at.xy).tolist(), np.asarray(at.covariance).tolist()
        decided = best != NOTHING and probability >= self.settings.selection.gate
        return Pointed(
            t,
            self.arm.forearm.settings.name,
            (x, y),
            ((a, b), (b, c)),
            best.robot,
            best.zone,
            probability,
            decided,
        )

    def _refuse(self, t: float, why: str) -> Pointed:
        self.dwell.step(t, NOTHING, 0.0, True)
        return Pointed(t, self.arm.forearm.settings.name, None, None, refused=why)


def steered_by_cursor(spot: Spot, seconds: float, states: Mapping[str, RobotState]) -> Spot:
    """A spot whose user has seen the cursor for some seconds and steers it.

    The user adds what the lights tell to the aim; the longer it was seen, the more. So the information about
    the target is that of the open-loop ray, and a growing share of that of the cursor.
    """
    here, ray = np.asarray(spot.xy).tolist(), np.asarray(spot.covariance)
    away = min((math.dist(here, state.xy) for state in states.values()), default=math.inf)
    seen = 1.0 - math.exp(-max(0.0, seconds) / CORRECTING)
    told = seen / (CURSOR + CURSOR_SHARE * away) ** 2
    covariance = np.linalg.solve(np.eye(2) + told * ray, ray)  # of the two informations' sum
    return Spot(spot.xy, np.asarray(covariance, dtype=float))
