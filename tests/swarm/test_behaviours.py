from itertools import pairwise

import numpy as np
import pytest

from armspan.records import RobotState, Sheet
from armspan.swarm.behaviours import GATHER, RANDOM_WALK, STOP, Behaviours
from armspan.swarm.errands import Errands
from armspan.swarm.limits import Limits
from armspan.swarm.safety import SafetyFilter

SHEET, LIMITS = Sheet(0.9, 0.6), Limits()
START = {"a": (0.1, 0.1), "b": (0.8, 0.1), "c": (0.8, 0.5), "d": (0.1, 0.5)}


def states_at(t: float, places: dict[str, tuple[float, float]]) -> dict[str, RobotState]:
    return {name: RobotState(t, name, xy, 0.0) for name, xy in places.items()}


def play(name: str, seconds: float, seed: int = 0) -> list[dict[str, tuple[float, float]]]:
    """Robots that drive exactly where the last filter lets them, ten times a second."""
    errands = Errands(LIMITS, SHEET)
    behaviours = Behaviours(LIMITS, SHEET, errands, np.random.default_rng(seed))
    safe, places = SafetyFilter(LIMITS, SHEET), dict(START)
    behaviours.begin(name, 0.0, states_at(0.0, places))
    history = []
    for k in range(int(seconds * 10)):
        t = k / 10
        states = states_at(t, places)
        behaviours.step(t, states)
        for command in errands.step(t, states):
            admitted = safe.admit(command, states)
            here, goal = np.array(places[command.robot]), np.array(admitted.xy)
            way = goal - here
            far = min(np.linalg.norm(way), 0.015)
            places[command.robot] = tuple(here + way / max(np.linalg.norm(way), 1e-9) * far)
        history.append(dict(places))
    return history


def gaps(places: dict[str, tuple[float, float]]) -> float:
    at = np.array(list(places.values()))
    return min(np.linalg.norm(a - b) for k, a in enumerate(at) for b in at[:k])


@pytest.mark.parametrize("name", [GATHER, RANDOM_WALK])
def test_robots_keep_their_distance_and_the_sheet(name: str) -> None:
    for places in play(name, 60.0):
        assert gaps(places) >= 2 * LIMITS.body_radius_m + LIMITS.gap_m - 1e-3
        at = np.array(list(places.values()))
        assert at.min() >= LIMITS.body_radius_m - 1e-9
        assert (at <= [0.9 - LIMITS.body_radius_m + 1e-9, 0.6 - LIMITS.body_radius_m + 1e-9]).all()


def test_gathering_brings_them_round_their_middle_and_ends() -> None:
    last = play(GATHER, 60.0)[-1]
    middle = np.mean(list(START.values()), axis=0)
    assert max(np.linalg.norm(np.array(xy) - middle) for xy in last.values()) < 0.12
    assert play(GATHER, 70.0)[-1] == play(GATHER, 60.0)[-1]


def test_a_random_walk_moves_everyone_and_is_another_one_with_other_dice() -> None:
    history = play(RANDOM_WALK, 60.0)
    for name, start in START.items():
        assert max(np.linalg.norm(np.array(places[name]) - start) for places in history) > 0.08
    assert play(RANDOM_WALK, 20.0, seed=1)[-1] != history[199]
    assert play(RANDOM_WALK, 20.0) == history[:200]


def test_only_one_robot_moves_at_a_time() -> None:
    history = play(RANDOM_WALK, 40.0)
    for before, after in pairwise(history):
        assert sum(before[name] != after[name] for name in START) <= 1


def test_stop_ends_a_behaviour_and_its_errand() -> None:
    errands = Errands(LIMITS, SHEET)
    behaviours = Behaviours(LIMITS, SHEET, errands, np.random.default_rng(0))
    states = states_at(0.0, START)
    behaviours.begin(RANDOM_WALK, 0.0, states)
    behaviours.step(0.0, states)
    assert errands.goals
    behaviours.begin(STOP, 0.1, states)
    behaviours.step(0.1, states)
    assert not errands.goals
    assert behaviours.current is None


def test_a_lifted_robot_is_not_sent() -> None:
    errands = Errands(LIMITS, SHEET)
    behaviours = Behaviours(LIMITS, SHEET, errands, np.random.default_rng(0))
    states = {name: RobotState(0.0, name, xy, 0.0, held=name != "c") for name, xy in START.items()}
    behaviours.begin(RANDOM_WALK, 0.0, states)
    behaviours.step(0.0, states)
    assert set(errands.goals) == {"c"}
