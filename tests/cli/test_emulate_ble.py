"""Emulated bands and cubes in processes of their own, reached by the real drivers through real sockets."""

import asyncio
import json
import math
import re
import signal
import socket
from itertools import pairwise

import pytest

from armspan.cli import emulate_metawear, emulate_toio, parser
from armspan.config.survey import survey
from armspan.devices.metawear.driver import MetaWearBand
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.toio.driver import ToioCubes
from armspan.devices.toio.entry import ToioEntry
from armspan.devices.toio.quantities import UNIT_M
from armspan.errors import DeviceError
from armspan.links.hci import radio_named
from armspan.records import GoTo, ImuSample, Link, RobotState, Tap
from command_line import code_of, contents, fresh, refused
from devices.promises import GRAVITY, check_events, check_rest
from fast_time import now, run

WORDS = {
    "bands": ("metawear", "--boards", "2", "--motion", "wave", "--port", "0"),
    "cubes": ("toio", "--cubes", "2", "--port", "0"),
    "cable": ("metawear", "--usb"),
}


def radio_and_addresses(line):
    found = re.fullmatch(r'radio = "(bumble:tcp-client:127\.0\.0\.1:\d+)"  # (.+)\n', line)
    assert found, line
    return radio_named(found[1]), found[2].split(", ")


async def played(source, enough, seconds=30.0):
    """What a source tells until it is enough."""
    events = []
    try:
        async with asyncio.timeout(seconds):
            async for event in source:
                events.append(event)
                if enough(events):
                    return events
    finally:
        await asyncio.wait_for(source.aclose(), 5.0)
    raise AssertionError(events)


def of(kind, events):
    return [event for event in events if isinstance(event, kind)]


def states(events, name):
    return [event for event in of(RobotState, events) if event.robot == name]


# --- processes of their own ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("truth")


@pytest.fixture(scope="module")
def emulators(folder):
    """All of them at once: a process needs a second to begin."""
    started = {
        name: fresh("-m", "armspan", "emulate", *words, "--truth", folder / f"{name}.jsonl")
        for name, words in WORDS.items()
    }
    yield started
    for process in started.values():
        process.kill()
        process.communicate()


@pytest.fixture(scope="module")
def lines(emulators):
    """The first line of each."""
    return {name: process.stdout.readline() for name, process in emulators.items()}


@pytest.fixture(scope="module")
def told(lines):
    """What the real drivers hear from all of them, at once."""

    async def scene():
        return await asyncio.gather(_bands(lines["bands"]), _cubes(lines["cubes"]), _cable(lines["cable"]))

    return dict(zip(WORDS, asyncio.run(scene()), strict=True))


async def _bands(line):
    radio, addresses = radio_and_addresses(line)
    assert addresses == ["E8:C9:8F:52:7B:01", "E8:C9:8F:52:7B:02"]
    entries = [
        MetaWearEntry(name, address, profile=profile)
        for name, address, profile in zip(("right", "left"), addresses, ("fusion", "raw"), strict=True)
    ]
    return await asyncio.gather(
        *(
            played(MetaWearBand(entry, radio=radio).source(), lambda told: len(of(ImuSample, told)) >= 150)
            for entry in entries
        )
    )


async def _cubes(line):
    radio, addresses = radio_and_addresses(line)
    assert addresses == ["D0:8B:7F:00:00:01", "D0:8B:7F:00:00:02"]
    cubes = ToioCubes([ToioEntry(f"c{k}", address) for k, address in enumerate(addresses)], radio=radio)
    both = asyncio.Event()
    goal = []

    async def go():
        await both.wait()
        ahead = states(heard, "c0")[-1]
        goal[:] = [ahead.xy[0] + 0.05 * math.cos(ahead.heading), ahead.xy[1] + 0.05 * math.sin(ahead.heading)]
        await cubes.send(GoTo(ahead.t, "c0", tuple(goal), 0.1, ahead.t + 5.0))

    heard = []

    def enough(events):
        heard.append(events[-1])
        if states(heard[-2:], "c0") and states(heard, "c1"):
            both.set()
        return bool(goal) and math.dist(states(heard, "c0")[-1].xy, goal) < 0.02

    _, events = await asyncio.gather(go(), played(cubes.source(), enough))
    return events


