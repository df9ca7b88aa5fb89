"""Simulated takes: complete, true to their truth, and the same for the same seed."""

import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.frames import rotation_from_quaternion
from armspan.simulation.gesture_styles import LABELS
from armspan.simulation.takes import simulate_everyday, simulate_takes


@pytest.fixture(scope="module")
def takes():
    return simulate_takes(np.random.default_rng(1), persons=2, takes=2, everyday_s=8.0)


def test_every_person_performs_every_gesture_as_often_as_asked(takes):
    made = sorted((take.person, take.label, take.number) for take in takes)
    gestures = [(person, label, number) for person in (0, 1) for label in LABELS[1:] for number in (0, 1)]
    assert made == sorted([*gestures, (0, "null", 0), (1, "null", 0)])
    assert [take.label for take in takes[:7]] != [take.label for take in takes[7:14]]


def test_both_bands_are_there_before_and_after(takes):
    for take in takes[:14]:
        assert set(take.samples) == {"left", "right"}
        for name, samples in take.samples.items():
            times = [sample.t for sample in samples]
            assert {sample.source for sample in samples} == {name}
            assert np.all(np.diff(times) > 0)
            assert 0.95 < take.start - times[0] < 2.1
            assert 0.95 < times[-1] - take.end < 2.05
            assert len(samples) == pytest.approx(100 * (times[-1] - times[0]), rel=0.04)  # 1 % is lost


def test_what_is_felt_is_in_the_stretch_that_is_told(takes):
    for take in takes[:14]:
        rates = {True: [], False: []}
        for samples in take.samples.values():
            for sample in samples:
                rates[take.start <= sample.t <= take.end].append(np.linalg.norm(sample.gyr))
        assert np.mean(rates[True]) > 5 * np.mean(rates[False])


def test_the_set_up_is_held_still_and_level_and_hanging(takes):
    for setup in {id(take.setup): take.setup for take in takes}.values():
        for name in ("left", "right"):
            stretched, hanging = (
                np.mean([sample.acc for sample in samples[name]], axis=0)
                for samples in (setup.stretched, setup.hanging)
            )
            assert len(setup.stretched[name]) > 90
            assert np.linalg.norm(stretched) == pytest.approx(9.81, abs=0.3)
            cosine = stretched @ hanging / np.linalg.norm(stretched) / np.linalg.norm(hanging)
            assert abs(np.degrees(np.arccos(cosine)) - 90) < 15


def test_bands_stay_as_they_were_put_on(takes):
    # The hanging arm before a gesture feels gravity on the side of the band on which it was in the set-up.
    for take in takes[:14]:
        for name, samples in take.samples.items():
            before = np.mean([sample.acc for sample in samples[:30]], axis=0)
            hanging = np.mean([sample.acc for sample in take.setup.hanging[name]], axis=0)
            cosine = before @ hanging / np.linalg.norm(before) / np.linalg.norm(hanging)
            assert np.degrees(np.arccos(cosine)) < 35


def test_a_fused_attitude_agrees_with_gravity(takes):
    sample = takes[0].setup.hanging["left"][50]
    up = rotation_from_quaternion(sample.quat) @ np.array(sample.acc)
    assert up == pytest.approx((0.0, 0.0, 9.81), abs=0.6)


def test_one_seed_gives_one_set_and_raw_bands_no_attitude(takes):
    again = simulate_takes(np.random.default_rng(1), persons=2, takes=2, everyday_s=8.0)
    assert [take.samples for take in again] == [take.samples for take in takes]
    [raw] = simulate_takes(np.random.default_rng(1), takes=1, labels=("stop",), fusion="raw")
    assert raw.samples["left"][0].quat is None


def test_everyday_motion_is_as_long_as_asked():
    [one, two] = simulate_everyday(np.random.default_rng(4), 30.0, persons=2)
    for take in (one, two):
        times = [sample.t for sample in take.samples["right"]]
        assert take.label == "null"
        assert times[-1] - times[0] == pytest.approx(30.0, abs=0.1)
        assert np.std([np.linalg.norm(sample.gyr) for sample in take.samples["right"]]) > 0.2
    assert one.samples != two.samples


@pytest.mark.parametrize(
    "wanted",
    [{"persons": 0}, {"takes": 0}, {"labels": ("mixing", "wave")}, {"amplitude": -1.0}],
)
def test_what_cannot_be_made_is_refused(wanted):
    with pytest.raises(ConfigError):
        simulate_takes(np.random.default_rng(0), **wanted)
    with pytest.raises(ConfigError):
        simulate_everyday(np.random.default_rng(0), 0.0)
