import asyncio
from itertools import pairwise

import pytest

import fast_time
from armspan.conductor import BandSettings, Conductor, Settings
from armspan.errors import DeviceError
from armspan.records import (
    Body,
    Drive,
    GoTo,
    ImuSample,
    Light,
    Press,
    RobotState,
    Say,
    Sheet,
    Stop,
    Tap,
    Tick,
    Touch,
)
from armspan.session import QUEUE, FastPace, LivePace, Session, latest, ticks

BODY = Body(1.6, (0.06, 0.15, 0.22), 0.72)
SETTINGS = Settings(BODY, Sheet(0.9, 0.6), (BandSettings("wrist"),), ("a",), stops=((0.1, 0.1), (0.8, 0.1), (0.8, 0.5)))


class Swarm:
    def __init__(self, fails_on=()):
        self.sent, self.fails_on = [], fails_on

    async def send(self, command):
        self.sent.append(command)
        if isinstance(command, self.fails_on):
            raise OSError("radio gone")


async def of(*events, pace=None, then=None):
    for event in events:
        if pace:
            await pace(event.t)
        yield event
    if then:
        raise then


def play(*sources, swarm=None, sinks=()):
    swarm = swarm or Swarm()
    records = []

    async def run():
        session = Session(Conductor(SETTINGS), swarm, [records.append, *sinks])
        await session.run(list(sources))
        return session

    return asyncio.run(run()), swarm, records


def test_everything_is_told_in_order_and_the_robots_are_stopped_at_the_end():
    events = [Press(0.0, "setup"), Tick(0.05), Tick(0.1)]
    _, swarm, records = play(of(*events))
    assert [r for r in records if r in events] == events
    assert isinstance(records[1], Say)
    assert swarm.sent[-1] == Stop(0.1, None, "quit")
    assert records[-2:] == [Press(0.1, "quit"), Stop(0.1, None, "quit")]


def test_a_source_that_fails_stops_the_robots_and_its_error_comes_through():
    swarm = Swarm()
    with pytest.raises(OSError, match="cable"):
        play(of(Tick(0.05), then=OSError("cable")), swarm=swarm)
    assert isinstance(swarm.sent[-1], Stop)


def test_a_conductor_that_fails_stops_the_robots(monkeypatch):
    swarm = Swarm()

    def fail(self, event):
        if isinstance(event, Tick):
            raise RuntimeError("a mistake in a behaviour")
        return []

    monkeypatch.setattr(Conductor, "step", fail)
    with pytest.raises(RuntimeError, match="mistake"):
        play(of(Tick(0.05), Tick(0.1)), swarm=swarm)
    assert any(isinstance(command, Stop) for command in swarm.sent)


def test_cancelling_closes_the_sources_and_stops_the_robots():
    swarm, closed, records = Swarm(), [], []

    async def endless():
        try:
            t = 0.0
            while True:
                t += 0.05
                yield Tick(t)
                await asyncio.sleep(0.001)
        finally:
            closed.append(True)

    async def run():
        session = Session(Conductor(SETTINGS), swarm, [records.append])
        task = asyncio.create_task(session.run([endless()]))
        await asyncio.sleep(0.05)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task

    asyncio.run(run())
    assert closed == [True]
    assert isinstance(swarm.sent[-1], Stop)
    assert isinstance(records[-1], Stop)


@pytest.mark.parametrize("event", [Press(0.01, "stop"), Touch(0.01, "a", 1, "long"), Tap(0.01, "wrist", 3)])
def test_a_stop_is_sent_before_anything_that_waits(event):
    order = []

    class Slow(Swarm):
        async def send(self, command):
            order.append(("sent", command))

    waiting = [RobotState(0.0, "a", (0.1, 0.1), 0.0)] * 50
    _, _, records = play(of(*waiting, event), swarm=Slow())
    assert isinstance(order[0][1], Stop)
    assert records[0] == event  # it took the head of the queue
    assert isinstance(records[1], Stop)


def test_a_full_queue_drops_samples_only_and_counts_them():
    sample = ImuSample(0.0, "wrist", (0, 0, 9.8), (0, 0, 0))
    session, _, records = play(of(*[sample] * (QUEUE + 100), Tick(0.05), Press(0.1, "setup")))
    assert session.counters.dropped == 100
    assert Tick(0.05) in records
    assert Press(0.1, "setup") in records


