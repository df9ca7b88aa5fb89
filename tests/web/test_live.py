import asyncio
import json

import pytest
from fastapi import WebSocketDisconnect

from armspan.web import live as live_module
from armspan.web.live import Live


class Source:
    """Stands for what is shown: counts how often a frame was made."""

    def __init__(self):
        self.version, self.room_number, self.frames = 1, 1, 0

    def frame(self):
        self.frames += 1
        return {"t": self.version, "room": self.room_number}

    def room(self):
        return {"number": self.room_number}


class Line:
    """A browser's end: what it got, and what it is made to send."""

    def __init__(self):
        self.got, self.said = [], asyncio.Queue()

    async def accept(self):
        pass

    async def receive_text(self):
        text = await self.said.get()
        if text is None:
            raise WebSocketDisconnect
        return text

    async def send_bytes(self, data):
        self.got.append(json.loads(data))

    @property
    def frames(self):
        return [message["t"] for message in self.got if "t" in message]


@pytest.fixture
def fast(monkeypatch):
    """Frames as fast as the loop turns, and no frame where nothing changed."""
    monkeypatch.setattr(live_module, "RATE_HZ", 1e6)
    monkeypatch.setattr(live_module, "ALIVE", 1e6)


async def turns(count=40):
    for _ in range(count):
        await asyncio.sleep(0)


def play(lines, acts):
    """Serve lines of a source and let ``acts(source, live, *lines)`` happen meanwhile."""

    async def run():
        source, stopped = Source(), []

        async def stopping():
            stopped.append(source.version)

        live, ends = Live(source, stopping), [Line() for _ in range(lines)]
        serving = [asyncio.create_task(live.serve(end)) for end in ends]
        await turns()
        await acts(source, live, *ends)
        for end in ends:
            end.said.put_nowait(None)
        await asyncio.wait_for(asyncio.gather(*serving), 1)
        return source, live, ends, stopped

    return asyncio.run(run())


def test_the_room_comes_first_and_then_the_latest_frame(fast):
    async def acts(source, live, line):
        pass

    _, live, (line,), _ = play(1, acts)
    assert line.got == [{"room": {"number": 1}}, {"t": 1, "room": 1}]
    assert live.viewers == set()


def test_a_browser_that_does_not_draw_gets_two_frames_and_later_only_the_latest(fast):
    async def acts(source, live, line):
        for version in range(2, 9):
            source.version = version
            await turns()
        assert line.frames == [1, 2]
        line.said.put_nowait("k")
        await turns()

    _, _, (line,), _ = play(1, acts)
    assert line.frames == [1, 2, 8]


def test_a_slow_browser_holds_nobody_up_and_a_frame_is_made_once_for_all(fast):
    async def acts(source, live, slow, quick, other):
        for version in range(2, 9):
            for line in (quick, other):
                line.said.put_nowait("k")
            source.version = version
            await turns()

    source, _, (slow, quick, other), _ = play(3, acts)
    assert slow.frames == [1, 2]
    assert quick.frames == other.frames == list(range(1, 9))
    assert source.frames == 8


def test_acknowledging_what_was_never_sent_buys_nothing(fast):
    async def acts(source, live, line):
        for _ in range(50):
            line.said.put_nowait("k")
        await turns()
        for version in range(2, 9):
            source.version = version
            await turns()

    _, _, (line,), _ = play(1, acts)
    assert line.frames == [1, 2, 3]


def test_a_room_that_changed_is_sent_before_its_first_frame(fast):
    async def acts(source, live, line):
        line.said.put_nowait("k")
        source.version, source.room_number = 2, 7
        await turns()

    _, _, (line,), _ = play(1, acts)
    assert line.got[2:] == [{"room": {"number": 7}}, {"t": 2, "room": 7}]


def test_nothing_is_made_while_nobody_looks(fast):
    async def run():
        source = Source()
        live, line = Live(source, None), Line()
        serving = asyncio.create_task(live.serve(line))
        await turns()
        line.said.put_nowait(None)
        await serving
        source.version = 5
        await turns()
        assert source.frames == 1
        late = Line()
        serving = asyncio.create_task(live.serve(late))
        await turns()
        late.said.put_nowait(None)
        await serving
        return late.frames

    assert asyncio.run(run()) == [5]


def test_a_line_on_which_nothing_changes_is_kept_alive(monkeypatch):
    monkeypatch.setattr(live_module, "ALIVE", 0.02)

    async def acts(source, live, line):
        line.said.put_nowait("k")
        await asyncio.sleep(0.15)

    _, _, (line,), _ = play(1, acts)
    assert line.frames == [1, 1, 1]  # and then it waits for the browser


def test_a_stop_is_passed_on_from_any_browser(fast):
    async def acts(source, live, first, second):
        second.said.put_nowait("stop")
        await turns()

    _, _, _, stopped = play(2, acts)
    assert stopped == [1]
