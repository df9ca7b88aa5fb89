import asyncio
import contextlib
import io
import json
import math
import ssl
import sys
from pathlib import Path

import aiohttp
import pytest
from yarl import URL

from armspan.devices.phone.driver import PhoneBands
from armspan.devices.phone.emulator import EmulatedPhone, Faults, play, serve
from armspan.devices.phone.entry import PhoneEntry
from armspan.devices.phone.voices import LoggerVoice, PageVoice, ServerVoice, lying_still
from armspan.errors import ConfigError, DeviceError, MissingExtra
from armspan.records import ImuSample, Link, Press, Tap
from devices.promises import check_closes, check_events, check_lost_and_mended, check_rest
from fast_time import run

TOKEN = "quiet-river-9"
TILTED = (math.cos(math.radians(30)), math.sin(math.radians(30)), 0.0, 0.0)
UP = (0.0, 9.80665 * math.sin(math.radians(60)), 9.80665 * math.cos(math.radians(60)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("certificate")


def page(name="wrist", **more):
    return PhoneEntry(name, listen="127.0.0.1:0", token=TOKEN, **more)


def pushed(name="wrist", **more):
    return PhoneEntry(name, app="sensor-logger", listen="127.0.0.1:0", token=TOKEN, **more)


def asked(url):
    return PhoneEntry("wrist", app="sensor-server", url=url)


class Room:
    """Bands whose events are kept."""

    def __init__(self, *entries, folder=Path(), **options):
        self.bands, self.events = PhoneBands(entries, folder=folder, **options), []

    async def __aenter__(self):
        self._ears = asyncio.create_task(self._listen())
        await asyncio.sleep(0.2)
        return self

    async def __aexit__(self, *_):
        self._ears.cancel()
        await asyncio.gather(self._ears, return_exceptions=True)

    async def _listen(self):
        async with contextlib.aclosing(self.bands.source()) as source:
            async for event in source:
                self.events.append(event)

    def samples(self, name="wrist"):
        return [event for event in self.events if isinstance(event, ImuSample) and event.source == name]

    def links(self, name="wrist"):
        return [event for event in self.events if isinstance(event, Link) and event.source == name]

    def url(self, name="wrist"):
        return self.bands.urls()[name]


def phone(voice, faults=None, rate=60.0, **more):
    return EmulatedPhone(voice, lying_still(rate, TILTED), faults or Faults(), **more)


@pytest.mark.parametrize(
    "voice",
    [PageVoice(), PageVoice(apple=True), PageVoice(attitude="quaternion"), PageVoice(apple=True, attitude="none")],
)
def test_a_page_is_a_band(folder, voice):
    async def scene():
        async with Room(page(), folder=folder) as room:
            await play(phone(voice), room.url(), 2.0)
        return room

    room = run(scene)
    check_events(room.events)
    told = room.samples()
    assert len(told) > 110
    check_rest(told)
    assert told[-1].acc == pytest.approx(UP, abs=0.1)
    if voice.attitude == "none":
        assert told[-1].quat is None
    else:
        assert told[-1].quat == pytest.approx(TILTED, abs=1e-3)
    counters = room.bands.report()["wrist"]
    assert (counters["lost"], counters["malformed"], counters["refused"]) == (0, 0, 0)
    assert counters["rate"] == pytest.approx(60.0, abs=1.0)


def test_a_page_that_loses_its_line_comes_back(folder):
    async def scene():
        async with Room(page(), folder=folder) as room:
            await play(phone(PageVoice(), Faults(lost=0.05, breaks=(1.0, 2.5))), room.url(), 4.0)
        return room

    room = run(scene)
    check_events(room.events)
    check_lost_and_mended(room.events, "wrist")
    assert [(link.up, link.fresh) for link in room.links()[:4]] == [(True, False), (False, False)] * 2
    assert room.bands.report()["wrist"]["lost"] == pytest.approx(0.05 * 180 + 2 * 30, abs=20)
    assert room.bands.report()["wrist"]["gaps"] >= 2


@pytest.mark.parametrize("app", ["browser", "sensor-logger", "sensor-server"])
def test_silence_is_told_within_a_little_more_than_a_second_and_mended(folder, app):
    faults = Faults(silences=((1.0, 2.0),))

    async def scene():
        if app == "sensor-server":
            async with served(phone(ServerVoice(), faults)) as url, Room(asked(url)) as room:
                await asyncio.sleep(4.0)
            return room
        async with Room(page() if app == "browser" else pushed(), folder=folder) as room:
            voice = PageVoice() if app == "browser" else LoggerVoice("ios")
            await play(phone(voice, faults, ordered=app == "browser"), room.url(), 4.0)
        return room

    room = run(scene)
    check_events(room.events)
    check_lost_and_mended(room.events, "wrist")
    down = room.links()[1]
    before = max(event.t for event in room.samples() if event.t < down.t)
    assert 0.9 < down.t - before < 1.6


@contextlib.asynccontextmanager
async def served(served_phone, port=0):
    told = asyncio.get_running_loop().create_future()
    task = asyncio.create_task(serve(served_phone, port, told.set_result))
    try:
        yield f"ws://127.0.0.1:{await told}"
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def test_a_phone_that_is_asked_may_come_late_and_come_back():
    async def scene():
        async with served(phone(ServerVoice())) as url:
            port = int(url.rpartition(":")[2])
        async with Room(asked(url), retry_s=0.5) as room:
            await asyncio.sleep(1.0)
            for _ in range(2):
                async with served(phone(ServerVoice()), port):
                    await asyncio.sleep(3.0)
                await asyncio.sleep(1.0)
        return room

    room = run(scene)
    check_events(room.events)
    check_rest(room.samples())
    assert [(link.up, link.fresh) for link in room.links()] == [
        (True, False),
        (False, False),
        (True, True),
        (False, False),
    ]


def test_a_phone_without_game_rotation_is_asked_for_less(monkeypatch):
    monkeypatch.setattr("armspan.devices.phone.emulator.KNOWN", ("accelerometer", "gyroscope", "rotation_vector"))

    async def scene():
        async with served(phone(ServerVoice())) as url, Room(asked(url), retry_s=0.2) as room:
            await asyncio.sleep(2.0)
        return room

    room = run(scene)
    assert room.samples()[-1].quat == pytest.approx(TILTED)


def test_pushes_with_jitter_are_a_band():
    async def scene():
        async with Room(pushed()) as room:
            await play(phone(LoggerVoice("ios", 0.1), Faults(jitter=0.25, lost=0.03), ordered=False), room.url(), 5.0)
        return room

    room = run(scene)
    check_events(room.events)
    check_rest(room.samples())
    counters = room.bands.report()["wrist"]
    assert 0 < counters["lost"] < 8
    assert counters["late"] == 0


def test_two_phones_at_one_door_are_told_apart():
    entries = pushed("left", device="phone-a"), pushed("right", device="phone-b")

    async def scene():
        async with Room(*entries) as room:
            voices = [LoggerVoice(device=device) for device in ("phone-a", "phone-b", "phone-c")]
            rates = (50.0, 100.0, 60.0)
            await asyncio.gather(
                *(
                    play(phone(voice, rate=rate, ordered=False), room.url("left"), 3.0)
                    for voice, rate in zip(voices, rates, strict=True)
                )
            )
        return room

    room = run(scene)
    check_events(room.events)
    report = room.bands.report()
    assert report["left"]["rate"] == pytest.approx(50, abs=1)
    assert report["right"]["rate"] == pytest.approx(100, abs=2)
    assert set(room.bands.strangers) == {"phone-c"}


def test_a_phone_that_is_named_is_no_other_bands():
    entries = pushed("left", device="phone-a"), pushed("right")

    async def scene():
        async with Room(*entries) as room:
            await play(phone(LoggerVoice(device="phone-a"), ordered=False), room.url("left"), 1.0)
            await play(phone(LoggerVoice(device="phone-b"), ordered=False), room.url("right"), 1.0)
        return room

    room = run(scene)
    assert len(room.samples("left")) == pytest.approx(len(room.samples("right")), abs=3)
    assert room.samples("left")[-1].t < room.samples("right")[0].t


def test_a_band_keeps_to_its_phone_until_that_is_silent():
    async def scene():
        async with Room(pushed()) as room:
            first, second = (phone(LoggerVoice(device=name, session=name), ordered=False) for name in "ab")
            task = asyncio.create_task(play(first, room.url(), 2.0))
            await asyncio.sleep(0.5)
            await play(second, room.url(), 5.0)
            await task
        return room

    room = run(scene)
    check_events(room.events)
    assert [(link.up, link.fresh) for link in room.links()[:3]] == [(True, False), (False, False), (True, True)]
    assert room.bands.strangers["b"] > 3


def test_phone_and_watch_come_in_one_push():
    entries = pushed("upper", stream="phone", segment="upperarm"), pushed("wrist", stream="watch")

    async def scene():
        async with Room(*entries) as room:
            phones = [
                phone(LoggerVoice(platform, device="p", session=platform), ordered=False)
                for platform in ("ios", "apple-watch")
            ]
            merged = Merged(*(one.voice for one in phones))
            await play(EmulatedPhone(merged, lying_still(50, TILTED), ordered=False), room.url("wrist"), 3.0)
        return room

    room = run(scene)
    for name in ("upper", "wrist"):
        check_rest(room.samples(name))
        assert room.samples(name)[-1].acc == pytest.approx(UP, abs=1e-6)


class Merged(LoggerVoice):
    """The pushes of a phone and its watch as the app makes them: together."""

    def __init__(self, *voices):
        super().__init__()
        self.voices = voices

    def tell(self, samples, t):
        pushes = [[json.loads(data) for data in voice.tell(samples, t)] for voice in self.voices]
        return [
            json.dumps(one | {"sessionId": "s", "payload": one["payload"] + other["payload"]}).encode()
            for one, other in zip(*pushes, strict=True)
        ]


def test_advice_is_given_where_something_should_be_changed():
    async def scene():
        async with Room(pushed(device="a")) as room:
            assert room.bands.advice() == []
            slow, other = (phone(LoggerVoice(batch_s=1.0, device=name), ordered=False) for name in "ab")
            await asyncio.gather(play(slow, room.url(), 3.5), play(other, room.url(), 3.5))
        return room.bands.advice()

    strange, slow = run(scene)
    assert "deviceId is 'b'" in strange
    assert slow.startswith(
        "wrist: samples are 1.0 s old when they come, and pointing needs 0.25 s; set a shorter batch"
    )


def test_http_to_a_door_with_tls_says_nothing_on_the_terminal(folder, capfd):
    async def scene():
        async with Room(page(), folder=folder) as room:
            at = URL(room.url())
            for noise in (b"GET / HTTP/1.1\r\nHost: a\r\n\r\n", b"\x00" * 100):
                reader, writer = await asyncio.open_connection(at.host, at.port)
                writer.write(noise)
                with contextlib.suppress(ConnectionError):
                    await reader.read()
                writer.close()
            await play(phone(PageVoice()), room.url(), 1.0)
        return room

    assert len(run(scene).samples()) > 50
    assert capfd.readouterr() == ("", "")


# --- stop, taps, and what is answered ------------------------------------------------------------------------


def going_on():
    """A client that goes on when it is warned of the certificate."""
    return aiohttp.ClientSession(connector=aiohttp.TCPConnector(ssl=False))


@contextlib.asynccontextmanager
async def line(url):
    at = URL(url)
    where = at.with_path("/line").with_query(at.query).with_scheme("wss")
    async with going_on() as session, session.ws_connect(where) as open_line:
        yield open_line


async def post(url, data=b"", **headers):
    async with going_on() as session, session.post(url, data=data, headers=headers) as answer:
        return answer.status, await answer.text()


def test_stop_and_tap_come_through_and_are_answered(folder):
    async def scene():
        async with Room(page(), folder=folder) as room, line(room.url()) as open_line:
            answers = []
            for text in ('{"hello":{"page":"p"}}', '{"stop":1}', '{"tap":2}', "nonsense", '{"stop":2}'):
                await open_line.send_str(text)
                if "tap" not in text:
                    answers.append(await open_line.receive_json(timeout=3))
            await asyncio.sleep(0.1)
            status = await post(room.url().replace("/?", "/stop?"))
        return room, answers, status

    room, answers, status = run(scene)
    assert [answer["band"] for answer in answers] == ["wrist"] * 4
    assert [answer.get("stopped", False) for answer in answers] == [False, True, False, True]
    assert "error" in answers[2]
    assert status == (200, "stopped\n")
    kinds = [type(event) for event in room.events]
    assert kinds == [Press, Tap, Press, Press]
    assert [(event.name, event.value) for event in room.events if isinstance(event, Press)] == [("stop", "wrist")] * 3
    assert room.events[1].count == 2
    assert room.bands.report()["wrist"]["malformed"] == 1


def test_the_page_hears_what_arrives(folder):
    async def scene():
        async with Room(page(), folder=folder) as room, line(room.url()) as open_line:
            found = []
            await open_line.send_str('{"hello":{"page":"p"}}')
            for k in range(100):
                text = {"n": 2 * k, "t": 20.0 * k, "a": [0, 0, 9.8], "r": [0, 0, 0], "o": [0, 0, 0], "u": 20.0 * k}
                await open_line.send_str(json.dumps(text))
                await asyncio.sleep(0.02)
            while not found or "lost" not in found[-1] or found[-1]["lost"] < 60:
                found.append(await open_line.receive_json(timeout=3))
        return found

    found = run(scene)
    assert found[-1]["rate"] == pytest.approx(50.0, abs=2.0)


def test_the_latest_page_counts(folder):
    async def scene():
        async with Room(page(), folder=folder) as room, line(room.url()) as first, line(room.url()) as second:
            for open_line, name in ((first, "one"), (second, "two")):
                await open_line.send_str(json.dumps({"hello": {"page": name}}))
                await open_line.receive_json(timeout=3)
            await first.send_str('{"stop":1}')
            await second.send_str('{"stop":2}')
            message, answer = await first.receive(timeout=3), await second.receive_json(timeout=3)
            posted = [await post(say(room.url()), hello(name) + b"\n") for name in ("one", "three", "two")]
        return room, first.close_code or message.data, answer, [json.loads(text) for _, text in posted]

    room, code, answer, (one, three, two) = run(scene)
    assert code == 4000
    assert answer["stopped"] is True
    assert one == two == {"taken": True}
    assert three["band"] == "wrist"
    assert [type(event) for event in room.events] == [Press]


def hello(name):
    return json.dumps({"hello": {"page": name}}).encode()


def say(url):
    return url.replace("/?", "/say?")


def test_a_page_may_post_what_it_says(folder):
    async def scene():
        async with Room(page(), folder=folder) as room:
            await play(phone(PageVoice(apple=True, posts=True)), room.url(), 2.0)
            answers = [
                await post(say(room.url()), hello("emulated") + b'\n{"stop":1}\n{"tap":2}\nnonsense'),
                await post(say(room.url()), b'{"stop":1}'),
                await post(say(room.url())),
            ]
            await asyncio.sleep(1.5)
        return room, answers

    room, answers = run(scene)
    check_events(room.events)
    check_rest(room.samples())
    assert len(room.samples()) > 110
    assert room.samples()[-1].acc == pytest.approx(UP, abs=0.1)
    assert [link.up for link in room.links()] == [True, False]
    assert room.bands.report()["wrist"]["lost"] == 0
    assert [type(event) for event in room.events if not isinstance(event, ImuSample | Link)] == [Press, Tap]
    assert [status for status, _ in answers] == [200, 400, 400]
    told = json.loads(answers[0][1])
    assert (told["stopped"], told["band"], "error" in told) == (True, "wrist", True)


def test_a_line_that_begins_otherwise_is_closed(folder):
    async def scene():
        async with Room(page(), folder=folder) as room, line(room.url()) as open_line:
            await open_line.send_str('{"stop":1}')
            message = await open_line.receive(timeout=3)
        return room, open_line.close_code or message.data

    room, code = run(scene)
    assert code == 1008
    assert room.events == []
    assert room.bands.report()["wrist"]["malformed"] == 1


def test_strangers_and_wrong_bands_do_not_come_in(folder):
    async def scene():
        async with Room(page(), folder=folder) as room:
            bare = room.url().partition("?")[0]
            answers = [
                await post(bare + "stop"),
                await post(bare + f"stop?token={TOKEN}x"),
                await post(bare + "stop", Authorization=f"Bearer {TOKEN}"),
                await post(bare + f"stop?token={TOKEN}", Origin="https://example.org"),
                await post(bare + f"stop?token={TOKEN}&band=leg"),
            ]
            with pytest.raises(DeviceError, match=r"refuses.*403"):
                await play(phone(PageVoice()), bare, 2.0)
        return room, answers

    room, answers = run(scene)
    assert [status for status, _ in answers] == [403, 403, 200, 403, 400]
    assert "band 'leg' does not exist; there are: wrist" in answers[-1][1]
    assert room.bands.report()["wrist"]["refused"] == 4
    assert [type(event) for event in room.events] == [Press]


def test_pushes_that_cannot_be_read_are_answered_and_counted():
    async def scene():
        async with Room(pushed()) as room:
            answers = [await post(room.url(), data) for data in (b"hello", b"{}", io.BytesIO(b"x" * (2 << 20)))]
            await play(phone(LoggerVoice(), ordered=False), room.url(), 2.0)
        return room, answers

    room, answers = run(scene)
    assert [status for status, _ in answers] == [400, 200, 413]
    assert answers[0][1].startswith("this is not a push of Sensor Logger")
    assert room.bands.report()["wrist"]["malformed"] == 1
    assert len(room.samples()) > 60


@pytest.mark.parametrize(
    ("package", "entry"),
    [
        ("cryptography", page()),
        ("aiohttp", page()),
        ("aiohttp", pushed()),
        ("aiohttp", PhoneEntry("wrist", app="sensor-server", url="ws://127.0.0.1:9")),
    ],
)
def test_a_missing_package_is_told(folder, monkeypatch, package, entry):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtra, match=rf"{package} is not installed: pip install 'armspan\[phone\]'"):
        run(lambda: anext(PhoneBands([entry], folder=folder).source()))


# --- opening and closing -------------------------------------------------------------------------------------


@pytest.mark.parametrize("app", ["browser", "sensor-logger"])
def test_closing_leaves_nothing_behind(folder, app):
    async def scene():
        bands = PhoneBands([page() if app == "browser" else pushed()], folder=folder)
        source = bands.source()
        first = asyncio.ensure_future(anext(source))
        await asyncio.sleep(0.2)
        voice = PageVoice() if app == "browser" else LoggerVoice()
        speaking = asyncio.create_task(play(phone(voice, ordered=False), bands.urls()["wrist"]))
        await first
        await check_closes(source)
        speaking.cancel()
        await asyncio.gather(speaking, return_exceptions=True)

    run(scene)


def test_a_taken_port_is_told(folder):
    async def scene():
        async with Room(page(), folder=folder) as room:
            port = room.url().split(":")[2].split("/")[0]
            other = PhoneBands([PhoneEntry("leg", listen=f"127.0.0.1:{port}")], folder=folder)
            with pytest.raises(DeviceError, match=f"port {port} of 127.0.0.1 is taken"):
                await anext(other.source())

    run(scene)


@pytest.mark.parametrize(
    ("entries", "words"),
    [
        ((page("a"), PhoneEntry("b", listen="127.0.0.1:0")), "both listen on 127.0.0.1:0 but differ"),
        ((page("a"), pushed("b")), "both listen on 127.0.0.1:0 but differ in app"),
        ((pushed("a"), pushed("b")), "'a' and 'b' are the same phone; set device"),
        ((pushed("a", stream="watch"), pushed("b", stream="watch")), "are the same watch"),
        (
            (
                PhoneEntry("a", app="sensor-server", url="ws://h:80"),
                PhoneEntry("b", app="sensor-server", url="ws://h:80"),
            ),
            "'a' and 'b' are the same phone",
        ),
    ],
)
def test_bands_that_contradict_each_other_are_refused(entries, words):
    with pytest.raises(ConfigError, match=words):
        PhoneBands(entries)


def test_the_session_clock_may_be_given(folder):
    async def scene():
        clock = asyncio.get_running_loop().time
        async with Room(page(), folder=folder, now=lambda: clock() + 1000.0) as room:
            await play(phone(PageVoice()), room.url(), 1.0)
            return room, clock() + 1000.0

    room, end = run(scene)
    assert end - 2.0 < room.samples()[0].t < room.samples()[-1].t < end


def test_the_certificate_is_kept_in_the_folder(tmp_path):
    async def scene():
        async with Room(page(), folder=tmp_path):
            return [path.name for path in tmp_path.iterdir()]

    assert run(scene) == ["armspan-door.pem"]
    ssl.create_default_context().load_verify_locations(tmp_path / "armspan-door.pem")


def test_an_invitation_says_what_to_do_on_each_phone(monkeypatch):
    monkeypatch.setattr("armspan.devices.phone.driver.machine_names", lambda: ("192.168.1.4", "127.0.0.1"))
    bands = PhoneBands(
        [
            PhoneEntry("wrist", listen="0.0.0.0:8443", token=TOKEN),
            PhoneEntry("watch", app="sensor-logger", listen="0.0.0.0:8001", token=TOKEN, stream="watch"),
            PhoneEntry("arm", app="sensor-server", url="ws://192.168.1.23:8080"),
        ]
    )
    text = bands.invitation()
    assert f"https://192.168.1.4:8443/?token={TOKEN}&band=wrist" in text
    assert "warn" in text
    assert f"wrist motion, set its push URL to http://192.168.1.4:8001/?token={TOKEN} " in text
    assert "start SensorServer on the phone; it is looked for at ws://192.168.1.23:8080" in text
