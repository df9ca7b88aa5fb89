import numpy as np
import pytest

from armspan.records import GoTo, Sheet
from armspan.simulation.bodies import Plant
from armspan.simulation.robots import VirtualRobots
from armspan.swarm.answers import SLUGGISH_LEAD, Answers
from armspan.swarm.limits import Limits
from armspan.swarm.safety import SafetyFilter

SHEET = Sheet(2.0, 1.0)


def driven(gain, seconds=5.0):
    """How far ahead a virtual Cellulo's goals lie after so long at full speed, and how fast it then is."""
    plant = Plant(gain=(gain, gain))
    robots = VirtualRobots(["a"], [[0.1, 0.2]], [0.0], SHEET, np.random.default_rng(2), plant)
    safety, states, lead = SafetyFilter(Limits(), SHEET), {}, 0.0
    for k in range(round(seconds / 0.05)):
        t = 0.05 * k
        states |= {state.robot: state for _, state in robots.advance(t)}
        for command in safety.admit(t, [GoTo(t, "a", (1.8, 0.8), 0.15, t + 0.3)], states):
            robots.command(t, command)
            lead = np.hypot(*np.subtract(command.xy, states["a"].xy))
    return lead, np.hypot(*robots.truth()[2][0])


@pytest.mark.parametrize(("gain", "least", "most"), [(0.6, 0.031, 0.034), (0.8, 0.039, 0.043), (1.0, 0.0449, 0.0451)])
def test_a_sluggish_robot_gets_nearer_goals(gain, least, most):
    lead, speed = driven(gain)
    assert least <= lead <= most
    assert speed <= 0.16


def test_nothing_is_learnt_from_a_robot_that_is_held_up():
    answers, row = Answers(0.045, 0.075), np.array([0])
    answers.know(1)
    for k in range(100):
        answers.learn(row, np.array([[0.1, 0.1, 0.05 * k]]), np.array([0.15]), np.array([False]))
    assert answers.gain[0] == 0.6
    assert answers.lead(row)[0] == pytest.approx(SLUGGISH_LEAD)
