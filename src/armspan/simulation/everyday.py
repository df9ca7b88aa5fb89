"""What arms do when they make no gesture: walking, writing, drinking, talking ... a random sequence of snippets.

Every snippet is a row of parts, each a posture of the leading arm and of the other (degrees: plane, elevation,
axial, flexion, pronation; see `joints`), None where the arm just hangs, and what swings about it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from armspan.frames import Array
from armspan.records import Vec2
from armspan.simulation.course import LEFT, RIGHT, Piece, Wave
from armspan.simulation.joints import ANGLES, ELEVATION, FLEXION, JOINTS, LIFT, TURN

Degrees: TypeAlias = tuple[float, float, float, float, float]

_STILL: Degrees = (0.0, 0.0, 0.0, 0.0, 0.0)
_TABLE: Degrees = (25.0, 32.0, -45.0, 75.0, 70.0)


@dataclass(frozen=True, slots=True)
class Part:
    """Both arms for ``seconds``, swinging at ``rate`` [Hz] by ``swing`` and ``other_swing``.

    ``against`` is the phase [rad] between the arms, None by chance; ``bounce`` [m] of the body at twice the rate;
    ``loose`` a factor of how far the posture differs from one time to the next.
    """

    lead: Degrees | None
    other: Degrees | None
    seconds: Vec2
    swing: Degrees = _STILL
    other_swing: Degrees = _STILL
    rate: Vec2 = (0.5, 1.5)
    against: float | None = None
    bounce: float = 0.0
    loose: float = 1.0


@dataclass(frozen=True, slots=True)
class Snippet:
    """Something people do, ``weight`` times as often as the least common."""

    name: str
    weight: float
    parts: Sequence[Part]


_OVER: Degrees = (25.0, 55.0, -25.0, 45.0, 60.0)
_WALKING = Part(
    (0.0, 2.0, 0.0, 22.0, 25.0),
    (0.0, 2.0, 0.0, 22.0, 25.0),
    (4.0, 12.0),
    (2.0, 17.0, 3.0, 9.0, 4.0),
    (2.0, 17.0, 3.0, 9.0, 4.0),
    (0.8, 1.05),
    np.pi,
    0.02,
    0.4,
)
SNIPPETS: tuple[Snippet, ...] = (
    Snippet("walking", 4.0, (_WALKING,)),
    Snippet("pause", 3.0, (Part(None, None, (1.0, 5.0)),)),
    Snippet(
        "scratching an arm",
        1.0,
        (
            Part(
                (5.0, 35.0, -75.0, 95.0, 60.0),
                (20.0, 20.0, -30.0, 60.0, 20.0),
                (1.0, 2.5),
                (0.0, 2.0, 3.0, 9.0, 5.0),
                rate=(2.0, 3.5),
            ),
        ),
    ),
    Snippet(
        "scratching the head",
        1.5,
        (Part((55.0, 95.0, -25.0, 128.0, 40.0), None, (1.0, 3.0), (2.0, 2.0, 5.0, 7.0, 8.0), rate=(2.0, 3.5)),),
    ),
    Snippet(
        "drinking",
        1.5,
        (
            Part(_OVER, None, (0.4, 0.9)),
            Part((35.0, 48.0, -35.0, 128.0, 15.0), None, (1.2, 3.0), (0.0, 3.0, 0.0, 3.0, 8.0), rate=(0.3, 0.6)),
            Part(_OVER, None, (0.3, 0.7)),
        ),
    ),
    Snippet(
        "typing",
        2.0,
        (Part(_TABLE, _TABLE, (4.0, 12.0), (1.0, 1.0, 2.5, 2.0, 4.0), (1.0, 1.0, 2.5, 2.0, 4.0), (1.5, 4.0)),),
    ),
    Snippet(
        "writing",
        1.5,
        (
            Part(
                (30.0, 35.0, -55.0, 80.0, 60.0),
                (15.0, 30.0, -70.0, 85.0, 80.0),
                (3.0, 9.0),
                (2.0, 1.0, 5.0, 3.0, 4.0),
                rate=(1.5, 3.5),
            ),
        ),
    ),
    Snippet(
        "folding the arms",
        1.5,
        (Part((10.0, 32.0, -72.0, 105.0, 35.0), (10.0, 26.0, -80.0, 108.0, 60.0), (2.0, 9.0), loose=0.5),),
    ),
    Snippet(
        "talking with both hands",
        3.0,
        (
            Part(
                (35.0, 32.0, -45.0, 85.0, 10.0),
                (35.0, 32.0, -45.0, 85.0, 10.0),
                (2.0, 7.0),
                (8.0, 8.0, 16.0, 18.0, 20.0),
                (8.0, 8.0, 16.0, 18.0, 20.0),
                (0.5, 1.3),
                loose=1.6,
            ),
        ),
    ),
    Snippet(
        "talking with one hand",
        2.0,
        (
            Part(
                (35.0, 38.0, -35.0, 90.0, 0.0),
                None,
                (1.5, 5.0),
                (10.0, 10.0, 18.0, 20.0, 25.0),
                rate=(0.5, 1.4),
                loose=1.8,
            ),
        ),
    ),
    Snippet("reaching for something", 3.0, (Part(_OVER, None, (0.2, 1.0), loose=1.8),)),
    Snippet("moving something with both hands", 2.0, (Part(_OVER, _OVER, (0.4, 2.0), loose=1.3),)),
    Snippet(
        "carrying something",
        1.5,
        (Part((20.0, 20.0, -30.0, 82.0, -25.0), (20.0, 20.0, -30.0, 82.0, -25.0), (3.0, 8.0), bounce=0.015),),
    ),
    Snippet("looking at a watch", 1.5, (Part((15.0, 42.0, -65.0, 100.0, 75.0), None, (0.8, 2.0)),)),
    Snippet("resting on the table", 2.0, (Part(_TABLE, _TABLE, (3.0, 12.0)),)),
    Snippet("pointing", 2.0, (Part((15.0, 78.0, -5.0, 10.0, 60.0), None, (1.0, 4.0), loose=1.2),)),
    Snippet(
        "doing one's hair",
        1.0,
        (
            Part(
                (60.0, 100.0, -10.0, 125.0, 30.0),
                (60.0, 100.0, -10.0, 125.0, 30.0),
                (1.0, 3.0),
                (4.0, 4.0, 6.0, 9.0, 8.0),
                (4.0, 4.0, 6.0, 9.0, 8.0),
                (0.6, 1.5),
            ),
        ),
    ),
    Snippet(
        "stretching",
        0.5,
        (Part((50.0, 140.0, 0.0, 60.0, 20.0), (50.0, 140.0, 0.0, 70.0, 20.0), (0.6, 2.0), loose=1.5),),
    ),
    Snippet(
        "waving",
        0.7,
        (Part((65.0, 70.0, 35.0, 85.0, 40.0), None, (1.0, 2.0), (2.0, 3.0, 20.0, 8.0, 5.0), rate=(1.2, 2.2)),),
    ),
    Snippet(
        "wiping the table",
        1.0,
        (Part((30.0, 50.0, -40.0, 50.0, 80.0), None, (2.0, 5.0), (12.0, 7.0, 12.0, 14.0, 0.0), rate=(0.7, 1.5)),),
    ),
)
_DIFFERS: Array = np.radians((10.0, 6.0, 10.0, 10.0, 14.0))
_WAY, _FARTHER = (0.4, 0.85), 0.3
"""How long a way takes [s], and how much more by each quarter turn of the joint that turns farthest."""


def draw_everyday(
    hang: Array, start: float, seconds: float, leading: int, rng: np.random.Generator
) -> list[tuple[str, Piece]]:
    """Pieces, each with its snippet's name, that fill ``seconds`` from ``start`` [s] on; all are over by then.

    ``hang`` (2, 7) is where the arms hang; the arm ``leading`` does three of four one-handed things.
    """
    weights = np.array([snippet.weight for snippet in SNIPPETS])
    pieces: list[tuple[str, Piece]] = []
    t, end = start, start + seconds
    while True:
        snippet = SNIPPETS[int(rng.choice(len(SNIPPETS), p=weights / weights.sum()))]
        lead = leading if rng.uniform() < 0.75 else 1 - leading
        turn = float(np.radians(12.0) * rng.standard_normal())
        for part in snippet.parts:
            piece, until = _piece(part, hang, t, lead, turn, rng)
            if piece is not None and piece.over > end:
                return pieces
            if piece is not None:
                pieces.append((snippet.name, piece))
            t = until
        if t >= end:
            return pieces
        t += float(rng.exponential(0.6)) if rng.uniform() < 0.5 else 0.0


def _piece(
    part: Part, hang: Array, start: float, lead: int, turn: float, rng: np.random.Generator
) -> tuple[Piece | None, float]:
    # A busy moment lasts from one way to the next; the next part begins while the arm leaves this one.
    lasting = float(rng.uniform(*part.seconds))
    if part.lead is None and part.other is None:
        return None, start + lasting
    joints = _joints(part, hang, lead, turn, rng)
    far = float(np.abs(joints - hang)[:, : FLEXION + 1].max()) / (np.pi / 2.0)
    way = rng.uniform(*_WAY, size=4) + _FARTHER * far
    begin = start + rng.uniform(0.0, 0.12, 2)
    end = begin.max() + way[:2].max() + lasting + rng.uniform(0.0, 0.12, 2)
    rate = float(rng.uniform(*part.rate))
    against = float(rng.uniform(0.0, 2.0 * np.pi)) if part.against is None else part.against
    first, share = float(rng.uniform(0.0, 2.0 * np.pi)), np.ones(2)
    share[1 - lead] = float(part.other is not None)
    phase = np.array([first, first])
    phase[1 - lead] += against
    piece = Piece(
        joints,
        _pair(begin),
        _pair(way[:2]),
        _pair(end),
        _pair(way[2:]),
        share=_pair(share),
        waves=_swings(part, lead, rng),
        rate=(rate, rate),
        phase=_pair(phase),
        unsteady=(float(rng.uniform(0.1, 0.6)), first),
    )
    return piece, min(piece.end)


def _joints(part: Part, hang: Array, lead: int, turn: float, rng: np.random.Generator) -> Array:
    joints = hang.copy()
    both = part.loose * _DIFFERS * rng.standard_normal(ANGLES)
    for arm, posture in ((lead, part.lead), (1 - lead, part.other)):
        own = 0.5 * part.loose * _DIFFERS * rng.standard_normal(ANGLES)
        if posture is not None:
            joints[arm, :ANGLES] = np.radians(posture) + both + own
    joints[:, TURN] = turn
    joints[:, FLEXION] = np.maximum(joints[:, FLEXION], np.radians(4.0))
    joints[:, ELEVATION] = np.maximum(joints[:, ELEVATION], np.radians(-10.0))
    return joints


def _swings(part: Part, lead: int, rng: np.random.Generator) -> tuple[Wave, ...]:
    cosine, sine, bounce = np.zeros((3, 2, JOINTS))
    size = float(np.exp(0.25 * rng.standard_normal()))
    lag = rng.uniform(-1.2, 1.2, (2, ANGLES)) if part.against is None else np.full((2, ANGLES), 0.2)
    for arm, swing in ((lead, part.swing), (1 - lead, part.other_swing)):
        amplitude = size * np.radians(swing)
        cosine[arm, :ANGLES], sine[arm, :ANGLES] = amplitude * np.cos(lag[arm]), amplitude * np.sin(lag[arm])
    bounce[:, LIFT] = part.bounce
    return Wave(cosine, sine), Wave(bounce, np.zeros((2, JOINTS)), order=2)


def _pair(values: Array) -> Vec2:
    return float(values[LEFT]), float(values[RIGHT])
