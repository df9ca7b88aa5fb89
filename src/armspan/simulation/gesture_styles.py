"""How one person performs the seven gestures: what stays the same from take to take, and what does not.

The figures are chosen, not fitted: no recording of these gestures by both wrists is public. Spreads between
people are such that an unseen person's gestures are told apart as often as in published studies (88 to 96 %).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from armspan.errors import ConfigError, known_names
from armspan.frames import Array
from armspan.simulation.joints import ANGLES, AXIAL, JOINTS, PLANE

Label: TypeAlias = Literal[
    "initial", "x_left_high", "x_right_high", "raise_both", "mixing", "stop", "arms_to_ground", "breaststroke"
]
LABELS: tuple[Label, ...] = (
    "initial",
    "x_left_high",
    "x_right_high",
    "raise_both",
    "mixing",
    "stop",
    "arms_to_ground",
    "breaststroke",
)
CYCLIC: tuple[Label, ...] = ("mixing", "arms_to_ground", "breaststroke")

HABIT_SD: Array = np.radians((15.0, 12.0, 17.0, 14.0, 26.0))
"""Between people, of the five joints' angles in one gesture."""

_ASYMMETRY = 0.35
_SPREAD: Mapping[Label, float] = {"stop": 0.7, "x_left_high": 0.85, "x_right_high": 0.85, "breaststroke": 1.1}
_TURNED_BACK = 0.6
"""How much of an elbow that is held farther out is made up for by turning the forearm in."""

_REPEAT_SD: Array = np.radians((5.5, 4.5, 6.0, 6.0, 10.0))
_CARELESS = 0.4
_WARMING = 1.3
_TIRING = 40.0


@dataclass(frozen=True, slots=True)
class CycleStyle:
    """How a person circles with the hands: in which plane, which way round, and how the hands go together.

    ``tilt`` [rad] turns the circle's plane, level at 0, upright at a quarter turn; ``roundness`` is the minor axis
    as a share of the major; ``direction`` 1 or -1; ``together`` 1 mirrored, -1 both the same way round;
    ``apart`` [rad] the phase between the hands; ``harmonic`` (5,) [rad] what makes the path no ellipse.
    """

    radius: float
    tilt: float
    roundness: float
    direction: float
    together: float
    apart: float
    rate: float
    cycles: float
    harmonic: Array


@dataclass(frozen=True, slots=True)
class GestureStyle:
    """One person's style. ``amplitude`` below 1 limits the shoulders' range, as a patient's.

    ``hang`` (2, 7) is where the arms hang; ``habits`` and ``warmups`` (2, 5) [rad] are added to each gesture's angles,
    the latter less and less; ``via`` [rad] is by how much the plane leans to the front while arms are
    raised; ``leads`` [s] how much earlier the right arm sets out; ``turn`` [rad] the trunk's.
    """

    amplitude: float
    extent: float
    tempo: float
    hold: float
    hang: Array
    habits: Mapping[Label, Array]
    warmups: Mapping[Label, Array]
    cycles: Mapping[Label, CycleStyle]
    via: float
    leads: float
    turn: float
    fatigue: float
    palms_out: bool
    noise: float


@dataclass(frozen=True, slots=True)
class TakeStyle:
    """One take of one person: factors of amplitude, tempo and holding time, angles (2, 7) added, onsets [s]."""

    amplitude: float
    elevation: float
    tempo: float
    hold: float
    joints: Array
    onset: tuple[float, float]
    radius: float
    rate: float


def checked_label(label: str) -> Label:
    """The label, if it is one (ConfigError)."""
    for known in LABELS:
        if label == known:
            return known
    raise ConfigError(known_names("gesture", label, LABELS))


def draw_style(rng: np.random.Generator, *, amplitude: float = 1.0) -> GestureStyle:
    """Draw one person's style.

    Raises:
        ConfigError: on an amplitude that is not in (0, 1.5].

    """
    if not 0.0 < amplitude <= 1.5:
        raise ConfigError(f"amplitude {amplitude:g} is a share of the usual range: expected above 0 up to 1.5")
    return GestureStyle(
        amplitude=amplitude,
        extent=_factor(rng, 0.12),
        tempo=_factor(rng, 0.18),
        hold=float(rng.uniform(0.9, 1.7)),
        hang=_draw_hang(rng),
        habits={label: _draw_habit(label, rng) for label in LABELS},
        warmups={label: 0.8 * _draw_habit(label, rng) for label in LABELS},
        cycles={label: _draw_cycle(label, rng) for label in CYCLIC},
        via=float(np.radians(-35.0 + 30.0 * rng.standard_normal())),
        leads=float(rng.normal(0.015, 0.02)),
        turn=float(np.radians(4.0) * rng.standard_normal()),
        fatigue=_factor(rng, 0.4),
        palms_out=bool(rng.uniform() < 0.6),
        noise=float(np.radians(rng.uniform(1.0, 2.2))),
    )


