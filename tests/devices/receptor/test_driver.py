import asyncio
import contextlib
import os
import pty
import socket
import tty

import aiohttp
import numpy as np
import pytest

from armspan.devices.receptor.driver import Receptors
from armspan.devices.receptor.emulator import EmulatedReceptor, write_on
from armspan.devices.receptor.entry import HttpReceptor, SerialReceptor, UdpReceptor
from armspan.errors import ConfigError, DeviceError, DeviceNotFound
from armspan.records import Hit, Link
from devices.promises import check_closes, check_events, check_lost_and_mended
from fast_time import now, run

ROBOTS = ("amber", "birch")
TOKEN = "quiet-river-9"


class Cable:
    """A pseudo-terminal under a name that stays; ``ours`` is the microcontroller's end."""

    def __init__(self, folder):
        self.path = str(folder / "port")
        self.plug()

    def plug(self):
        self.ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self.path)
        os.symlink(os.ttyname(self._theirs), self.path)

    def write(self, data):
        os.write(self.ours, data)

    def pull(self):
        os.unlink(self.path)
        os.close(self.ours)
        os.close(self._theirs)


@pytest.fixture
def cable(tmp_path):
    made = Cable(tmp_path)
    yield made
    with contextlib.suppress(OSError):
        made.pull()


@contextlib.asynccontextmanager
async def listened(*entries, **options):
    """Receptors whose events are kept."""
    receptors, events = Receptors(entries, ROBOTS, **options), []

    async def listen():
        async with contextlib.aclosing(receptors.source()) as source:
            async for event in source:
                events.append(event)

    ears = asyncio.create_task(listen())
    await asyncio.sleep(0.2)
    try:
        yield receptors, events
    finally:
        ears.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await ears


def hits(events):
    return [(event.robot, event.on) for event in events if isinstance(event, Hit)]


# --- serial --------------------------------------------------------------------------------------------------


def test_a_serial_port_tells_hits(cable):
    async def scene():
        async with listened(SerialReceptor("tops", cable.path)) as (receptors, events):
            cable.write(b"hit am")
            await asyncio.sleep(0.1)
            cable.write(b"ber\r\nwhat?\r\nhit cobalt\r\n")
            await asyncio.sleep(0.1)
            cable.write(b"lost amber\r\n")
            await asyncio.sleep(0.3)
            return receptors, events

    receptors, events = run(scene)
    assert events[0] == Link(events[0].t, "tops", True)
    assert hits(events) == [("amber", True), ("amber", False)]
    check_events(events)
    report = receptors.report()["tops"]
    assert report == {"lines": 2, "unknown": 1, "malformed": 1, "too_long": 0, "refused": 0}
    [sentence] = receptors.told()
    assert sentence == "receptor 'tops': robot 'cobalt' does not exist; there are: amber, birch."


def test_a_port_that_was_pulled_out_ends_its_hits_and_is_mended(cable):
    async def scene():
        async with listened(SerialReceptor("tops", cable.path), retry_s=0.5) as (_, events):
            cable.write(b"hit amber\nhit bir")
            await asyncio.sleep(0.2)
            cable.pull()
            await asyncio.sleep(1.2)
            cable.plug()
            await asyncio.sleep(1.0)
            cable.write(b"ch\nhit birch\n")
            await asyncio.sleep(0.3)
            return events

    events = run(scene)
    check_lost_and_mended(events, "tops")
    check_events(events)
    assert hits(events) == [("amber", True), ("amber", False), ("birch", True)]
    down = next(k for k, event in enumerate(events) if isinstance(event, Link) and not event.up)
    assert hits(events[:down]) == [("amber", True), ("amber", False)]


def test_a_hit_that_is_never_lost_expires_where_hits_are_repeated(cable):
    async def scene():
        async with listened(SerialReceptor("tops", cable.path, expire_s=0.6)) as (_, events):
            for _ in range(5):
                cable.write(b"hit amber\n")
                await asyncio.sleep(0.3)
            await asyncio.sleep(1.0)
            return events

    events = run(scene)
    on, off = [event for event in events if isinstance(event, Hit)]
    assert (on.on, off.on) == (True, False)
    assert off.t - on.t == pytest.approx(4 * 0.3 + 0.6, abs=0.15)


def test_without_a_port_the_room_is_told_at_once(tmp_path):
    async def scene():
        async for _ in Receptors([SerialReceptor("tops", str(tmp_path / "nothing"))], ROBOTS).source():
            pass

    with pytest.raises(DeviceNotFound, match="nothing cannot be opened"):
        run(scene)


def test_closing_ends_it(cable):
    async def scene():
        before = now()
        receptors = Receptors([SerialReceptor("tops", cable.path), UdpReceptor("air", listen="127.0.0.1:0")], ROBOTS)
        await check_closes(receptors.source())
        return now() - before

    assert run(scene) < 1.0


def test_an_emulated_receptor_is_heard_through_its_chatter(cable):
    async def scene():
        board = EmulatedReceptor(np.random.default_rng(2), bounces=4)
        async with listened(SerialReceptor("tops", cable.path, expire_s=0.8)) as (receptors, events):
            pen = asyncio.create_task(write_on(board, cable.write, now, asyncio.sleep))
            for robot in ("amber", "birch", "amber"):
                board.hear(Hit(now(), robot, True))
                await asyncio.sleep(2.0)
                board.hear(Hit(now(), robot, False))
                await asyncio.sleep(0.5)
            pen.cancel()
            return receptors, events

    receptors, events = run(scene)
    assert hits(events) == [(robot, on) for robot in ("amber", "birch", "amber") for on in (True, False)]
    assert receptors.report()["tops"]["lines"] > 25  # repeated five times a second


