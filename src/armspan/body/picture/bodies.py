"""All bodies in a picture: the detector sees the foremost, so what is found is painted over and it looks again."""

import numpy as np
from numpy.typing import NDArray

from armspan.body.picture.detector import PARTS, detect
from armspan.body.picture.landmarks import Points, body_points
from armspan.body.picture.networks import Networks
from armspan.body.picture.regions import Pixels

MOST = 6
"""People looked for: a picture to measure in shows one."""
SAME = 0.5
"""A body with so many of its points on bodies known already is one of them, or a likeness in what is left of it."""
TRUNK = (11, 12, 23, 24)
LIMBS = (
    *((19, 15, 13, 11, 23, 25, 27, 31), (20, 16, 14, 12, 24, 26, 28, 32)),
    *((12, 11, 24, 23, 12), (7, 0, 8), (11, 7, 8, 12)),
)
"""The landmarks' numbers along both sides, across the trunk, the face and the neck."""
STROKE = 0.5
"""How wide a limb is painted over, over the trunk's diagonal."""


def find_bodies(image: Pixels, networks: Networks) -> list[Points]:
    """The bodies in a picture, the foremost first."""
    known: list[Points] = []
    taken = np.zeros(image.shape[:2], np.uint8)
    left = image
    while len(known) < MOST:
        before = len(known)
        parts = PARTS[:1] if known else PARTS  # whoever is found only from nearby is no second person
        for region in detect(left, networks.detector, parts):
            body = body_points(image, region, networks.body)
            if body and share(body, taken) < SAME:
                known.append(body)
                taken |= silhouette(body, taken.shape)
        if len(known) == before:
            break
        left = np.where(taken[..., None] > 0, image.mean(axis=(0, 1)).astype(np.uint8), image)
    return known


def share(body: Points, taken: NDArray[np.uint8]) -> float:
    """How many of the points lie where the mask (height, width) is set."""
    height, width = taken.shape
    right, down = body.places.astype(int).T
    inside = (right >= 0) & (right < width) & (down >= 0) & (down < height)
    return float(np.count_nonzero(taken[down[inside], right[inside]]) / len(body.places))


def silhouette(body: Points, shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """Roughly where a body is: a mask of ``shape`` with a thick stroke along every limb."""
    import cv2

    mask = np.zeros(shape, np.uint8)
    diagonal = float(np.linalg.norm(np.ptp(body.places[list(TRUNK)], axis=0)))
    for limb in LIMBS:
        line = np.rint(body.places[list(limb)]).astype(np.int32)
        cv2.polylines(mask, [line], False, 1, max(1, round(STROKE * diagonal)))
    return mask