def draw_take(style: GestureStyle, before: int, alike: int, label: Label, rng: np.random.Generator) -> TakeStyle:
    """How a gesture is done after ``before`` others, of which ``alike`` were the same one."""
    cold = float(np.exp(-alike / _WARMING))
    tired = style.fatigue * (1.0 - float(np.exp(-before / _TIRING)))
    amplitude = style.extent * style.amplitude * _factor(rng, 0.12) * (1.0 - 0.10 * tired) * (1.0 - 0.10 * cold)
    scatter = _factor(rng, _CARELESS) * _REPEAT_SD * rng.standard_normal((2, ANGLES))
    joints = np.zeros((2, JOINTS))
    joints[:, :ANGLES] = style.habits[label] + cold * style.warmups[label] + scatter
    joints[:, ANGLES] = style.turn + np.radians(4.0) * rng.standard_normal()
    late = float(rng.uniform(0.02, 0.08)) * float(rng.choice((-1.0, 1.0))) - style.leads
    return TakeStyle(
        amplitude=amplitude,
        elevation=style.amplitude * float(np.sqrt(amplitude / style.amplitude)),
        tempo=style.tempo * _factor(rng, 0.12) * (1.0 - 0.15 * tired) * (1.0 - 0.12 * cold),
        hold=_factor(rng, 0.2),
        joints=joints,
        onset=(max(0.0, -late), max(0.0, late)),
        radius=_factor(rng, 0.10),
        rate=_factor(rng, 0.10),
    )


def _factor(rng: np.random.Generator, share: float) -> float:
    return float(np.exp(share * rng.standard_normal()))


def _draw_hang(rng: np.random.Generator) -> Array:
    plane, elevation, flexion, pronation = np.radians(rng.normal((55.0, 7.0, 13.0, 35.0), (20.0, 2.0, 5.0, 15.0)))
    both = [plane, elevation, -0.8 * plane, flexion, pronation, 0.0, 0.0]
    hang = np.array([both, both])
    hang[:, :ANGLES] += np.radians(2.0) * rng.standard_normal((2, ANGLES))
    return hang


def _draw_habit(label: Label, rng: np.random.Generator) -> Array:
    both, apart = rng.standard_normal(ANGLES), rng.standard_normal(ANGLES)
    sd = HABIT_SD * _SPREAD.get(label, 1.0)
    habit = np.asarray(sd * np.array([both + _ASYMMETRY * apart, both - _ASYMMETRY * apart]))
    habit[:, AXIAL] -= _TURNED_BACK * habit[:, PLANE]
    return habit


_RADIUS: Mapping[Label, tuple[float, float]] = {
    "mixing": (0.115, 0.25),
    "arms_to_ground": (0.11, 0.25),
    "breaststroke": (1.0, 0.18),
}


def _draw_cycle(label: Label, rng: np.random.Generator) -> CycleStyle:
    radius, spread = _RADIUS[label]
    tilt, together, apart, direction = _draw_plane(label, rng)
    return CycleStyle(
        radius=radius * _factor(rng, spread),
        tilt=tilt,
        roundness=float(rng.uniform(0.45, 1.0)),
        direction=direction,
        together=together,
        apart=apart + 0.25 * float(rng.standard_normal()),
        rate=float(np.clip(1.05 * _factor(rng, 0.2), 0.7, 1.5)),
        cycles=float(rng.uniform(2.0, 4.0)),
        harmonic=np.radians(3.0 if label == "breaststroke" else 1.2) * rng.standard_normal(ANGLES),
    )


def _draw_plane(label: Label, rng: np.random.Generator) -> tuple[float, float, float, float]:
    chance, lean, way = float(rng.uniform()), float(rng.standard_normal()), float(rng.uniform())
    if label == "breaststroke":
        return 0.0, 1.0, 0.0, 1.0 if way < 0.85 else -1.0
    if label == "arms_to_ground":
        return 0.25 * lean, 1.0 if chance < 0.7 else -1.0, 0.0, 1.0 if way < 0.6 else -1.0
    if chance < 0.35:  # both stir, as in two bowls
        return 0.3 * lean, 1.0, 0.0, 1.0 if way < 0.6 else -1.0
    if chance < 0.65:  # the hands chase each other round one bowl
        return 0.3 * lean, -1.0, np.pi, 1.0 if way < 0.5 else -1.0
    return np.pi / 2.0 + 0.3 * lean, 1.0, np.pi, 1.0 if way < 0.8 else -1.0  # the forearms roll about each other
