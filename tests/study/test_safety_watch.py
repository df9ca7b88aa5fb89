import pytest

from armspan.records import Drive, GoTo, Press, RobotState, Sheet, Stop
from armspan.study.safety import BODY, watch
from armspan.swarm.limits import Limits

SHEET, LIMITS = Sheet(0.9, 0.6), Limits()


def at(xy, t=0.0, robot="a", held=False):
    return RobotState(t, robot, xy, 0.0, held=held)


def go(xy=(0.53, 0.3), t=0.0, speed=0.1, lease=0.3):
    return GoTo(t, "a", xy, speed, t + lease)


def kinds(*records):
    return watch(records, LIMITS, SHEET).violations


def test_a_proper_session_has_none():
    assert kinds(at((0.5, 0.3)), go(), at((0.503, 0.3), 0.02), at((0.7, 0.3), 0.0, "b"), Stop(1.0)) == {}


@pytest.mark.parametrize(
    ("records", "what"),
    [
        ((at((0.5, 0.3)), go(speed=0.2)), "speed above the cap"),
        ((at((0.5, 0.3)), go(lease=0.5)), "lease too long"),
        ((at((0.86, 0.3)), go((0.88, 0.3))), "goal off the sheet"),
        ((at((0.5, 0.3)), Stop(0.0), go(t=0.1)), "motion after stop"),
        ((at((0.5, 0.3), held=True), go()), "motion of a held robot"),
        ((at((0.5, 0.3)), go((0.7, 0.3))), "goal too far ahead"),
        ((Drive(0.0, "a", (0.1, 0.0), 0.0, 0.3),), "open-ended velocity"),
        ((at((0.95, 0.3)),), "robot off the sheet"),
        ((at((0.5, 0.3)), at((0.51, 0.3), 0.02)), "robot too fast"),
        ((at((0.5, 0.3)), at((0.58, 0.3), 0.0, "b")), "robots touch"),
    ],
)
def test_each_violation_is_seen(records, what):
    assert kinds(*records) == {what: 1}


def test_a_resume_allows_motion_again_and_a_single_stop_latches_nothing():
    assert kinds(at((0.5, 0.3)), Stop(0.0), Press(0.1, "resume"), go(t=0.2)) == {}
    assert kinds(at((0.5, 0.3)), Stop(0.0, "a"), go(t=0.2)) == {}


def test_the_least_gap_is_between_bodies():
    safety = watch([at((0.2, 0.3)), at((0.4, 0.3), 0.0, "b"), at((0.3, 0.45), 0.0, "c")], LIMITS, SHEET)
    assert safety.least_gap == pytest.approx(0.18028 - 2 * BODY, abs=1e-4)


def test_held_robots_are_in_nobodys_way():
    assert kinds(at((0.5, 0.3)), at((0.52, 0.3), 0.0, "b", held=True)) == {}
