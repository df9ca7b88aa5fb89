"""A second arm: where it sits, what it does, and that it changes nothing about the first."""

import numpy as np
import pytest

from armspan.errors import DataError
from armspan.simulation.bands import BandTraits, VirtualBand
from armspan.simulation.everyday import SNIPPETS
from armspan.simulation.person import VirtualPerson, draw_person
from two_arms import FLAWLESS, both, climbs, drawn, flawless


def roughness(places):
    """The greatest leap [m/s²] of the acceleration between two milliseconds."""
    return float(np.abs(np.diff(np.diff(places, 2, axis=0) / 0.001**2, axis=0)).max())


def test_it_is_mirrored_about_the_middle_of_the_eyes():
    person = flawless()
    assert person.pose([0.0]).shoulder[0] == pytest.approx((0.0, -0.2, 1.35))
    assert person.other_pose([0.0]).shoulder[0] == pytest.approx((0.0, 0.26, 1.35))
    assert person.other_pose([0.0]).wrist[0] == pytest.approx((0.0, 0.26, 0.8), abs=1e-9)
    assert person.other_pose([0.0]).eye[0] == pytest.approx((0.0, 0.0, 1.6))


def test_both_arms_are_stretched_palms_down_and_hang_again():
    person = flawless()
    person.stretch(0.0)
    for pose in both(person, [3.0]):
        assert pose.room_from_forearm[0] == pytest.approx(np.eye(3), abs=1e-9)
    person.hang(3.0)
    assert [climbs(pose)[0] for pose in both(person, [6.0])] == pytest.approx([-90.0, -90.0])
    person.rest(6.0)
    left, right = both(person, [9.0])
    assert left.wrist[0, 1] + right.wrist[0, 1] == pytest.approx(0.06)  # alike on both sides of the middle
    assert left.wrist[0, 0] > 0.2


def test_it_hangs_while_the_first_points():
    person = drawn(1)
    person.stretch(0.0)
    person.point(3.0, (2.0, 0.0, 1.0))
    person.track(6.0, (2.0, 0.1, 1.0))
    assert climbs(person.other_pose([6.0]))[0] < -70
    assert climbs(person.pose([6.0]))[0] > -50


def test_the_first_arm_moves_to_the_last_bit_as_that_of_a_one_armed_person():
    poses = []
    for second in (False, True):
        rng = np.random.default_rng(5)
        person = drawn(5) if second else VirtualPerson(draw_person(rng), (0.0, 0.0), 0.0, rng)
        person.stretch(0.5)
        person.hang(3.0)
        person.point(6.0, (2.0, 0.5, 0.8))
        person.correct(9.0, (0.1, 0.0, 0.0))
        person.rest(11.0)
        poses.append(person.pose(np.arange(10.0, 14.0, 0.05)))
    for name in ("wrist", "room_from_forearm", "eye"):
        assert (getattr(poses[0], name) == getattr(poses[1], name)).all()


@pytest.mark.parametrize("seed", range(4))
def test_what_it_does_is_smooth(seed):
    # Hands accelerate by 100 m/s² at most and in tenths of a second, not in one millisecond.
    person = drawn(seed)
    person.perform(0.5, "raise_both")
    person.perform(2.0, "mixing")  # waits for the end of the first
    person.point(6.5, (2.0, 0.3, 0.8))
    times = np.arange(5.6, 9.0, 0.001)
    for pose in both(person, times):
        assert roughness(pose.wrist) < 2.5
        speeds = np.linalg.norm(np.diff(pose.wrist, axis=0), axis=1) / 0.001
        assert speeds.max() < 5.0


def test_a_gesture_begins_after_the_reaction_and_arms_return_by_themselves():
    person = drawn(2)
    told = person.perform(2.0, "x_left_high")
    assert 0.2 < told.start - 2.0 < 0.6
    assert told.start < told.reached < told.left < told.end
    left, _ = both(person, np.array([told.start, told.start + 0.15, told.left, told.end, told.end + 2.0]))
    assert climbs(left)[0] < -60
    assert climbs(left)[2] > 10
    assert climbs(left)[3:] == pytest.approx(climbs(left)[4], abs=2.0)
    assert climbs(left)[4] < -60


