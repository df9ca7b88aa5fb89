"""Choosing when a gesture counts as made, from what a spotter says of takes and motion that it has not learnt from."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from armspan.frames import Array
from armspan.gesture.decision import Decision, Rule
from armspan.gesture.model import softmax
from armspan.gesture.scoring import rate_bound

STOP = "stop"
"""The gesture that is to be missed least: it has a threshold of its own and may fire early."""

THRESHOLDS = (0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9, 0.95)
"""The thresholds that are tried."""
_AGREE = (2, 3, 4, 6)
_HIGH = 0.6
_EARLY = 2


@dataclass(slots=True, eq=False)
class Heard:
    """Decision values hop by hop: of takes with their labels, and of stretches of everyday motion."""

    takes: list[tuple[str, Array]] = field(default_factory=list)
    nulls: list[Array] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Outcome:
    rule: Rule
    hits: int
    wrong: int
    false: int
    delay: float

    @property
    def f1(self) -> float:
        return 2 * self.hits / max(1, self.hits + self.wrong + self.false + self.total)

    total: int = 0


def choose_rule(
    heard: Heard,
    labels: tuple[str, ...],
    lead: dict[str, float],
    temperature: float,
    rate_per_hour: float,
    hop_s: float,
) -> tuple[Rule, dict[str, Any]]:
    """The rule that finds most takes with no more false triggers than wanted, and an account of it.

    With too little null data for the wanted rate to show (less than 1 / rate), no trigger at all is let pass.
    """
    takes = [(label, softmax(scores, temperature)) for label, scores in heard.takes]
    nulls = [softmax(scores, temperature) for scores in heard.nulls]
    hours = sum(map(len, nulls)) * hop_s / 3600
    allowed = int(rate_per_hour * hours)
    tried = [
        _try(Rule(threshold=threshold, agree=agree), takes, nulls, labels, lead, hop_s)
        for agree in _AGREE
        for threshold in THRESHOLDS
    ]
    quiet = [outcome for outcome in tried if outcome.false <= allowed] or [min(tried, key=lambda o: o.false)]
    chosen = _in_the_middle(quiet)
    rule = _with_early(chosen, takes, nulls, labels, lead, hop_s)
    final = _try(rule, takes, nulls, labels, lead, hop_s)
    others = [_try(rule.at(threshold), takes, nulls, labels, lead, hop_s) for threshold in THRESHOLDS]
    return rule, _account(final, len(takes), hours, hop_s) | {"thresholds": [_at_threshold(other) for other in others]}


def _in_the_middle(quiet: Sequence[_Outcome]) -> _Outcome:
    """Of the rules that do as well as the best, the one that is furthest from doing worse.

    For each agreement they are a range of thresholds: the widest range is taken, in it the threshold a little above
    the middle, since a missed gesture is made again and a false one is obeyed.
    """
    best = max(outcome.f1 for outcome in quiet)
    near = [outcome for outcome in quiet if outcome.f1 >= best - 0.005]
    ranges = [sorted((o for o in near if o.rule.agree == n), key=lambda o: o.rule.threshold) for n in _AGREE]
    widest = max((found for found in ranges if found), key=lambda found: (len(found), -found[0].rule.agree))
    return widest[round(_HIGH * (len(widest) - 1))]


def _at_threshold(outcome: _Outcome) -> dict[str, Any]:
    """What the chosen rule would have done with another threshold."""
    return {
        "threshold": outcome.rule.threshold,
        "recognised": outcome.hits,
        "wrong_or_twice": outcome.wrong,
        "false_triggers": outcome.false,
    }


def _account(final: _Outcome, takes: int, hours: float, hop_s: float) -> dict[str, Any]:
    bound = rate_bound(final.false, hours)
    return {
        "takes": takes,
        "recognised": final.hits,
        "wrong_or_twice": final.wrong,
        "event_f1": round(final.f1, 4),
        "false_triggers": final.false,
        "null_hours": round(hours, 4),
        "false_per_hour": round(final.false / hours, 2) if hours else None,
        "below_per_hour": round(bound, 2) if bound is not None else None,
        "latency_s": round(final.delay, 2) if final.hits else None,
    }


def _try(
    rule: Rule,
    takes: Sequence[tuple[str, Array]],
    nulls: Sequence[Array],
    labels: tuple[str, ...],
    lead: dict[str, float],
    hop_s: float,
) -> _Outcome:
    hits = wrong = false = 0
    delays = []
    for label, probabilities in takes:
        fired = _run(rule, probabilities, labels, lead, hop_s)
        right = [t for t, what in fired if what == label]
        hits += bool(right)
        wrong += len(fired) - bool(right)
        delays += right[:1]
    for probabilities in nulls:
        false += len(_run(rule, probabilities, labels, lead, hop_s))
    return _Outcome(rule, hits, wrong, false, float(np.median(delays)) if delays else np.inf, len(takes))


def _run(
    rule: Rule, probabilities: Array, labels: tuple[str, ...], lead: dict[str, float], hop_s: float
) -> list[tuple[float, str]]:
    # Where nothing reaches the threshold even unsmoothed, nothing can fire.
    if probabilities[:, :-1].max(initial=0.0) < min(rule.threshold, *(v for v, _ in rule.early.values()), 1.0):
        return []
    decision = Decision(labels, rule, lead)
    fired = [(k * hop_s, decision.step(k * hop_s, row)) for k, row in enumerate(probabilities)]
    return [(t, event.label) for t, event in fired if event is not None]


def _with_early(
    chosen: _Outcome,
    takes: Sequence[tuple[str, Array]],
    nulls: Sequence[Array],
    labels: tuple[str, ...],
    lead: dict[str, float],
    hop_s: float,
) -> Rule:
    """The rule with a lower threshold for the stop gesture: half way down to where it would add something false."""
    rule = chosen.rule
    if STOP not in labels:
        return rule
    agree, lowest = min(_EARLY, rule.agree), rule.threshold
    for threshold in sorted((value for value in THRESHOLDS if value <= rule.threshold), reverse=True):
        lower = Rule(threshold=rule.threshold, agree=rule.agree, early={STOP: (threshold, agree)})
        outcome = _try(lower, takes, nulls, labels, lead, hop_s)
        if outcome.false > chosen.false or outcome.wrong > chosen.wrong or outcome.hits < chosen.hits:
            break
        lowest = threshold
    half_way = round((lowest + rule.threshold) / 2, 3)
    return Rule(threshold=rule.threshold, agree=rule.agree, early={STOP: (half_way, agree)})
