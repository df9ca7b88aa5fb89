"""From the arm to what is pointed at: ray, spot, posterior, choice."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from armspan.conductor.arm import Arm
from armspan.conductor.settings import Settings
from armspan.frames import Array
from armspan.pointing.place import Place
from armspan.pointing.rays import arm_rays
from armspan.pointing.selection import NOTHING, Candidate, Candidates, Dwell
from armspan.pointing.smoothing import SmoothRotation
from armspan.pointing.spots import Spot, spot
from armspan.records import Model, Pointed, RobotState, Selected

SURE = 0.9
"""Posterior above which a choice teaches the place."""


@dataclass(slots=True)
class Aim:
    """What the arm says at one tick: its ray in ``user`` and the best candidate."""

    ray: tuple[Array, Array]
    best: Candidate
    pointed: Pointed


class Pointer:
    """Follows the calibrated arm from tick to tick."""

    def __init__(self, settings: Settings, arm: Arm, place: Place, model: Model) -> None:
        self.settings, self.arm, self.place, self.model = settings, arm, place, model
        self.dwell = Dwell(settings.selection)
        self._zones = Candidates.on_sheet(settings.sheet, settings.zones)
        self._smooth = {name: SmoothRotation() for name in arm.by_name}
        self._aim: Aim | None = None

    def tick(self, t: float, states: Mapping[str, RobotState]) -> tuple[Pointed, bool]:
        """Where the arm points at ``t`` [s], and whether that completes a dwell."""
        self.place.advance(t)
        self._aim = None
        silent = self.arm.silent(t)
        if silent:
            return self._refuse(t, f"stale: nothing heard of {' and '.join(silent)}"), False
        ray = self._ray(t)
        if ray is None:
            return self._refuse(t, "the band is not set up"), False
        place = self.place.now()
        lights, ground = spot(place, *ray, -self.settings.light_height_m), spot(place, *ray, 0.0)
        if lights.refused or ground.refused or ground.covariance is None:
            return self._refuse(t, lights.refused or ground.refused or ""), False
        self._aim = self._judge(t, ray, lights, ground, states)
        done = self.dwell.step(t, self._aim.best, self._aim.pointed.probability, self.arm.moving)
        return self._aim.pointed, done

    def tap(self) -> bool:
        """Choose what is held, without waiting for the dwell."""
        return self._aim is not None and self.dwell.take()

    def selected(self, t: float, how: str) -> Selected:
        """The choice just made, as a record."""
        aim = self._aim
        chosen, probability = (aim.best, aim.pointed.probability) if aim else (NOTHING, 0.0)
        source = self.arm.forearm.settings.name
        return Selected(t, source, chosen.robot, chosen.zone, probability, "tap" if how == "tap" else "dwell")

    def learn(self, chosen: Selected, states: Mapping[str, RobotState]) -> bool:
        """Refine the place by a robot that was surely meant; zones are too wide to teach anything."""
        state = states.get(chosen.robot or "")
        if self._aim is None or state is None or chosen.probability < SURE:
            return False
        point = np.array([*state.xy, -self.settings.light_height_m])
        return self.place.confirm(*self._aim.ray, point)

    def _ray(self, t: float) -> tuple[Array, Array] | None:
        attitudes: dict[str, Array] = {}
        for name, band in self.arm.by_name.items():
            attitude = band.in_user()
            if attitude is None:
                return None
            attitudes[band.settings.segment] = self._smooth[name](t, attitude)
        origin, direction = arm_rays(self.settings.body, attitudes["forearm"], attitudes.get("upperarm"), self.model)
        return origin, direction

    def _judge(
        self, t: float, ray: tuple[Array, Array], lights: Spot, ground: Spot, states: Mapping[str, RobotState]
    ) -> Aim:
        candidates = self._zones.with_robots(list(states.values()))
        posterior = candidates.posterior(
            np.asarray(lights.xy),
            np.asarray(ground.xy),
            np.asarray(ground.covariance),
            self.settings.selection.elsewhere,
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