async def _cable(line):
    found = re.fullmatch(r'address = "(usb:.+)"\n', line)
    assert found, line
    band = MetaWearBand(MetaWearEntry("right", found[1]))
    return await played(band.source(), lambda told: len(of(ImuSample, told)) >= 50)


def test_bands_of_another_process_send_samples(told):
    for events, name in zip(told["bands"], ("right", "left"), strict=True):
        check_events(events)
        samples = of(ImuSample, events)
        assert isinstance(events[0], Link)
        assert events[0].up
        spacing = (samples[-1].t - samples[0].t) / (len(samples) - 1)
        assert spacing == pytest.approx(0.01, rel=0.1)
        force = [math.hypot(*sample.acc) for sample in samples]
        assert sum(force) / len(force) == pytest.approx(GRAVITY, abs=1.0)
        assert max(math.hypot(*sample.gyr) for sample in samples) > 0.3, name  # it moves
        assert {sample.quat is None for sample in samples} == {name == "left"}


def test_cubes_of_another_process_obey(told, folder):
    events = told["cubes"]
    check_events(events)
    _, *true = [json.loads(line) for line in (folder / "cubes.jsonl").read_text().splitlines()]
    for name, begin in zip(("c0", "c1"), true, strict=False):
        first, last = states(events, name)[0], states(events, name)[-1]
        assert math.dist(first.xy, begin["xy_m"]) < 4 * UNIT_M
        assert (math.dist(first.xy, last.xy) > 0.02) == (name == "c0")


def test_a_cable_to_another_process(told):
    check_events(told["cable"])
    check_rest(of(ImuSample, told["cable"]))


def test_a_survey_finds_what_another_process_emulates(told, lines, tmp_path):
    radio, addresses = radio_and_addresses(lines["bands"])
    seen = asyncio.run(survey(0.6, radio, port=1, dev=tmp_path))
    found = {device.address: device for device in seen.found}
    assert set(addresses) == set(found)
    assert {(each.kind, each.firmware, each.battery) for each in found.values()} == {("metawear", "1.7.2", 0.87)}


def test_sigterm_ends_them_with_0(emulators, lines, folder):
    for process in emulators.values():
        process.send_signal(signal.SIGTERM)
    for name, process in emulators.items():
        _, err = process.communicate(timeout=20)
        assert (process.returncode, err) == (0, ""), name
        first, *rest = [json.loads(line) for line in (folder / f"{name}.jsonl").read_text().splitlines()]
        assert first.keys() == {"monotonic"}
        assert rest[-1]["t"] > 1.0


# --- what goes wrong, in fast time -----------------------------------------------------------------------


def emulated(device, capsys, *words):
    """A decorator for a scene that is played with an emulator, and gets its radio and addresses."""

    def play(scene):
        args = parser().parse_args(["emulate", device.__name__.rsplit("_", 1)[-1], "--port", "0", *words])

        async def main():
            task = asyncio.create_task(device.emulate(args))
            line = ""
            while not line:
                await asyncio.sleep(0.02)
                line = capsys.readouterr().out
            try:
                await scene(*radio_and_addresses(line))
            finally:
                task.cancel()
                (ended,) = await asyncio.gather(task, return_exceptions=True)
                assert isinstance(ended, asyncio.CancelledError), ended

        run(main, 60.0)

    return play


def test_a_band_is_pressed_breaks_and_is_reset(capsys):
    @emulated(emulate_metawear, capsys, "--press-at", "5", "--link-loss-at", "6", "--away-s", "2", "--reset-at", "12")
    async def scene(radio, addresses):
        band = MetaWearBand(MetaWearEntry("right", *addresses), radio=radio, now=now)
        began = now()
        events = await played(band.source(), lambda told: len(of(Link, told)) >= 5, 40.0)
        (tap,) = of(Tap, events)
        assert tap.count == 2
        assert tap.t - began == pytest.approx(5.0, abs=0.8)
        links = [(link.up, link.fresh) for link in of(Link, events)]
        # Away for two seconds; after the reset everything begins anew.
        assert links == [(True, True), (False, False), (True, False), (False, False), (True, True)]
        down, up = (link.t - began for link in of(Link, events)[1:3])
        assert 6.0 < down < 7.5
        assert up > 8.0


