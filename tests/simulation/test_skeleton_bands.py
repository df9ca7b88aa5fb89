"""Virtual bands on skeletons: held against hand-made motion, the virtual person's own sensors and a real sensor."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armspan.errors import DataError
from armspan.simulation.anatomy import sideways
from armspan.simulation.inertial import motion
from armspan.simulation.person import draw_person
from armspan.simulation.second_arm import TwoArmedPerson
from armspan.simulation.skeleton_bands import BAND_COLUMNS, virtual_bands, wrist_felt

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "gestures"
CAMERA_FROM_USER = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
"""A camera that is faced: x to the person's right, y up, z ahead of the camera, so towards the person's back."""
UPPER, FOREARM, HAND = 0.3, 0.25, 0.08
DOWN = np.array([0.0, 0.0, -1.0])
MIDDLE = slice(40, -40)


def arm(shoulder, upper, forearm):
    """Joints (n, 4, 3) of an arm from directions (n, 3) in ``user``."""
    upper, forearm = np.broadcast_arrays(upper, forearm)
    elbow = shoulder + UPPER * upper
    wrist = elbow + FOREARM * forearm
    return np.stack([np.broadcast_to(shoulder, elbow.shape), elbow, wrist, wrist + HAND * forearm], axis=1)


def body(forearm, upper=DOWN):
    """Joints (n, 8, 3) in ``user`` of a body whose arms do the same."""
    return np.concatenate([arm(np.array([0.0, y, 1.4]), upper, forearm) for y in (0.18, -0.18)], axis=1)


def seen(joints_user):
    """The joints as the camera sees them, 3 m away."""
    return joints_user @ CAMERA_FROM_USER.T + [0.1, -1.0, 3.0]


def swinging(rate=100.0, seconds=8.0, swing=0.8, hertz=0.3):
    """A bent forearm that swings level about the elbow: joints, and its angle with its two derivatives."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    w = 2.0 * np.pi * hertz
    angle, first, second = swing * np.sin(w * t), swing * w * np.cos(w * t), -swing * w**2 * np.sin(w * t)
    forearm = np.stack([np.cos(angle), np.sin(angle), 0.0 * t], axis=1)
    return body(forearm), angle, first, second


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_level_swing_has_its_angle_rate_and_centripetal_acceleration(side):
    joints, angle, first, second = swinging()
    band = virtual_bands(seen(joints), 100.0)[side]
    zero = np.zeros_like(angle)
    radial = np.stack([np.cos(angle), np.sin(angle), zero], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle), zero], axis=1)
    acceleration = FOREARM * (second[:, None] * across - first[:, None] ** 2 * radial)
    # palm down: a turn about z alone, (0, 0, sin, cos) of half the angle
    attitude = np.stack([zero, zero, np.sin(angle / 2), np.cos(angle / 2)], axis=1)
    attitude *= np.sign(band[0, 3])
    assert band.shape == (len(angle), len(BAND_COLUMNS))
    np.testing.assert_allclose(band[MIDDLE, :4], attitude[MIDDLE], atol=2e-3)
    np.testing.assert_allclose(band[MIDDLE, 4:7], acceleration[MIDDLE], atol=0.01)
    np.testing.assert_allclose(band[MIDDLE, 7:], np.stack([zero, zero, first], axis=1)[MIDDLE], atol=0.01)
    assert np.abs(first).max() > 1.4
    assert np.abs(acceleration).max() > 0.5


def test_a_hanging_arm_feels_gravity_along_the_forearm_only():
    still = np.broadcast_to(body(DOWN[None]), (60, 8, 3))
    for band in virtual_bands(seen(still), 30.0).values():
        np.testing.assert_allclose(wrist_felt(band), np.tile([-9.80665, 0, 0, 0, 0, 0], (60, 1)), atol=1e-6)
        np.testing.assert_allclose(
            Rotation.from_quat(band[:, :4]).apply([0, 1, 0]), np.tile([0, 1, 0], (60, 1)), 0, 1e-6
        )


def test_a_raised_bent_forearm_has_its_palm_to_the_front():
    # upper arm ahead, forearm up: the palm that looked down at a hanging bent arm looks ahead, the back behind
    raised = np.broadcast_to(body(-DOWN[None], np.array([[1.0, 0.0, 0.0]])), (40, 8, 3))
    for band in virtual_bands(seen(raised), 30.0).values():
        np.testing.assert_allclose(
            Rotation.from_quat(band[0, :4]).as_matrix(), [[0, 0, -1], [0, 1, 0], [1, 0, 0]], 0, 1e-6
        )


