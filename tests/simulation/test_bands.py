"""Virtual bands: the kinematics by hand, noise and drift by statistics, bursts and losses by counting."""

from dataclasses import replace

import numpy as np
import pytest
from vqf import VQF

from armspan.simulation.bands import BandTraits, VirtualBand, draw_band
from armspan.simulation.figure import Pose
from armspan.simulation.person import VirtualPerson, draw_person

G = 9.80665
ACC_DIGIT, GYR_DIGIT = G / 2048.0, np.radians(1.0 / 16.4)
PLAIN = BandTraits(fusion="raw", lever=(0.0, 0.0, 0.0))


def turn(axis, angle):
    """Rotations (m, 3, 3) by ``angle`` (m,) about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    one, nil = np.ones_like(c), np.zeros_like(c)
    rows = {
        "x": [[one, nil, nil], [nil, c, -s], [nil, s, c]],
        "y": [[c, nil, s], [nil, one, nil], [-s, nil, c]],
        "z": [[c, -s, nil], [s, c, nil], [nil, nil, one]],
    }[axis]
    return np.moveaxis(np.array(rows), -1, 0)


class Puppet:
    """An arm whose wrist and forearm move as two functions of time say."""

    def __init__(self, rotation, wrist=lambda t: np.zeros((len(t), 3))):
        self.rotation, self.wrist = rotation, wrist

    def pose(self, times):
        t = np.asarray(times)
        nowhere, wrist, rotation = np.zeros((len(t), 3)), self.wrist(t), self.rotation(t)
        elbow, turned = wrist, rotation
        return Pose(nowhere, nowhere, nowhere, nowhere, elbow, wrist, wrist, rotation, turned)


def still(axis, degrees):
    return Puppet(lambda t: turn(axis, np.full(len(t), np.radians(degrees))))


def samples(band, person, seconds=1.0):
    return [sample for _, sample in band.advance(seconds, person)]


def measured(traits, person, seconds=1.0, segment="forearm", seed=0):
    band = VirtualBand("b", segment, traits, np.random.default_rng(seed))
    told = samples(band, person, seconds)
    return np.array([s.t for s in told]), np.array([s.acc for s in told]), np.array([s.gyr for s in told])


# --- kinematics ------------------------------------------------------------------------------------------------


def test_a_level_arm_at_rest_feels_one_g_upwards():
    _, acc, gyr = measured(PLAIN, still("x", 0.0))
    assert len(acc) == 100
    assert acc == pytest.approx(np.tile([0.0, 0.0, G], (100, 1)), abs=ACC_DIGIT)
    assert gyr == pytest.approx(np.zeros((100, 3)), abs=GYR_DIGIT)


def test_a_hanging_arm_feels_gravity_against_its_length():
    # x points down after a quarter turn about y: what holds the sensor up pushes along -x.
    _, acc, _ = measured(PLAIN, still("y", 90.0))
    assert acc[0] == pytest.approx([-G, 0.0, 0.0], abs=ACC_DIGIT)


def test_a_mounted_sensor_feels_it_in_its_own_axes():
    # Rolled by +90 degrees about the segment: the sensor's y points up.
    half = np.sqrt(0.5)
    _, acc, _ = measured(replace(PLAIN, segment_from_sensor=(half, half, 0.0, 0.0)), still("x", 0.0))
    assert acc[0] == pytest.approx([0.0, G, 0.0], abs=ACC_DIGIT)


def test_a_steady_spin_is_felt_as_rate_and_centripetal_acceleration():
    # 2 rad/s about the vertical with a lever of 0.3 m: 2² 0.3 = 1.2 m/s² towards the axis.
    spin = Puppet(lambda t: turn("z", 2.0 * t))
    _, acc, gyr = measured(replace(PLAIN, lever=(0.3, 0.0, 0.0)), spin)
    assert acc == pytest.approx(np.tile([-1.2, 0.0, G], (100, 1)), abs=ACC_DIGIT)
    assert gyr == pytest.approx(np.tile([0.0, 0.0, 2.0], (100, 1)), abs=GYR_DIGIT)


def test_a_fast_spin_is_not_underrated():
    spin = Puppet(lambda t: turn("z", 20.0 * t))
    _, _, gyr = measured(PLAIN, spin)
    assert gyr[:, 2] == pytest.approx(np.full(100, 20.0), abs=GYR_DIGIT)


def test_a_spin_that_quickens_is_felt_tangentially():
    # Angle 1.5 t²: rate 3 t, quickening 3 rad/s²; 0.4 m aside feels 1.2 m/s² along and (3 t)² 0.4 inwards.
    spin = Puppet(lambda t: turn("z", 1.5 * t * t))
    t, acc, gyr = measured(replace(PLAIN, lever=(0.4, 0.0, 0.0)), spin)
    assert acc[:, 1] == pytest.approx(np.full(100, 1.2), abs=2 * ACC_DIGIT)
    assert acc[:, 0] == pytest.approx(-3.6 * t * t, abs=2 * ACC_DIGIT)
    assert gyr[:, 2] == pytest.approx(3.0 * t, abs=GYR_DIGIT)


def test_a_wrist_that_is_shaken_adds_its_own_acceleration():
    # 5 cm at 2 Hz: 0.05 (4 π)² = 7.9 m/s², 180 degrees behind the place.
    def place(t):
        return np.stack([0.05 * np.sin(4.0 * np.pi * t), 0.0 * t, 0.0 * t], axis=1)

    t, acc, _ = measured(PLAIN, Puppet(lambda t: turn("x", 0.0 * t), place))
    assert acc[:, 0] == pytest.approx(-7.8957 * np.sin(4.0 * np.pi * t), abs=0.01)


def test_a_falling_sensor_feels_nothing():
    def place(t):
        return np.stack([0.0 * t, 0.0 * t, -0.5 * G * t * t], axis=1)

    _, acc, _ = measured(PLAIN, Puppet(lambda t: turn("x", 0.0 * t), place))
    assert acc == pytest.approx(np.zeros((100, 3)), abs=ACC_DIGIT)


def test_the_upper_arm_s_band_rides_on_the_upper_arm():
    rng = np.random.default_rng(3)
    virtual = VirtualPerson(draw_person(rng), (0.0, 0.0), 0.0, rng)
    virtual.stretch(0.0)
    worn = replace(PLAIN, lever=(-0.1, 0.0, 0.04))
    forearm = VirtualBand("f", "forearm", worn, np.random.default_rng(0))
    upperarm = VirtualBand("u", "upperarm", worn, np.random.default_rng(0))
    for band, rotation in (
        (forearm, virtual.pose([2.9]).room_from_forearm[0]),
        (upperarm, virtual.pose([2.9]).room_from_upperarm[0]),
    ):
        acc = np.mean([s.acc for s in samples(band, virtual, 3.0)[-20:]], axis=0)
        assert acc == pytest.approx(G * rotation[2], abs=0.15)


def test_an_independent_filter_finds_the_attitude_from_what_is_felt():
    """VQF (Laidig and Seel 2023) knows nothing of the simulation; it can only agree if rate and force do."""
    rng = np.random.default_rng(5)
    virtual = VirtualPerson(draw_person(rng), (0.0, 0.0), 0.0, rng)
    worn = replace(draw_band(rng), fusion="raw", loss=0.0, acc_bias=(0.0, 0.0, 0.0), acc_wander=0.0, late=0.0)
    band, told, true = VirtualBand("b", "forearm", worn, rng), [], []
    for k in range(600):
        if k % 60 == 0:
            virtual.point(0.05 * k, (1.5, 0.3 * (k % 7) - 1.0, 0.7)) if k else virtual.rest(0.0)
        new = [sample for _, sample in band.advance(0.05 * k, virtual)]
        told += new
        true += list(virtual.pose([sample.t for sample in new]).room_from_forearm) if new else []
    gyr, acc = (np.array([getattr(sample, name) for sample in told]) for name in ("gyr", "acc"))
    found = np.array([matrix(quat) for quat in VQF(0.01).updateBatch(gyr, acc)["quat6D"]])
    error = found @ matrix(worn.segment_from_sensor).T @ np.array(true).swapaxes(1, 2)
    assert np.degrees(np.arccos(np.clip(error[300:, 2, 2], -1.0, 1.0))).max() < 1.5
    heading = np.unwrap(np.arctan2(error[300:, 1, 0], error[300:, 0, 0]))
    assert np.degrees(np.ptp(heading)) < 3.0


# --- errors of the chip ----------------------------------------------------------------------------------------


def test_what_is_felt_is_cut_off_and_rounded():
    def place(t):
        return np.stack([5.0 * np.sin(2.0 * np.pi * t), 0.0 * t, 0.0 * t], axis=1)  # up to 197 m/s²

    _, acc, gyr = measured(PLAIN, Puppet(lambda t: turn("z", 40.0 * t), place))
    assert np.abs(acc).max() == pytest.approx(16.0 * G)
    assert np.abs(gyr).max() == pytest.approx(np.radians(2000.0))
    assert acc / ACC_DIGIT == pytest.approx(np.round(acc / ACC_DIGIT), abs=1e-6)
    assert gyr / GYR_DIGIT == pytest.approx(np.round(gyr / GYR_DIGIT), abs=1e-6)


def test_noise_and_offsets_are_those_of_the_chip():
    traits = replace(
        PLAIN,
        acc_noise=170e-6 * G,
        gyr_noise=np.radians(0.007),
        acc_bias=(0.3, 0.0, 0.0),
        gyr_bias=(0.0, np.radians(0.5), 0.0),
        gyr_scale=(0.0, 0.0, 0.01),
    )
    _, acc, gyr = measured(traits, Puppet(lambda t: turn("z", 2.0 * t)), 60.0)
    assert len(acc) == 6000
    # Per root Hz, white up to 50 Hz: 1.2 mg and 0.05 deg/s, besides the rounding.
    assert acc.std(axis=0) == pytest.approx(np.full(3, 170e-6 * G * np.sqrt(50.0)), rel=0.05)
    assert gyr.std(axis=0) == pytest.approx(np.full(3, np.radians(0.0495)), rel=0.1)
    assert acc.mean(axis=0) == pytest.approx([0.3, 0.0, G], abs=0.001)
    assert np.degrees(gyr.mean(axis=0)) == pytest.approx([0.0, 0.5, np.degrees(2.02)], abs=0.005)


def test_raw_bands_leave_the_offsets_in():
    rng = np.random.default_rng(0)
    raw = np.degrees([draw_band(rng, fusion="raw").gyr_bias for _ in range(300)])
    onboard = np.degrees([draw_band(rng).gyr_bias for _ in range(300)])
    assert raw.std() == pytest.approx(0.5, rel=0.1)
    assert onboard.std() < 0.1
    assert samples(VirtualBand("b", "forearm", draw_band(rng, fusion="raw"), rng), still("x", 0.0))[0].quat is None


# --- the band's own fusion -------------------------------------------------------------------------------------


def matrix(quat):
    w, x, y, z = quat
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("degrees", [0.0, 1.0, 90.0, 179.0, 180.0, -120.0])
def test_a_flawless_fusion_tells_the_attitude(axis, degrees):
    band = VirtualBand("b", "forearm", BandTraits(), np.random.default_rng(0))
    told = samples(band, still(axis, degrees))[0].quat
    assert np.linalg.norm(told) == pytest.approx(1.0, abs=1e-6)
    assert matrix(told) == pytest.approx(turn(axis, np.radians([degrees]))[0], abs=1e-6)


def test_the_heading_is_arbitrary_and_the_mounting_is_in():
    # Earth is turned by 90 degrees against the room, the sensor by 180 degrees about x on the arm.
    traits = BandTraits(heading=np.pi / 2, segment_from_sensor=(0.0, 1.0, 0.0, 0.0))
    band = VirtualBand("b", "forearm", traits, np.random.default_rng(0))
    told = matrix(samples(band, still("x", 0.0))[0].quat)
    assert told == pytest.approx(np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]), abs=1e-6)


def heading(sample):
    forward = matrix(sample.quat)
    return np.arctan2(forward[1, 0], forward[0, 0])


def test_the_heading_drifts_as_much_as_a_metamotion_s():
    slopes, tilts = [], []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        traits = replace(draw_band(rng), segment_from_sensor=(1.0, 0.0, 0.0, 0.0), rate_hz=2.0)
        told = samples(VirtualBand("b", "forearm", traits, rng), still("x", 0.0), 300.0)
        yaw = np.degrees(np.unwrap([heading(s) for s in told]))
        slopes.append((yaw[-1] - yaw[0]) / (told[-1].t - told[0].t) * 60.0)
        tilts += [np.degrees(np.arccos(matrix(s.quat)[2, 2])) for s in told]
    assert (np.abs(slopes) > 0.6).all()
    assert (np.abs(slopes) < 4.0).all()
    assert 1.7 < np.mean(np.abs(slopes)) < 2.8
    assert min(slopes) < 0.0 < max(slopes)
    assert 0.3 < np.sqrt(np.mean(np.square(tilts))) < 0.9


@pytest.mark.parametrize("towards", [0.0, 2.0])
def test_a_push_misleads_the_vertical_and_is_forgotten(towards):
    # 1 m/s² for one second of a filter that settles in 4 s: 0.102 rad (1 - e^(-1/4)) = 1.29 deg; then it
    # decays by e in 4 s. What is pushed ahead and to the left seems to be tipped up there.
    def place(t):
        pushed = np.where(t < 1.0, 0.5 * t * t, t - 0.5)
        return np.stack([0.6 * pushed, 0.8 * pushed, 0.0 * t], axis=1)

    band = VirtualBand("b", "forearm", BandTraits(settling=4.0, heading=towards), np.random.default_rng(0))
    told = samples(band, Puppet(lambda t: turn("x", 0.0 * t), place), 6.0)
    tipped = np.degrees([np.arcsin(matrix(s.quat)[2, :2]) for s in told])
    assert tipped[99] == pytest.approx([0.6 * 1.29, 0.8 * 1.29], abs=0.03)
    assert tipped[499] == pytest.approx([0.6 * 0.475, 0.8 * 0.475], abs=0.03)


# --- clock and radio -------------------------------------------------------------------------------------------


def test_bursts_and_losses_are_those_of_a_radio():
    traits = replace(BandTraits(fusion="raw"), loss=0.008, loss_run=1.5, burst=0.0437, delay=0.002)
    told = VirtualBand("b", "forearm", traits, np.random.default_rng(2)).advance(400.0, still("x", 0.0))
    t = np.array([sample.t for _, sample in told])
    assert len(t) / 40000 == pytest.approx(0.992, abs=0.002)
    gaps = np.round(np.diff(t) * 100.0).astype(int) - 1
    runs = gaps[gaps > 0]
    assert runs.mean() == pytest.approx(1.5, rel=0.15)
    assert runs.max() >= 3
    arrivals = np.unique([arrived for arrived, _ in told])
    assert np.median(np.diff(arrivals)) == pytest.approx(0.0437, rel=0.03)
    delay = np.array([arrived for arrived, _ in told]) - t
    assert delay.min() > 0.0
    assert delay.mean() == pytest.approx(0.0239, abs=0.001)  # half an interval and the radio's own 2 ms


def test_a_missed_burst_comes_with_the_next():
    traits = replace(BandTraits(fusion="raw"), missed=0.2)
    told = VirtualBand("b", "forearm", traits, np.random.default_rng(2)).advance(100.0, still("x", 0.0))
    arrived = np.array([at for at, _ in told])
    assert (np.diff(arrived) >= 0.0).all()
    late = np.array([at - sample.t for at, sample in told]) > 0.0455
    assert 0.1 < late.mean() < 0.25


def test_the_driver_s_clock_is_late_by_milliseconds_and_never_turns_back():
    # The heading of an arm that spins at 1 rad/s tells when a sample was really measured.
    rng = np.random.default_rng(4)
    traits = replace(
        draw_band(rng),
        segment_from_sensor=(1.0, 0.0, 0.0, 0.0),
        heading=0.0,
        yaw_drift=0.0,
        yaw_wander=0.0,
        tilt=0.0,
        settling=0.0,
    )
    told = samples(VirtualBand("b", "forearm", traits, rng), Puppet(lambda t: turn("z", 1.0 * t)), 60.0)
    t = np.array([sample.t for sample in told])
    assert (np.diff(t) > 0.0).all()
    late = t - np.unwrap([heading(sample) for sample in told])
    assert 0.0005 < late.mean() < 0.006
    assert late.std() < 0.002
    assert np.diff(late).std() > 0.0001  # the samples' own jitter


def test_nothing_is_told_before_it_is_measured_nor_twice():
    band = VirtualBand("b", "forearm", draw_band(np.random.default_rng(0)), np.random.default_rng(1), start=5.0)
    assert band.advance(4.9, still("x", 0.0)) == []
    first = band.advance(6.0, still("x", 0.0))
    assert 95 <= len(first) <= 100
    assert band.advance(6.0, still("x", 0.0)) == []
    again = band.advance(7.0, still("x", 0.0))
    assert again[0][1].t > first[-1][1].t


# --- repeatability ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("fusion", ["onboard", "raw"])
def test_the_samples_do_not_depend_on_how_often_they_are_asked_for(fusion):
    def run(block):
        rng = np.random.default_rng(7)
        virtual = VirtualPerson(draw_person(rng), (0.0, 0.0), 0.0, rng)
        band = VirtualBand("b", "forearm", draw_band(rng, fusion=fusion), rng)
        told = []
        for second in range(4):
            virtual.point(float(second), (1.5, 0.4 * second - 0.5, 0.7))
            for k in range(round(1.0 / block)):
                told += band.advance(second + (k + 1) * block, virtual)
        return told

    whole = run(0.05)
    assert len(whole) > 380
    assert run(0.01) == whole
    assert run(0.25) == whole


def test_equal_seeds_make_equal_samples():
    def run(seed):
        rng = np.random.default_rng(seed)
        return VirtualBand("b", "upperarm", draw_band(rng), rng).advance(2.0, still("x", 10.0))

    assert run(1) == run(1)
    assert run(1) != run(2)


def test_bands_are_worn_as_people_wear_them():
    rng = np.random.default_rng(6)
    for upside_down, sign in ((False, 1.0), (True, -1.0)):
        along, roll = [], []
        for _ in range(200):
            worn = matrix(draw_band(rng, upside_down=upside_down).segment_from_sensor)
            along.append(sign * worn[0, 0])
            roll.append(np.arctan2(worn[2, 2], worn[1, 2]))
        assert min(along) > np.cos(np.radians(16.0))
        assert 1.0 < np.degrees(np.arccos(np.clip(along, -1.0, 1.0))).mean() < 6.0
        assert np.histogram(roll, 4, (-np.pi, np.pi))[0].min() > 30
