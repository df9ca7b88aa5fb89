"""Whatever is asked in whatever order: what leaves the swarm's part of the mind."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis
from hypothesis import strategies as st

from armspan.conductor.robots_only import RobotsOnly
from armspan.records import COMMANDS, Drive, GoTo, Link, Press, RobotState, Sheet, Stop, Tick, Touch, Zone
from armspan.simulation.robots import VirtualRobots
from armspan.study.safety import SafetyWatch
from armspan.swarm.director import BEHAVIOURS, MAKERS
from armspan.swarm.limits import Limits
from puppet import settings

NAMES = ("a", "b", "c", "d")
SHEET = Sheet(1.2, 0.9)
ZONES = (
    Zone("garden", ((0.1, 0.1), (0.4, 0.1), (0.4, 0.4), (0.1, 0.4))),
    Zone("harbour", ((0.7, 0.5), (1.0, 0.5), (1.0, 0.8), (0.7, 0.8))),
)

robots = st.sampled_from(NAMES)
wild = st.floats(-3, 3)
commands = st.one_of(
    st.builds(GoTo, st.just(0.0), robots, st.tuples(wild, wild), st.floats(-1, 9), st.floats(-1, 99)),
    st.builds(Drive, st.just(0.0), robots, st.tuples(wild, wild), wild, st.floats(-1, 99)),
)
asked = st.one_of(
    st.tuples(st.just("behaviour"), st.sampled_from([*BEHAVIOURS, "dance", "sweep@garden", "gather:a,b", "follow:c"])),
    st.tuples(st.just("command"), commands.map(lambda command: msgspec.json.encode(command).decode())),
    st.tuples(st.sampled_from(["stop", "resume", "quit", "nonsense"]), st.just("")),
    st.tuples(st.just("resume"), robots),
)
befalls = st.tuples(st.sampled_from(["lift", "put", "hush", "hear", "drain", "charge", "touch", "unlink"]), robots)


@hypothesis(max_examples=40, derandomize=True, deadline=None)
@given(st.lists(st.one_of(asked, asked, befalls), min_size=1, max_size=25), st.integers(0, 99))
def test_no_motion_after_a_stop_before_a_resume_and_none_for_who_waits(script, seed):
    rng = np.random.default_rng(seed)
    mind = RobotsOnly(settings(sheet=SHEET, robots=NAMES, zones=ZONES, dice=seed))
    at = {name: (0.2 + 0.25 * k, 0.4) for k, name in enumerate(NAMES)}
    held, silent, empty, t = set(), set(), set(), 0.0
    latched, waiting = False, set()
    watch = SafetyWatch(Limits(), SHEET)

    def tell(event):
        nonlocal latched
        watch.take(event)
        outputs = mind.step(event)
        if isinstance(event, Press) and event.name == "resume":
            latched = latched and event.value != ""
            waiting.difference_update({event.value} if event.value else NAMES)
        if isinstance(event, Press) and event.name == "behaviour":
            waiting.clear()  # asked for anew: that nothing leaves for the unfit is checked by their states
        for output in outputs:
            if isinstance(output, COMMANDS):
                watch.take(output)
            if isinstance(output, Stop):
                latched = latched or output.robot is None
                waiting.update({output.robot} if output.robot else ())
            if isinstance(output, GoTo):
                assert not latched
                assert output.robot not in held | silent | empty | (waiting & (held | silent | empty))
                here = np.array(at[output.robot])
                at[output.robot] = tuple((here + rng.uniform(0, 1) * (output.xy - here)).tolist())

    for name, value in [("wait", ""), *script]:
        {
            "lift": held.add, "put": held.discard, "hush": silent.add, "hear": silent.discard,
            "drain": empty.add, "charge": empty.discard,
        }.get(name, lambda _: None)(value)  # fmt: skip
        if name == "touch":
            tell(Touch(t, value, 0, "long"))
        elif name == "unlink":
            tell(Link(t, value, False))
        elif name in ("behaviour", "command", "stop", "resume", "quit", "nonsense"):
            tell(Press(t, name, value))
        for _ in range(13 if name == "hush" else 3):
            t = round(t + 0.05, 9)
            for robot in NAMES:
                if robot not in silent:
                    tell(RobotState(t, robot, at[robot], 0.0, robot in held, 0.01 if robot in empty else None))
            if name == "hush" and _ < 11:
                continue  # not told to be silent for long enough yet: no ticks
            tell(Tick(t))
    watch.violations.pop("motion after stop", None)  # judged above, where a resume for one robot is known
    watch.violations.pop("robot too fast", None)  # these jump to anywhere on their way
    assert watch.violations == {}


@pytest.mark.parametrize("name", sorted(MAKERS))
def test_on_virtual_robots_no_behaviour_ever_breaks_a_limit_or_touches(name):
    rng = np.random.default_rng(5)
    names = [f"r{k}" for k in range(6)]
    start = np.array([[0.2 + 0.17 * (k % 3), 0.2 + 0.17 * (k // 3)] for k in range(6)])
    start += rng.uniform(-0.02, 0.02, (6, 2))
    plant = VirtualRobots(names, start, rng.uniform(0, 6, 6), SHEET, rng)
    mind = RobotsOnly(settings(sheet=SHEET, robots=tuple(names), zones=ZONES))
    watch = SafetyWatch(Limits(), SHEET)
    moved = 0.0
    for k in range(200):
        t = 0.05 * k
        events = [state for _, state in plant.advance(t)] + [Tick(t)]
        if k == 10:
            mind.steering.behave(t, name, "asked for", (0.6, 1.2))
        for event in events:
            watch.take(event)
            outputs = mind.steering.tick(t, (0.8, 0.3)) if isinstance(event, Tick) else mind.step(event)
            for output in outputs:
                watch.take(output)
                if isinstance(output, COMMANDS):
                    plant.command(t, output)
        moved = max(moved, float(np.abs(plant.truth()[0] - start).max()))
    assert moved > 0.03
    assert plant.contacts == 0
    assert watch.violations == {}