def test_the_truth_is_what_moves():
    person = drawn(3)
    told = person.perform(1.0, "raise_both")
    times = np.arange(0.5, told.end + 1.5, 0.02)
    speed = np.max([np.linalg.norm(np.gradient(p.wrist, 0.02, axis=0), axis=1) for p in both(person, times)], axis=0)
    moving = times[speed > 0.3]
    assert 0.0 <= moving[0] - told.start < 0.3
    assert 0.0 <= told.end - moving[-1] < 0.4


def test_a_second_gesture_waits_for_the_first():
    person = drawn(4)
    first, second = person.perform(1.0, "stop"), person.perform(1.5, "mixing")
    assert second.start >= first.end
    assert person.performed == [first, second]
    assert person.free == second.end


def test_whoever_is_called_away_ends_there():
    person = drawn(4)
    first = person.perform(1.0, "stop")
    person.perform(1.5, "mixing")
    person.point(first.start + 1.0, (2.0, 0.0, 1.0))
    [told] = person.performed  # the second never began
    assert first.start + 1.2 < told.end < first.start + 1.6
    assert told.label == "stop"
    after = person.perform(first.start + 4.0, "raise_both")
    left, right = both(person, [(after.reached + after.left) / 2])
    assert min(climbs(left)[0], climbs(right)[0]) > 10


def test_relaxing_finishes_a_gesture_and_breaks_off_the_rest():
    person = drawn(6)
    told = person.perform(1.0, "raise_both")
    person.relax(told.start + 0.3)
    assert person.performed == [told]
    assert climbs(both(person, [told.left])[0])[0] > 10
    person.everyday(told.end + 1.0, 60.0)
    person.relax(told.end + 10.0)
    for pose in both(person, np.arange(told.end + 13.0, told.end + 30.0, 0.1)):
        assert climbs(pose).max() < -55
    person.stretch(told.end + 40.0)
    person.relax(told.end + 44.0)
    assert climbs(both(person, [told.end + 48.0])[1])[0] < -60


def test_everyday_things_are_many_and_over_in_time():
    person = drawn(7)
    names = person.everyday(0.0, 600.0)
    assert set(names) == {snippet.name for snippet in SNIPPETS} - {"pause"}
    poses = both(person, np.arange(0.0, 605.0, 0.05))
    for pose in poses:
        assert climbs(pose)[-60:].max() < -60  # 2 s after its end
        assert (climbs(pose) > -40).mean() > 0.3
        speeds = np.linalg.norm(np.diff(pose.wrist, axis=0), axis=1) / 0.05
        assert 0.05 < np.median(speeds) < 1.0
        assert speeds.max() < 5.0
    assert person.performed == []


def test_everyday_motion_takes_some_time():
    with pytest.raises(DataError, match="0 s"):
        drawn(0).everyday(0.0, 0.0)


def test_one_seed_is_one_person():
    def wrists(seed):
        person = drawn(seed)
        person.everyday(0.0, 20.0)
        return person.other_pose(np.arange(0.0, 20.0, 0.1)).wrist

    assert (wrists(1) == wrists(1)).all()
    assert (wrists(1) != wrists(2)).any()


def test_a_band_on_the_other_forearm_feels_that_arm():
    person = flawless()
    person.stretch(0.0)
    traits = BandTraits(lever=(0.0, 0.0, 0.0))
    band = VirtualBand("left", "other_forearm", traits, np.random.default_rng(0))
    upper = VirtualBand("upper", "other_upperarm", traits, np.random.default_rng(1))
    hanging, stretched = (band.advance(t, person) for t in (0.2, 3.0))
    assert hanging[0][1].acc == pytest.approx((-9.81, 0.0, 0.0), abs=0.01)  # up is towards the elbow
    assert stretched[-1][1].acc == pytest.approx((0.0, 0.0, 9.81), abs=0.01)
    assert upper.advance(3.0, person)[-1][1].acc == pytest.approx((0.0, 0.0, 9.81), abs=0.01)
    person.point(3.0, (2.0, 0.0, 1.35))
    assert band.advance(6.0, person)[-1][1].acc == pytest.approx((-9.81, 0.0, 0.0), abs=0.01)


def test_a_one_armed_person_wears_no_band_on_the_other_arm():
    person = VirtualPerson(FLAWLESS, (0.0, 0.0), 0.0, np.random.default_rng(0))
    band = VirtualBand("left", "other_forearm", BandTraits(), np.random.default_rng(0))
    with pytest.raises(DataError, match="TwoArmedPerson"):
        band.advance(1.0, person)
