import numpy as np
import pytest

from armspan.records import Light, RobotState
from armspan.swarm.lights import CHOSEN, OFF, ON_IT, CursorLights, ring_toward


def state(xy=(0.5, 0.5), heading=0.0, t=0.0, robot="a"):
    return RobotState(t, robot, xy, heading)


@pytest.mark.parametrize(
    ("spot", "lit"),
    [((0.55, 0.5), 0), ((0.5 + 0.025, 0.5 + 0.0433), 1), ((0.45, 0.5), 3), ((0.5 + 0.025, 0.5 - 0.0433), 5)],
)
def test_the_light_on_the_spots_side_is_lit(spot, lit):
    """Light k sits 60 k degrees clockwise from the front: with y down, that is from x towards y."""
    ring = ring_toward(spot, state())
    assert [k for k in range(6) if ring[k] != OFF] == [lit]


def test_heading_and_led_zero_turn_the_ring():
    assert ring_toward((0.55, 0.5), state(heading=np.pi / 3))[5] != OFF
    assert ring_toward((0.55, 0.5), state(), led_zero=np.pi / 3)[5] != OFF


def test_distance_is_told_by_colour_and_number():
    colours = [set(ring_toward((0.5 + d, 0.5), state())) - {OFF} for d in (0.04, 0.09, 0.2)]
    assert len({next(iter(c)) for c in colours}) == 3
    assert set(ring_toward((0.51, 0.5), state())) == {ON_IT}
    assert set(ring_toward((0.9, 0.5), state())) == {OFF}


def shown(commands: list[Light], ring):
    ring = list(ring)
    for light in commands:
        if light.led is None:
            ring = [light.colour] * 6
        else:
            ring[light.led] = light.colour
    return tuple(ring)


def test_the_commands_make_the_ring_and_only_changes_are_sent():
    lights, ring, states = CursorLights(), (OFF,) * 6, {"a": state()}
    rng = np.random.default_rng(0)
    sent = 0
    for k in range(200):
        spot = tuple(rng.uniform(0.3, 0.7, 2))
        for t in (0.2 * k, 0.2 * k + 0.1):
            commands = lights.step(t, spot, states)
            sent += len(commands)
            ring = shown(commands, ring)
        assert ring == ring_toward(spot, states["a"])
    assert sent < 3.5 * 200


def test_no_spot_is_dark_and_a_choice_is_blue():
    lights, states = CursorLights(), {"a": state()}
    assert shown(lights.step(0.0, (0.5, 0.5), states), (OFF,) * 6) == (ON_IT,) * 6
    lights.flash("a", 1.0)
    assert shown(lights.step(0.2, (0.5, 0.5), states), (ON_IT,) * 6) == (CHOSEN,) * 6
    assert shown(lights.step(1.2, None, states), (CHOSEN,) * 6) == (OFF,) * 6
