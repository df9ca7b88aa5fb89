"""The report's two curves in their readings: calibrated on the wrong rays, and not calibrated anew.

The report (§1.3.2 and 1.3.3) shifts the rays of an ideal user by an angle, or his measures by a share, and shows how
far the places pointed at are then from the true ones. It leaves open about which axis, and whether the calibration,
which is the method's own step (§1.3.1), is made with the wrong rays or left out. Here is each meaning in both ways.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from armspan.frames import Array, yaw_rotation
from armspan.pointing.calibration import Fit, Method, calibrate
from armspan.pointing.priors import pitched
from armspan.pointing.rays import arm_rays, unit
from armspan.records import Body
from armspan.study.pointing_error.scene import Scene, about, attitudes, moving, place_beside

DRAWS = 40
"""How many random axes are drawn for each size."""

MEASURES_OF_REPORT = ("eye height", "eye to the side", "shoulder to the side", "shoulder below the eye", "arm length")
"""The report's five measures; its sixth, the shoulder ahead of the eye, is zero, and a share of it is nothing."""

ALL_MEASURES = "all measures"


@dataclass(frozen=True, slots=True, eq=False)
class Wrong:
    """What a wrong system believes: a body, the arm's attitudes (n, 3, 3) and the eye's place beside the feet [m]."""

    body: Body
    user_from_forearm: Array
    eye_left: float


@dataclass(frozen=True, slots=True)
class Curve:
    """Median errors [mm] over the rays of a ``scene`` for an ``error`` of each of ``sizes`` [``unit``].

    ``refitted_mm``: calibrated on the wrong rays by least squares, ``worst_mm`` the largest of any ray;
    ``unfitted_mm``: at the true place, without a calibration.
    """

    scene: str
    error: str
    unit: str
    sizes: tuple[float, ...]
    refitted_mm: tuple[float, ...]
    worst_mm: tuple[float, ...]
    unfitted_mm: tuple[float, ...]


def imu_yaw(scene: Scene, angle: float) -> Wrong:
    """The arm seems turned about the vertical by ``angle`` [rad], the torso not: a heading zeroed wrongly."""
    return _arm(scene, yaw_rotation(angle) @ scene.user_from_forearm)


def imu_pitch(scene: Scene, angle: float) -> Wrong:
    """The arm seems raised by ``angle`` [rad] about the band's own y axis: a band that sits askew."""
    return _arm(scene, pitched(scene.user_from_forearm, -angle))


def imu_roll(scene: Scene, angle: float) -> Wrong:
    """The arm seems rolled by ``angle`` [rad] about itself: a band turned round the wrist."""
    return _arm(scene, scene.user_from_forearm @ about(_X, angle))


def ray_yaw(scene: Scene, angle: float) -> Wrong:
    """Whole rays turned about the vertical through the eye by ``angle`` [rad]."""
    return _rays(scene, yaw_rotation(angle) @ _ray_attitudes(scene))


def ray_pitch(scene: Scene, angle: float) -> Wrong:
    """Whole rays raised by ``angle`` [rad], each about the level axis across it."""
    return _rays(scene, pitched(_ray_attitudes(scene), -angle))


def ray_roll(scene: Scene, angle: float) -> Wrong:
    """Whole rays turned by ``angle`` [rad] about the user's x axis: a world that is not level."""
    return _rays(scene, about(_X, angle) @ _ray_attitudes(scene))


def one_axis(scene: Scene, angle: float, dice: np.random.Generator) -> Wrong:
    """Whole rays turned by ``angle`` [rad] about one axis, drawn from all directions."""
    return _rays(scene, about(unit(dice.normal(size=3)), angle) @ _ray_attitudes(scene))


def own_axes(scene: Scene, angle: float, dice: np.random.Generator) -> Wrong:
    """Every ray tilted by the whole ``angle`` [rad] in a direction of its own, drawn evenly round the ray."""
    rays = _ray_attitudes(scene)
    way = dice.uniform(0.0, 2.0 * np.pi, size=(len(rays), 1))
    return _rays(scene, about(np.cos(way) * rays[:, :, 1] + np.sin(way) * rays[:, :, 2], angle) @ rays)


_X = np.array([1.0, 0.0, 0.0])

ANGLES: dict[str, Callable[[Scene, float], Wrong]] = {
    "IMU yaw": imu_yaw,
    "IMU pitch": imu_pitch,
    "IMU roll": imu_roll,
    "whole ray about z": ray_yaw,
    "whole ray pitched": ray_pitch,
    "whole ray about x": ray_roll,
}
"""What an error by an angle may mean, where its size says all."""

Drawn = Callable[[Scene, float, np.random.Generator], Wrong]

DRAWN_ANGLES: dict[str, Drawn] = {
    "one random axis": one_axis,
    "each ray its own way": own_axes,
}


