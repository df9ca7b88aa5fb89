"""The cursor without a screen: every robot's lights tell where the pointed spot lies from it.

A robot with the spot on it is green all round. Farther off, only the light on the spot's side is lit, and its
colour tells the distance: yellow, orange, red, then nothing. So direction is told by place and nearness both
by number and by colour. A robot that has just been chosen is blue all round.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from armspan.records import Colour, Light, RobotState, Vec2

LEDS = 6
OFF: Colour = (0, 0, 0)
ON_IT: Colour = (0, 255, 0)
CHOSEN: Colour = (0, 0, 255)
RINGS: tuple[tuple[float, Colour], ...] = (
    (0.06, (255, 255, 0)),
    (0.12, (255, 100, 0)),
    (0.25, (255, 0, 0)),
)
"""Up to which distance [m] the light on the spot's side has which colour."""
NEAR = 0.025
_REFRESH = 0.1
_AGAIN = 2.0
Ring = tuple[Colour, ...]
_DARK: Ring = (OFF,) * LEDS


def ring_toward(spot: Vec2, state: RobotState, led_zero: float = 0.0) -> Ring:
    """The six colours of a robot for a spot [m] in ``sheet``.

    ``led_zero`` [rad] is where light 0 sits, clockwise from the robot's front as seen from above.
    """
    dx, dy = spot[0] - state.xy[0], spot[1] - state.xy[1]
    distance = math.hypot(dx, dy)
    if distance < NEAR:
        return (ON_IT,) * LEDS
    colour = next((colour for reach, colour in RINGS if distance < reach), None)
    if colour is None:
        return _DARK
    bearing = math.atan2(dy, dx) - state.heading - led_zero
    lit = round(bearing / (2 * math.pi / LEDS)) % LEDS
    return tuple(colour if k == lit else OFF for k in range(LEDS))


@dataclass(slots=True)
class CursorLights:
    """Keeps the robots' lights showing the spot, with as few commands as change needs."""

    led_zero: float = 0.0
    _shown: dict[str, Ring] = field(default_factory=dict)
    _whole: dict[str, float] = field(default_factory=dict)
    _chosen: tuple[str, float] = ("", 0.0)
    _next: float = 0.0

    def flash(self, robot: str, until: float) -> None:
        """Show a robot as chosen until ``until`` [s]."""
        self._chosen = (robot, until)

    def step(self, t: float, spot: Vec2 | None, states: Mapping[str, RobotState]) -> list[Light]:
        """The light commands due at ``t`` [s] for a spot [m], or for none."""
        if t < self._next:
            return []
        self._next = t + _REFRESH
        lights: list[Light] = []
        for robot, state in states.items():
            ring = _DARK if spot is None else ring_toward(spot, state, self.led_zero)
            if self._chosen[0] == robot and t < self._chosen[1]:
                ring = (CHOSEN,) * LEDS
            lights.extend(self._change(t, robot, ring))
        return lights

    def _change(self, t: float, robot: str, ring: Ring) -> list[Light]:
        shown = self._shown.get(robot)
        stale = t - self._whole.get(robot, -math.inf) > _AGAIN and ring != _DARK
        if ring == shown and not stale:
            return []
        self._shown[robot] = ring
        differing = [] if shown is None else [k for k in range(LEDS) if ring[k] != shown[k]]
        if shown is not None and not stale and len(differing) <= 2:
            return [Light(t, robot, ring[k], k) for k in differing]
        self._whole[robot] = t
        ground = max(set(ring), key=ring.count)
        return [
            Light(t, robot, ground),
            *(Light(t, robot, ring[k], k) for k in range(LEDS) if ring[k] != ground),
        ]
