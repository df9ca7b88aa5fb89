"""The person's measures as ``armspan body`` answers them: a table for people, a document for programs."""

from typing import Any

import numpy as np
from rich.markup import escape
from rich.table import Table

from armspan.body.measured import Measured
from armspan.body.observation import MEASURES, Observation
from armspan.frames import Array
from armspan.records import Body


def _values(body: Body) -> Array:
    return np.array([body.eye_height_m, *body.shoulder_to_eye_m, body.shoulder_to_fingertip_m])


def _sds(body: Body) -> Array:
    return np.asarray(np.sqrt(np.diagonal(np.reshape(body.covariance or (0.0,) * 25, (5, 5)))))


def document(found: Measured) -> dict[str, Any]:
    """The measures with their covariance, what they were before any view, and what the views said."""
    body, known = found.fused.body, found.prior
    return {
        "body": {
            "eye_height_m": body.eye_height_m,
            "shoulder_to_eye_m": body.shoulder_to_eye_m,
            "shoulder_to_fingertip_m": body.shoulder_to_fingertip_m,
            "upper_arm_m": body.upper_arm_m,
            "elbow_to_fingertip_m": body.elbow_to_fingertip_m,
            "arm": body.arm,
            "covariance_m2": body.covariance,
        },
        "sd_m": dict(zip(MEASURES, _sds(body).tolist(), strict=True)),
        "prior": {
            "mean_m": dict(zip(MEASURES, known.mean.tolist(), strict=True)),
            "sd_m": dict(zip(MEASURES, np.sqrt(np.diagonal(known.covariance)).tolist(), strict=True)),
        },
        "taken": [_row(observation) for observation in found.fused.taken],
        "rejected": [_row(odd.observation) | {"z": odd.z} for odd in found.fused.rejected],
        "notes": found.notes,
    }


def _row(observation: Observation) -> dict[str, Any]:
    return {
        "measure": observation.measure,
        "value_m": observation.value,
        "sd_m": observation.sd,
        "source": observation.source,
    }


_MEANT = {
    "eye height": "floor to dominant eye",
    "forward": "shoulder to eye, forward",
    "left": "shoulder to eye, to the left",
    "up": "shoulder to eye, up",
    "arm length": "shoulder to fingertip",
}


def table(found: Measured) -> Table:
    """The five measures, and beside them what each view said."""
    known, body, taken = found.prior, found.fused.body, found.fused.taken
    sources = list(dict.fromkeys(told.source for told in taken))
    rows = Table("measure", r"\[m]", r"± 1 sd \[mm]", title=f"{body.arm} arm")
    for source in ["expected", *(source.split(",")[0] for source in sources)] if sources else []:
        rows.add_column(escape(source))
    sds = _sds(body)
    for row, (measure, value) in enumerate(zip(MEASURES, _values(body), strict=True)):
        cells = [_MEANT[measure], f"{value:.3f}", f"{1000.0 * sds[row]:.0f}"]
        if sources:
            cells.append(f"{known.mean[row]:.3f} ± {1000.0 * np.sqrt(known.covariance[row, row]):.0f}")
        for source in sources:
            told = [o for o in taken if o.source == source and o.measure == measure]
            cells.append(", ".join(f"{o.value:.3f} ± {1000.0 * o.sd:.0f}" for o in told))
        rows.add_row(*cells)
    return rows
