"""What a calibration knew before, what it knows now, and which of it the data told."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from armspan.frames import Array
from armspan.pointing.priors import Priors, Refined, freedom
from armspan.records import Body

Verdict: TypeAlias = Literal[
    "determined by the data", "partly", "prior only", "as given", "not told apart from the sheet's height"
]

DETERMINED = 0.5
"""Share of the prior's standard deviation below which the data speak louder: three quarters of what is known."""

PARTLY = 0.9
"""Share of the prior's standard deviation above which the data said next to nothing."""


_SURE = 1e-6
"""A doubt [m, rad] that is rounding."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of a calibration: ``value`` and ``sd`` found, ``prior`` and ``prior_sd`` assumed, in ``unit``.

    Without a prior both are None; with a ``prior_sd`` of 0 it was held as given. The eye's height is never freed,
    and its doubt is None where the body has none.
    """

    name: str
    unit: Literal["m", "rad"]
    value: float
    sd: float | None
    prior: float | None
    prior_sd: float | None
    verdict: Verdict


def parameters(
    place: Array, covariance: Array, assumed: Body, found: Refined, priors: Priors, *, z_up: bool
) -> tuple[Parameter, ...]:
    """The place, the band's pitch and the body's measures, each with its verdict.

    ``place`` (4,) is (x, y, z, yaw) of ``sheet_from_user`` with its covariance (4, 4), ``assumed`` the body before.
    """
    sd = np.sqrt(np.diagonal(covariance))
    free = freedom(assumed, priors)
    height = None if priors.plane_height is None else priors.plane_height[0] * (-1.0 if z_up else 1.0)
    before = np.array([*assumed.shoulder_to_eye_m, assumed.shoulder_to_fingertip_m, 0.0])
    now = np.array([*found.body.shoulder_to_eye_m, found.body.shoulder_to_fingertip_m, found.pitch])
    rows = [_free("x", "m", place[0], sd[0]), _free("y", "m", place[1], sd[1])]
    if height is None:
        rows.append(_free("z", "m", place[2], sd[2]))
    else:
        rows.append(_told("z", "m", (place[2], sd[2]), (height, free.plane_sd)))
    rows.append(_free("yaw", "rad", place[3], sd[3]))
    pitch, *measures = (
        _told(name, "rad" if name == "pitch" else "m", (now[k], found.doubt[k]), (before[k], free.prior_sd[k]))
        for k, name in ((4, "pitch"), (0, "forward"), (1, "left"), (2, "up"), (3, "arm length"))
    )
    return (*rows, pitch, _eye(assumed), *measures)


def _free(name: str, unit: Literal["m", "rad"], value: float, sd: float) -> Parameter:
    return Parameter(name, unit, float(value), float(sd), None, None, "determined by the data")


def _told(name: str, unit: Literal["m", "rad"], found: tuple[float, float], prior: tuple[float, float]) -> Parameter:
    return Parameter(
        name, unit, float(found[0]), float(found[1]), float(prior[0]), float(prior[1]), _verdict(found[1], prior[1])
    )


def _verdict(sd: float, prior_sd: float) -> Verdict:
    if prior_sd < _SURE:
        return "as given"
    share = sd / prior_sd
    return "determined by the data" if share < DETERMINED else "partly" if share < PARTLY else "prior only"


def _eye(body: Body) -> Parameter:
    sd = None if body.covariance is None else float(np.sqrt(max(0.0, body.covariance[0])))
    return Parameter(
        "eye height", "m", body.eye_height_m, sd, body.eye_height_m, sd, "not told apart from the sheet's height"
    )