@pytest.mark.parametrize(
    ("words", "told"), [(("--bootloader",), "is in its bootloader"), (("--old-firmware",), "too old for samples")]
)
def test_a_board_that_cannot_serve_says_why(words, told, capsys):
    @emulated(emulate_metawear, capsys, *words)
    async def scene(radio, addresses):
        band = MetaWearBand(MetaWearEntry("right", *addresses, profile="raw"), radio=radio, now=now)
        with pytest.raises(DeviceError, match=told):
            await played(band.source(), lambda events: False, 20.0)


@pytest.mark.parametrize(
    ("words", "usual_s", "longest_s"),
    [(("--drop", "0.1", "--absent", "silent"), 0.01 / 0.9, (0.02, 0.2)), (("--silence-at", "5"), 0.01, (2.9, 3.6))],
)
def test_samples_get_lost_or_fall_silent(words, usual_s, longest_s, capsys):
    @emulated(emulate_metawear, capsys, *words)
    async def scene(radio, addresses):
        band = MetaWearBand(MetaWearEntry("right", *addresses, profile="raw"), radio=radio, now=now)
        events = await played(band.source(), lambda told: len(of(ImuSample, told)) >= 400, 40.0)
        gaps = [after.t - before.t for before, after in pairwise(of(ImuSample, events))]
        assert longest_s[0] < max(gaps) < longest_s[1]
        usual = [gap for gap in gaps if gap < 0.5]  # it looks after a link that was silent, which takes a moment
        assert sum(usual) / len(usual) == pytest.approx(usual_s, rel=0.06)


def test_a_cube_is_kidnapped(capsys):
    @emulated(emulate_toio, capsys, "--kidnap-at", "3")
    async def scene(radio, addresses):
        entries = [ToioEntry(f"c{k}", address) for k, address in enumerate(addresses)]
        cubes = ToioCubes(entries, radio=radio, now=now)
        began = now()

        def enough(told):
            return now() - began > 6.0

        events = await played(cubes.source(), enough, 20.0)
        before = [state for state in states(events, "c0") if state.t - began < 2.9][-1]
        after = states(events, "c0")[-1]
        assert math.dist(before.xy, after.xy) == pytest.approx(0.1, abs=4 * UNIT_M)
        assert not any(3.5 < state.t - began < 4.5 and not state.held for state in states(events, "c0"))
        assert math.dist(states(events, "c1")[0].xy, states(events, "c1")[-1].xy) < 4 * UNIT_M


# --- words -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("metawear", "--boards", "0"), "'0' is not a number of boards from 1 to 8"),
        (("metawear", "--port", "70000"), "'70000' is not a port from 0 to 65535"),
        (("metawear", "--drop", "2"), "'2' is not a share from 0 to 1"),
        (("metawear", "--latency-ms", "nan"), "'nan' is not a time in milliseconds"),
        (("metawear", "--model", "mms2"), "invalid choice: 'mms2'"),
        (("metawear", "--model", "mms", "--old-firmware"), "the model mms has none that is older"),
        (("metawear", "--usb", "--model", "mmrl_current"), "only the MetaMotion S"),
        (("metawear", "--usb", "--drop", "0.1"), "--usb is a cable"),
        (("metawear", "--usb", "--port", "1"), "not allowed with argument"),
        (("toio", "--cubes", "x"), "'x' is not a number of cubes"),
        (("toio", "--mat", "sea"), "invalid choice: 'sea'"),
        (("toio", "--mat", "simple", "--cubes", "50"), "50 cubes do not fit on the mat simple"),
        (("toio", "--kidnap-at", "-1"), "'-1' is not a time in seconds"),
    ],
)
def test_bad_input_is_one_sentence(words, told, capsys):
    code = code_of("emulate", *words)
    out, err = capsys.readouterr()
    assert (code, out, len(err.splitlines())) == (2, "", 1), err
    assert err.startswith("armspan emulate")
    assert told in err


def test_a_truth_that_says_something_is_kept(capsys, tmp_path):
    path = tmp_path / "truth.jsonl"
    path.write_text("{}\n")
    assert "exists and is kept" in refused(capsys, tmp_path, "emulate", "metawear", "--truth", path)
    assert contents(tmp_path) == {path: b"{}\n"}


def test_a_port_that_is_taken_is_one_sentence(capsys, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        said = refused(capsys, tmp_path, "emulate", "toio", "--port", port)
    assert said.startswith(f"armspan emulate: port {port} of 127.0.0.1 cannot be opened")
