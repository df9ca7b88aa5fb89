"""What the set-up wizard says: plain words for devices, measures, stops and verdicts; no page here."""

import math
from collections.abc import Mapping, Sequence
from typing import get_args

import numpy as np

from armspan.body.told import Eye, Sex, Told
from armspan.conductor import Settings
from armspan.conductor.sight import Sight, StopSeen
from armspan.errors import ConfigError
from armspan.records import Arm, Body
from armspan.web.host import Device

UNKNOWN = "not known"
GOAL = 120.0
"""Seconds from strapping on to steering that are aimed at."""

FIELDS: dict[str, tuple[str, str]] = {
    "height_m": ("Height", "without shoes, against a wall, such as 1.75"),
    "span_m": ("Arm span", "fingertip to fingertip, both arms stretched out to the sides"),
    "shoulder_height_m": ("Shoulder height", "from the floor to the bony top of the shoulder, standing"),
    "forearm_hand_m": ("Forearm and hand", "from the back of the bent elbow to the tip of the middle finger"),
    "sole_m": ("Thickness of the soles", "of the shoes worn while pointing, such as 0.03; empty: barefoot"),
    "seat_height_m": ("Height of the seat", "only for who points while sitting: from the floor to the seat"),
}
"""The sizes [m] that can be typed: the names of `Told`, what they are called, and how they are taken."""

MEASURES = (
    "Floor to the eye",
    "Shoulder to eye, forward",
    "Shoulder to eye, to the left",
    "Shoulder to eye, up",
    "Shoulder to fingertip",
)
"""The five measures in the order of `Body.covariance`."""

ASKED = {
    "idle": "Nothing is asked now",
    "rest": "Resting the arm, so that the bands find their own offsets",
    "stretch": "Arm stretched forward: this finds the heading",
    "hang": "Arm hanging: this finds how the bands sit",
    "drive": "The robot drives to its stop",
    "point": "Point at the robot's light",
}
"""The steps of the set-up by `Sight.step`."""


class FieldError(ConfigError):
    """What was typed in one field cannot be; ``field`` names it as in `FIELDS`."""

    def __init__(self, field: str, text: str) -> None:
        super().__init__(text)
        self.field = field


# --- devices -----------------------------------------------------------------------------------------------


def device_row(device: Device) -> dict[str, str]:
    """A device's line in the table."""
    rate = f"{device.rate_hz:.0f} a second" if device.rate_hz is not None else UNKNOWN
    return {
        "name": device.name,
        "kind": "Band" if device.kind == "band" else "Robot",
        "where": device.where,
        "link": "Connected" if device.up else "Not connected",
        "battery": _share(device.battery),
        "rate": rate,
        "lost": lost_words(device.lost),
        "note": device.note,
    }


def _share(share: float | None) -> str:
    if share is None:
        return UNKNOWN
    return f"{100 * share:.0f} %" + (": charge it" if share < 0.15 else "")


def lost_words(share: float | None) -> str:
    """A share of lost samples."""
    if share is None:
        return UNKNOWN
    if share == 0.0:
        return "none"
    percent = "under 0.1 %" if share < 0.001 else f"{100 * share:.1f} %"
    return percent + (": bring it nearer" if share > 0.05 else "")


def devices_verdict(devices: Sequence[Device]) -> str:
    """Whether all are there."""
    away = [device.name for device in devices if not device.up]
    if not devices:
        return "The room names no devices"
    if away:
        return f"Waiting for {', '.join(away)}"
    return f"All {len(devices)} devices are connected"


# --- measures ----------------------------------------------------------------------------------------------


def told_of(typed: Mapping[str, str]) -> Told:
    """What was typed, as sizes in metres; empty fields are not told.

    Raises:
        FieldError: what cannot be, with its field, in the words of the page.

    """
    sizes = {field: _metres(field, typed.get(field, "")) for field in FIELDS}
    sex: Sex | None = next((word for word in get_args(Sex) if word == typed.get("sex")), None)
    eye: Eye = next((word for word in get_args(Eye) if word == typed.get("eye")), "right")
    arm: Arm = "left" if typed.get("arm") == "left" else "right"
    try:
        return Told(
            height_m=sizes["height_m"],
            sex=sex,
            span_m=sizes["span_m"],
            shoulder_height_m=sizes["shoulder_height_m"],
            forearm_hand_m=sizes["forearm_hand_m"],
            sole_m=sizes["sole_m"] or 0.0,
            seat_height_m=sizes["seat_height_m"],
            arm=arm,
            eye=eye,
            self_reported=typed.get("self_reported") == "yes",
        )
    except ConfigError as error:
        raise _in_words(str(error)) from None


