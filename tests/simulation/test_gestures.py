"""The seven gestures as seen from outside: where hands are, how often they circle, how people and takes differ."""

import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.simulation.gesture_styles import CYCLIC, LABELS, draw_style, draw_take
from two_arms import both, climbs, drawn

STATIC = [label for label in LABELS if label not in (*CYCLIC, "initial")]
PEOPLE = range(24)


@pytest.fixture(scope="module")
def seen():
    """For every gesture and person: what was performed, and both arms' poses while it lasts, every 20 ms."""
    shown = {}
    for seed in PEOPLE:
        person, t = drawn(seed), 1.0
        for label in LABELS:
            told = person.perform(t, label)
            shown[label, seed] = told, *both(person, np.arange(told.reached, told.left, 0.02))
            t = told.end + 0.5
    return shown


def median(seen, label, measure):
    """The median over people of what is measured at (left, right)."""
    return float(np.median([measure(left, right) for _, left, right in (seen[label, seed] for seed in PEOPLE)]))


def height(pose):
    """Of the wrist above the shoulder."""
    return float((pose.wrist - pose.shoulder)[:, 2].mean())


def test_hanging(seen):
    assert median(seen, "initial", lambda left, right: max(height(left), height(right))) < -0.4
    assert median(seen, "initial", lambda left, right: np.ptp(left.wrist, axis=0).max()) < 0.06


@pytest.mark.parametrize(("label", "sign"), [("x_left_high", 1), ("x_right_high", -1)])
def test_a_diagonal_has_the_named_side_high(seen, label, sign):
    for seed in PEOPLE:
        _, left, right = seen[label, seed]
        assert sign * (height(left) - height(right)) > 0.15, seed
    assert median(seen, label, lambda left, right: sign * (height(left) - height(right))) > 0.5
    # Both point away from the body, and the arms are about straight.
    assert median(seen, label, lambda left, right: left.wrist[:, 1].mean() - right.wrist[:, 1].mean()) > 0.8
    reach = median(seen, label, lambda left, right: np.linalg.norm(left.wrist - left.shoulder, axis=1).mean())
    assert reach > 0.45


def test_raised_arms_make_a_v(seen):
    assert median(seen, "raise_both", lambda left, right: min(height(left), height(right))) > 0.3
    hands = median(seen, "raise_both", lambda left, right: (left.wrist - right.wrist)[:, 1].mean())
    shoulders = median(seen, "raise_both", lambda left, right: (left.shoulder - right.shoulder)[:, 1].mean())
    assert hands > 1.5 * shoulders


def test_stop_crosses_the_forearms_before_the_face(seen):
    crossed = [np.mean((left.fingertip - right.fingertip)[:, 1]) < 0 for _, left, right in of(seen, "stop")]
    assert np.mean(crossed) > 0.75
    for _, left, right in of(seen, "stop"):
        hands = (left.fingertip + right.fingertip) / 2 - left.eye
        assert hands[:, 0].mean() > 0.0  # before, not behind
    assert abs(median(seen, "stop", lambda left, right: (left.fingertip - left.eye)[:, 2].mean())) < 0.15
    assert 25 < median(seen, "stop", lambda left, right: climbs(left).mean()) < 70


def of(seen, label):
    return [seen[label, seed] for seed in PEOPLE]


def test_mixing_is_before_the_belly(seen):
    assert -0.35 < median(seen, "mixing", lambda left, right: height(left)) < -0.1
    assert median(seen, "mixing", lambda left, right: (left.wrist - left.eye)[:, 0].mean()) > 0.1
    assert median(seen, "mixing", lambda left, right: (left.wrist - right.wrist)[:, 1].mean()) < 0.35


def test_arms_to_ground_are_low(seen):
    assert median(seen, "arms_to_ground", lambda left, right: max(height(left), height(right))) < -0.35
    assert median(seen, "arms_to_ground", lambda left, right: climbs(left).mean()) < -35


def test_the_breaststroke_has_its_elbows_at_shoulder_height_and_sweeps_far(seen):
    def elbows(left, right):
        return (left.elbow - left.shoulder)[:, 2].mean()

    assert abs(median(seen, "breaststroke", elbows)) < 0.1
    assert median(seen, "breaststroke", lambda left, right: np.ptp(left.wrist[:, 0])) > 0.2
    assert median(seen, "breaststroke", lambda left, right: np.ptp(left.wrist[:, 1])) > 0.2


