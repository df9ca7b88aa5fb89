"""The printed sheet on the floor as a scale: where it lies gives the floor, the ankles upon it the body's plane.

Frames: ``camera`` has x right, y down in the picture and z along the view; ``marker`` has x right, y up as printed and
z out of the paper. The camera is a pinhole without distortion whose axis meets the picture's middle.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from armspan.body.marker_sheet import MARKER_DICTIONARY, MARKER_ID
from armspan.body.picture.image import Pixels, opencv
from armspan.body.picture.marker_edges import refined
from armspan.body.picture.marker_pose import corner_sd, likely_focal, poses
from armspan.body.scale import ANKLE_HEIGHT, ANKLE_SD
from armspan.body.skeleton import Keypoint, Skeleton
from armspan.errors import DataError
from armspan.frames import Array

_PLANE_SD = 0.025
"""How far shoulders and eyes may lie before or behind the ankles [m]."""
_FOCAL_SD, _TILT_SD = 0.02, 0.005
"""Doubt of EXIF's focal length (share; whole millimetres on film), and of the paper's tilt [rad] (assumed)."""
_FLAT = 0.7
"""Cosine between the sheet's normal and the picture's body at least: the camera looks at most 45 degrees down."""
_BELIED = 40.0
"""A pose is wrong whose misfit is larger than the other one's by so many variances of a corner."""
_SMALLEST_SIDE_PX = 12.0
_SMALL_PICTURE_PX = 2100
_UPPER = ("nose", "leye", "reye", "neck", "lsh", "rsh")
_ANKLES = ("lan", "ran")
_EYE, _ARM = 1.6, 0.7
_LEAST_HEIGHT_SD = 0.005


@dataclass(frozen=True, slots=True, eq=False)
class Marker:
    """The sheet's marker: its ``corners`` (4, 2) [px], from the printed upper left one clockwise."""

    corners: Array
    id: int


@dataclass(frozen=True, slots=True, eq=False)
class MarkerScale:
    """The body's plane, upright through the ankles and facing the camera, in ``camera`` [m].

    ``foot`` (3,) is on the floor below the ankles; ``right``, ``up`` and ``facing`` (3,) are unit vectors, the last
    one level and towards the camera. ``sd_share`` is the doubt of lengths, ``height_sd`` [m] that of the floor, and
    ``notes`` say what had to be assumed.
    """

    focal: float
    middle: Array
    foot: Array
    up: Array
    facing: Array
    sd_share: float = 0.0
    height_sd: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def right(self) -> Array:
        """Level unit vector to the right in the picture."""
        return np.cross(self.up, self.facing)

    @property
    def camera_height(self) -> float:
        """Height of the camera above the floor [m]."""
        return float(-self.up @ self.foot)

    @property
    def distance(self) -> float:
        """Level distance from the camera to the body's plane [m]."""
        return float(-self.facing @ self.foot)

    def nearer(self, distance: float) -> "MarkerScale":
        """The scale of a plane so much nearer to the camera [m].

        Seen from the side, the near arm is half the shoulders' breadth before the ankles: 6 % longer from 3 m away.
        """
        return replace(self, foot=self.foot + distance * self.facing)

    def place(self, points: Array) -> Array:
        """Pixels (n, 2) as metres (n, 2) in the body's plane: right from below the ankles, up above the floor.

        NaN where a pixel's ray does not meet the plane.
        """
        rays = _rays(points, self.focal, self.middle)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (self.facing @ self.foot) / (rays @ self.facing)
        hits = rays * np.where(reach > 0, reach, np.nan)[:, None] - self.foot
        return np.stack([hits @ self.right, hits @ self.up], axis=-1)


# --- finding it -------------------------------------------------------------------------------------------


