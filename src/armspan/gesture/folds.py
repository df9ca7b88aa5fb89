"""Which takes are held out together."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from armspan.gesture.takes import Take


def take_folds(takes: Sequence[Take], most: int) -> list[NDArray[np.intp]]:
    """Folds over takes: the n-th take of each label and person goes to fold n, round and round.

    No more folds than the commonest label has takes of one person; empty when there would be one only.
    """
    seen: dict[tuple[str, str], int] = {}
    order = sorted(range(len(takes)), key=lambda k: (takes[k].label, takes[k].person, takes[k].number))
    rank = np.zeros(len(takes), dtype=int)
    per_label: dict[str, int] = {}
    for k in order:
        key = (takes[k].label, takes[k].person)
        rank[k] = seen[key] = seen.get(key, -1) + 1
        per_label[takes[k].label] = per_label.get(takes[k].label, 0) + 1
    # Persons with one take each: what is counted on then is the label's takes, whoever made them.
    if max(rank, default=0) == 0:
        counts: dict[str, int] = {}
        for k in order:
            rank[k] = counts[takes[k].label] = counts.get(takes[k].label, -1) + 1
    folds = min(most, int(rank.max(initial=0)) + 1)
    return [np.flatnonzero(rank % folds == fold) for fold in range(folds)] if folds > 1 else []


def person_folds(takes: Sequence[Take], most: int) -> list[NDArray[np.intp]]:
    """Folds over persons, one each while there are no more than ``most``; empty with one person."""
    persons = sorted({take.person for take in takes})
    if len(persons) < 2:
        return []
    folds = min(most, len(persons))
    number = np.array([persons.index(take.person) for take in takes])
    return [np.flatnonzero(number % folds == fold) for fold in range(folds)]
