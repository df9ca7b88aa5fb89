"""Pictures of bodies in a room through a pinhole: floor, wall, a sheet on the floor; numpy and OpenCV, no GPU."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Pixels = npt.NDArray[np.uint8]

SIZE = (1280, 960)
FOCAL = 1035.0
"""28 mm on a 35 mm film's diagonal, the main camera of a telephone [px]."""
FINER = 2
"""Pixels drawn for each pixel kept, each way."""


@dataclass(frozen=True)
class Camera:
    """A pinhole at ``place`` that looks at ``aim`` [m, scene], level to the horizon."""

    place: Array
    aim: Array
    focal: float = FOCAL
    size: tuple[int, int] = SIZE

    def axes(self) -> Array:
        """Rows: right, down and ahead of the camera, in the scene."""
        ahead = (self.aim - self.place) / np.linalg.norm(self.aim - self.place)
        right = np.cross(ahead, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(ahead, right), ahead])

    def project(self, points: Array) -> Array:
        """Pixels (n, 2) of points (n, 3) [m]; whole numbers are the centres of pixels."""
        seen = (np.atleast_2d(points) - self.place) @ self.axes().T
        centre = (np.array(self.size) - 1) / 2
        return np.asarray(self.focal * seen[:, :2] / seen[:, 2:] + centre)


@dataclass(frozen=True)
class Mesh:
    """Triangles in the scene with a colour (0 to 1, RGB) each."""

    vertices: Array
    faces: npt.NDArray[np.int64]
    colours: Array


@dataclass(frozen=True)
class Sheet:
    """A page flat on the floor.

    ``centre`` (x, y) and ``size`` [m], ``turn`` [rad] of its top from the x axis, ``page`` in grey (h, w).
    """

    centre: tuple[float, float]
    turn: float
    page: Pixels
    size: tuple[float, float]


def draw(camera: Camera, meshes: Sequence[Mesh], sheet: Sheet | None, rng: np.random.Generator) -> Pixels:
    """The picture (h, w, 3) uint8 RGB, with the noise of a telephone's sensor."""
    import cv2

    fine = Camera(camera.place, camera.aim, camera.focal * FINER, (camera.size[0] * FINER, camera.size[1] * FINER))
    image = cv2.resize(_room(camera, rng), fine.size, interpolation=cv2.INTER_LINEAR)
    if sheet is not None:
        _lay(image, fine, sheet)
    for mesh in meshes:
        _shade_floor(image, fine, mesh)
    for mesh in sorted(meshes, key=lambda m: -float(np.linalg.norm(m.vertices.mean(axis=0) - camera.place))):
        _paint(image, fine, mesh)
    image = cv2.resize(image, camera.size, interpolation=cv2.INTER_AREA)
    image = cv2.GaussianBlur(image, (0, 0), 0.6)
    image = image + rng.normal(0.0, 0.008, image.shape)
    return np.asarray(np.clip(255 * image + 0.5, 0, 255), dtype=np.uint8)


def _room(camera: Camera, rng: np.random.Generator) -> Any:
    """A floor of boards and a plain wall 1.8 m behind the origin, as seen from the camera."""
    width, height = camera.size
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([(u - (width - 1) / 2) / camera.focal, (v - (height - 1) / 2) / camera.focal, np.ones(u.shape)], -1)
    rays = rays.astype(np.float32) @ camera.axes().astype(np.float32)
    back = -camera.place[:2] / np.linalg.norm(camera.place[:2])
    toward = rays[..., :2] @ back.astype(np.float32)
    wall = (np.linalg.norm(camera.place[:2]) + 1.8) / np.maximum(toward, 1e-6)
    floor = np.where(rays[..., 2] < -1e-6, -camera.place[2] / np.minimum(rays[..., 2], -1e-6), np.inf)
    on_floor = floor < wall
    reach = np.minimum(floor, wall)[..., None]
    points = np.where(np.isfinite(reach), reach, 0) * rays + camera.place.astype(np.float32)
    along = points[..., 0] * -back[1] + points[..., 1] * back[0]
    return np.where(on_floor[..., None], _boards(points, rng), _plaster(along, points[..., 2], rng)).astype(np.float32)


