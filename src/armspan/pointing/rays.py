"""Rays: where the arm points, from its attitude and the person's measures.

The four models are those of the report (§1.2, head to finger), of Gromov et al. (IROS 2018, §III) and their
simpler neighbours; two bands see the elbow's bend, one band takes the arm to be straight.
"""

import numpy as np

from armspan.errors import CalibrationError, known_names
from armspan.frames import Array
from armspan.pointing.laser import LaserSettings, laser_rays
from armspan.records import MODELS, Body, Model


def arm_rays(
    body: Body,
    user_from_forearm: Array,
    user_from_upperarm: Array | None,
    model: Model,
    laser: LaserSettings | None = None,
) -> tuple[Array, Array]:
    """Origins [m] and unit directions (..., 3) of the arm's rays, in ``user``.

    ``user_from_forearm`` and ``user_from_upperarm`` are (..., 3, 3) with x along the limb to the hand. The
    origin of ``user`` is the floor straight below the dominant eye. With a ``laser`` the forearm's ray is its beam.

    Raises:
        CalibrationError: if the model needs an upper arm or a length that is not there.

    """
    if model not in MODELS:
        raise CalibrationError(known_names("model", model, MODELS))
    eye = np.array([0.0, 0.0, body.eye_height_m])
    shoulder = eye - np.asarray(body.shoulder_to_eye_m)
    finger = shoulder + _shoulder_to_finger(body, user_from_forearm, user_from_upperarm, model)
    if model == "forearm" and laser is not None:
        return laser_rays(laser, body, user_from_forearm, user_from_upperarm)
    if model == "forearm":
        return _elbow(body, shoulder, user_from_forearm, user_from_upperarm), user_from_forearm[..., :, 0]
    origins = np.broadcast_to(shoulder if model == "shoulder-finger" else eye, finger.shape)
    return origins, unit(finger - origins)


def default_model(body: Body, has_upper_arm: bool) -> Model:
    """``two-band`` where the upper arm's attitude and both lengths are known, else ``head-finger``."""
    lengths = body.upper_arm_m is not None and body.elbow_to_fingertip_m is not None
    return "two-band" if has_upper_arm and lengths else "head-finger"


def unit(vectors: Array) -> Array:
    """Vectors (..., 3) scaled to length 1."""
    squares = vectors * vectors
    return np.asarray(vectors / np.sqrt(squares[..., :1] + squares[..., 1:2] + squares[..., 2:]))


def _shoulder_to_finger(body: Body, forearm: Array, upperarm: Array | None, model: Model) -> Array:
    if model != "two-band":
        return np.asarray(body.shoulder_to_fingertip_m * forearm[..., :, 0])
    if upperarm is None:
        raise CalibrationError("The two-band model needs the upper arm's attitude too: use head-finger with one band")
    upper_arm, forearm_length = _limbs(body)
    return np.asarray(upper_arm * upperarm[..., :, 0] + forearm_length * forearm[..., :, 0])


def _limbs(body: Body) -> tuple[float, float]:
    if body.upper_arm_m is None or body.elbow_to_fingertip_m is None:
        raise CalibrationError(
            "The two-band model needs both lengths of the arm, upper_arm_m and elbow_to_fingertip_m: "
            "measure them into the body file, or use the head-finger model"
        )
    return body.upper_arm_m, body.elbow_to_fingertip_m


def _elbow(body: Body, shoulder: Array, forearm: Array, upperarm: Array | None) -> Array:
    """The forearm's ray may start anywhere on its line: at the elbow if it is known, else at the shoulder."""
    if upperarm is None or body.upper_arm_m is None:
        return np.broadcast_to(shoulder, forearm.shape[:-1])
    return np.asarray(shoulder + body.upper_arm_m * upperarm[..., :, 0])
