"""What is pointed at: the posterior over robots and zones, and the dwell that makes it a choice.

A hit test asks whether the spot lies on a robot: at three degrees of noise it answers yes once in five. The
posterior asks which candidate explains the spot best, and says how sure it is; below the gate the answer is
"undecided", which is a result.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import msgspec
import numpy as np
import shapely
from numpy.typing import NDArray

from armspan.errors import ConfigError
from armspan.frames import Array
from armspan.records import RobotState, Sheet, Zone


class SelectionSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a selection is made.

    ``gate`` is the posterior that a candidate needs, ``hold`` the lower one that keeps it (hysteresis),
    ``dwell_s`` how long it is held to be chosen, ``elsewhere`` the prior that nothing known is meant.
    """

    gate: float = 0.8
    hold: float = 0.65
    dwell_s: float = 1.0
    elsewhere: float = 0.05

    def __post_init__(self) -> None:
        if not 0.3 <= self.dwell_s <= 2.0:
            raise ConfigError(f"dwell_s is {self.dwell_s}; a dwell lasts 0.3 to 2 s, and 1.0 is a good start")
        if not 0.5 <= self.hold <= self.gate < 1.0:
            raise ConfigError(f"gate {self.gate} and hold {self.hold}: expected 0.5 <= hold <= gate < 1")
        if not 0.0 < self.elsewhere < 1.0:
            raise ConfigError(f"elsewhere is {self.elsewhere}; it is a probability between 0 and 1, such as 0.05")


@dataclass(frozen=True, slots=True)
class Candidate:
    """A robot or a zone that can be meant."""

    robot: str | None = None
    zone: str | None = None


NOTHING = Candidate()
_GRID = 7
"""Points along a zone's longer side at which the spot's density is averaged."""

_AIM = 0.006
"""Spread [m] of where on a robot people aim: its light, not its rim."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """The robots and zones that can be meant now, as arrays; built once, moved with ``with_robots``."""

    zones: tuple[Candidate, ...]
    zone_points: Array
    zone_of_point: NDArray[np.int64]
    zone_spacing: Array
    area: float
    robots: tuple[Candidate, ...] = ()
    robot_xy: Array = field(default_factory=lambda: np.zeros((0, 2)))

    @classmethod
    def on_sheet(cls, sheet: Sheet, zones: Sequence[Zone]) -> "Candidates":
        """The zones of a sheet; what is meant beside them lies anywhere on twice the sheet's area."""
        grids = [_inner_points(zone) for zone in zones]
        points = np.concatenate([grid for grid, _ in grids]) if grids else np.zeros((0, 2))
        owner = np.repeat(np.arange(len(grids)), [len(grid) for grid, _ in grids]).astype(np.int64)
        spacing = np.array([space for _, space in grids])
        names = tuple(Candidate(zone=zone.name) for zone in zones)
        return cls(names, points, owner, spacing, 2 * sheet.width_m * sheet.height_m)

    def with_robots(self, states: Sequence[RobotState]) -> "Candidates":
        """The same zones, and the robots where they are now; a held robot cannot be meant."""
        here = [state for state in states if not state.held]
        xy = np.array([state.xy for state in here], dtype=float).reshape(-1, 2)
        robots = tuple(Candidate(robot=state.robot) for state in here)
        return Candidates(self.zones, self.zone_points, self.zone_of_point, self.zone_spacing, self.area, robots, xy)

    def posterior(
        self, robot_spot: Array, zone_spot: Array, covariance: Array, elsewhere: float, odds: Array | None = None
    ) -> Array:
        """Probabilities (robots + zones + 1,) that each is meant; the last is "nothing known".

        ``robot_spot`` (2,) [m] is where the ray meets the plane of the robots' lights, ``zone_spot`` where it
        meets the sheet; ``covariance`` (2, 2) [m²] holds for both. All candidates are alike a priori. ``odds``
        (robots,) tell how much likelier what the robots' receptors say is if each robot is meant than if not.
        """
        of_robots = _density(self.robot_xy - robot_spot, covariance, _AIM**2)
        if odds is not None:
            of_robots = of_robots * odds
        of_zones = self._zone_density(zone_spot, covariance)
        return _shared(np.concatenate([of_robots, of_zones]), elsewhere, elsewhere / self.area)

    def by_receptors(self, elsewhere: float, odds: Array) -> Array:
        """The same where no ray is known: every place of the sheet is as likely as any other."""
        return _shared(np.concatenate([odds, np.ones(len(self.zones))]), elsewhere, elsewhere)

    def _zone_density(self, spot: Array, covariance: Array) -> Array:
        """Density [1/m²] of the spot for each zone (k,): somewhere in it is meant, everywhere alike."""
        if not self.zones:
            return np.zeros(0)
        spread = (self.zone_spacing**2 / 12)[self.zone_of_point]
        at_points = _density(self.zone_points - spot, covariance, spread)
        total = np.bincount(self.zone_of_point, at_points, len(self.zones))
        return np.asarray(total / np.bincount(self.zone_of_point, minlength=len(self.zones)))

    def extent(self, zone: str) -> tuple[Array, Array]:
        """A zone's middle (2,) [m] and the covariance (2, 2) [m²] of its points about it."""
        number = [candidate.zone for candidate in self.zones].index(zone)
        points = self.zone_points[self.zone_of_point == number]
        middle = points.mean(axis=0)
        own = self.zone_spacing[number] ** 2 / 12 * np.eye(2)
        return middle, (points - middle).T @ (points - middle) / len(points) + own

    def name(self, index: int) -> Candidate:
        """The candidate at a place in the posterior."""
        return (*self.robots, *self.zones, NOTHING)[index]