@pytest.mark.parametrize("seed", range(3))
def test_where_the_person_stands_and_faces_does_not_matter(seed):
    rng = np.random.default_rng(seed)
    joints = seen(swinging()[0])
    turn = Rotation.from_rotvec([0.0, rng.uniform(-3, 3), 0.0]).as_matrix()
    moved = virtual_bands(joints @ turn.T + rng.normal(size=3), 100.0)
    for side, band in virtual_bands(joints, 100.0).items():
        np.testing.assert_allclose(moved[side], band, atol=1e-6)


def test_signs_of_quaternions_do_not_jump_in_a_full_turn():
    angle = np.linspace(0.0, 4.0 * np.pi, 800)
    joints = body(np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1))
    band = virtual_bands(joints, 100.0, up=(0, 0, 1))["right"]
    assert np.abs(np.diff(band[:, :4], axis=0)).max() < 0.05


def test_twice_the_rate_is_four_times_the_acceleration():
    joints = seen(swinging()[0])
    slow, fast = virtual_bands(joints, 50.0, cutoff_hz=1.5), virtual_bands(joints, 100.0, cutoff_hz=3.0)
    np.testing.assert_allclose(fast["right"][:, 4:7], 4.0 * slow["right"][:, 4:7], atol=1e-9)
    np.testing.assert_allclose(fast["right"][:, 7:], 2.0 * slow["right"][:, 7:], atol=1e-9)


def test_jitter_of_a_centimetre_stays_about_a_metre_per_second_squared():
    rng = np.random.default_rng(5)
    still = body(np.array([[1.0, 0.0, 0.0]])) + rng.normal(scale=0.01, size=(2000, 8, 3))
    noise = virtual_bands(still, 19.0, up=(0, 0, 1))["right"][:, 4:7].std(axis=0)
    # white noise of density 2 (1 cm)² / 19 Hz through (2 pi f)² and the filter run twice
    f = np.linspace(0.0, 9.49, 5000)
    passed = 1.0 / (1.0 + (np.tan(np.pi * f / 19.0) / np.tan(np.pi * 3.0 / 19.0)) ** 4)
    expected = 0.01 * np.sqrt(2.0 / 19.0 * np.trapezoid(((2.0 * np.pi * f) ** 2 * passed) ** 2, f))
    assert expected == pytest.approx(0.9, rel=0.2)  # as the constant's docstring says
    np.testing.assert_allclose(noise, expected, rtol=0.1)


def test_a_straight_arm_with_jitter_does_not_roll_wildly():
    rng = np.random.default_rng(6)
    still = body(np.broadcast_to(DOWN, (400, 3))) + rng.normal(scale=0.005, size=(400, 8, 3))
    for band in virtual_bands(still, 19.0, up=(0, 0, 1)).values():
        left = Rotation.from_quat(band[:, :4]).apply([0.0, 1.0, 0.0])
        assert np.median(left[:, 1]) > 0.7
        assert band[:, 7:].std(axis=0).max() < 0.6


def test_a_lost_plane_is_held_from_before():
    # the arm stretches to the side, where y to the left cannot help, and bends again: the roll comes through
    t = np.linspace(0.0, 6.0, 600)
    bend = np.radians(60.0) * np.abs(np.cos(np.pi * t / 6.0))
    side = np.array([0.0, -1.0, 0.0])
    forearm = np.cos(bend)[:, None] * side + np.sin(bend)[:, None] * np.array([1.0, 0.0, 0.0])
    band = virtual_bands(body(forearm, side[None]), 100.0, up=(0, 0, 1))["right"]
    # bent to the front, the back of the hand looks away from the upper arm, so ahead turned by the bend
    back = Rotation.from_quat(band[:, :4]).apply([0.0, 0.0, 1.0])
    expected = np.sin(bend)[:, None] * -side + np.cos(bend)[:, None] * np.array([1.0, 0.0, 0.0])
    assert np.degrees(np.arccos(np.clip((back * expected).sum(axis=1), -1, 1))).max() < 15.0


def test_arms_held_straight_out_have_some_attitude_that_stays():
    out = np.array([0.0, 1.0, 0.0])
    still = np.broadcast_to(body(out[None], out), (60, 8, 3))
    for band in virtual_bands(still, 30.0, up=(0, 0, 1)).values():
        np.testing.assert_allclose(Rotation.from_quat(band[:, :4]).apply([1, 0, 0]), np.tile(out, (60, 1)), 0, 1e-6)
        np.testing.assert_allclose(band[:, 4:], 0.0, atol=1e-6)


