"""The tips of index and middle finger: the hand landmark network on a square about the hand of a found body.

Zhang et al. 2020, "MediaPipe Hands". The body's own points say where the hand is; its points of the hand are knuckles,
not tips.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from armspan.body.picture.landmarks import Points, middle
from armspan.body.picture.networks import Network
from armspan.body.picture.regions import Pixels, Region, crop, upright
from armspan.frames import Array

SIDE = 224
"""The network's picture, in pixels."""
POINTS = 21
TIPS: Mapping[str, int] = {"idxtip": 8, "midtip": 12}
LIKELY = 0.6
"""Below, what is in the square is no hand to measure with."""
NEAR = 0.3
"""The hand's wrist lies within so many forearms of the body's."""
DOUBTED = 0.14
"""A point on which the looks differ by so much of the square on average has no confidence left."""

_WRIST, _MIDDLE_KNUCKLE = 0, 9
_FOREARM = 1.25
"""The first square over the forearm, elbow to wrist, of which a hand is 0.75."""
_FORESHORTENED = 1.0
"""The next square is no smaller, over the forearm, however short a hand that points at the camera looks."""
_LEAST = 3.0
"""The first square over the distance from wrist to knuckles, where the forearm points at the camera."""
_MORE = 2.4
"""The next square over the distance from wrist to middle knuckle, half a hand: all fingers and some room."""
_FINGERS = 0.95
"""Where the squares' middles lie, from the wrist to the knuckles and beyond."""
_OTHERS: tuple[dict[str, float], ...] = ({}, {"turned": 0.15}, {"turned": -0.15})


def hand_points(image: Pixels, elbow: Array, wrist: Array, knuckles: Array, network: Network) -> Points | None:
    """A hand's 21 points, None where no hand is seen well or what is seen is not on this arm.

    ``elbow``, ``wrist`` and ``knuckles`` (2,), the middle of the knuckles, are the body's own points [px].
    """
    forearm = float(np.linalg.norm(wrist - elbow))
    seen = look(image, about(wrist, knuckles, forearm), network)
    better = follow(seen.places, forearm)
    squares = [replace(better.moved(**other), mirrored=way) for other in _OTHERS for way in (False, True)]
    looks = [look(image, square, network) for square in squares]
    found = middle(looks, POINTS)
    if found.score < LIKELY:
        return None
    found = replace(found, confidences=found.score * agreement(looks, DOUBTED * better.size))
    return found if np.linalg.norm(found.places[_WRIST] - wrist) <= NEAR * max(forearm, better.size / _MORE) else None


def agreement(looks: list[Points], none: float) -> Array:
    """How far the looks agree on each point: 1 where they do, 0 where they are ``none`` [px] from the median or more.

    A stretched finger beside curled ones is at times seen as curled, too.
    """
    places = np.array([each.places for each in looks])
    away = np.linalg.norm(places - np.median(places, axis=0), axis=-1).mean(axis=0)
    return np.asarray(np.maximum(0, 1 - away / max(none, 1e-9)))


def about(wrist: Array, knuckles: Array, forearm: float) -> Region:
    """The first square about a hand, fingers up."""
    palm = upright(wrist, knuckles, _LEAST, _FINGERS)
    return Region(palm.centre, max(palm.size, _FOREARM * forearm), palm.angle)


def follow(places: Array, forearm: float) -> Region:
    """The next square, about the hand's points (21, 2) of the last."""
    palm = upright(places[_WRIST], places[_MIDDLE_KNUCKLE], _MORE, _FINGERS)
    return Region(palm.centre, max(palm.size, _FORESHORTENED * forearm), palm.angle)


def look(image: Pixels, region: Region, network: Network) -> Points:
    """The network's points as seen in one square; each is as sure as the whole hand is."""
    landmarks, score, *_ = network(crop(image, region, SIDE))
    certain = float(score.squeeze())
    places = region.to_picture(landmarks.reshape(POINTS, 3)[:, :2] / SIDE)
    return Points(places, np.full(POINTS, certain), certain)
