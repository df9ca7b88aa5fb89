"""People in a picture as skeletons: detector, body, hands."""

from collections.abc import Mapping
from pathlib import Path

from armspan.body.picture.bodies import find_bodies
from armspan.body.picture.hands import TIPS, hand_points
from armspan.body.picture.landmarks import Points
from armspan.body.picture.networks import Network, open_networks
from armspan.body.picture.regions import Pixels
from armspan.body.skeleton import Keypoint, Skeleton

BODY: Mapping[str, int] = {
    "nose": 0, "leye": 2, "reye": 5, "lear": 7, "rear": 8,
    "lsh": 11, "rsh": 12, "lel": 13, "rel": 14, "lwr": 15, "rwr": 16, "lidxknuckle": 19, "ridxknuckle": 20,
    "lhip": 23, "rhip": 24, "lkn": 25, "rkn": 26, "lan": 27, "ran": 28,
    "lheel": 29, "rheel": 30, "ltoe": 31, "rtoe": 32,
}  # fmt: skip
"""The network's numbers of a skeleton's points; left and right are the person's own."""
PINKY: Mapping[str, int] = {"l": 17, "r": 18}


def find_people(image: Pixels, weights: Path) -> list[Skeleton]:
    """The people in a picture, the foremost first; none where nobody is seen.

    ``image`` is (height, width, 3), red green blue; ``weights`` is the folder that ``armspan body --set-up`` fills.
    Points outside of the picture are guesses of the network; they stay, and a skeleton tells that they are outside.

    Raises:
        DeviceError: the networks are not in ``weights``.
        MissingExtra: OpenCV or LiteRT is not installed.

    """
    networks = open_networks(weights)
    height, width = image.shape[:2]
    return [
        Skeleton(named(body) | fingertips(image, body, networks.hand), (width, height), "BlazePose", body.score)
        for body in find_bodies(image, networks)
    ]


def named(body: Points) -> dict[str, Keypoint]:
    """A body's points by name."""
    return {name: keypoint(body, index, 1.0) for name, index in BODY.items()}


def fingertips(image: Pixels, body: Points, network: Network) -> dict[str, Keypoint]:
    """The fingertips, by name, of the hands that are seen well; none is surer than the wrist it hangs on."""
    found: dict[str, Keypoint] = {}
    for side, pinky in PINKY.items():
        elbow, wrist, index = (body.places[BODY[side + joint]] for joint in ("el", "wr", "idxknuckle"))
        hand = hand_points(image, elbow, wrist, (index + body.places[pinky]) / 2, network)
        if hand is not None:
            certain = float(body.confidences[BODY[side + "wr"]])
            found |= {side + name: keypoint(hand, number, certain) for name, number in TIPS.items()}
    return found


def keypoint(points: Points, index: int, most: float) -> Keypoint:
    """One of the points as a skeleton's, its confidence at most ``most``."""
    right, down = points.places[index]
    return float(right), float(down), min(float(points.confidences[index]), most)