@pytest.mark.parametrize("up", [(0, 0, 0), (0, np.nan, 0), (1, 0)])
def test_up_must_point_somewhere(up):
    with pytest.raises(DataError, match="up is"):
        virtual_bands(GOOD, 100.0, up=up)


@pytest.mark.parametrize("label", ["breaststroke", "x_left_high"])
def test_the_virtual_persons_own_sensors_feel_the_same(label):
    rng = np.random.default_rng(3)
    person = TwoArmedPerson(draw_person(rng), (0.0, 0.0), 0.4, rng, np.random.default_rng(4))
    told = person.perform(1.0, label)
    rate = 60.0
    times = np.arange(0.5, told.end + 0.5, 1.0 / rate)
    poses = {"own": person.pose(times), "other": person.other_pose(times)}
    own_left = sideways(person.person.arm) > 0
    arms = [np.stack([p.shoulder, p.elbow, p.wrist, p.fingertip], axis=1) for p in poses.values()]
    joints = np.concatenate(arms if own_left else arms[::-1], axis=1)
    bands = virtual_bands(joints, rate, cutoff_hz=6.0, up=(0, 0, 1))
    for segment, side in (("forearm", "left"), ("other_forearm", "right")):
        side = side if own_left else {"left": "right", "right": "left"}[side]
        truth = motion(person, segment, times, np.eye(3), np.zeros(3))
        felt = wrist_felt(bands[side])
        force, across = np.linalg.norm(truth.force, axis=1), np.linalg.norm(truth.rate[:, 1:], axis=1)
        assert np.corrcoef(force, np.linalg.norm(felt[:, :3], axis=1))[0, 1] > 0.97
        assert np.corrcoef(across, np.linalg.norm(felt[:, 4:], axis=1))[0, 1] > 0.98
        np.testing.assert_allclose(np.median(felt[:, 0] - truth.force[:, 0]), 0.0, atol=0.1)


@pytest.mark.skipif(not (DATA / "UTDMHAD_skel_arms.npz").exists(), reason="UTD-MHAD is not beside the checkout")
def test_the_real_sensor_of_the_same_recordings_agrees_with_the_right_wrist():
    with np.load(DATA / "UTDMHAD_skel_arms.npz") as file:
        cuts = np.split(file["X"].astype(float), np.cumsum(file["lengths"])[:-1])
        kept = np.flatnonzero(file["y"] < 21)
    with np.load(DATA / "UTDMHAD21arm.npz") as file:
        real, lengths = file["X"].astype(float), file["orig_len"]
    found = {"left": [], "right": []}
    for k in range(0, len(kept), 17):
        joints, seconds = cuts[kept[k]], (lengths[k] - 1) / 50.0
        bands = virtual_bands(joints, (len(joints) - 1) / seconds)
        for side, band in bands.items():
            rate = np.linalg.norm(band[:, 7:], axis=1)
            there = np.interp(np.linspace(0, 1, len(rate)), np.linspace(0, 1, 128), np.linalg.norm(real[k, 3:], axis=0))
            found[side].append(np.corrcoef(rate, there)[0, 1])
    assert np.median(found["right"]) > 0.7
    assert np.median(found["left"]) < 0.5


GOOD = seen(swinging(seconds=1.0)[0])


@pytest.mark.parametrize(
    ("joints", "rate", "cutoff", "words"),
    [
        (GOOD[:, :7], 100.0, 3.0, r"shape \(100, 7, 3\).*left shoulder"),
        (GOOD[:15], 100.0, 3.0, "15 frames.*at least 16"),
        (np.where(np.arange(100)[:, None, None] == 7, np.nan, GOOD), 100.0, 3.0, "frame 7 .*NaN"),
        (GOOD, 6.0, 3.0, "6 frames a second smoothed at 3 Hz"),
        (GOOD, np.nan, 3.0, "nan frames a second"),
        (GOOD, 100.0, 0.0, "smoothed at 0 Hz"),
        (GOOD[:, [0, 1, 2, 3, 0, 5, 6, 7]], 100.0, 3.0, "shoulders are 0.000 m apart"),
        (GOOD[:, [0, 1, 2, 3, 4, 5, 5, 7]], 100.0, 3.0, "right arm has no length in frame 0"),
    ],
)
def test_what_is_no_skeleton_is_refused_in_words(joints, rate, cutoff, words):
    with pytest.raises(DataError, match=words):
        virtual_bands(joints, rate, cutoff_hz=cutoff)
