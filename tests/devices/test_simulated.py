import asyncio

import pytest

from armspan.devices.simulated import STEP, SimulatedSwarm, source
from armspan.records import GoTo, Stop, Tick


class Clockwork:
    """A world that ticks until it is told to stop."""

    def __init__(self, ends=float("inf")):
        self.ends, self.now, self.taken = ends, 0.0, []

    @property
    def ended(self):
        return self.now >= self.ends or any(isinstance(record, Stop) for record in self.taken)

    def advance(self, t):
        self.now = t
        return [Tick(t - 0.01), Tick(t)]

    def take(self, record):
        self.taken.append(record)


def collected(world, seconds=None, then=None):
    waits, events = [], []

    async def pace(t):
        waits.append(t)

    async def run():
        async for event in source(world, pace, seconds):
            events.append(event)
            if then:
                then(event)

    asyncio.run(run())
    return events, waits


def test_events_come_after_their_step_was_waited_for():
    events, waits = collected(Clockwork(), seconds=0.15)
    assert [event.t for event in events] == pytest.approx([0.04, 0.05, 0.09, 0.10, 0.14, 0.15])
    assert waits == pytest.approx([0.05, 0.10, 0.15, 0.20])  # the last one lets the others finish


def test_steps_do_not_drift():
    _, waits = collected(Clockwork(), seconds=600)
    assert len(waits) == 12001
    assert waits[11999] == 12000 * STEP


def test_it_ends_with_its_world():
    events, _ = collected(Clockwork(ends=0.1))
    assert events[-1].t == pytest.approx(0.1)


def test_what_is_decided_reaches_the_world_before_its_next_step():
    world = Clockwork()

    def stop(event):
        if event.t > 0.2:
            world.take(Stop(event.t))

    events, _ = collected(world, then=stop)
    assert events[-1].t == pytest.approx(0.25)


@pytest.mark.parametrize(("seconds", "steps"), [(0.001, 1), (0.05, 1), (0.0501, 2), (1.0, 20)])
def test_seconds(seconds, steps):
    events, _ = collected(Clockwork(), seconds)
    assert len(events) == 2 * steps


def test_a_command_is_taken_at_once():
    world, go = Clockwork(), GoTo(0.0, "ash", (0.1, 0.1), 0.1, 0.3)
    asyncio.run(SimulatedSwarm(world).send(go))
    assert world.taken == [go]


def test_closing_it_early_is_allowed():
    async def run():
        async def pace(t):
            pass

        stream = source(Clockwork(), pace)
        first = await anext(stream)
        await stream.aclose()
        return first

    assert asyncio.run(run()) == Tick(0.04)
