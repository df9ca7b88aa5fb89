"""How much nearer to the camera than the ankles each point of a person is, who stands as a view asks.

A plane through the ankles holds the body only roughly: from 3 m away what is 0.16 m nearer looks 5 % larger. The depths
are those of a body of average build; they matter as far as a scale knows where its camera stands.
"""

from collections.abc import Mapping

import numpy as np

from armspan.body.anthropometry import Prior
from armspan.body.scale import ANKLE_BEHIND, Scale, View
from armspan.body.skeleton import Keypoint, facing
from armspan.frames import Array

HALF_SHOULDERS = 0.10
"""From the middle to a shoulder's point, share of the stature (rendered bodies)."""
EYE_ASIDE = 0.03
"""From the middle to an eye [m], before which a pointing finger is held."""
ALONG_ARM = {"sh": 0.0, "el": 0.40, "wr": 0.76, "idxknuckle": 0.88, "idxtip": 1.0, "midtip": 1.0}
"""Share of the way from shoulder to fingertip."""
_HEAD = ("nose", "leye", "reye")
_UPPER = ("neck", "lsh", "rsh", *(side + point for side in "lr" for point in ALONG_ARM))


def place(points: Mapping[str, Keypoint], scale: Scale, depths: Mapping[str, float] | None = None) -> dict[str, Array]:
    """Points (3,) [m]: right, up, and how much nearer than the ankles; those that no scale can place are left out."""
    deep = depths or {}
    placed = {}
    for name, (x, y, _) in points.items():
        depth = deep.get(name, 0.0)
        right, up = scale.nearer(depth).place(np.array([[x, y]]))[0]
        placed[name] = np.array([right, up, depth])
    return {name: point for name, point in placed.items() if np.isfinite(point).all()}


def depths_of(points: Mapping[str, Array], view: View, prior: Prior) -> dict[str, float]:
    """How much nearer than the ankles [m] the points of a person in the view's pose are.

    From the front: shoulders and arms a little before the ankles, the face before the shoulders. From the side: half
    the shoulders' breadth nearer or farther, and along the stretched arm as the finger is held before the eye; none
    where it does not show which way the person looks.
    """
    if view == "front":
        shoulders = ANKLE_BEHIND * prior.stature
        face = shoulders + float(prior.mean[1])
        return dict.fromkeys(_UPPER, shoulders) | dict.fromkeys(_HEAD, face)
    if (ahead := facing(points)) is None:
        return {}
    arm = prior.told.arm
    near = float(np.sign(ahead[0])) * (1.0 if arm == "right" else -1.0)  # who looks right shows their right side
    half = HALF_SHOULDERS * prior.stature
    pointing = {arm[0] + point: near * (half + along * (EYE_ASIDE - half)) for point, along in ALONG_ARM.items()}
    other = "l" if arm == "right" else "r"
    return {other + "sh": -near * half} | pointing