# --- datagrams -----------------------------------------------------------------------------------------------


def send(port, *messages):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        for message in messages:
            sock.sendto(message, ("127.0.0.1", port))


def test_datagrams_tell_hits_with_the_token_and_nothing_without():
    async def scene():
        entry = UdpReceptor("air", listen="127.0.0.1:0", token=TOKEN)
        async with listened(entry) as (receptors, events):
            port = receptors.ports["air"]
            send(port, b"hit amber", b"hit amber token=not-this-one", b"\xff\xff", b"")
            await asyncio.sleep(0.2)
            assert events == []
            send(port, b"hit birch token=%s\r\nlost birch token=%s" % (TOKEN.encode(), TOKEN.encode()))
            await asyncio.sleep(0.3)
            return receptors, events

    receptors, events = run(scene)
    assert isinstance(events[0], Link)
    assert hits(events) == [("birch", True), ("birch", False)]
    assert receptors.report()["air"]["refused"] == 2


def test_datagrams_of_addresses_that_are_not_allowed_are_refused():
    async def scene():
        async with listened(
            UdpReceptor("far", listen="127.0.0.1:0", allow=("192.168.7.0/24",)),
            UdpReceptor("near", listen="127.0.0.1:0", allow=("127.0.0.1",)),
        ) as (receptors, events):
            for name in ("far", "near"):
                send(receptors.ports[name], b"hit amber")
            await asyncio.sleep(0.2)
            return receptors, events

    receptors, events = run(scene)
    assert hits(events) == [("amber", True)]
    assert (receptors.report()["far"]["refused"], receptors.report()["near"]["refused"]) == (1, 0)


def test_a_lost_datagram_costs_a_second_at_most():
    async def scene():
        async with listened(UdpReceptor("air", listen="127.0.0.1:0")) as (receptors, events):
            board = EmulatedReceptor(np.random.default_rng(4), lost=0.3)
            port = receptors.ports["air"]
            pen = asyncio.create_task(write_on(board, lambda line: send(port, line), now, asyncio.sleep))
            board.notice(now(), "amber", True)
            await asyncio.sleep(5.0)
            pen.cancel()  # its battery is empty, and nobody says lost
            await asyncio.sleep(2.0)
            return events

    events = run(scene)
    on, off = [event for event in events if isinstance(event, Hit)]
    assert (on.on, off.on) == (True, False)
    assert 4.5 < off.t - on.t < 6.2


def test_a_port_that_is_taken_is_said():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        port = sock.getsockname()[1]

        async def scene():
            async for _ in Receptors([UdpReceptor("air", listen=f"127.0.0.1:{port}")], ROBOTS).source():
                pass

        with pytest.raises(DeviceError, match=f"port {port} of 127.0.0.1 cannot be had for datagrams"):
            run(scene)


# --- HTTP ----------------------------------------------------------------------------------------------------


def test_requests_tell_hits_and_are_answered():
    async def scene():
        entry = HttpReceptor("web", listen="127.0.0.1:0", token=TOKEN)
        async with listened(entry) as (receptors, events), aiohttp.ClientSession() as client:
            url = f"http://127.0.0.1:{receptors.ports['web']}/"

            async def post(data, **query):
                async with client.post(url, data=data, params=query) as answer:
                    return answer.status, await answer.text()

            answers = [
                await post(b"hit amber"),
                await post(b"hit amber", token=TOKEN),
                await post(b"hit ambre\nhit birch\n", token=TOKEN),
                await post(b"birch!\n", token=TOKEN),
                await post(b"x" * 10_000, token=TOKEN),
                await post(b"lost amber\nlost birch\n", token=TOKEN),
            ]
            await asyncio.sleep(0.2)
            return receptors, events, answers

    receptors, events, answers = run(scene)
    assert [status for status, _ in answers] == [403, 200, 400, 400, 413, 200]
    assert "there are: amber, birch" in answers[2][1]
    assert "'hit ROBOT'" in answers[3][1]
    assert hits(events) == [("amber", True), ("birch", True), ("amber", False), ("birch", False)]
    assert receptors.report()["web"]["refused"] == 1


# --- rooms ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ([SerialReceptor("a", "/dev/x"), SerialReceptor("a", "/dev/y")], "'a' is named twice"),
        ([SerialReceptor("a", "/dev/x"), SerialReceptor("b", "/dev/x")], "'a' and 'b' are the same door"),
        ([UdpReceptor("a"), UdpReceptor("b")], "'a' and 'b' are the same door"),
        ([UdpReceptor("a", robots=("zoe",))], "robot 'zoe' does not exist; there are: amber, birch"),
    ],
)
def test_doors_that_cannot_be_are_refused(entries, words):
    with pytest.raises(ConfigError, match=words):
        Receptors(entries, ROBOTS)


def test_datagrams_and_requests_may_share_a_number():
    Receptors([UdpReceptor("a", listen="127.0.0.1:4000"), HttpReceptor("b", listen="127.0.0.1:4000")], ROBOTS)