def _metres(field: str, text: str) -> float | None:
    cleaned = text.strip().removesuffix("m").strip().replace(",", ".")
    if not cleaned:
        return None
    try:
        value = float(cleaned)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FieldError(field, f"{text.strip()!r} is not a number: write metres, such as 1.75")
    return value


def _in_words(text: str) -> FieldError:
    """A complaint about a size, with the names that the page uses."""
    found = text.partition(" = ")[0]
    for name, (label, _) in FIELDS.items():
        text = text.replace(f"{name} = ", f"{label} = ")
    return FieldError(found if found in FIELDS else "height_m", text)


def arms_with_band(settings: Settings) -> tuple[Arm, ...]:
    """The arms that can point: those with a band on the forearm, any where a band's arm is not told."""
    worn = [band.arm for band in settings.bands if band.segment == "forearm"]
    return tuple(arm for arm in get_args(Arm) if any(on in (None, arm) for on in worn))


def whole_number(text: str) -> int | None:
    """Which person of several.

    Raises:
        FieldError: for what is no whole number from 1.

    """
    text = text.strip()
    if not text:
        return None
    if not text.isdecimal() or int(text) < 1:
        raise FieldError("person", f"{text!r} is none: count the people from 1 on the left")
    return int(text)


def body_rows(body: Body) -> list[dict[str, str]]:
    """The five measures with one standard deviation."""
    values = (body.eye_height_m, *body.shoulder_to_eye_m, body.shoulder_to_fingertip_m)
    sds = [None] * 5 if body.covariance is None else np.sqrt(np.reshape(body.covariance, (5, 5)).diagonal()).tolist()
    return [
        {"measure": words, "value": f"{1000 * value:.0f} mm", "sd": UNKNOWN if sd is None else f"± {1000 * sd:.0f} mm"}
        for words, value, sd in zip(MEASURES, values, sds, strict=True)
    ]


# --- calibration -------------------------------------------------------------------------------------------


def is_ready(sight: Sight) -> bool:
    """Whether the person can steer: the place is known and nothing is being asked."""
    return sight.step == "idle" and sight.place is not None


def progress_words(sight: Sight) -> str:
    """What the set-up is at."""
    if sight.stopped:
        return "All robots are stopped, and the set-up needs one that drives: let them move again"
    if is_ready(sight):
        return "The set-up is done"
    asked = ASKED.get(sight.step, sight.step)
    return f"Stop {sight.stop} of {sight.stops}: {asked}" if sight.step in ("drive", "point") else asked


def progress_share(sight: Sight) -> float:
    """How much of the set-up is done, of 1: the poses count as one stop each."""
    steps = ("rest", "stretch", "hang")
    if is_ready(sight):
        return 1.0
    if sight.step in steps:
        return steps.index(sight.step) / (len(steps) + sight.stops)
    if sight.step not in ("drive", "point"):
        return 0.0
    return (len(steps) + sight.stop - 1 + 0.5 * (sight.step == "point")) / (len(steps) + sight.stops)


def stop_words(sight: Sight, number: int) -> str:
    """What is known of a stop, from 1: how far its ray passed by, in degrees and words."""
    seen = {stop.number: stop for stop in sight.seen}
    if sight.step in ("drive", "point") and number == sight.stop:
        return "now"
    if number in seen:
        return seen_words(seen[number])
    if sight.step in ("drive", "point") and number < sight.stop:
        return "taken"
    return "to come"


def seen_words(stop: StopSeen) -> str:
    """How well a stop fits the others."""
    degrees = math.degrees(stop.residual)
    if not stop.used:
        return f"{degrees:.1f} degrees off: fits none of the others and was left out"
    word = "fits well" if degrees < 2.0 else "fits fairly" if degrees < 4.0 else "fits badly"
    return f"{degrees:.1f} degrees off: {word}"


def verdict(sight: Sight) -> str:
    """The quality in plain words and what to do; nothing before the set-up is done."""
    if not is_ready(sight) or not sight.seen:
        return ""
    worst = max(sight.seen, key=lambda stop: (not stop.used, stop.residual)).number
    match sight.quality:
        case "good":
            return "Good: what you point at will be found. You can steer now."
        case "fair":
            return (
                "Fair: you can steer, but keep robots and places a hand's width apart. To make it better, take "
                f"stop {worst} again: it fits worst."
            )
    return (
        f"Poor: what you point at will often be missed. Take stop {worst} again with a straight arm; if that does not "
        "help, see that the bands sit tight and the measures are yours, and begin again."
    )


def clock_words(seconds: float, *, ready: bool) -> str:
    """The time since the set-up began."""
    minutes, rest = divmod(int(seconds), 60)
    spent = f"{minutes} min {rest:02d} s"
    if not ready:
        return f"{spent} since you began (the aim: steering in under 2 minutes)"
    return f"Ready after {spent}: " + ("under 2 minutes, as aimed at" if seconds < GOAL else "the aim is 2 minutes")
