import numpy as np
import pytest

from armspan.conductor.hits import FLICKER, Hits
from armspan.pointing.laser import LaserSettings
from armspan.pointing.selection import NOTHING, Candidate, Candidates
from armspan.records import Hit, RobotState, Sheet

LASER = LaserSettings(receptors=("ash", "elm"), dwell_s=0.3, release_s=0.5)
ASH, ELM, OAK = Candidate("ash"), Candidate("elm"), Candidate("oak")


def hits(*said):
    made = Hits(LASER)
    for t, robot, on in said:
        made.take(Hit(t, robot, on))
    return made


def test_what_is_hit_is_likelier_and_what_is_dark_a_little_less_likely():
    odds = hits((1.0, "ash", True)).odds([ASH, ELM, OAK])
    assert odds == pytest.approx([0.7 / 0.001, 0.3 / 0.999, 1.0])  # oak has no receptor: it says nothing


def test_a_robot_without_a_receptor_is_not_listened_to():
    made = hits((1.0, "oak", True))
    assert not made.heard("oak")
    assert made.odds([OAK]) == pytest.approx([1.0])


def test_a_hit_that_holds_for_the_dwell_is_due_once():
    made = hits((1.0, "ash", True))
    assert not made.due(1.25, ASH, already=False)
    assert not made.due(1.30, ELM, already=False)
    assert made.due(1.30, ASH, already=False)
    assert not made.due(1.35, ASH, already=False)


def test_a_repeated_hit_does_not_begin_anew():
    made = hits((1.0, "ash", True), (1.2, "ash", True))
    assert made.due(1.3, ASH, already=False)


def test_it_is_released_by_darkness_and_not_by_a_flicker():
    made = hits((1.0, "ash", True))
    made.due(1.5, ASH, already=False)
    for t, on in ((2.0, False), (2.2, True)):
        made.take(Hit(t, "ash", on))
        made.tick(t + 0.2)
    assert not made.due(3.0, ASH, already=True)
    made.take(Hit(3.0, "ash", False))
    made.tick(3.45)
    made.take(Hit(3.46, "ash", True))
    assert not made.due(4.0, ASH, already=True)
    made.take(Hit(4.0, "ash", False))
    made.tick(4.55)
    made.take(Hit(5.0, "ash", True))
    assert made.due(5.3, ASH, already=True)


def test_what_was_chosen_otherwise_is_not_chosen_again_by_its_first_hit():
    made = hits((1.0, "ash", True))
    assert not made.due(2.0, ASH, already=True)


def test_what_is_hit_while_the_set_up_leads_must_be_dark_first():
    made = hits((1.0, "ash", True))
    made.tick(1.1, leading=True)
    made.tick(1.2)
    assert not made.due(2.0, ASH, already=False)
    made.take(Hit(2.0, "ash", False))
    made.tick(2.6)
    made.take(Hit(3.0, "ash", True))
    assert made.due(3.4, ASH, already=False)


def test_a_flicker_is_seen_through():
    made = hits((1.0, "ash", True), (2.0, "ash", False))
    assert made.sees(1.5, "ash")
    assert made.sees(2.0 + 0.9 * FLICKER, "ash")
    assert not made.sees(2.0 + 1.1 * FLICKER, "ash")
    assert not made.sees(2.0, "elm")


def test_by_receptors_alone_one_light_decides_and_two_do_not():
    states = [RobotState(0.0, name, xy, 0.0) for name, xy in (("ash", (0.1, 0.1)), ("elm", (0.5, 0.1)))]
    candidates = Candidates.on_sheet(Sheet(0.9, 0.6), ()).with_robots(states)
    best, probability = hits((1.0, "elm", True)).best(candidates, 0.05)
    assert (best, probability > 0.99) == (ELM, True)
    _, probability = hits((1.0, "elm", True), (1.0, "ash", True)).best(candidates, 0.05)
    assert probability < 0.6
    best, probability = hits().best(candidates, 0.05)
    assert best == NOTHING or probability < 0.8
    assert np.isfinite(probability)