def wrong_measure(scene: Scene, measure: str, share: float) -> Wrong:
    """A measure of the report's (or `ALL_MEASURES`) believed larger by a ``share`` of it than it is."""
    factor = {name: 1.0 + share * (measure in (name, ALL_MEASURES)) for name in MEASURES_OF_REPORT}
    forward, left, up = scene.body.shoulder_to_eye_m
    body = msgspec.structs.replace(
        scene.body,
        eye_height_m=scene.body.eye_height_m * factor["eye height"],
        shoulder_to_eye_m=(forward, left * factor["shoulder to the side"], up * factor["shoulder below the eye"]),
        shoulder_to_fingertip_m=scene.body.shoulder_to_fingertip_m * factor["arm length"],
    )
    return Wrong(body, scene.user_from_forearm, scene.eye_left * factor["eye to the side"])


def fit_wrong(scene: Scene, wrong: Wrong, method: Method = "least-squares") -> Fit:
    """The calibration made with the wrong rays and the points that the true ones hit."""
    pairs = moving(wrong.user_from_forearm, scene.points())
    return calibrate(wrong.body, pairs, "head-finger", z_up=True, method=method)


def refitted(scene: Scene, wrong: Wrong, method: Method = "least-squares") -> Array:
    """Places (n, 3) [m] pointed at after a calibration on the wrong rays."""
    return scene.hits(fit_wrong(scene, wrong, method).transform(), wrong.body, wrong.user_from_forearm)


def unfitted(scene: Scene, wrong: Wrong) -> Array:
    """Places (n, 3) [m] pointed at by the wrong rays of a user who is known to stand on the origin."""
    return scene.hits(place_beside(wrong.eye_left), wrong.body, wrong.user_from_forearm)


def errors_mm(scene: Scene, places: Array) -> Array:
    """Distances (n,) [mm] of places (n, 3) [m] from those that are truly pointed at."""
    return np.asarray(1000.0 * np.linalg.norm(places - scene.points(), axis=-1))


def angle_curves(scene: Scene, degrees: Sequence[int], dice: np.random.Generator) -> tuple[Curve, ...]:
    """Every meaning of an error by an angle; of what is drawn only sizes from 0 on, since chance has no sign."""
    upwards = [d for d in degrees if d >= 0]
    fixed = [
        _curve(scene, (name, "deg"), degrees, [[make(scene, np.radians(d))] for d in degrees])
        for name, make in ANGLES.items()
    ]
    drawn = [
        _curve(scene, (name, "deg"), upwards, [_draws(scene, make, np.radians(d), dice) for d in upwards])
        for name, make in DRAWN_ANGLES.items()
    ]
    return (*fixed, *drawn)


def _draws(scene: Scene, make: Drawn, angle: float, dice: np.random.Generator) -> list[Wrong]:
    return [make(scene, angle, dice) for _ in range(DRAWS)]


def body_curves(scene: Scene, percents: Sequence[int]) -> tuple[Curve, ...]:
    """All measures together and each alone, believed wrong by the ``percents``."""
    return tuple(
        _curve(scene, (name, "%"), percents, [[wrong_measure(scene, name, p / 100)] for p in percents])
        for name in (ALL_MEASURES, *MEASURES_OF_REPORT)
    )


def _curve(scene: Scene, named: tuple[str, str], sizes: Sequence[int], wrongs: Sequence[Sequence[Wrong]]) -> Curve:
    after = [_all_errors(scene, each, refitted) for each in wrongs]
    before = [_all_errors(scene, each, unfitted) for each in wrongs]
    return Curve(
        scene.name,
        *named,
        tuple(map(float, sizes)),
        tuple(float(np.median(errors)) for errors in after),
        tuple(float(np.max(errors)) for errors in after),
        tuple(float(np.median(errors)) for errors in before),
    )


def _all_errors(scene: Scene, wrongs: Sequence[Wrong], places: Callable[[Scene, Wrong], Array]) -> Array:
    return np.concatenate([errors_mm(scene, places(scene, wrong)) for wrong in wrongs])


def _arm(scene: Scene, user_from_forearm: Array) -> Wrong:
    return Wrong(scene.body, user_from_forearm, scene.eye_left)


def _rays(scene: Scene, user_from_ray: Array) -> Wrong:
    """Rays that are turned whole: those of an arm that begins at the eye."""
    return Wrong(msgspec.structs.replace(scene.body, shoulder_to_eye_m=(0.0, 0.0, 0.0)), user_from_ray, scene.eye_left)


def _ray_attitudes(scene: Scene) -> Array:
    _, directions = arm_rays(scene.body, scene.user_from_forearm, None, "head-finger")
    x, y, z = directions.T
    return attitudes(np.arctan2(y, x), np.arcsin(z))
