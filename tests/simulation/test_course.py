"""Pieces of movement: smooth, at their place, and gone afterwards."""

import numpy as np
import pytest

from armspan.simulation.course import Course, Piece, Wave

HANG = np.zeros((2, 7))
THERE = np.tile([0.0, 1.0, 0.0, 0.5, 0.0, 0.0, 0.0], (2, 1))
TIMES = np.arange(0.0, 6.0, 0.001)


def course(*pieces, noise=0.0):
    made = Course(HANG, noise, np.random.default_rng(0))
    for piece in pieces:
        made.add(piece)
    return made


def held(start=1.0, **more):
    return Piece(THERE, (start, start + 0.1), (0.5, 0.5), (start + 2.0, start + 2.0), (0.5, 0.6), **more)


def roughness(angles):
    """The greatest leap of the second derivative between two milliseconds."""
    acceleration = np.diff(angles, 2) / 0.001**2
    return float(np.abs(np.diff(acceleration)).max())


def test_an_arm_goes_there_and_comes_back():
    left, right = (course(held()).at(arm, TIMES)[1] for arm in (0, 1))
    assert (left[TIMES <= 1.0] == 0.0).all()
    assert left[(TIMES > 1.51) & (TIMES < 2.99)] == pytest.approx(1.0)
    assert left[TIMES > 3.51] == pytest.approx(0.0)
    assert left[1250] == pytest.approx(0.5)  # half the way at half the time
    assert right[1350] == pytest.approx(0.5)
    assert (held().begun, held().over) == (1.0, 3.6)


def test_it_oscillates_where_it_is():
    sine = np.zeros((2, 7))
    sine[:, 1] = 0.2
    piece = held(waves=(Wave(np.zeros((2, 7)), sine),), rate=(2.0, 2.0), phase=(0.0, np.pi))
    left, right = (course(piece).at(arm, np.array([1.625, 2.125, 2.25]))[1] for arm in (0, 1))
    assert left == pytest.approx((1.2, 1.2, 1.0))
    assert right == pytest.approx(1.0 + 0.2 * np.sin(4 * np.pi * (np.array([1.625, 2.125, 2.25]) - 1.1) + np.pi))


def test_a_detour_is_made_on_the_ways_only():
    via = np.zeros((2, 7))
    via[:, 0] = -0.6
    plane = course(held(via=via)).at(0, TIMES)[0]
    assert plane[1250] == pytest.approx(-0.6)
    assert plane[3250] == pytest.approx(-0.6)
    assert np.abs(plane[(TIMES > 1.5) & (TIMES < 3.0)]).max() < 1e-12


def test_an_idle_arm_hangs():
    piece = held(share=(0.0, 1.0))
    assert (course(piece).at(0, TIMES) == 0.0).all()
    assert piece.begun == 1.1


@pytest.mark.parametrize("cut", [1.1, 1.3, 2.0, 3.2])
def test_it_is_twice_differentiable_also_when_broken_off(cut):
    # A minimum-jerk way of 1 rad in 0.5 s has a jerk of at most 480 rad/s³ = 0.48 rad/s² a millisecond; two
    # ways at once have twice that. A leap of the acceleration itself would be tens of rad/s².
    made = course(held(), held(start=1.6))
    made.cut(cut)
    for arm in (0, 1):
        assert roughness(made.at(arm, TIMES)[1]) < 1.0
    assert made.at(0, np.array([cut + 1.2]))[1] == pytest.approx(0.0, abs=1e-9)


def test_what_was_to_follow_is_given_up():
    made = course(held(), held(start=4.0))
    made.cut(2.0)
    assert (made.at(0, np.array([5.0])) == 0.0).all()


def test_only_a_moving_arm_errs():
    made = course(held(), noise=0.05)
    angles = made.at(0, TIMES)[1]
    assert (angles[TIMES <= 1.0] == 0.0).all()
    assert 0.01 < np.std(angles[(TIMES > 1.6) & (TIMES < 2.9)]) < 0.15


def test_what_is_over_is_forgotten():
    made = course(held(), held(start=4.0))
    before = made.at(0, TIMES[TIMES > 3.7])
    made.forget(3.7)
    assert (made.at(0, TIMES[TIMES > 3.7]) == before).all()
    assert made.at(0, np.array([2.0]))[1] == 0.0