@pytest.mark.parametrize("label", STATIC)
def test_static_ones_are_held(seen, label):
    for told, left, right in of(seen, label):
        assert 0.75 <= told.left - told.reached <= 2.1
        assert np.ptp(left.wrist, axis=0).max() < 0.15
        assert np.ptp(right.wrist, axis=0).max() < 0.15


@pytest.mark.parametrize("label", CYCLIC)
def test_cyclic_ones_circle(seen, label):
    rates = []
    for told, *arms in of(seen, label):
        assert 1.0 < told.left - told.reached < 4.5
        for pose in arms:
            assert np.ptp(pose.wrist, axis=0).max() > 0.06
            rates.append(turns(pose.wrist) / (told.left - told.reached))
    # A few people's circle is bent so much that it does not go round its own middle.
    assert np.mean([0.6 < rate < 1.6 for rate in rates]) > 0.85


def turns(path):
    """How often a path (m, 3) goes round its middle, in the plane in which it mostly lies."""
    centred = path - path.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    angle = np.unwrap(np.arctan2(centred @ axes[1], centred @ axes[0]))
    return abs(angle[-1] - angle[0]) / 2 / np.pi


def test_nobody_does_it_like_another_nor_twice_alike():
    elevation = {}
    for seed in range(8):
        person, t = drawn(seed), 1.0
        for k in range(10):
            told = person.perform(t, "x_right_high")
            elevation[seed, k] = climbs(both(person, [(told.reached + told.left) / 2])[1])[0]
            t = told.end + 0.3
    table = np.array([[elevation[seed, k] for k in range(3, 10)] for seed in range(8)])
    within, between = table.std(axis=1).mean(), table.mean(axis=1).std()
    assert 3 < within < 12
    assert between > within


def style_of_takes(before, alike, seed=3):
    """The mean take after so many others."""
    style, rng = draw_style(np.random.default_rng(seed)), np.random.default_rng(0)
    takes = [draw_take(style, before, alike, "mixing", rng) for _ in range(400)]
    angles = np.mean([take.joints[:, :5] for take in takes], axis=0)
    return np.mean([take.tempo for take in takes]), np.mean([take.amplitude for take in takes]), angles


def test_first_takes_are_slower_and_otherwise_and_last_ones_tired():
    first, third, settled = (style_of_takes(k, k) for k in (0, 2, 8))
    tired = style_of_takes(200, 50)
    assert first[0] < settled[0]
    assert tired[0] < 0.95 * settled[0]
    assert tired[1] < settled[1]
    far = [np.abs(angles - settled[2]).mean() for _, _, angles in (first, third)]
    assert far[0] > 3 * far[1] > 0


def test_takes_vary_by_a_tenth_or_so():
    style, rng = draw_style(np.random.default_rng(1)), np.random.default_rng(2)
    takes = [draw_take(style, 20, 10, "stop", rng) for _ in range(500)]
    for values in ([take.amplitude for take in takes], [take.tempo for take in takes]):
        assert 0.10 < np.std(values) / np.mean(values) < 0.15
    onsets = np.array([abs(np.subtract(*take.onset)) for take in takes])
    assert 0.02 <= np.median(onsets) <= 0.08
    assert all(min(take.onset) == 0.0 for take in takes)


def test_a_limited_range_is_lower():
    def highest(amplitude):
        style = draw_style(np.random.default_rng(7), amplitude=amplitude)
        person = drawn(7, style=style)
        told = person.perform(1.0, "raise_both")
        return height(both(person, [(told.reached + told.left) / 2])[0])

    assert highest(0.5) < highest(0.75) < highest(1.0)
    assert highest(0.5) < 0.0


def test_what_is_no_gesture_or_no_amplitude_is_refused():
    with pytest.raises(ConfigError, match="breaststroke"):
        drawn(0).perform(1.0, "brestroke")
    with pytest.raises(ConfigError, match="amplitude 0"):
        draw_style(np.random.default_rng(0), amplitude=0.0)
