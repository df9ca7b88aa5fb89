import asyncio

from armspan.devices.replay import NoSwarm, source
from armspan.records import Calibrated, ImuSample, Pointed, Press, RobotState, Say, Stop, Tick

SAMPLE = ImuSample(0.012, "wrist", (0.0, 0.0, 9.81), (0.0, 0.0, 0.0))
PLACE = Calibrated(0.05, "wrist", (0.0, 0.0, 0.0), 0.0, (0.0,) * 16, 0.0, 0.0, 4)
RECORDS = [
    Press(0.0, "setup"),
    Say(0.0, "Stretch your arm", "stretch"),
    RobotState(0.02, "ash", (0.1, 0.1), 0.0),
    SAMPLE,  # measured before the state above, arrived after it
    Tick(0.05),
    PLACE,
    Pointed(0.05, "wrist", None, None),
    Stop(0.05),
    Tick(0.1),
]
EVENTS = [RECORDS[k] for k in (0, 2, 3, 4, 8)]


def collected(records, seconds=None):
    steps = []

    async def pace(t):
        steps.append(t)

    async def run():
        async for event in source(records, pace, seconds):
            steps.append(event)

    asyncio.run(run())
    return steps


def test_events_come_again_in_their_order_each_after_its_time():
    steps = collected(RECORDS)
    assert steps[1::2] == EVENTS
    assert steps[::2] == [event.t for event in EVENTS]


def test_seconds_leave_out_what_was_measured_later():
    assert collected(RECORDS, 0.05)[1::2] == EVENTS[:4]
    assert collected(RECORDS, 0.015)[1::2] == [EVENTS[0], SAMPLE]


def test_nothing_to_replay():
    assert collected([]) == []


def test_commands_go_nowhere():
    assert asyncio.run(NoSwarm().send(Stop(0.0))) is None
