"""Whether a robot may be driven at all."""

from armspan.records import RobotState, Sheet
from armspan.swarm.limits import Limits

STALE = 0.5
"""Age [s] of a robot's last state beyond which it is not driven: a lead is measured from where it is."""

_OFF = 0.005


def unfit(t: float, state: RobotState, sheet: Sheet, limits: Limits) -> str | None:
    """Why a robot must not be driven at ``t`` [s], in words; None where it may."""
    if state.held:
        return "lifted or off the sheet"
    if state.t - t > STALE:
        return f"{state.robot} tells of a time to come: its clock is ahead"
    if t - state.t > STALE:
        return f"nothing heard of {state.robot} for {STALE} s"
    x, y = state.xy
    if not (-_OFF <= x <= sheet.width_m + _OFF and -_OFF <= y <= sheet.height_m + _OFF):
        return "off the sheet"
    if state.battery is not None and state.battery < limits.battery:
        return f"battery at {100 * state.battery:.0f} %"
    return None
