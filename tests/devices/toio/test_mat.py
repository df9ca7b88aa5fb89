import math

import numpy as np
import pytest

from armspan.devices.toio.mat import Chassis, Mat
from armspan.devices.toio.quantities import speed_of, value_of
from armspan.devices.toio.wire import decode, encode

TRUE = Chassis(gain=(1.0, 1.0), mismatch=0.0)


def mat(xy=((0.28, 0.28),), heading=(0.0,), chassis=TRUE, **options):
    return Mat(xy, heading, np.random.default_rng(0), chassis, **options)


def tell(mat, cube, name, t=0.0, **args):
    mat.cubes[cube].write(t, *encode(name, **args))


def test_speed_values():
    # 4.3 rpm a value on a wheel of 12.5 mm: 2.814 mm/s; 8 to 115 count
    assert speed_of(50) == pytest.approx(0.1407, abs=1e-4)
    assert speed_of(-50) == -speed_of(50)
    assert [speed_of(value) for value in (0, 7, -7)] == [0, 0, 0]
    assert speed_of(8) == pytest.approx(0.0225, abs=1e-4)
    assert speed_of(115) == speed_of(255) == pytest.approx(494 / 60 * math.pi * 0.0125, rel=2e-3)
    assert [value_of(v) for v in (0.0, 0.010, 0.012, 0.1407, -0.1407, 9.0)] == [0, 0, 8, 50, -50, 115]


def test_both_wheels_forward_is_straight_ahead():
    scene = mat(heading=(math.pi / 2,))
    tell(scene, 0, "motorTimed", left=50, right=50, duration_ms=1000)
    scene.advance(3.0)
    x, y, heading = scene.pose[:, 0]
    assert (x, heading) == pytest.approx((0.28, math.pi / 2))
    assert y == pytest.approx(0.28 + 0.1407, abs=0.002)  # the lag costs nothing in the end


def test_the_left_wheel_alone_turns_clockwise():
    scene = mat()
    tell(scene, 0, "motorTimed", left=50, right=0, duration_ms=500)
    scene.advance(2.0)
    assert scene.pose[2, 0] == pytest.approx(0.5 * 0.1407 / 0.0266, rel=0.03)
    assert scene.pose[1, 0] > 0.28  # y is down: from x ahead, clockwise leads there


def test_the_wheels_are_late():
    scene = mat()
    tell(scene, 0, "motor", left=50, right=50)
    scene.advance(0.1)
    early = np.hypot(*scene.velocity[:, 0])
    scene.advance(0.8)
    assert early == pytest.approx(0.1407 * (1 - math.exp(-1)), rel=0.1)
    assert np.hypot(*scene.velocity[:, 0]) == pytest.approx(0.1407, rel=0.01)


def test_the_camera_reads_position_ids_with_noise():
    scene = mat(heading=(math.radians(90),))
    tell(scene, 0, "setIdNotification", interval_ms=10, condition=0)
    told = [decode(*note).args for _, _, note in scene.advance(5.0) if note[0] == "id"]
    places = np.array([(args["x"], args["y"], args["angle_deg"]) for args in told])
    assert len(places) > 490
    assert places.mean(axis=0) == pytest.approx((45 + 280 * 411 / 560, 45 + 280 * 411 / 560, 90), abs=0.2)
    assert places.std(axis=0) == pytest.approx((0.58, 0.58, 1.04), abs=0.08)  # half an ID, and a twelfth for rounding


def test_cubes_that_meet_touch_once_and_do_not_pass():
    scene = mat([(0.2, 0.28), (0.3, 0.28)], (0.0, math.pi))
    for cube in (0, 1):
        tell(scene, cube, "motorTimed", left=50, right=50, duration_ms=2000)
    scene.advance(3.0)
    assert scene.contacts == 1
    assert scene.pose[0, 1] - scene.pose[0, 0] == pytest.approx(0.045, abs=0.002)


def test_a_cube_off_the_mat_or_in_a_hand_is_blind():
    for away in (lambda scene: scene.lift(0), lambda scene: scene.put_down(0, (-0.01, 0.2), 0.0)):
        scene = mat()
        scene.advance(0.5)
        away(scene)
        told = [decode(*note).name for _, _, note in scene.advance(1.0) if note[0] == "id"]
        assert told == ["idMissed"]
        scene.put_down(0, (0.1, 0.1), 0.0)
        (first, *_) = [decode(*note) for _, _, note in scene.advance(1.1) if note[0] == "id"]
        assert (first.args["x"], first.args["y"]) == pytest.approx((118, 118), abs=3)


def test_other_mats_begin_elsewhere():
    scene = mat([(0.0, 0.0)], mat="simple")
    (first, *_) = [decode(*note) for _, _, note in scene.advance(0.5) if note[0] == "id"]
    assert (first.args["x"], first.args["y"]) == pytest.approx((98, 142), abs=3)


def test_one_seed_is_one_scene_whatever_the_steps():
    def play(steps):
        scene = Mat([(0.2, 0.2), (0.4, 0.3)], (0.0, 1.0), np.random.default_rng(3))
        tell(scene, 0, "motor", left=40, right=30)
        notes = []
        for t in steps:
            notes += scene.advance(t)
        return notes, scene.pose.tolist()

    assert play([2.0]) == play(np.arange(0.0, 2.0001, 0.005))


@pytest.mark.parametrize("movement", [0, 1, 2])
@pytest.mark.parametrize("change", [0, 1, 2, 3])
def test_a_cube_drives_to_a_target_by_itself(movement, change):
    scene = mat([(0.3, 0.3)], (2.0,), Chassis())
    target = {"x": 120, "y": 330, "angle_deg": 90, "angle_mode": 0}
    tell(scene, 0, "motorTarget", id=1, timeout_s=9, movement=movement, max_speed=60, change=change, **target)
    replies = [decode(*note).args["result"] for _, _, note in scene.advance(9.5) if note[1][0] == 0x83]
    assert replies == [0]
    place = 45 + scene.pose[:2, 0] * 411 / 0.56
    assert np.abs(place - (120, 330)).max() < 15 + 6  # where it stopped, and what it coasted
    assert abs(math.degrees(scene.pose[2, 0]) - 90) < 4 + 8
