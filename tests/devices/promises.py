"""What every device promises, whatever it is: to be called by the tests of each.

Samples: times never fall, every number is finite, at rest the specific force is that of gravity. Sources: closing one
ends it and leaves no task behind; a lost link is told and mended.
"""

import asyncio
import math

from armspan.records import ImuSample, Link, is_finite

GRAVITY = 9.80665


def check_events(events):
    """Times of one device never fall, and every number is finite."""
    last = {}
    for event in events:
        assert is_finite(event), event
        name = getattr(event, "source", None) or getattr(event, "robot", None)
        key = (type(event), name)
        assert event.t >= last.get(key, -math.inf), (event, last[key])
        last[key] = event.t


def check_rest(samples, tolerance=0.5):
    """A band that lies still feels gravity, and no turn to speak of."""
    assert samples
    assert all(isinstance(sample, ImuSample) for sample in samples)
    force = sum(math.hypot(*sample.acc) for sample in samples) / len(samples)
    assert abs(force - GRAVITY) < tolerance, force
    rate = sum(math.hypot(*sample.gyr) for sample in samples) / len(samples)
    assert rate < 0.2, rate
    for sample in samples:
        assert sample.quat is None or abs(math.hypot(*sample.quat) - 1.0) < 1e-3


async def check_closes(source, wanted=1):
    """Closing a source that has told something ends it at once, and no task of its own goes on."""
    before = asyncio.all_tasks()
    for _ in range(wanted):
        await anext(source)
    await asyncio.wait_for(source.aclose(), 5.0)
    await asyncio.sleep(0)
    left = [task for task in asyncio.all_tasks() - before if not task.done()]
    assert left == [], left


def check_lost_and_mended(events, name):
    """A link that broke was told, and then that it is up again, with something after it."""
    links = [event.up for event in events if isinstance(event, Link) and event.source == name]
    assert False in links, links
    down = links.index(False)
    assert True in links[down:], links