def find_marker(pixels: Pixels, where: str) -> Marker:
    """The sheet's marker in an RGB picture, its corners to fractions of a pixel.

    Raises:
        DataError: where there is none, or more than one, or it is too small; ``where`` names the picture.
        MissingExtra: without OpenCV.

    """
    cv2 = opencv()
    grey = cv2.cvtColor(np.ascontiguousarray(pixels), cv2.COLOR_RGB2GRAY)
    found = _detected(grey)
    if not found:
        raise DataError(f"{where}: {_why_none(grey)}")
    if len(found) > 1:
        raise DataError(f"{where} shows {len(found)} of the printed markers: leave one sheet on the floor")
    marker = Marker(refined(grey, found[0].corners), MARKER_ID)
    side = float(np.linalg.norm(marker.corners - np.roll(marker.corners, 1, axis=0), axis=1).min())
    if side < _SMALLEST_SIDE_PX:
        raise DataError(
            f"{where} shows the marker only {side:.0f} pixels wide: take the picture with more pixels or from nearer"
        )
    return marker


def _detected(grey: Any) -> list[Marker]:
    """The sheet's markers, in the picture as it is, or smoothed against noise, or a small one with more pixels."""
    cv2 = opencv()
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    parameters.minMarkerPerimeterRate = 0.01
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, MARKER_DICTIONARY))
    detector = cv2.aruco.ArucoDetector(dictionary, parameters)
    tries = [(1, 0.0), (1, 1.5)] + [(2, 1.0)] * (max(grey.shape) < _SMALL_PICTURE_PX)
    for share, smooth in tries:
        tried = grey if share == 1 else cv2.resize(grey, None, fx=share, fy=share, interpolation=cv2.INTER_CUBIC)
        corners, ids, _ = detector.detectMarkers(cv2.GaussianBlur(tried, (0, 0), smooth) if smooth else tried)
        named = [] if ids is None else zip(np.ravel(ids), corners, strict=True)
        quads = [np.asarray(quad, float).reshape(4, 2) for id_, quad in named if id_ == MARKER_ID]
        if quads:
            return [Marker((quad + 0.5) / share - 0.5, MARKER_ID) for quad in quads]
    return []


def _why_none(grey: Any) -> str:
    if _detected(np.ascontiguousarray(grey[:, ::-1])):
        return "the picture is mirrored: turn the mirroring of the camera off, or use its main camera"
    return (
        "no printed marker is seen: lay the sheet (armspan body --print-marker) flat on the floor half a metre before "
        "the feet, all of its white rim in the picture, without glare, or measure with the typed height"
    )


# --- what it tells ----------------------------------------------------------------------------------------


def marker_scale(
    marker: Marker, skeleton: Skeleton, size: tuple[int, int], focal_px: float | None, *, sole: float = 0.0
) -> MarkerScale:
    """The scale of a picture of ``size`` (width, height) [px] that shows a person behind the sheet on the floor.

    Without ``focal_px`` the focal length is found from the marker's own perspective and a phone's main camera, and
    noted. ``sole`` [m] is that of the shoes. The pose is the one of IPPE's two (Collins and Bartoli, IJCV 2014) whose
    normal points up along the body.

    Raises:
        DataError: where no ankle is known, or the sheet does not lie flat on the floor the person stands on.

    """
    if skeleton.size is not None and skeleton.size != size:
        raise DataError(f"the skeleton is of a picture of {skeleton.size} pixels, the marker of one of {size}")
    points = skeleton.trusted()
    ankles = np.array([points[name][:2] for name in _ANKLES if name in points])
    if not len(ankles):
        raise DataError("no ankle is seen: the sheet gives a scale where the whole person is in the picture")
    upright = _upright(points, ankles)
    focal, focal_sd, notes = focal_px, _FOCAL_SD, list[str]()
    if focal is None:
        focal, focal_sd = likely_focal(marker.corners, upright, size)
        notes.append(f"focal length not in the picture: {focal:.0f} px ± {focal_sd:.0%} by the sheet's perspective")
    seen = _Seen(marker.corners, focal, ankles, ANKLE_HEIGHT + sole, upright, size)
    scale = seen.scale()
    share, height_sd = _doubt(seen, scale, focal_sd)
    return replace(scale, sd_share=share, height_sd=height_sd, notes=tuple(notes))


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """All that the body's plane follows from: pixels, focal length [px], height of the ankles' points [m]."""

    corners: Array
    focal: float
    ankles: Array
    ankle_height: float
    upright: Array
    size: tuple[int, int]
    tilt: float = 0.0

    def scale(self) -> MarkerScale:
        middle = (np.array(self.size, float) - 1) / 2
        (up, sheet, misfit), other = poses(self.corners, self.focal, middle, self.upright)
        belied = misfit - other.misfit > _BELIED * corner_sd(self.corners) ** 2
        if belied or up[:2] @ self.upright < _FLAT:
            raise DataError(_NOT_FLAT)
        up = _unit(up + self.tilt * _unit(up * (sheet @ up) - sheet))
        rays = _rays(self.ankles, self.focal, middle)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (up @ sheet + self.ankle_height) / (rays @ up)
        if not (reach > 0).all():
            raise DataError(_NOT_FLAT)
        foot = (rays * reach[:, None]).mean(axis=0) - self.ankle_height * up
        facing = -foot + (foot @ up) * up
        return MarkerScale(self.focal, middle, foot, up, _unit(facing))


