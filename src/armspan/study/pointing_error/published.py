"""The report's published points, and the reading that lands on them.

The values were read from the vector graphics of the report's figures 1.3.2 and 1.3.3 (published with the project
chili-epfl/cellulo_pointing_ros, 2019). The simulation's own code is not public, so how they came about is inferred:
`as_published` is a supposition, which is borne out by their geometry and by nothing else.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from armspan.frames import Array, yaw_rotation
from armspan.study.pointing_error.readings import (
    ALL_MEASURES,
    Wrong,
    errors_mm,
    fit_wrong,
    imu_yaw,
    refitted,
    unfitted,
    wrong_measure,
)
from armspan.study.pointing_error.scene import CIRCLE_Y, Scene

BODY_MM_PER_PERCENT = 12.15
"""Figure 1.3.3a is a straight line to both sides, 109.4 mm at 9 and at -9 %."""

ANGLE_MM: dict[int, float] = {
    **dict(zip(range(1, 10), (39.2, 75.6, 118.1, 157.7, 197.4, 237.2, 276.7, 316.0, 355.2), strict=True)),
    **dict(zip(range(-1, -10, -1), (39.1, 77.9, 116.6, 155.1, 193.4, 231.5, 251.8, 308.0, 325.3), strict=True)),
}
"""Figure 1.3.3b: the error [mm] by the angle [deg]."""

MAP_SIZE = 9
"""The figures 1.3.2 are called those of 10 % and 10 degrees; their geometry is that of 9."""

MAP_SCALE, MAP_TURN, MAP_CENTRE_TURN = 0.910, float(np.radians(18.0)), float(np.radians(9.0))
"""Figure 1.3.2a: all places scaled about the origin. 1.3.2b: the circle turned about itself, its centre about the
origin [rad], both without a change of size."""


Places: TypeAlias = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Published:
    """A published error [mm] at a ``size`` [``unit``] beside the supposed reading's, in figure ``figure``."""

    figure: str
    size: float
    unit: str
    published_mm: float
    as_published_mm: float


@dataclass(frozen=True, slots=True)
class Map:
    """Places [mm] of a ``figure`` from above: true, published (redrawn from the geometry read), and in three readings.

    ``error`` says what was wrong; x is ahead and y to the left of the user, who stands on the origin.
    """

    figure: str
    error: str
    true: Places
    published: Places
    as_published: Places
    unfitted: Places
    refitted: Places


def as_published(scene: Scene, wrong: Wrong) -> Array:
    """Places (n, 3) [m] where the calibration's shift is left out and its yaw is applied the wrong way round.

    With wrong measures the calibration finds no yaw, so that this is the place without a calibration. With a wrong
    yaw of the arm it finds the same yaw with the other sign, which here comes on top instead of undoing the first.
    """
    yaw = fit_wrong(scene, wrong).yaw
    return np.asarray(unfitted(scene, wrong) @ yaw_rotation(-yaw).T)


def wrong_by(scene: Scene, unit: str, size: float) -> Wrong:
    """The report's two errors: all measures by a share [%], or the arm's yaw by an angle [deg]."""
    return wrong_measure(scene, ALL_MEASURES, size / 100.0) if unit == "%" else imu_yaw(scene, np.radians(size))


def compare(scene: Scene) -> tuple[Published, ...]:
    """Every published point of the figures 1.3.3a and b beside the supposed reading's."""
    sizes = sorted(ANGLE_MM)
    points = [("1.3.3a", size, "%", BODY_MM_PER_PERCENT * abs(size)) for size in sizes]
    points += [("1.3.3b", size, "deg", ANGLE_MM[size]) for size in sizes]
    return tuple(
        Published(figure, float(size), unit, told, _median(scene, wrong_by(scene, unit, size)))
        for figure, size, unit, told in points
    )


def maps(scene: Scene) -> tuple[Map, Map]:
    """The figures 1.3.2a and b."""
    true = scene.points()
    centre = np.array([0.0, CIRCLE_Y, 0.0])
    turned = (true - centre) @ yaw_rotation(MAP_TURN).T + centre @ yaw_rotation(MAP_CENTRE_TURN).T
    told = MAP_SCALE * true * [1.0, 1.0, 0.0]
    return (
        _map(scene, "1.3.2a", f"all measures {MAP_SIZE} % too small", wrong_by(scene, "%", -MAP_SIZE), told),
        _map(scene, "1.3.2b", f"yaw of the arm {MAP_SIZE} deg off", wrong_by(scene, "deg", MAP_SIZE), turned),
    )


def _map(scene: Scene, figure: str, error: str, wrong: Wrong, published: Array) -> Map:
    places = (
        scene.points(),
        published,
        as_published(scene, wrong),
        unfitted(scene, wrong),
        refitted(scene, wrong),
    )
    return Map(figure, error, *(_plain(each) for each in places))


def _median(scene: Scene, wrong: Wrong) -> float:
    return float(np.median(errors_mm(scene, as_published(scene, wrong))))


def _plain(places: Array) -> Places:
    return tuple((float(1000.0 * x), float(1000.0 * y)) for x, y, _ in places)
