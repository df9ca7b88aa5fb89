"""Small takes that can be told apart: one sine per label, with noise; everyday motion is noise alone."""

import numpy as np

from armspan.gesture.takes import NULL, Take

COLUMNS = ("right_ax", "right_ay", "right_az")
FREQUENCIES = {"wave": 1.0, "shake": 3.0, "circle": 2.0}


def made_take(label: str, person: str = "p", number: int = 1, *, rate: float = 50.0, rest: float = 0.0) -> Take:
    rng = np.random.default_rng([number, sum(map(ord, label + person))])
    times = np.arange(round((2.0 + 2 * rest) * rate) + 1) / rate
    moving = (times >= rest) & (times <= rest + 2.0)
    phase = 2 * np.pi * FREQUENCIES[label] * rng.uniform(0.9, 1.1) * times + rng.uniform(0, 1)
    clean = np.stack([np.sin(phase), np.cos(phase), np.sin(2 * phase)], axis=1) * moving[:, None]
    values = 3 * clean + 0.3 * rng.standard_normal((len(times), 3))
    return Take(label, person, number, COLUMNS, times, values, False, (rest, rest + 2.0) if rest else None)


def made_takes(count: int = 6, persons: tuple[str, ...] = ("p",), rest: float = 0.0) -> list[Take]:
    return [
        made_take(label, person, number, rest=rest)
        for label in FREQUENCIES
        for person in persons
        for number in range(1, count + 1)
    ]


def made_null(seconds: float = 60.0, rate: float = 50.0, seed: int = 0) -> Take:
    rng = np.random.default_rng([seed, 99])
    times = np.arange(round(seconds * rate)) / rate
    return Take(NULL, "p", 1 + seed, COLUMNS, times, rng.standard_normal((len(times), 3)))


def made_stream(labels: list[str], rate: float = 50.0) -> tuple[Take, list[tuple[float, float, str]]]:
    """Gestures three seconds apart in everyday motion, and when they are made."""
    null = made_null(4.0 + 5.0 * len(labels), rate, seed=5)
    values, truth = null.values.copy(), []
    for k, label in enumerate(labels):
        take = made_take(label, "p", 50 + k, rate=rate)
        start = 3.0 + 5.0 * k
        at = round(start * rate)
        values[at : at + len(take.values)] = take.values
        truth.append((start, start + 2.0, label))
    return Take(NULL, "p", 9, COLUMNS, null.times, values), truth
