import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.swarm.behaviours.gather import Gather
from ideal_robots import least, run, stage, standing, xy

RADIUS = 0.1476 / 2**0.5
"""Of a ring of four robots 0.1476 m apart, 1.2 times 0.123 m: their square's half diagonal."""

CORNERS = [(0.1, 0.1), (0.9, 0.1), (0.9, 0.9), (0.1, 0.9)]


def test_four_robots_make_a_ring_round_the_pointed_spot():
    behaviour = Gather(stage(), states := standing(CORNERS))
    end = xy(run(behaviour, states, pointed=(0.6, 0.4))[-1])
    assert behaviour.done
    assert np.hypot(*(end - [0.6, 0.4]).T) == pytest.approx([RADIUS] * 4, abs=0.008)
    assert least(end) == pytest.approx(0.1476, abs=0.012)


def test_without_a_spot_they_meet_at_their_centroid():
    states = standing([(0.1, 0.1), (0.9, 0.1), (0.9, 0.7), (0.1, 0.7)])
    end = xy(run(Gather(stage(), states), states)[-1])
    assert end.mean(axis=0) == pytest.approx([0.5, 0.4], abs=0.008)


def test_the_spot_is_the_one_at_the_beginning():
    behaviour = Gather(stage(), states := standing(CORNERS))
    end = xy(run(behaviour, states, pointed=lambda t: (0.6, 0.4) if t < 0.5 else (0.2, 0.8))[-1])
    assert end.mean(axis=0) == pytest.approx([0.6, 0.4], abs=0.008)


@pytest.mark.parametrize("pointed", [(0.0, 0.0), (-3.0, -1.0), (float("nan"), 0.2)])
def test_near_a_corner_the_ring_is_shifted_on_to_the_sheet(pointed):
    behaviour = Gather(stage(), states := standing([(0.1, 0.1), (0.3, 0.1), (0.3, 0.3), (0.1, 0.3)]))
    end = xy(run(behaviour, states, pointed=pointed)[-1])
    middle = 0.2 if np.isnan(pointed[0]) else 0.045 + RADIUS  # robots' centres stay a radius from the edge
    assert end.mean(axis=0) == pytest.approx([middle, middle], abs=0.008)


def test_two_hundred_robots_make_a_filled_disc():
    here = stage(4.0, 4.0)
    states = standing(np.random.default_rng(2).uniform(0.1, 3.9, (200, 2)))
    behaviour = Gather(here, states)
    end = xy(run(behaviour, states, 60.0, pointed=(2.0, 2.0))[-1])
    assert behaviour.done
    # 0.1476 m apart a hexagonal lattice has 0.01887 m² for a robot: 200 fill a disc of 1.096 m, and a rim of half a gap
    assert 1.096 - 0.0738 < np.hypot(*(end - 2.0).T).max() < 1.096 + 0.0738
    assert least(end) > 0.1476 - 0.016


def test_those_who_stay_close_the_ring_when_one_goes():
    behaviour = Gather(stage(), states := standing(CORNERS))
    trace = run(behaviour, states, pointed=(0.5, 0.5))
    left = {name: state for name, state in trace[-1].items() if name != "b"}
    end = xy(run(behaviour, left)[-1])
    assert np.hypot(*(end - 0.5).T) == pytest.approx([0.1476 / 3**0.5] * 3, abs=0.008)  # a triangle now


def test_more_robots_than_fit_are_refused():
    with pytest.raises(ConfigError, match="at most 6 fit"):
        Gather(stage(0.3, 0.3), standing([(0.15, 0.15)] * 7))
