import numpy as np
import pytest

from armspan.swarm.behaviours.formation import FormationAt
from ideal_robots import least, run, stage, standing, xy

ANGLE = np.array([(0.2, 0.2), (0.4, 0.2), (0.2, 0.5)])  # centroid (0.2667, 0.3)


def test_the_shape_is_kept_and_its_centroid_comes_to_the_spot():
    behaviour = FormationAt(stage(), standing(ANGLE))
    end = xy(run(behaviour, standing(ANGLE), pointed=(0.5667, 0.6))[-1])
    assert behaviour.done
    assert end == pytest.approx(ANGLE + 0.3, abs=0.008)


def test_it_is_the_spot_at_the_beginning():
    behaviour = FormationAt(stage(), standing(ANGLE))
    end = xy(run(behaviour, standing(ANGLE), pointed=lambda t: (0.5667, 0.6) if t < 1 else None)[-1])
    assert end == pytest.approx(ANGLE + 0.3, abs=0.008)


def test_at_the_edge_the_shape_is_shifted_not_squeezed():
    end = xy(run(FormationAt(stage(), standing(ANGLE)), standing(ANGLE), pointed=(1.0, 1.0))[-1])
    # its box, 0.2 by 0.3 m, ends 0.045 m from both edges
    assert end == pytest.approx(ANGLE - [0.4, 0.5] + 0.955, abs=0.008)


def test_robots_that_stand_too_close_are_set_apart():
    close = standing([(0.3, 0.3), (0.38, 0.3), (0.3, 0.38)])
    end = xy(run(FormationAt(stage(), close), close, pointed=(0.6, 0.6))[-1])
    assert least(end) >= 0.12 - 0.016
    assert end.mean(axis=0) == pytest.approx([0.6, 0.6], abs=0.008)


def test_without_a_spot_it_is_done_at_once_and_nothing_moves():
    behaviour = FormationAt(stage(), standing(ANGLE))
    assert not behaviour.done
    assert behaviour.step(0.0, standing(ANGLE), None) == []
    assert behaviour.done
    assert behaviour.step(0.05, standing(ANGLE), (0.5, 0.5)) == []  # too late


def test_it_waits_for_robots_before_it_looks_for_a_spot():
    behaviour = FormationAt(stage(), standing(ANGLE))
    assert behaviour.step(0.0, {}, None) == []
    assert not behaviour.done
    assert len(behaviour.step(0.05, standing(ANGLE), (0.5, 0.5))) == 3
