import numpy as np
import pytest

from armspan.records import RobotState, Sheet
from armspan.swarm.errands import Errands
from armspan.swarm.limits import Limits


def drive(start, goal, others=(), seconds=20.0):
    """An ideal robot that always reaches the goal it was sent last, at 0.15 m/s; its path (n, 2)."""
    errands, here, aim = Errands(Limits(), Sheet(0.9, 0.6)), np.array(start), np.array(start)
    errands.send("a", goal)
    path = [here.copy()]
    for k in range(int(seconds * 20)):
        t = k / 20
        states = {"a": RobotState(t, "a", tuple(here), 0.0)}
        states |= {f"o{j}": RobotState(t, f"o{j}", xy, 0.0) for j, xy in enumerate(others)}
        commands = errands.step(t, states)
        if not errands.goals:
            return np.array(path), k / 20
        for command in commands:
            assert command.until - command.t <= 0.3 + 1e-9
            aim = np.array(command.xy)
        way = aim - here
        here = here + way * min(1.0, 0.15 / 20 / max(np.linalg.norm(way), 1e-12))
        path.append(here.copy())
    return np.array(path), None


def test_a_free_way_is_straight_and_ends_at_the_goal():
    path, done = drive((0.1, 0.1), (0.6, 0.1))
    assert done is not None
    assert path[-1] == pytest.approx([0.6, 0.1], abs=0.006)
    assert np.abs(path[:, 1] - 0.1).max() < 1e-9


def test_a_robot_in_the_way_is_driven_round():
    path, done = drive((0.1, 0.3), (0.7, 0.3), others=[(0.4, 0.3)])
    assert done is not None
    assert np.linalg.norm(path - [0.4, 0.3], axis=1).min() > 2 * 0.045


def test_ten_commands_a_second_and_none_without_errands():
    errands = Errands(Limits(), Sheet(0.9, 0.6))
    errands.send("a", (0.5, 0.5))
    states = {"a": RobotState(0.0, "a", (0.1, 0.1), 0.0)}
    assert sum(len(errands.step(k / 20, states)) for k in range(20)) == 10
    errands.cancel()
    assert errands.step(2.0, states) == []
    assert errands.arrived("a", states)