def _boards(points: Any, rng: np.random.Generator) -> Any:
    row = np.floor(points[..., 1] / 0.14).astype(int) % 64
    shift = rng.random(64)[row]
    board = (np.floor(points[..., 0] / 1.2 + shift).astype(int) % 16) * 64 + row
    tone = 0.85 + 0.25 * rng.random(64 * 16)[board]
    grain = 0.02 * np.sin(60 * points[..., 1] * 2 * np.pi + 3 * np.sin(2.3 * points[..., 0]))
    seam = np.abs((points[..., 1] / 0.14) % 1 - 0.5) > 0.485
    return (tone + grain - 0.25 * seam)[..., None] * np.array([0.55, 0.40, 0.27])


def _plaster(along: Any, up: Any, rng: np.random.Generator) -> Any:
    tint = np.array([0.80, 0.79, 0.75]) + rng.uniform(-0.08, 0.08, 3)
    light = 0.95 + 0.08 * np.sin(0.6 * along + rng.uniform(0, 6)) * np.cos(0.5 * up)
    skirting = (up < 0.09)[..., None]
    frame = ((np.abs(along - 1.5) < 0.35) & (np.abs(up - 1.75) < 0.25))[..., None]
    wall = light[..., None] * tint
    return np.where(skirting, 0.92, np.where(frame, wall * np.array([0.5, 0.6, 0.75]), wall))


def _lay(image: Any, camera: Camera, sheet: Sheet) -> None:
    import cv2

    half_w, half_h = sheet.size[0] / 2, sheet.size[1] / 2
    up = np.array([np.cos(sheet.turn), np.sin(sheet.turn)])
    right = np.array([up[1], -up[0]])
    corners = [(-half_w, half_h), (half_w, half_h), (half_w, -half_h), (-half_w, -half_h)]
    floor = np.array([[*(np.array(sheet.centre) + a * right + b * up), 0.0] for a, b in corners])
    height, width = sheet.page.shape
    page_corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=np.float32) - 0.5
    matrix = cv2.getPerspectiveTransform(page_corners, camera.project(floor).astype(np.float32))
    page = cv2.GaussianBlur(sheet.page.astype(np.float32) / 255, (0, 0), 1.2)
    flat = {"dsize": camera.size, "flags": cv2.INTER_LINEAR}
    cover = cv2.warpPerspective(np.ones_like(page), matrix, **flat)[..., None]
    tone = cv2.warpPerspective(page, matrix, **flat)[..., None] * 0.88 + 0.04 * cover
    image[:] = image * (1 - cover) + tone


def _shade_floor(image: Any, camera: Camera, mesh: Mesh) -> None:
    """A soft dark spot under the feet."""
    import cv2

    low = mesh.vertices[mesh.vertices[:, 2] < 0.1]
    spot = camera.project(np.column_stack([low[:, :2], np.zeros(len(low))]))
    hull = cv2.convexHull(spot.astype(np.float32)).astype(np.int32)
    mask = np.zeros(image.shape[:2], dtype=np.float32)
    cv2.fillConvexPoly(mask, hull, 0.45)
    image *= 1 - cv2.GaussianBlur(mask, (0, 0), 12)[..., None]


def _paint(image: Any, camera: Camera, mesh: Mesh) -> None:
    """Triangles from the farthest to the nearest, those that face away left out; light from above and ahead."""
    import cv2

    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    centres = corners.mean(axis=1)
    facing = np.einsum("fi,fi->f", normals, camera.place - centres) > 0
    smooth = _smooth_normals(mesh, normals)
    light = camera.axes().T @ np.array([-0.45, -0.75, -0.5])
    shade = 0.52 + 0.5 * np.clip(smooth @ (light / np.linalg.norm(light)), 0, 1)
    colours = np.clip(mesh.colours * shade[:, None], 0, 1)
    depth = (centres - camera.place) @ camera.axes()[2]
    pixels = np.rint(camera.project(mesh.vertices)[mesh.faces] * 16).astype(np.int32)
    for i in np.argsort(-depth):
        if facing[i]:
            cv2.fillConvexPoly(image, pixels[i], colours[i].tolist(), cv2.LINE_8, 4)


def _smooth_normals(mesh: Mesh, normals: Array) -> Array:
    """Normals of faces after averaging over vertices, unit length."""
    at_vertices = np.zeros_like(mesh.vertices)
    for k in range(3):
        np.add.at(at_vertices, mesh.faces[:, k], normals)
    smooth = at_vertices[mesh.faces].sum(axis=1)
    return np.asarray(smooth / np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-12))
