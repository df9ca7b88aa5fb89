import numpy as np
import pytest

from armspan.records import RobotState
from armspan.simulation.reading import read_cursor
from armspan.swarm.lights import CHOSEN, ring_toward

DARK = np.zeros((6, 3))
GREEN, YELLOW, ORANGE, RED = (0, 1, 0), (1, 1, 0), (1, 0.39, 0), (1, 0, 0)


def ring(colour, led=None):
    lit = DARK.copy()
    lit[slice(None) if led is None else led] = colour
    return lit


def read(*robots, target, seed=0):
    """Where the cursor seems to be, for robots as (lights, xy, heading)."""
    lights, xy, heading = (np.array(part, dtype=float) for part in zip(*robots, strict=True))
    return read_cursor(lights, xy, heading, np.array(target, dtype=float), np.random.default_rng(seed))


def often(*robots, target):
    """The mean over many readers: the misjudgements go away."""
    return np.mean([read(*robots, target=target, seed=seed) for seed in range(60)], axis=0)


def test_dark_and_chosen_robots_tell_nothing():
    assert read((DARK, (0.3, 0.3), 0.0), target=(0.3, 0.3)) is None
    assert read((ring((0, 0, 1)), (0.3, 0.3), 0.0), target=(0.3, 0.3)) is None
    assert read((ring((0.3, 0.3, 0)), (0.3, 0.3), 0.0), target=(0.3, 0.3)) is None  # too dim to see


def test_green_all_round_means_on_this_robot():
    where = often((ring(GREEN), (0.3, 0.3), 1.0), target=(0.3, 0.3))
    assert np.hypot(*(where - (0.3, 0.3))) < 0.01
    where = often((ring(GREEN), (0.45, 0.3), 1.0), target=(0.3, 0.3))
    assert np.hypot(*(where - (0.45, 0.3))) < 0.03  # and not where it should be


@pytest.mark.parametrize(("led", "way"), [(0, (1, 0)), (3, (-1, 0)), (1, (0.5, 0.866)), (5, (0.5, -0.866))])
def test_one_light_tells_the_side_clockwise_from_the_front(led, way):
    # y grows downwards, so clockwise from above is from x to y
    where = often((ring(ORANGE, led), (0.3, 0.3), 0.0), target=(0.3, 0.3))
    away = where - (0.3, 0.3)
    assert away @ np.array(way) / np.hypot(*away) > 0.85
    assert 0.04 < np.hypot(*away) < 0.12


def test_the_robots_heading_turns_the_side():
    away = often((ring(ORANGE, 0), (0.3, 0.3), np.pi / 2), target=(0.3, 0.3)) - (0.3, 0.3)
    assert away[1] > 3 * abs(away[0])


def test_colours_tell_how_far():
    far = [
        np.hypot(*(often((ring(colour, 0), (0.3, 0.3), 0.0), target=(0.3, 0.3)) - (0.3, 0.3)))
        for colour in (YELLOW, ORANGE, RED)
    ]
    assert 0.0 <= far[0] < far[1] < far[2] < 0.25


def test_lights_that_look_as_they_should_leave_the_cursor_on_the_target():
    # the target is 9 cm ahead of the robot, whose front light is orange: six to twelve centimetres
    where = often((ring(ORANGE, 0), (0.3, 0.3), 0.0), target=(0.39, 0.3))
    assert np.hypot(*(where - (0.39, 0.3))) < 0.012


def test_a_dark_robot_nearby_tells_too():
    lit = (ring(ORANGE, 0), (0.3, 0.3), 0.0)
    alone = often(lit, target=(0.3, 0.3))
    beside = often(lit, (DARK, (0.3, 0.45), 0.0), target=(0.3, 0.3))
    assert beside[1] < alone[1] + 0.005
    assert np.hypot(*(beside - (0.3, 0.45))) > np.hypot(*(alone - (0.3, 0.45))) - 0.005


def test_one_seed_is_one_reading():
    robot = (ring(RED, 2), (0.3, 0.3), 0.4)
    assert (read(robot, target=(0.3, 0.3)) == read(robot, target=(0.3, 0.3))).all()
    assert (read(robot, target=(0.3, 0.3)) != read(robot, target=(0.3, 0.3), seed=1)).any()


@pytest.mark.parametrize("distance", [0.01, 0.04, 0.09, 0.18])
def test_the_lights_of_the_swarm_are_understood(distance):
    """What the cursor's lights say is read back by a person who was told the rule and nothing else."""
    for angle in np.radians([0, 45, 130, 250]):
        robot = np.array([0.4, 0.3])
        cursor = robot + distance * np.array([np.cos(angle), np.sin(angle)])
        lights = np.array(ring_toward(tuple(cursor), RobotState(0.0, "a", tuple(robot), 0.7))) / 255
        where = often((lights, robot, 0.7), target=tuple(cursor))
        assert np.hypot(*(where - cursor)) < 0.03
    assert CHOSEN == (0, 0, 255)