_NOT_FLAT = (
    "the printed sheet does not lie flat on the floor before the person: lay it there, half a metre before the feet, "
    "and hold the camera at chest height"
)


def _upright(points: Mapping[str, Keypoint], ankles: Array) -> Array:
    """Unit vector (2,) in the picture from the ankles up the body."""
    upper = [points[name][:2] for name in _UPPER if name in points]
    if not upper:
        raise DataError("neither shoulders nor head are seen: the whole person must be in the picture")
    way = np.mean(upper, axis=0) - ankles.mean(axis=0)
    length = float(np.linalg.norm(way))
    if length == 0.0:
        raise DataError("shoulders and ankles are at one point of the picture: the skeleton cannot be used")
    upright: Array = way / length
    return upright


def _doubt(seen: _Seen, scale: MarkerScale, focal_sd: float) -> tuple[float, float]:
    """Doubt of lengths (share) and of the floor [m], by differences of the geometry.

    The second is what the doubt of an eye's height has beyond the share of that height.
    """
    moved = corner_sd(seen.corners)
    changed = [replace(seen, corners=seen.corners + moved * side) for side in np.eye(8).reshape(8, 4, 2)]
    changed.append(replace(seen, focal=seen.focal * (1 + focal_sd)))
    changed.append(replace(seen, ankle_height=seen.ankle_height + ANKLE_SD))
    changed.append(replace(seen, tilt=_TILT_SD))
    reference = _pixels(scale, np.array([[0.0, _EYE], [0.0, 1.4], [_ARM, 1.4]]))
    places = [scale.nearer(_PLANE_SD).place(reference)] + [other.scale().place(reference) for other in changed]
    eye, length = np.array([_reading(place) for place in places]).T
    share, eye_sd = float(np.linalg.norm(length / _ARM - 1)), float(np.linalg.norm(eye - _EYE))
    return share, float(np.sqrt(max(eye_sd**2 - (share * _EYE) ** 2, _LEAST_HEIGHT_SD**2)))


def _reading(place: Array) -> Sequence[float]:
    return float(place[0, 1]), float(np.linalg.norm(place[2] - place[1]))


def _pixels(scale: MarkerScale, places: Array) -> Array:
    """Pixels (n, 2) of points (n, 2) [m] in the body's plane."""
    points = scale.foot + places[:, :1] * scale.right + places[:, 1:] * scale.up
    pixels: Array = scale.middle + scale.focal * points[:, :2] / points[:, 2:]
    return pixels


def _unit(vector: Array) -> Array:
    unit: Array = vector / np.linalg.norm(vector)
    return unit


def _rays(pixels: Array, focal: float, middle: Array) -> Array:
    """Directions (n, 3) in ``camera`` of pixels (n, 2)."""
    across = (np.asarray(pixels, float).reshape(-1, 2) - middle) / focal
    return np.column_stack([across, np.ones(len(across))])