def _shared(likelihood: Array, elsewhere: float, nothing: float) -> Array:
    """The posterior of candidates (n,) that are alike a priori, and of nothing known, of weight ``nothing``."""
    share = (1 - elsewhere) / max(1, len(likelihood))
    weights = np.append(likelihood * share, nothing)
    return np.asarray(weights / weights.sum())


def _density(offsets: Array, covariance: Array, extra: float | Array) -> Array:
    """Normal densities [1/m²] at offsets (n, 2), with ``extra`` variance [m²] on each axis."""
    a, b, c = covariance[0, 0] + extra, covariance[0, 1], covariance[1, 1] + extra
    determinant = a * c - b * b
    x, y = offsets[:, 0], offsets[:, 1]
    squared = (c * x * x - 2 * b * x * y + a * y * y) / determinant
    return np.asarray(np.exp(-0.5 * squared) / (2 * np.pi * np.sqrt(determinant)))


def _inner_points(zone: Zone) -> tuple[Array, float]:
    """Points (n, 2) [m] on a grid inside a zone, and their spacing [m]."""
    shape = shapely.Polygon(zone.polygon)
    x0, y0, x1, y1 = shape.bounds
    spacing = max(x1 - x0, y1 - y0) / _GRID
    xs = np.arange(x0 + spacing / 2, x1, spacing)
    ys = np.arange(y0 + spacing / 2, y1, spacing)
    grid = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    inside = grid[shapely.contains_xy(shape, grid[:, 0], grid[:, 1])]
    if len(inside) == 0:
        inside = np.array([shape.representative_point().coords[0]])
    return inside, float(spacing)


@dataclass(slots=True)
class Dwell:
    """Turns a stream of posteriors into choices: one candidate above the gate, held for the dwell.

    A choice is made once; the next needs that the candidate was left. While the arm moves fast nothing is
    added up, since a sweep crosses candidates that are not meant.
    """

    settings: SelectionSettings
    held: Candidate = NOTHING
    since: float = 0.0
    chosen: bool = False

    def step(self, t: float, best: Candidate, probability: float, moving: bool) -> bool:
        """Take the best candidate at ``t`` [s]; True at the moment at which it is chosen."""
        same = best == self.held and best != NOTHING
        keeps = probability >= (self.settings.hold if same else self.settings.gate)
        if best == NOTHING or not keeps:
            self.held, self.chosen = NOTHING, False
            return False
        if not same:
            self.held, self.since, self.chosen = best, t, False
        if moving and not self.chosen:
            self.since = t
        if self.chosen or t - self.since < self.settings.dwell_s:
            return False
        self.chosen = True
        return True

    def progress(self, t: float) -> float:
        """Share of the dwell that is done at ``t`` [s], for a growing ring."""
        if self.held == NOTHING:
            return 0.0
        return 1.0 if self.chosen else min(1.0, (t - self.since) / self.settings.dwell_s)

    def take(self) -> bool:
        """Choose the held candidate at once, as a tap does; False when there is none, or it was chosen."""
        if self.held == NOTHING or self.chosen:
            return False
        self.chosen = True
        return True
