"""Nelder-Mead on the mean unsigned angle: the report's way (§1.3), kept as a documented baseline.

The parameters are (x, y, z, yaw) of ``sheet_from_user`` with the sheet's z into the table. scipy's default
simplex moves a coordinate by 5 % and a zero by 0.00025: harmless numbers in other units, but in millimetres a
start at (0, 0, 800, 0) spans a quarter of a micrometre in x and y, which is why the report's own solver
mostly stops where it began.
"""

import numpy as np
from scipy.optimize import minimize

from armspan.frames import Array
from armspan.pointing.least_squares import Problem, angles

_SIMPLEX_STEPS = np.diag([0.5, 0.5, 0.3, 0.8])  # [m, m, m, rad]
_START = np.array([0.0, 0.0, 0.8, 0.0])


def nelder_mead(problem: Problem, centre: Array) -> Array:
    """The place (4,) of least mean angle, searched in metres from a simplex set by hand.

    ``centre`` (3,) [m] is the points' centroid in ``sheet`` (z into the table); the place is written as
    `Problem`'s parameters.
    """
    simplex = np.vstack([_START, _START + _SIMPLEX_STEPS])
    options = {"initial_simplex": simplex, "xatol": 1e-8, "fatol": 1e-8, "maxiter": 10000, "maxfev": 40000}
    found = minimize(lambda pose: _mean_angle(problem, centre, pose), _START, method="Nelder-Mead", options=options)
    return _place(centre, np.asarray(found.x))


def nelder_mead_report(problem: Problem, centre: Array) -> Array:
    """The same as the report does it: millimetres, start (0, 0, 800, 0), scipy's defaults, tol 1e-8."""
    units = np.array([1000.0, 1000.0, 1000.0, 1.0])
    found = minimize(
        lambda pose: _mean_angle(problem, centre, pose / units),
        _START * units,
        method="Nelder-Mead",
        tol=1e-8,
        options={"maxiter": 10000},
    )
    return _place(centre, np.asarray(found.x) / units)


def _mean_angle(problem: Problem, centre: Array, pose: Array) -> float:
    return float(angles(problem, _place(centre, pose)[None])[0].mean())


def _place(centre: Array, pose: Array) -> Array:
    """(x, y, z, yaw) of ``sheet_from_user`` as the points' centroid in ``user`` and the yaw."""
    (x, y, z), yaw = centre - pose[:3], pose[3]
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return np.array([cosine * x - sine * y, -sine * x - cosine * y, -z, yaw])
