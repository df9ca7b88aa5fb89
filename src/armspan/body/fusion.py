"""What was expected of a person and what was seen of them, as one body."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from armspan.body.anthropometry import Prior
from armspan.body.observation import MEASURES, Observation
from armspan.errors import DataError, known_names
from armspan.frames import Array
from armspan.records import Body

REJECTED_BEYOND = 3.0
"""Standard deviations (of prior and observation together) beyond which an observation is taken for a mistake."""


@dataclass(frozen=True, slots=True)
class Rejected:
    """An observation that lies ``z`` standard deviations off what was expected; positive where it is greater."""

    observation: Observation
    z: float


@dataclass(frozen=True, slots=True)
class Fused:
    """The body, the observations that went into it, and those that were mistakes."""

    body: Body
    taken: tuple[Observation, ...]
    rejected: tuple[Rejected, ...]


def fuse(prior: Prior, observations: Sequence[Observation]) -> Fused:
    """The body after all ``observations``, whose order does not matter and whose errors share nothing.

    Every observation is judged against the prior alone; then precisions and weighted values add (the
    linear-Gaussian update in information form). The limbs grow with the arm.

    Raises:
        DataError: for an observation of an unknown measure, of no finite value or of no positive ``sd``.

    """
    taken, rejected = [], []
    for observation in observations:
        z = _z(prior, observation)
        if abs(z) > REJECTED_BEYOND:
            rejected.append(Rejected(observation, z))
        else:
            taken.append(observation)
    mean, covariance = _update(prior, taken)
    return Fused(_body(prior, mean, covariance), tuple(taken), tuple(rejected))


def _z(prior: Prior, observation: Observation) -> float:
    place = _place(observation)
    variance = float(prior.covariance[place, place]) + observation.sd**2
    return (observation.value - float(prior.mean[place])) / math.sqrt(variance)


def _place(observation: Observation) -> int:
    if observation.measure not in MEASURES:
        raise DataError(f"{observation.source}: {known_names('measure', observation.measure, MEASURES)}")
    if not (math.isfinite(observation.value) and math.isfinite(observation.sd) and observation.sd > 0.0):
        raise DataError(
            f"{observation.source}: {observation.measure} = {observation.value:g} m with standard deviation "
            f"{observation.sd:g} m, but a finite value and a positive one were expected: leave this one out"
        )
    return MEASURES.index(observation.measure)


def _update(prior: Prior, taken: Sequence[Observation]) -> tuple[Array, Array]:
    """Mean (5,) [m] and covariance (5, 5) [m²] after the observations."""
    if not taken:
        return prior.mean, prior.covariance
    precision, pull = np.linalg.inv(prior.covariance), np.zeros(len(MEASURES))
    for observation in taken:
        place = MEASURES.index(observation.measure)
        precision[place, place] += 1.0 / observation.sd**2
        pull[place] += (observation.value - float(prior.mean[place])) / observation.sd**2
    covariance = np.linalg.inv(precision)
    covariance = (covariance + covariance.T) / 2.0
    return prior.mean + covariance @ pull, covariance


def _body(prior: Prior, mean: Array, covariance: Array) -> Body:
    eye_height, forward, left, up, arm_length = mean.tolist()
    growth = arm_length / float(prior.mean[4])
    return Body(
        eye_height_m=eye_height,
        shoulder_to_eye_m=(forward, left, up),
        shoulder_to_fingertip_m=arm_length,
        arm=prior.told.arm,
        upper_arm_m=prior.upper_arm * growth,
        elbow_to_fingertip_m=prior.elbow_to_fingertip * growth,
        covariance=tuple(covariance.ravel().tolist()),
    )
