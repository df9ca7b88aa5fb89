"""Robots that wander about without an aim."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from armspan.errors import ConfigError, known_names
from armspan.frames import Array
from armspan.records import Drive, GoTo, RobotState, Vec2
from armspan.swarm.behaviours.protocol import Stage

Mode: TypeAlias = Literal["ballistic", "run-and-tumble", "correlated"]

AT_EDGE = 0.01
"""A robot this near [m] to where its way meets the edge turns away."""

BLOCKED_S, BLOCKED_M = 0.7, 0.01
"""A robot that moved less [m] in so long [s] turns elsewhere."""

RUN_S = 2.0
"""How long [s] a run lasts between two tumbles."""

SIGMA = 1.0
"""How fast the heading of a correlated walk drifts [rad/√s]."""


@dataclass(slots=True)
class _Walker:
    """Where a robot heads [rad], since when [s], and from where it has to get away to count as moving."""

    heading: float
    turned: float
    left: Vec2
    left_at: float


class RandomWalk:
    """Wander about: ``ballistic`` (straight on up to the edge), ``run-and-tumble`` or ``correlated``.

    In all modes a robot that meets the edge, or is blocked, takes a new heading, even over those that lead inside.
    Run-and-tumble takes one every `RUN_S` too; a correlated walk's heading drifts as Brownian motion (`SIGMA`).

    Raises:
        ConfigError: of a mode that does not exist.

    """

    def __init__(self, stage: Stage, states: Mapping[str, RobotState], *, mode: Mode = "ballistic") -> None:
        if mode not in get_args(Mode):
            raise ConfigError(known_names("a random walk's mode", mode, get_args(Mode)))
        self._stage = stage
        self._mode = mode
        self._walkers: dict[str, _Walker] = {}
        self._last: float | None = None

    @property
    def done(self) -> bool:
        """Never."""
        return False

    def step(self, t: float, states: Mapping[str, RobotState], pointed: Vec2 | None) -> list[GoTo | Drive]:
        """To where each one's heading meets the edge."""
        passed = 0.0 if self._last is None else max(t - self._last, 0.0)
        self._last = t
        self._walkers = {name: walker for name, walker in self._walkers.items() if name in states}
        return [self._wish(t, passed, states[name]) for name in sorted(states)]

    def _wish(self, t: float, passed: float, state: RobotState) -> GoTo:
        here = np.clip(state.xy, *self._stage.bounds)
        walker = self._walkers.get(state.robot)
        if walker is None:
            walker = _Walker(self._new_heading(here), t, state.xy, t)
            self._walkers[state.robot] = walker
        elif self._turns(t, walker, state.xy):
            walker.heading, walker.turned = self._new_heading(here), t
            walker.left, walker.left_at = state.xy, t
        elif self._mode == "correlated":
            walker.heading += SIGMA * math.sqrt(passed) * float(self._stage.rng.standard_normal())
        x, y = _edge_ahead(here, walker.heading, *self._stage.bounds)
        limits = self._stage.limits
        return GoTo(t, state.robot, (x, y), limits.speed_m_s, t + limits.lease_s)

    def _turns(self, t: float, walker: _Walker, xy: Vec2) -> bool:
        if math.dist(xy, walker.left) >= BLOCKED_M:
            walker.left, walker.left_at = xy, t
        here = np.clip(xy, *self._stage.bounds)
        at_edge = math.dist(here, _edge_ahead(here, walker.heading, *self._stage.bounds)) < AT_EDGE
        tumbles = self._mode == "run-and-tumble" and t - walker.turned >= RUN_S
        return at_edge or tumbles or t - walker.left_at >= BLOCKED_S

    def _new_heading(self, here: Array) -> float:
        """Even over the headings that do not lead straight out."""
        low, high = self._stage.bounds
        inward = (here < low + AT_EDGE).astype(float) - (here > high - AT_EDGE)
        heading = 0.0
        for _ in range(32):
            heading = float(self._stage.rng.uniform(-math.pi, math.pi))
            way = np.array([math.cos(heading), math.sin(heading)])
            if (way * inward >= 0).all():
                break
        return heading


def _edge_ahead(here: Array, heading: float, low: Array, high: Array) -> Vec2:
    """Where [m] a heading [rad] from inside a box meets its edge."""
    way = np.array([math.cos(heading), math.sin(heading)])
    room = np.where(way > 0, high - here, here - low)
    length = float(np.min(room / np.maximum(np.abs(way), 1e-9)))
    x, y = np.clip(here + length * way, low, high)
    return float(x), float(y)
