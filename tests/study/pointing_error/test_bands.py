import numpy as np
import pytest

from armspan.study.pointing_error.bands import DESK_PLACES, compare, virtual_crowds
from armspan.study.pointing_error.recordings import Gestures
from armspan.study.pointing_error.trials import (
    CORNERS,
    EDGES,
    MISSED_M,
    Misses,
    fitted,
    many_draws,
    misses,
    pick,
    together,
)
from armspan.study.pointing_error.virtual import nine_places, virtual_gestures
from straight_arms import BODY, pointing_at, with_x

PLACES = nine_places((1.2, 0.1), 0.3, 0.7)


def straight(repeats=2, noise=0.0, rng=None):
    """A person whose arm is exactly straight, its forearm turned by some noise [rad]."""
    places = np.tile(np.arange(9), repeats)
    arm = pointing_at(PLACES[places])
    if noise:
        off = arm[:, :, 0] + noise * rng.standard_normal((len(arm), 3))
        arm = with_x(off / np.linalg.norm(off, axis=1, keepdims=True))
    return Gestures(BODY, arm, arm, PLACES[places], places)


def bent(repeats=2):
    """A person who bends the elbow by a different angle at every gesture, the fingertip in its place all the same."""
    rng = np.random.default_rng(4)
    places = np.tile(np.arange(9), repeats)
    eye = np.array([0.0, 0.0, BODY.eye_height_m])
    shoulder = eye - np.array(BODY.shoulder_to_eye_m)
    sight = PLACES[places] - eye
    fingertip = eye + 0.55 * sight / np.linalg.norm(sight, axis=1, keepdims=True)
    chord = fingertip - shoulder
    half = np.linalg.norm(chord, axis=1, keepdims=True) / 2.0  # two limbs of 0.36 m: the elbow lies over the middle
    aside = np.cross(chord, rng.standard_normal(chord.shape))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    elbow = shoulder + chord / 2.0 + np.sqrt(0.36**2 - half**2) * aside
    upper, lower = (elbow - shoulder) / 0.36, (fingertip - elbow) / 0.36
    return Gestures(BODY, with_x(lower), with_x(upper), PLACES[places], places)


def test_a_straight_arm_needs_no_second_band():
    for model in ("head-finger", "two-band"):
        rng = np.random.default_rng(0)
        found = many_draws([straight()], lambda _: CORNERS, EDGES, model, rng, draws=2, drawn=False)
        assert found.metres.max() < 1e-6


def test_rays_of_a_flawless_arm_meet_their_targets():
    person = straight()
    fit = fitted(person, pick(person, CORNERS, 1, np.random.default_rng(0)), "head-finger")
    found = misses(person, fit, np.arange(18), drawn=False)
    assert found.metres.max() < 1e-6
    assert found.angles.max() < 1e-6


def test_a_bent_arm_is_seen_by_two_bands_only():
    row = compare("bent", [bent()], simulated=True, rng=np.random.default_rng(0), draws=2)
    assert np.median(row.two.metres) < 0.02
    assert np.median(row.one.metres) > 0.05


def test_misses_are_distances_and_angles_seen_from_the_eye():
    person = straight()
    fit = fitted(person, pick(person, CORNERS, 1, np.random.default_rng(0)), "head-finger")
    moved = Gestures(BODY, person.forearm, person.upperarm, person.targets + np.array([0.03, 0.04, 0.0]), person.places)
    found = misses(moved, fit, np.array([4]), drawn=False)
    eye, target = np.array([0.0, 0.0, 1.65]), moved.targets[4]
    seen, meant = person.targets[4] - eye, target - eye
    cosine = seen @ meant / np.linalg.norm(seen) / np.linalg.norm(meant)
    assert found.metres[0] == pytest.approx(0.05, abs=1e-6)
    assert found.angles[0] == pytest.approx(np.arccos(cosine), abs=1e-6)


def test_a_gesture_above_the_horizon_counts_as_missed():
    person = straight()
    fit = fitted(person, pick(person, CORNERS, 1, np.random.default_rng(0)), "head-finger")
    up = with_x(np.array([[0.6, 0.0, 0.8]]))
    skyward = Gestures(BODY, up, up, PLACES[:1], np.array([0]))
    assert misses(skyward, fit, np.array([0])).metres.tolist() == [MISSED_M]


def test_picks_hold_each_place_as_often_as_asked():
    person = straight(repeats=5)
    rows = pick(person, (0, 4), 3, np.random.default_rng(1))
    assert len(set(rows.tolist())) == 6
    assert sorted(person.places[rows].tolist()) == [0, 0, 0, 4, 4, 4]


def test_more_gestures_at_a_stop_average_their_noise():
    person = straight(repeats=25, noise=0.03, rng=np.random.default_rng(2))
    rng = np.random.default_rng(3)

    def found(gestures):
        return many_draws([person], lambda _: CORNERS, EDGES, "head-finger", rng, gestures=gestures, draws=6)

    assert np.median(found(25).metres) < np.median(found(1).metres)


def test_stops_that_place_nobody_count_every_gesture_as_missed():
    person = straight()
    found = many_draws([person], lambda _: (4,), EDGES, "head-finger", np.random.default_rng(0), draws=1)
    assert found.metres.tolist() == [MISSED_M] * 8


def test_documents_are_in_millimetres_and_degrees():
    found = together([Misses(np.array([0.1]), np.array([0.1])), Misses(np.array([0.3]), np.array([0.3]))])
    assert found.document()["median_mm"] == pytest.approx(200.0)
    assert found.document()["median_deg"] == pytest.approx(11.459, abs=1e-3)
    assert found.document()["gestures"] == 2


def test_virtual_people_point_at_all_nine_places():
    person = virtual_gestures(np.random.default_rng(0), "straight", DESK_PLACES, repeats=2)
    assert np.bincount(person.places).tolist() == [2] * 9
    assert person.targets == pytest.approx(DESK_PLACES[person.places])
    eye = np.array([0.0, 0.0, person.body.eye_height_m])
    tip = eye - np.array(person.body.shoulder_to_eye_m) + person.body.shoulder_to_fingertip_m * person.forearm[:, :, 0]
    sight = person.targets - eye
    tip = tip - eye
    cosine = (tip * sight).sum(axis=1) / np.linalg.norm(tip, axis=1) / np.linalg.norm(sight, axis=1)
    assert np.degrees(np.arccos(np.median(cosine))) < 25.0  # heading, habits and measures are all wrong by degrees
    again = virtual_gestures(np.random.default_rng(0), "straight", DESK_PLACES, repeats=2)
    assert np.array_equal(person.forearm, again.forearm)


def test_a_second_band_helps_virtual_people_with_natural_arms():
    crowds = virtual_crowds(np.random.default_rng(0), 4)
    assert len(crowds) == 4
    row = compare("", crowds["natural arm, table at 1 m"], simulated=True, rng=np.random.default_rng(1), draws=2)
    assert np.median(row.two.metres) < 0.8 * np.median(row.one.metres)
