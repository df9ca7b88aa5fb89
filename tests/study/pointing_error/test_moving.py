import numpy as np
import pytest

from armspan.study.pointing_error.monte_carlo import TABLE
from armspan.study.pointing_error.moving import CHOICES, miss_by_speed, real, robot_speed, simulated, speed
from armspan.study.pointing_error.recordings import Following
from straight_arms import BODY, pointing_at

RATE = 0.2
"""The robot flies round the person at this rate [rad/s]."""


def session(seconds=60.0, off=0.0):
    """A robot that circles at 2 m, slowly and by turns closer and farther below the eye, and a flawless arm."""
    times = np.arange(0.0, seconds, 0.1)
    turn = RATE * times
    points = np.column_stack([2.0 * np.cos(turn), 2.0 * np.sin(turn), 0.5 + 0.3 * np.sin(0.9 * turn)])
    head = np.tile([0.0, 0.0, BODY.eye_height_m], (len(times), 1))
    return Following(BODY, times, pointing_at(points), points, head + np.array([off, 0.0, 0.0]))


def level_circle():
    times = np.arange(0.0, 20.0, 0.1)
    turn = RATE * times
    points = np.column_stack([2.0 * np.cos(turn), 2.0 * np.sin(turn), 0.0 * turn + BODY.eye_height_m - 1.0])
    head = np.tile([0.0, 0.0, BODY.eye_height_m], (len(times), 1))
    return Following(BODY, times, pointing_at(points), points, head)


def test_speeds_of_a_circle():
    """Level, at radius 2 m and 1 m below: the view turns by the rate times the cosine of its slope."""
    inner = slice(3, -3)
    assert robot_speed(level_circle())[inner] == pytest.approx(2.0 * RATE, rel=1e-3)
    assert speed(level_circle())[inner] == pytest.approx(RATE * 2.0 / np.sqrt(5.0), rel=1e-3)


def test_choices_take_what_they_say():
    flown = session()
    rows = np.arange(100, 400)
    chosen = {name: choose(flown, rows) for name, choose in CHOICES}
    assert chosen["all samples"].tolist() == rows.tolist()
    assert len(chosen["one a second"]) in (30, 31)
    assert np.diff(flown.times[chosen["one a second"]]) == pytest.approx(1.0, abs=0.11)
    for name in ("arm slowest third", "robot slowest third"):
        pace = speed(flown) if name.startswith("arm") else robot_speed(flown)
        assert len(chosen[name]) == 100
        left_out = np.setdiff1d(rows, chosen[name])
        assert pace[chosen[name]].max() <= pace[left_out].min()
        fast = chosen[name.replace("slowest", "fastest")]
        assert pace[fast].min() >= pace[np.setdiff1d(rows, fast)].max()


def test_like_distances_hold_near_and_far_alike():
    flown = session()
    rows = np.arange(50, 550)
    away = np.linalg.norm(flown.points - flown.head, axis=1)
    chosen = {name: choose(flown, rows) for name, choose in CHOICES}
    slow = away[chosen["arm slowest third, like distances"]].mean()
    fast = away[chosen["arm fastest third, like distances"]].mean()
    plain = away[chosen["arm slowest third"]].mean() - away[chosen["arm fastest third"]].mean()
    assert abs(slow - fast) < 0.3 * abs(plain)


def test_a_flawless_session_places_the_head_by_every_choice():
    for row in real([session()], np.random.default_rng(0), segments=2):
        assert row.fits + row.refused == 2
        if row.fits:
            assert row.head < 1e-6
            assert row.angle < 1e-6


def test_the_head_is_told_from_where_it_was():
    rows = real([session(off=0.3)], np.random.default_rng(0), segments=2)
    assert {round(row.head, 4) for row in rows if row.fits} == {0.3}
    assert rows[0].document()["head_mm"] == pytest.approx(300.0, abs=0.1)


def test_a_segment_that_falls_into_a_gap_counts_as_refused():
    whole = session(60.0)
    kept = (whole.times < 1.0) | (whole.times > 59.0)
    gappy = Following(BODY, *(part[kept] for part in (whole.times, whole.forearm, whole.points, whole.head)))
    rows = real([gappy], np.random.default_rng(0), segments=4)
    assert all(row.fits + row.refused == 4 for row in rows)
    assert max(row.refused for row in rows if row.seconds == 5.0) >= 3  # two seconds of sixty are there


def test_a_flawless_arm_misses_at_no_speed():
    parts = miss_by_speed([session()])
    assert [pace for pace, _ in parts] == sorted(pace for pace, _ in parts)
    assert max(angle for _, angle in parts) < 1e-6


def test_virtual_people_follow_and_stop():
    rows = simulated(TABLE, np.random.default_rng(0), people=2)
    assert len(rows) == 2 * 6
    assert {row.seconds for row in rows if row.pairs == "4 stops"} == {4 * 4.0 + 12.0}  # 1.6 m at 0.1 m/s, 4 holds
    assert all(0.0 < row.median < 0.4 for row in rows)
    assert rows[0].document()["median_mm"] == pytest.approx(1000.0 * rows[0].median)
    assert rows == simulated(TABLE, np.random.default_rng(0), people=2)
