"""What the game master reads, from the frame that every browser draws: also while a log is shown again."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from armspan.web.activities import Agenda, in_words
from armspan.web.shown import HELD, LOST, UNHEARD

LOW = 0.2
"""Share of a battery below which it is low."""


@dataclass(frozen=True, slots=True)
class Sign:
    """A state in words, with the icon that says the same; ``bad`` asks for somebody's care."""

    words: str
    icon: str
    bad: bool = False


@dataclass(frozen=True, slots=True)
class RobotRow:
    """One robot as the table tells it; ``waits`` says why it stands until something new is asked, or nothing."""

    robot: str
    doing: Sign
    battery: Sign
    held: Sign
    link: Sign
    waits: str


def robot_rows(room: Mapping[str, Any] | None, frame: Mapping[str, Any]) -> list[RobotRow]:
    """Every robot of the room message, with what the frame message says of it."""
    if room is None or "robots" not in frame:
        return []
    return [_row(name, told, frame) for name, told in zip(room["robots"], frame["robots"], strict=False)]


def _row(name: str, told: list[float], frame: Mapping[str, Any]) -> RobotRow:
    state, battery = int(told[3]), told[4]
    unheard = bool(state & UNHEARD)
    waits = frame.get("waiting", {}).get(name, "")
    return RobotRow(
        name,
        _doing(name, waits, frame),
        battery_sign(None if battery < 0 else battery),
        Sign("not known", "help_outline")
        if unheard
        else Sign("lifted", "pan_tool", True)
        if state & HELD
        else Sign("on the sheet", "check"),
        Sign("out of reach", "link_off", True)
        if state & LOST
        else Sign("not heard yet", "help_outline", True)
        if unheard
        else Sign("connected", "link"),
        waits,
    )


def _doing(name: str, waits: str, frame: Mapping[str, Any]) -> Sign:
    if frame.get("stopped"):
        return Sign("stopped", "dangerous", True)
    if waits:
        return Sign("waits", "pause_circle")
    for order, robots in frame.get("running", ()):
        if name in robots:
            return Sign(in_words(order).lower(), "play_circle")
    return Sign("nothing", "remove")


def battery_sign(share: float | None) -> Sign:
    """A battery in words."""
    if share is None:
        return Sign("not known", "battery_unknown")
    words = f"{100 * share:.0f} %"
    if share < LOW:
        return Sign(f"low, {words}", "battery_alert", True)
    return Sign(words, "battery_full" if share > 0.8 else "battery_3_bar")


def turn_words(agenda: Agenda, frame: Mapping[str, Any], open_room: bool) -> str:
    """Whose turn it is, and how that stands."""
    if not open_room:
        return "No room is open."
    if not agenda.acts:
        return "The list has no activity: add one."
    act = agenda.acts[agenda.place]
    name = f"{agenda.place + 1}. {act.name}"
    if frame.get("stopped"):
        return f"{name}: all robots are stopped. Press Resume all, then Start."
    match agenda.state:
        case "ready":
            return f"{name}: is next. Press Start."
        case "paused":
            return f"{name}: paused. Start begins it again."
        case "begun":
            on = any(order == act.order for order, _ in frame.get("running", ()))
            return f"{name}: goes on." if on else f"{name}: goes on no more. Press Next, or Start for once more."


def done_words(frame: Mapping[str, Any]) -> str:
    """What the robots do now, whoever asked for it."""
    parts = [f"{in_words(order)} ({', '.join(robots)})" for order, robots in frame.get("running", ())]
    return "Now: " + ("; ".join(parts) if parts else "the robots do nothing")
