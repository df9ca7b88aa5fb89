"""What a person is told before a take."""

from collections.abc import Mapping

from armspan.conductor.recorder_plan import Ask
from armspan.gesture.takes import INITIAL, NULL

HOW: Mapping[str, str] = {
    INITIAL: "stand with your arms hanging",
    "x_left_high": "one big X with both arms, the left one high, the right one low",
    "x_right_high": "one big X with both arms, the right one high, the left one low",
    "raise_both": "both arms straight up",
    "mixing": "stir with both hands before the belly",
    "stop": "forearms crossed before the chest",
    "arms_to_ground": "circle with both hands, arms down to the ground",
    "breaststroke": "swim with both arms",
}
"""The gestures of the 2019 report, and how they go."""


def announced(ask: Ask, label_is_new: bool) -> str:
    """What comes next; how it goes where the label was not asked for before."""
    if ask.label == NULL:
        return f"Everyday motion, {ask.seconds:.0f} s, {ask.place} of {ask.of}: do what you like, but no gesture"
    how = f" ({HOW[ask.label]})" if label_is_new and ask.label in HOW else ""
    count = "for practice" if ask.practice else f"{ask.place} of {ask.of}"
    again = ", once more" if ask.tries else ""
    return f"Next: {ask.label}{how}, {count}{again}"


def now(ask: Ask) -> tuple[str, str]:
    """Words and cue with which a take begins."""
    if ask.label == NULL:
        return "Go about it now", f"everyday:{ask.seconds:g}"
    return f"Now: {ask.label}", f"gesture:{ask.label}"
