"""The account of a session: what was pointed at, what was chosen, what was safe."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from armspan.records import Body, Calibrated, Record, Sheet, Zone
from armspan.study.safety import BODY, SafetyWatch
from armspan.study.trials import TrialReader, TrialResult, summary
from armspan.swarm.limits import Limits

_MARGIN = 0.0015
"""How much a room's ``body_radius_m`` is wider than a robot [m]: a small robot's own radius follows from it."""


@dataclass(frozen=True, slots=True, eq=False)
class Account:
    """Everything a session showed, ready to be printed or written as JSON."""

    calibration: Calibrated | None
    trials: list[TrialResult]
    unasked: int
    safety: SafetyWatch
    seconds: float

    def document(self) -> dict[str, object]:
        """The account as JSON-able values, in millimetres and degrees."""
        without = [trial for trial in self.trials if not trial.feedback]
        with_cursor = [trial for trial in self.trials if trial.feedback]
        gap = self.safety.least_gap
        return {
            "seconds": round(self.seconds, 3),
            "calibration": self._calibration(),
            "pointing": {
                "without_feedback": dict(summary(without)),
                "with_feedback": dict(summary(with_cursor)),
            },
            "selection": {
                "shown": len(self.trials),
                "decided": sum(trial.decided for trial in self.trials),
                "right": sum(trial.right for trial in self.trials),
                "unasked": self.unasked,
            },
            "safety": {
                "violations": sum(self.safety.violations.values()),
                "kinds": self.safety.violations,
                "least_gap_mm": round(1000 * gap, 2) if np.isfinite(gap) else None,
            },
        }

    def _calibration(self) -> dict[str, object]:
        found = self.calibration
        if found is None:
            return {"found": False, "rms_deg": None, "pairs": 0, "sheet_rms_mm": None}
        return {
            "found": True,
            "rms_deg": round(float(np.degrees(found.rms)), 4),
            "sigma_deg": round(float(np.degrees(found.sigma)), 4),
            "pairs": found.pairs,
            "xyz_m": found.xyz,
            "yaw_deg": round(float(np.degrees(found.yaw)), 4),
        }


def account(
    records: Iterable[Record],
    body: Body,
    sheet: Sheet,
    zones: Sequence[Zone],
    limits: Limits,
    light_height: float,
) -> Account:
    """Read a whole session, in the order of its log."""
    trials = TrialReader(zones, body.eye_height_m, light_height)
    safety = SafetyWatch(limits, sheet, body=min(BODY, limits.body_radius_m - _MARGIN))
    calibration: Calibrated | None = None
    last = 0.0
    for record in records:
        trials.take(record)
        safety.take(record)
        if isinstance(record, Calibrated) and calibration is None:
            calibration = record
        last = max(last, record.t)
    return Account(calibration, trials.results, trials.unasked, safety, last)
