"""What a person types of their own body, checked for units and for sizes that do not fit together."""

import math
from typing import Literal, NamedTuple, TypeAlias

import msgspec

from armspan.errors import ConfigError
from armspan.records import Arm

Sex: TypeAlias = Literal["man", "woman"]
Eye: TypeAlias = Literal["right", "left", "both"]


class Told(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Typed sizes [m], taken barefoot with a tape: the height, and what else is known.

    Without ``height_m`` an adult of any height is meant, whom a picture must tell more of.

    ``span_m`` runs from fingertip to fingertip of arms held out level, ``shoulder_height_m`` from the floor to
    the bony top of the shoulder (acromion) of the *standing* person, ``forearm_hand_m`` from the back of the
    bent elbow to the tip of the middle finger. ``sole_m`` is the shoe's sole worn while pointing;
    ``seat_height_m``, of a seated user, the seat's top above the floor. ``eye`` is the one that sights,
    "both" where that is not known. A ``self_reported`` height was not measured.

    Raises:
        ConfigError: for another unit, a child, or sizes that do not fit the height.

    """

    height_m: float | None = None
    sex: Sex | None = None
    span_m: float | None = None
    shoulder_height_m: float | None = None
    forearm_hand_m: float | None = None
    sole_m: float = 0.0
    seat_height_m: float | None = None
    arm: Arm = "right"
    eye: Eye = "right"
    self_reported: bool = False

    def __post_init__(self) -> None:
        """Check every size by itself, then against the height."""
        if self.height_m is not None:
            _check_height(self.height_m)
        for name, limits in _LIMITS.items():
            value = getattr(self, name)
            if value is not None:
                _check_number(name, value, limits)
        for name, share in _SHARES.items():
            value = getattr(self, name)
            if value is not None and self.height_m is not None:
                _check_share(name, value, self.height_m, share)
        _check_word("sex", self.sex, ("man", "woman", None))
        _check_word("arm", self.arm, ("right", "left"))
        _check_word("eye", self.eye, ("right", "left", "both"))


class _Share(NamedTuple):
    """A size as a share of the height: the survey's extremes, widened, and what to say beyond them."""

    low: float
    high: float
    expected: str
    try_this: str


_HEIGHT = (1.2, 2.3)
_LIMITS: dict[str, tuple[float, float]] = {
    "span_m": (0.3, 2.8),
    "shoulder_height_m": (0.3, 2.4),
    "forearm_hand_m": (0.15, 1.2),
    "sole_m": (0.0, 0.15),
    "seat_height_m": (0.2, 1.0),
}
# 6068 adults: span 0.91 to 1.15, acromion height 0.79 to 0.85, forearm and hand 0.24 to 0.31 of the stature.
_SHARES: dict[str, _Share] = {
    "span_m": _Share(0.85, 1.22, "about 1.03", "measure from fingertip to fingertip, both arms out level"),
    "shoulder_height_m": _Share(
        0.75, 0.89, "about 0.82", "measure from the floor to the bony top of the shoulder, standing"
    ),
    "forearm_hand_m": _Share(
        0.22, 0.33, "about 0.27", "measure from the back of the bent elbow to the middle fingertip"
    ),
}
_UNITS = ((0.001, "millimetres"), (0.01, "centimetres"), (0.0254, "inches"), (0.3048, "feet"))
_THINNEST_SOLE = 0.005
_SYNONYMS = {"male": "man", "m": "man", "female": "woman", "f": "woman", "w": "woman", "r": "right", "l": "left"}


def _check_height(value: object) -> None:
    metres = _number("height_m", value)
    low, high = _HEIGHT
    if low <= metres <= high:
        return
    meant = _other_unit(metres, _HEIGHT)
    if meant is None and 0.0 < metres < low:
        raise ConfigError(
            f"height_m = {metres:g}, but the body sizes come from a survey of adults and hold from {low:g} to "
            f"{high:g} m: was another size typed, or, for a child, measure the five and write them to a body file"
        )
    raise ConfigError(_out_of_range("height_m", metres, _HEIGHT, meant))


def _check_number(name: str, value: object, limits: tuple[float, float]) -> None:
    metres = _number(name, value)
    if not limits[0] <= metres <= limits[1]:
        raise ConfigError(_out_of_range(name, metres, limits, _other_unit(metres, limits)))


def _number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        example = {"height_m": "1.75", "sole_m": "0.025", "seat_height_m": "0.45"}.get(name, "1.42")
        raise ConfigError(f"{name} = {value!r} is not a finite number: write metres, such as {example}")
    return float(value)


def _other_unit(value: float, limits: tuple[float, float]) -> str | None:
    """The likely meaning of a number that is too great as metres."""
    if value <= limits[1]:
        return None
    for metres, unit in _UNITS:
        if max(limits[0], _THINNEST_SOLE) <= value * metres <= limits[1]:
            return f"that looks like {unit}, did you mean {value * metres:.4g}{_inches(value, unit)}?"
    return None


def _inches(value: float, unit: str) -> str:
    """The other reading of feet: 5.9 may stand for 5 feet 9 inches."""
    feet, _, inches = f"{value:g}".partition(".")
    if unit != "feet" or not inches or not 1 <= int(inches) <= 11:
        return ""
    return f" ({value:g} feet) or {0.3048 * int(feet) + 0.0254 * int(inches):.4g} ({feet} feet {inches} inches)"


def _out_of_range(name: str, value: float, limits: tuple[float, float], meant: str | None) -> str:
    low, high = limits
    return (
        f"{name} = {value:g}, but it is in metres and lies between {low:g} and {high:g}: {meant or 'measure it again'}"
    )


def _check_share(name: str, value: float, height: float, share: _Share) -> None:
    if share.low * height <= value <= share.high * height:
        return
    raise ConfigError(
        f"{name} = {value:g} does not fit height_m = {height:g}: it is {value / height:.2f} of the height, where "
        f"{share.expected} was expected: {_did_you_mean(name, value, height, share) or share.try_this}"
    )


def _did_you_mean(name: str, value: float, height: float, share: _Share) -> str | None:
    """A mistake of measuring that explains the value."""
    if name == "span_m" and share.low * height <= 2.0 * value <= share.high * height:
        return f"that looks like one arm from the fingertip to the middle of the chest, did you mean {2.0 * value:g}?"
    if name == "shoulder_height_m" and 0.5 * height <= value < share.low * height:
        return f"that looks like a sitting person's, {share.try_this}"
    if name == "shoulder_height_m" and share.low * value <= height <= share.high * value:
        return "the shoulder lies above the head, did you mean the two the other way round?"
    if name == "forearm_hand_m" and 0.38 * height <= value <= 0.5 * height:
        return f"that looks like the whole arm, {share.try_this}"
    return None


def _check_word(name: str, value: object, known: tuple[str | None, ...]) -> None:
    if value in known:
        return
    words = ", ".join(repr(word) for word in known if word)
    meant = _SYNONYMS.get(str(value).strip().lower(), str(value).strip().lower())
    hint = f"did you mean {meant!r}?" if meant in known else "choose one"
    raise ConfigError(f"{name} = {value!r}, but it is one of {words}: {hint}")
