import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from armspan.errors import ConfigError
from armspan.pointing.selection import NOTHING, Candidate, Candidates, Dwell, SelectionSettings
from armspan.records import RobotState, Sheet, Zone

SHEET = Sheet(1.0, 1.0)
SQUARE = Zone("square", ((0.6, 0.6), (0.8, 0.6), (0.8, 0.8), (0.6, 0.8)))


def robots(*places, held=()):
    return [RobotState(0.0, f"r{k}", xy, 0.0, held=k in held) for k, xy in enumerate(places)]


def judge(places, spot, sd, zones=(), elsewhere=0.05, held=()):
    candidates = Candidates.on_sheet(SHEET, zones).with_robots(robots(*places, held=held))
    spot = np.array(spot)
    return candidates, candidates.posterior(spot, spot, np.eye(2) * sd**2, elsewhere)


def test_two_robots_alike_share_the_posterior():
    _, p = judge([(0.4, 0.5), (0.6, 0.5)], (0.5, 0.5), 0.05)
    assert p[0] == pytest.approx(p[1])
    assert p.sum() == pytest.approx(1.0)


def test_the_posterior_by_hand():
    """Robots at 0 and 2 sd of the spot, sd 50 mm widened by 6 mm of aim: weights exp(0) and exp(-d²/2s²)."""
    _, p = judge([(0.5, 0.5), (0.6, 0.5)], (0.5, 0.5), 0.05, elsewhere=1e-9)
    variance = 0.05**2 + 0.006**2
    far = np.exp(-0.5 * 0.1**2 / variance)
    assert p[0] == pytest.approx(1 / (1 + far), rel=1e-6)


def test_a_spot_beside_everything_means_nothing_known():
    candidates, p = judge([(0.2, 0.2)], (0.9, 0.9), 0.03)
    assert candidates.name(int(np.argmax(p))) == NOTHING


def test_a_zone_is_meant_anywhere_in_it():
    for spot in [(0.7, 0.7), (0.63, 0.77)]:
        candidates, p = judge([(0.3, 0.3)], spot, 0.02, [SQUARE])
        assert candidates.name(int(np.argmax(p))) == Candidate(zone="square")
        assert p.max() > 0.9


def test_a_held_robot_cannot_be_meant():
    candidates, p = judge([(0.5, 0.5), (0.6, 0.5)], (0.5, 0.5), 0.03, held=(0,))
    assert candidates.robots == (Candidate(robot="r1"),)
    assert len(p) == 2


def test_the_shape_of_the_noise_matters():
    """Noise along the line of sight only: the robot behind the spot beats the nearer one beside it."""
    candidates = Candidates.on_sheet(SHEET, []).with_robots(robots((0.5, 0.38), (0.58, 0.5)))
    spot = np.array([0.5, 0.5])
    p = candidates.posterior(spot, spot, np.diag([0.02**2, 0.08**2]), 0.01)
    assert p[0] > 0.9


@given(st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=8), st.floats(0.005, 0.3))
def test_a_posterior_is_a_distribution(places, sd):
    _, p = judge(places, (0.5, 0.5), sd, [SQUARE])
    assert p.min() >= 0
    assert p.sum() == pytest.approx(1.0)


def test_measured_selection_rates():
    """Four robots, 3 deg of noise at 22 mm/deg: gated at 0.8 about nine in ten decide, 98 % of these right.

    The figures of the literature's simulation were 91 % and 98.3 % for robots drawn on a sheet of this size.
    """
    rng = np.random.default_rng(3)
    decided = right = 0
    for _ in range(400):
        places = [tuple(xy) for xy in rng.uniform(0.05, 0.95, (4, 2))]
        goal = int(rng.integers(4))
        spot = places[goal] + rng.normal(0, 0.066, 2)
        candidates, p = judge(places, spot, 0.066, elsewhere=0.01)
        best = int(np.argmax(p))
        if p[best] >= 0.8 and candidates.name(best) != NOTHING:
            decided += 1
            right += candidates.name(best) == Candidate(robot=f"r{goal}")
    assert decided / 400 > 0.8
    assert right / decided > 0.95


R0, R1 = Candidate(robot="r0"), Candidate(robot="r1")


def steps(dwell, *stream):
    """Feed (best, probability, moving) every 0.1 s; the times at which something was chosen."""
    return [round(k * 0.1, 1) for k, item in enumerate(stream) if dwell.step(k * 0.1, *item)]


