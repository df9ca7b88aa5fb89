import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from armspan.errors import CalibrationError
from armspan.orientation import Attitude, Hold, heading_of, mount_from_forward, mount_from_poses
from armspan.records import ImuSample

G = 9.81


def matrices(*rotations: Rotation) -> np.ndarray:
    return np.stack([rotation.as_matrix() for rotation in rotations])


def wxyz(rotation: Rotation) -> tuple[float, ...]:
    return tuple(rotation.as_quat(scalar_first=True).tolist())


# A band on the arm: the wrist's attitude in each pose, and how the sensor sits on the wrist.
MOUNT = Rotation.from_euler("xyz", [25, -8, 12], degrees=True)  # wrist_from_sensor
HEADING = np.radians(130)


def poses(tilt_deg: float = 0.0, wobble_deg: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Forward (x to the heading, tilted up) and hanging (x down) as earth_from_sensor, five samples each."""
    rng = np.random.default_rng(0)
    forward = Rotation.from_euler("ZY", [HEADING, -np.radians(tilt_deg)])
    hanging = Rotation.from_euler("ZY", [HEADING, np.radians(90)])
    shake = [Rotation.from_rotvec(np.radians(wobble_deg) * rng.standard_normal(3)) for _ in range(5)]
    return (
        matrices(*[forward * s * MOUNT for s in shake]),
        matrices(*[hanging * s * MOUNT for s in shake]),
    )


def test_two_poses_find_mounting_and_heading():
    mount = mount_from_poses(*poses())
    assert mount.wrist_from_sensor == pytest.approx(MOUNT.as_matrix(), abs=1e-9)
    assert mount.heading == pytest.approx(HEADING)


def test_the_stretched_arm_points_along_x_of_the_user():
    forward, _ = poses()
    mount = mount_from_poses(*poses())
    attitude = Rotation.from_matrix(forward[0]).as_quat(scalar_first=True)
    assert mount.user_from_wrist(tuple(attitude)) == pytest.approx(np.eye(3), abs=1e-9)


def test_a_tilt_is_shared_between_the_two_poses():
    mount = mount_from_poses(*poses(tilt_deg=6))
    along = MOUNT.inv().apply([1, 0, 0])
    off = np.degrees(np.arccos(mount.wrist_from_sensor[0] @ along))
    assert off == pytest.approx(3.0, abs=1e-6)


@pytest.mark.parametrize(("tilt", "words"), [(35, "35 degrees up"), (-40, "40 degrees down")])
def test_an_arm_that_is_not_level_is_refused_with_its_angle(tilt, words):
    with pytest.raises(CalibrationError, match=words):
        mount_from_poses(*poses(tilt_deg=tilt))


def test_two_equal_poses_are_refused():
    _, hanging = poses()
    with pytest.raises(CalibrationError, match="level"):
        mount_from_poses(hanging, hanging)


def test_known_mounting_needs_one_pose_and_still_checks_the_level():
    forward, _ = poses()
    assert mount_from_forward(forward, MOUNT.as_matrix()).heading == pytest.approx(HEADING)
    with pytest.raises(CalibrationError, match="level"):
        mount_from_forward(poses(tilt_deg=30)[0], MOUNT.as_matrix())


def test_the_heading_is_a_circular_mean():
    around = [Rotation.from_euler("z", np.pi + offset) for offset in (-0.1, 0.05, 0.05)]
    heading = heading_of(matrices(*around), np.eye(3))
    assert np.cos(heading) == pytest.approx(-1.0, abs=1e-6)


def rest(t: float, gyr=(0.0, 0.0, 0.0)) -> ImuSample:
    return ImuSample(t, "wrist", (0.0, 0.0, G), gyr)


def test_raw_samples_at_rest_give_an_upright_attitude():
    attitude = Attitude()
    for k in range(300):
        attitude.update(rest(k / 100))
    up = Rotation.from_quat(attitude.quaternion, scalar_first=True).apply([0, 0, 1])
    assert up == pytest.approx([0, 0, 1], abs=1e-3)


def turned(keep) -> float:
    """Turn about the vertical [deg] seen after one second at 90 deg/s, of which only some samples arrive."""
    attitude = Attitude()
    rate = np.radians(90)
    for k in range(200):
        attitude.update(rest(k / 100))
    for k in range(200, 301):
        if keep(k):
            attitude.update(rest(k / 100, (0.0, 0.0, rate if k > 200 else 0.0)))
    return float(np.degrees(Rotation.from_quat(attitude.quaternion, scalar_first=True).as_euler("ZYX")[0]))


def test_lost_packets_do_not_lose_the_turn():
    whole = turned(lambda k: True)
    assert whole == pytest.approx(90, abs=2)
    assert turned(lambda k: k % 7 != 0 or k == 300) == pytest.approx(whole, abs=1.0)
    assert turned(lambda k: not 220 <= k < 235) == pytest.approx(whole, abs=1.0)


def test_the_bands_own_quaternion_is_taken_as_it_is_and_late_samples_are_passed_over():
    attitude = Attitude()
    new, old = wxyz(Rotation.from_euler("z", 0.3)), wxyz(Rotation.from_euler("z", 0.1))
    attitude.update(ImuSample(1.0, "wrist", (0, 0, G), (0, 0, 0), quat=new))
    attitude.update(ImuSample(0.9, "wrist", (0, 0, G), (0, 0, 0), quat=old))
    assert attitude.quaternion == new


def test_a_hold_drops_its_beginning_and_starts_anew_after_a_move():
    hold = Hold(needed=0.4, settle=0.2)
    q = (1.0, 0.0, 0.0, 0.0)
    done = [hold.add(k * 0.1, q, moving=k == 3) for k in range(11)]
    assert done == [False] * 10 + [True]  # still again from 0.4 s on, complete 0.6 s later
    assert len(hold.quaternions) == 5