def test_what_is_not_finite_does_not_get_in():
    session, _, records = play(of(ImuSample(0.0, "wrist", (0, 0, float("nan")), (0, 0, 0)), Tick(0.05)))
    assert session.counters.not_finite == 1
    assert records[0] == Tick(0.05)


def test_two_sources_in_fast_pace_interleave_in_time():
    records = []

    async def run():
        session = Session(Conductor(SETTINGS), Swarm(), [records.append])
        fast = FastPace(session)
        doors = [fast.door(), fast.door()]
        slow = of(*[Tick(k / 20) for k in range(1, 40)], pace=doors[0])
        quick = of(*[RobotState(k / 50, "a", (0.1, 0.1), 0.0) for k in range(1, 60)], pace=doors[1])
        await session.run([doors[0].through(slow), doors[1].through(quick)])

    asyncio.run(asyncio.wait_for(run(), 10))
    times = [r.t for r in records if isinstance(r, Tick | RobotState)]
    assert len(times) == 39 + 59
    assert max(a - b for a, b in pairwise(times)) < 0.0501


def test_live_pace_sleeps_until_its_time():
    async def run():
        pace, loop = LivePace(), asyncio.get_running_loop()
        start = loop.time()
        for t in (0.0, 0.02, 0.05):
            await pace(t)
        return loop.time() - start

    assert asyncio.run(run()) >= 0.049


def test_a_live_pace_may_go_several_times_as_fast():
    async def run():
        pace, loop = LivePace(times=10.0), asyncio.get_running_loop()
        start = loop.time()
        for t in (0.0, 1.0, 2.0):
            await pace(t)
        return loop.time() - start

    assert 0.19 < asyncio.run(run()) < 1.5


def test_of_several_motions_the_last_wins_and_a_stop_leads():
    old, new = GoTo(0.0, "a", (0.1, 0.1), 0.1, 0.3), Drive(0.0, "a", (0.1, 0.0), 0.0, 0.3)
    other, light, stop = GoTo(0.0, "b", (0.2, 0.2), 0.1, 0.3), Light(0.0, "a", (1, 2, 3)), Stop(0.0)
    assert latest([old, light, other, new, Say(0.0, "x"), stop]) == [stop, light, other, new]


def test_a_radio_that_fails_at_the_end_still_leaves_the_stop_on_record():
    records = []
    with pytest.raises(OSError, match="radio gone"):
        play(of(Tick(0.05)), swarm=Swarm(fails_on=(Stop,)), sinks=[records.append])
    assert records[-1] == Stop(0.05, None, "quit")


async def _forever(closed):
    try:
        while True:
            yield Tick(0.0)
            await asyncio.sleep(0.001)
    finally:
        closed.append(True)


async def _ends():
    yield Tick(0.1)


def test_devices_are_closed_once_the_others_have_ended():
    closed, swarm = [], Swarm()
    asyncio.run(Session(Conductor(SETTINGS), swarm).run([_ends()], [_forever(closed)]))
    assert closed == [True]
    assert isinstance(swarm.sent[-1], Stop)


def test_devices_that_fail_together_are_told_together_and_the_robots_stop_first():
    async def fails(why, after):
        await asyncio.sleep(after)
        raise DeviceError(why)
        yield

    swarm = Swarm()
    with pytest.raises(DeviceError, match="no adapter; bootloader"):
        fast_time.run(
            lambda: Session(Conductor(SETTINGS), swarm).run(
                [_forever([])], [fails("no adapter", 0.1), fails("bootloader", 0.3)]
            )
        )
    assert isinstance(swarm.sent[0], Stop)


def test_ticks_come_twenty_a_second_and_end():
    async def scene():
        began = fast_time.now()
        return [event async for event in ticks(lambda: fast_time.now() - began, seconds=0.5)]

    told = [event.t for event in fast_time.run(scene)]
    assert len(told) == 11
    assert all(b > a for a, b in pairwise(told))
    assert told[-1] >= 0.5
