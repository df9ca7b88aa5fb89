"""The lights against what EPFL's own firmware showed, recorded in cellulo_firmware.json."""

import json
from pathlib import Path

import numpy as np
import pytest

from armspan.simulation.lights import BOOT, Effect, Lights

CASES = json.loads((Path(__file__).parent / "cellulo_firmware.json").read_text())["led"]
RED, GREEN = (255, 0, 0), (0, 255, 0)


def seen(lights, tick):
    lights.advance(tick)
    return lights.now


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_every_recorded_effect(case):
    lights = Lights(boot=0)
    lights.show(Effect(case["effect"]), case["colour"], case["value"])
    for t_ms, *colours in case["rows"]:
        np.testing.assert_array_equal(seen(lights, t_ms // 10), np.broadcast_to(colours, (6, 3)), str(t_ms))


def test_an_idle_robot_is_dim_white():
    assert (seen(Lights(), 500) == BOOT).all()


def test_a_fade_ends_at_most_ten_below_and_never_above():
    lights = Lights()
    lights.show(Effect.CONST_ALL, RED)
    assert seen(lights, 400)[0].tolist() == [4085, 0, 0]
    lights.show(Effect.CONST_ALL, (0, 0, 0))
    assert (seen(lights, 800) == 0).all()


def test_one_light_leaves_the_others():
    lights = Lights()
    lights.show(Effect.CONST_ALL, RED)
    lights.advance(400)
    lights.show(Effect.CONST_SINGLE, GREEN, 2)
    colours = seen(lights, 800)
    assert colours[2].tolist() == [0, 4085, 0]
    assert (np.delete(colours, 2, axis=0) == [4085, 0, 0]).all()


def test_one_light_after_a_moving_effect_leaves_the_others_as_they_are():
    lights = Lights()
    lights.show(Effect.BLINK, RED, 15)
    lights.advance(5)
    lights.show(Effect.CONST_SINGLE, GREEN, 2)
    assert seen(lights, 400)[[1, 2]].tolist() == [[4095, 0, 0], [0, 4085, 0]]


def test_an_alert_flashes_over_an_effect_that_then_returns():
    lights = Lights(boot=0)
    lights.show(Effect.CONST_ALL, GREEN)
    lights.advance(400)
    lights.show(Effect.ALERT_SINGLE, RED, 0x24)  # twice, light 4
    lights.show(Effect.ALERT_ALL, RED, 9)  # ignored: one runs
    dark = [0, 4085, 0]
    for tick, colour in ((410, [4095, 0, 0]), (450, dark), (470, [4095, 0, 0]), (510, dark), (600, dark)):
        assert seen(lights, tick)[4].tolist() == colour, tick
        assert seen(lights, tick)[0].tolist() == dark
    lights.show(Effect.ALERT_ALL, RED, 1)  # taken: the first one is over
    assert seen(lights, 610)[0].tolist() == [4095, 0, 0]


def test_a_new_effect_ends_an_alert():
    lights = Lights(boot=0)
    lights.show(Effect.ALERT_ALL, RED, 9)
    lights.advance(10)
    lights.show(Effect.CONST_ALL, GREEN)
    assert seen(lights, 11)[0].tolist() == [0, 372, 0]


def test_blink_without_a_value_takes_300_ms():
    lights, same = Lights(boot=0), Lights(boot=0)
    lights.show(Effect.BLINK, RED, 0)
    same.show(Effect.BLINK, RED, 15)
    lit = [seen(lights, tick)[0, 0] for tick in range(200)]
    assert lit == [seen(same, tick)[0, 0] for tick in range(200)]
    assert set(lit) == {0, 4095}


def test_in_one_step_or_in_many():
    one, many = Lights(), Lights()
    for lights in (one, many):
        lights.show(Effect.WAITING, (10, 200, 255))
    for tick in range(1, 333):
        many.advance(tick)
    np.testing.assert_array_equal(seen(one, 332), many.now)
