import numpy as np
import pytest

from armspan.records import Calibrated, Pointed, Press, RobotState, Selected, Zone
from armspan.study.trials import read_trials, summary, zone_middle

GARDEN = Zone("garden", ((0.2, 0.2), (0.4, 0.2), (0.4, 0.4), (0.2, 0.4)))
COVARIANCE = ((0.03**2, 0.0), (0.0, 0.03**2))
PLACE = Calibrated(0.0, "wrist", (0.45, 0.9, 0.75), 1.57, (0.0,) * 16, 0.01, 0.02, 4)
ROBOT = RobotState(0.0, "amber", (0.5, 0.3), 0.0)


def pointed(t, xy, robot=None, zone=None, probability=0.9):
    return Pointed(t, "wrist", xy, COVARIANCE if xy else None, robot, zone, probability)


def read(*records):
    return read_trials([PLACE, ROBOT, *records], [GARDEN], 1.6, 0.045)


def test_a_right_choice():
    (trial,), unasked = read(
        Press(1.0, "trial", "robot:amber"),
        pointed(1.5, (0.53, 0.34), "amber"),
        pointed(2.5, (0.53, 0.34), "amber"),
        Selected(2.5, "wrist", "amber", None, 0.93, "dwell"),
        pointed(2.6, (0.8, 0.1)),  # after the choice: of no matter
        Press(2.7, "trial", ""),
    )
    assert unasked == 0
    assert (trial.chosen, trial.right, trial.decided) == ("robot:amber", True, True)
    assert trial.miss == pytest.approx(0.05)
    assert trial.seconds == pytest.approx(1.5)
    assert trial.probability == 0.93
    assert trial.inside_90  # (30, 40) mm at 30 mm: squared 2.78 < 4.605


def test_the_angle_is_that_seen_from_the_eye():
    """The eye is 0.85 m above the sheet at (0.45, 0.9); a robot's light 45 mm above it."""
    (trial,), _ = read(Press(1.0, "trial", "robot:amber"), pointed(2.0, (0.6, 0.3), "amber"), Press(3.0, "trial", ""))
    eye = np.array([0.45, 0.9, -0.85])
    a, b = np.array([0.6, 0.3, -0.045]) - eye, np.array([0.5, 0.3, -0.045]) - eye
    cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
    assert trial.angle == pytest.approx(np.arccos(cosine))


def test_an_undecided_trial_takes_the_mean_of_the_last_half_second():
    (trial,), _ = read(
        Press(1.0, "trial", "zone:garden"),
        pointed(1.2, (0.9, 0.9), zone="garden"),
        pointed(6.6, (0.30, 0.34), zone="garden", probability=0.5),
        pointed(6.9, (0.34, 0.30), robot="amber", probability=0.6),
        Press(7.0, "trial", "zone:garden"),
    )
    assert trial.spot == pytest.approx((0.32, 0.32))
    assert (trial.decided, trial.best, trial.probability) == (False, "robot:amber", 0.6)
    assert trial.seconds == pytest.approx(6.0)


def test_a_wrong_choice_a_choice_twice_and_one_unasked():
    trials, unasked = read(
        Selected(0.5, "wrist", "amber", None, 0.9, "tap"),
        Press(1.0, "trial", "zone:garden"),
        Selected(2.0, "wrist", "amber", None, 0.9, "dwell"),
        Selected(3.0, "wrist", None, "garden", 0.9, "dwell"),
        Press(4.0, "trial", ""),
    )
    assert [(t.decided, t.right) for t in trials] == [(True, False)]
    assert unasked == 2


def test_no_spot_is_no_miss():
    (trial,), _ = read(
        Press(1.0, "trial", "zone:garden"),
        Pointed(2.0, "wrist", None, None, refused="stale"),
        Press(3.0, "trial", ""),
    )
    assert trial.spot is trial.miss is trial.angle is trial.inside_90 is None
    assert summary([trial])["median_mm"] is None


def test_feedback_is_that_of_the_moment_and_the_summary_counts():
    trials, _ = read(
        Press(1.0, "trial", "robot:amber"),
        pointed(1.5, (0.51, 0.3), "amber"),
        Press(2.0, "trial", ""),
        Press(2.0, "feedback", "on"),
        Press(2.1, "trial", "robot:amber"),
        pointed(2.5, (0.50, 0.33), "amber"),
        Selected(2.6, "wrist", "amber", None, 0.9, "dwell"),
        Press(3.0, "trial", ""),
    )
    assert [t.feedback for t in trials] == [False, True]
    told = summary(trials)
    assert (told["trials"], told["decided"], told["right"]) == (2, 1, 1)
    assert told["median_mm"] == pytest.approx(20.0)


def test_a_target_that_this_room_does_not_have_is_passed_over():
    trials, unasked = read(Press(1.0, "trial", "zone:moon"), pointed(1.5, (0.5, 0.3), "amber"), Press(2.0, "trial", ""))
    assert (trials, unasked) == ([], 0)


def test_the_middle_of_a_zone():
    assert zone_middle(GARDEN) == pytest.approx((0.3, 0.3))


def test_a_robot_is_where_it_was_when_it_was_chosen():
    (trial,), _ = read(
        Press(1.0, "trial", "robot:amber"),
        pointed(2.0, (0.5, 0.31), "amber"),
        Selected(2.0, "wrist", "amber", None, 0.9, "dwell"),
        RobotState(2.1, "amber", (0.6, 0.3), 0.0),
        Press(2.2, "trial", ""),
    )
    assert trial.miss == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("off", "inside"), [((21.4, 0), True), ((21.6, 0), False), ((0, 42.7), True), ((0, 43), False)]
)
def test_the_ellipse_of_90_percent(off, inside):
    # 90 % of normal spots lie within sqrt(-2 ln 0.1) = 2.146 standard deviations: here of 10 mm in x, 20 mm in y.
    spot = (0.3 + off[0] / 1000, 0.3 + off[1] / 1000)
    flat = Pointed(2.0, "wrist", spot, ((1e-4, 0.0), (0.0, 4e-4)))
    (trial,), _ = read(Press(1.0, "trial", "zone:garden"), flat, Press(3.0, "trial", ""))
    assert trial.inside_90 is inside


def test_the_middle_of_a_bent_zone_is_its_areas_not_its_corners():
    corners = ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))  # three unit squares
    for order in (corners, corners[::-1]):
        assert zone_middle(Zone("L", order)) == pytest.approx((2.5 / 3, 2.5 / 3))