def test_a_dwell_of_a_second_chooses_once():
    dwell = Dwell(SelectionSettings())
    assert steps(dwell, *[(R0, 0.9, False)] * 40) == [1.0]


def test_hysteresis_keeps_what_the_gate_let_in():
    dwell = Dwell(SelectionSettings())
    assert steps(dwell, (R0, 0.85, False), *[(R0, 0.7, False)] * 12) == [1.0]
    assert steps(Dwell(SelectionSettings()), *[(R0, 0.7, False)] * 30) == []


def test_another_candidate_starts_anew_and_a_moving_arm_adds_nothing():
    assert steps(Dwell(SelectionSettings()), *[(R0, 0.9, False)] * 9, *[(R1, 0.9, False)] * 11) == [1.9]
    assert steps(Dwell(SelectionSettings()), *[(R0, 0.9, True)] * 30) == []


def test_the_same_candidate_again_needs_that_it_was_left():
    dwell = Dwell(SelectionSettings())
    held = [(R0, 0.9, False)] * 12
    assert steps(dwell, *held, *held, (NOTHING, 0.9, False), *held) == [1.0, 3.5]


def test_a_tap_chooses_what_is_held():
    dwell = Dwell(SelectionSettings())
    assert not dwell.take()
    dwell.step(0.0, R0, 0.9, False)
    assert dwell.progress(0.5) == pytest.approx(0.5)
    assert dwell.take()
    assert not dwell.take()
    assert dwell.progress(0.5) == 1.0


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"dwell_s": 5.0}, "0.3 to 2"),
        ({"gate": 0.6, "hold": 0.7}, "hold <= gate"),
        ({"elsewhere": 0.0}, "between 0 and 1"),
    ],
)
def test_settings_out_of_range_are_refused_in_words(wrong, words):
    with pytest.raises(ConfigError, match=words):
        SelectionSettings(**wrong)


# --- receptors -----------------------------------------------------------------------------------------------


def judge_with(odds, places, spot, sd, zones=(), elsewhere=0.05):
    candidates = Candidates.on_sheet(SHEET, zones).with_robots(robots(*places))
    spot = np.array(spot)
    return candidates, candidates.posterior(spot, spot, np.eye(2) * sd**2, elsewhere, np.array(odds))


def test_odds_of_one_change_nothing():
    places = [(0.5, 0.5), (0.6, 0.5)]
    _, plain = judge(places, (0.52, 0.5), 0.05, [SQUARE])
    _, same = judge_with([1.0, 1.0], places, (0.52, 0.5), 0.05, [SQUARE])
    assert same == pytest.approx(plain, rel=1e-12)


def test_the_posterior_with_a_hit_by_hand():
    """Both robots one sd from the spot: what the receptors say decides, 700 against 0.3."""
    _, p = judge_with([700.0, 0.3], [(0.45, 0.5), (0.55, 0.5)], (0.5, 0.5), 0.05, elsewhere=1e-9)
    assert p[0] / p[1] == pytest.approx(700 / 0.3)


def test_a_hit_carries_a_robot_over_one_that_the_ray_prefers_but_not_over_metres():
    places = [(0.5, 0.5), (0.6, 0.5)]
    _, near = judge_with([0.3, 700.0], places, (0.5, 0.5), 0.04)  # 2.5 sd away
    assert near[1] > 0.95
    candidates, far = judge_with([700.0], [(0.95, 0.95)], (0.05, 0.05), 0.05)  # a stray light, 25 sd away
    assert candidates.name(int(np.argmax(far))) == NOTHING


def test_without_a_ray_the_receptors_decide_by_themselves():
    candidates = Candidates.on_sheet(SHEET, [SQUARE]).with_robots(robots((0.1, 0.1), (0.9, 0.9)))
    p = candidates.by_receptors(0.05, np.array([700.0, 0.3]))
    total = 700.0 + 0.3 + 1.0 + 3 * 0.05 / 0.95
    assert p == pytest.approx([700 / total, 0.3 / total, 1 / total, 3 * 0.05 / 0.95 / total])
    both = candidates.by_receptors(0.05, np.array([700.0, 700.0]))
    assert both.max() < 0.8
    none = candidates.by_receptors(0.05, np.array([0.3, 0.3]))
    assert none.max() < 0.8
