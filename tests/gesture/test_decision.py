import numpy as np

from armspan.gesture.decision import Decision, Rule, Spotted

LABELS = ("wave", "stop")


def run(rule: Rule, rows: list[tuple[float, float]], lead: float = 0.5) -> tuple[list[Spotted], list[Spotted]]:
    """What fires and what was found in all, for probabilities of (wave, stop) every 0.1 s."""
    decision = Decision(LABELS, rule, dict.fromkeys(LABELS, lead))
    fired = [decision.step(k / 10, np.array([*row, 1 - sum(row)])) for k, row in enumerate(rows)]
    return [event for event in fired if event], decision.finish(len(rows) / 10)


PLAIN = Rule(threshold=0.6, agree=3, smoothing=1.0, release=0.5, rest=2)


def test_a_gesture_fires_once_however_long_it_lasts() -> None:
    fired, found = run(PLAIN, [(0, 0)] * 10 + [(0.9, 0)] * 30 + [(0, 0)] * 10)
    assert [(event.label, event.t) for event in fired] == [("wave", 1.2)]
    assert found[0].start == 0.5  # noticed at 1.0 s, begun half a second before
    assert found[0].end == 4.1  # the second of two quiet hops


def test_two_hops_are_too_few_where_three_must_agree() -> None:
    assert run(PLAIN, [(0, 0)] * 5 + [(0.9, 0)] * 2 + [(0, 0)] * 5)[0] == []


def test_a_dip_above_the_release_is_the_same_gesture_and_one_below_is_another() -> None:
    dip = [(0.9, 0)] * 6 + [(0.4, 0)] * 4 + [(0.9, 0)] * 6
    gone = [(0.9, 0)] * 6 + [(0.1, 0)] * 4 + [(0.9, 0)] * 6
    assert len(run(PLAIN, dip)[0]) == 1
    assert len(run(PLAIN, gone)[0]) == 2


def test_no_other_gesture_fires_before_the_first_is_over_save_an_early_one() -> None:
    rows = [(0.7, 0)] * 6 + [(0.35, 0.65)] * 6
    assert [event.label for event in run(PLAIN, rows)[0]] == ["wave"]
    early = Rule(threshold=0.6, agree=3, smoothing=1.0, release=0.5, rest=2, early={"stop": (0.4, 1)})
    fired = run(early, rows)[0]
    assert [(event.label, event.t) for event in fired] == [("wave", 0.2), ("stop", 0.6)]


def test_smoothing_holds_back_a_single_spike() -> None:
    smooth = Rule(threshold=0.6, agree=1, smoothing=0.3, release=0.5, rest=2)
    assert run(smooth, [(0, 0)] * 5 + [(1, 0)] + [(0, 0)] * 5)[0] == []
    assert len(run(smooth, [(0, 0)] * 5 + [(1, 0)] * 5)[0]) == 1


def test_a_gap_ends_what_was_going_on() -> None:
    decision = Decision(LABELS, PLAIN, {})
    for k in range(4):
        decision.step(k / 10, np.array([0.9, 0.0, 0.1]))
    decision.interrupt(0.5)
    assert decision.smooth is None
    assert [(event.label, event.end) for event in decision.closed] == [("wave", 0.5)]
    assert decision.step(0.6, np.array([0.9, 0.0, 0.1])) is None


def test_another_threshold_takes_the_early_ones_along() -> None:
    rule = Rule(threshold=0.8, agree=4, early={"stop": (0.6, 2)})
    lower = rule.at(0.4)
    assert (lower.threshold, lower.agree, lower.early) == (0.4, 4, {"stop": (0.3, 2)})
    assert lower.at(0.8) == rule
