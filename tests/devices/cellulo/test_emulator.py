import argparse
import asyncio
import contextlib
import io
import json
import os
import select
import signal
import socket
import subprocess
import sys
import termios
import time
import tty

import numpy as np
import pytest

from armspan.cli import emulate as verb
from armspan.devices.cellulo import relay
from armspan.devices.cellulo.emulator import Emulator, addresses, places
from armspan.devices.cellulo.firmware import Firmware
from armspan.devices.cellulo.wire import COMMANDS, EVENTS
from armspan.errors import ConfigError, DeviceError
from armspan.records import Sheet
from fast_time import START, hasten, now
from fast_time import run as play

ASH, ELM = addresses(2)
STRANGER = "00:06:66:D2:CF:01"
CLI = """
import argparse, sys
from armspan.cli import emulate
parser = argparse.ArgumentParser()
emulate.add_parser(parser.add_subparsers())
args = parser.parse_args(["emulate", "cellulo", *sys.argv[1:]])
sys.exit(args.run(args))
"""


@pytest.fixture(autouse=True)
def _fast(monkeypatch):
    hasten(monkeypatch)


class Peer:
    """A host that speaks the relay's bytes itself."""

    def __init__(self, reader, writer):
        self.reader, self.writer, self.stream = reader, writer, relay.client_side()
        self.heard = []

    def say(self, mac, name, **args):
        self.writer.write(self.stream.pack(mac, COMMANDS.encode(name, **args)))

    def connect(self, mac, status=relay.CONNECTED):
        self.writer.write(self.stream.status(mac, status))

    async def listen(self, seconds):
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                while data := await self.reader.read(4096):
                    self.heard += [(m, EVENTS.decode(p)) for m, p in self.stream.feed(data, now())]
                return False
        return True

    def names(self, mac):
        return [packet.name for who, packet in self.heard if who == mac]

    def statuses(self, mac):
        return [p.args["status"] for who, p in self.heard if who == mac and p.name == "AnnounceConnectionStatus"]


def run(scene, truth=None, **options):
    async def whole():
        firmware = Firmware(places(2, Sheet(0.8, 0.4)), np.zeros(2), Sheet(0.8, 0.4), np.random.default_rng(0))
        emulator = Emulator(firmware, {ASH: "ash", ELM: "elm"}, truth, **options)
        port = asyncio.get_running_loop().create_future()
        task = asyncio.create_task(emulator.serve(0, port.set_result))

        async def peer():
            return Peer(*await asyncio.open_connection("127.0.0.1", await port))

        try:
            await scene(emulator, peer)
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
            await asyncio.sleep(0.02)

    play(whole)


def test_robots_are_connected_by_wish_and_announced_to_the_next_host():
    async def scene(_, peer):
        first = await peer()
        first.connect(ASH)
        first.connect(STRANGER)
        await first.listen(0.2)
        assert first.statuses(ASH) == [relay.CONNECTED]
        assert first.statuses(STRANGER) == [relay.CONNECTING]
        assert first.statuses(ELM) == []
        assert "poseChanged" in first.names(ASH)
        assert "poseChanged" not in first.names(ELM)
        first.writer.close()
        await asyncio.sleep(0.05)
        second = await peer()
        await second.listen(0.2)
        assert second.statuses(ASH) == [relay.CONNECTED]
        second.connect(ASH, relay.DISCONNECTED)
        await second.listen(0.1)
        assert second.statuses(ASH) == [relay.CONNECTED, relay.DISCONNECTED]
        second.heard.clear()
        await second.listen(0.2)
        assert second.heard == []
        second.writer.close()

    run(scene)


def test_one_host_only():
    async def scene(_, peer):
        first, second = await peer(), await peer()
        first.connect(ASH)
        assert not await second.listen(1.0)
        assert await first.listen(0.2)
        assert first.heard
        for each in (first, second):
            each.writer.close()

    run(scene)


def test_robots_go_on_when_their_host_is_gone():
    async def scene(emulator, peer):
        host = await peer()
        host.say(ASH, "setGoalVelocity", vx_mm_s=100, vy_mm_s=0, w_rad_s=0)
        await host.listen(0.3)
        host.writer.transport.abort()
        await asyncio.sleep(0.3)
        fast = emulator.firmware.bodies.velocity[0, 0]
        assert 0.055 < fast < 0.105
        at = emulator.firmware.bodies.pose[0, 0]
        await asyncio.sleep(0.3)
        assert emulator.firmware.bodies.pose[0, 0] > at + 0.2 * fast

    run(scene)


def test_a_host_that_says_nothing_is_dropped_and_its_robots_go_on(monkeypatch):
    monkeypatch.setattr(relay, "SILENCE_S", 0.4)

    async def scene(emulator, peer):
        host = await peer()
        host.say(ASH, "setGoalVelocity", vx_mm_s=100, vy_mm_s=0, w_rad_s=0)
        with contextlib.suppress(ConnectionError):
            assert not await host.listen(2.0)
        assert 0.3 < emulator.now < 1.0
        assert emulator.firmware.bodies.velocity[0, 0] > 0.05
        host.writer.close()

    run(scene)


def test_a_heartbeat_comes_every_second_and_a_half(monkeypatch):
    monkeypatch.setattr(relay, "BEAT_S", 0.2)

    async def scene(_, peer):
        host = await peer()
        began = host.stream.heard
        await host.listen(0.5)
        assert host.stream.heard > began
        host.writer.close()

    run(scene)


def test_an_outage_loses_packets_both_ways_and_keeps_the_goal(monkeypatch):
    monkeypatch.setattr("armspan.devices.cellulo.emulator.OUTAGE", 0.4)

    async def scene(emulator, peer):
        host = await peer()
        host.connect(ASH)
        host.say(ASH, "setGoalVelocity", vx_mm_s=60, vy_mm_s=0, w_rad_s=0)
        await host.listen(0.45)
        assert host.statuses(ASH) == [relay.CONNECTED, relay.CONNECTING]
        host.heard.clear()
        host.say(ASH, "clearTracking")
        await host.listen(0.2)
        assert host.names(ASH) == []
        assert emulator.firmware.bodies.velocity[0, 0] > 0.03
        await host.listen(0.5)
        assert host.statuses(ASH) == [relay.CONNECTED]
        host.writer.close()

    run(scene, outage_at=0.3)


def test_the_truth_is_told_every_20_ms():
    truth = io.StringIO()

    async def scene(_, peer):
        host = await peer()
        await asyncio.sleep(0.1)
        host.say(ASH, "setGoalVelocity", vx_mm_s=100, vy_mm_s=0, w_rad_s=0)
        await host.listen(0.5)
        host.writer.close()
        await asyncio.sleep(0.1)

    run(scene, truth)
    head, *lines = [json.loads(line) for line in truth.getvalue().splitlines()]
    assert head["monotonic"] == pytest.approx(START, abs=0.01)
    assert head["robots"] == ["ash", "elm"]
    t = np.array([line["t"] for line in lines])
    assert np.diff(t) == pytest.approx(0.02, abs=1e-6)
    assert t[-1] == pytest.approx(0.7, abs=0.05)
    ash = np.array([line["robots"]["ash"] for line in lines])
    assert ash[0] == pytest.approx([0.2, 0.2, 0.0])
    assert ash[-1, 0] - ash[0, 0] == pytest.approx(0.02 * ash[:, 2].sum(), rel=0.1)
    assert ash[-1, 2] > 0.05
    assert lines[-1]["robots"]["elm"] == pytest.approx([0.6, 0.2, 0.0])
    assert lines[10]["host"]
    assert not lines[-1]["host"]
    assert lines[-1]["heard"] == pytest.approx(0.1, abs=0.02)


def test_places_and_addresses():
    assert addresses(2) == ("00:06:66:E7:00:01", "00:06:66:E7:00:02")
    assert len(set(addresses(300))) == 300
    xy = np.array(places(7, Sheet(0.9, 0.6, (1.0, 2.0))))
    gaps = np.linalg.norm(xy[:, None] - xy[None], axis=-1)[np.triu_indices(7, 1)]
    assert gaps.min() >= 0.1
    assert (xy >= [1.05, 2.05]).all()
    assert (xy <= [1.85, 2.55]).all()
    with pytest.raises(ConfigError, match=r"50 robots do not fit on a sheet of 0.4 x 0.3 m"):
        places(50, Sheet(0.4, 0.3))


def test_a_port_that_is_taken():
    async def scene(emulator, _):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            port = taken.getsockname()[1]
            with pytest.raises(DeviceError, match=f"port {port} cannot be listened on: .*; try another --port"):
                await emulator.serve(port, print)

    run(scene)


# --- the verb --------------------------------------------------------------------------------------------


def emulate(*options):
    return subprocess.Popen(
        [sys.executable, "-c", CLI, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_verb_says_where_it_listens_and_ends_cleanly(number, tmp_path):
    truth = tmp_path / "truth.jsonl"
    process = emulate("--port", "0", "--robots", "3", "--seed", "2", "--truth", str(truth), "--sheet", "0.6x0.4")
    line = process.stdout.readline()
    assert line.startswith("listening on 127.0.0.1:")
    room, _, macs = process.stdout.readline().partition("  # ")
    assert room == f'relay = "127.0.0.1:{line.rpartition(":")[2].strip()}"'
    assert macs.strip().split(", ") == list(addresses(3))
    with socket.create_connection(("127.0.0.1", int(line.rpartition(":")[2]))) as host:
        host.sendall(relay.client_side().status(ASH, relay.CONNECTED))
        assert host.recv(17)[:2] == b"\x01@"
        process.send_signal(number)
        out, err = process.communicate(timeout=5)
    assert (process.returncode, out, err) == (0, "", "")
    head = json.loads(truth.read_text().splitlines()[0])
    assert head["robots"] == ["r1", "r2", "r3"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--sheet", "wide"), "'wide' is not a size in metres as 0.8x0.6"),
        (("--sheet", "0.8xnan"), "'nan' is not a height in metres from 0.1 to 20"),
        (("--drop", "2"), "'2' is not a share from 0 to 1"),
        (("--robots", "1.5"), "'1.5' is not a number of robots from 1 to 200"),
        (("--latency-ms", "-1"), "'-1' is not a latency in milliseconds from 0 to 5000"),
        (("--fault", "flood@1"), "'flood@1' is no trouble; expected KIND[:ROBOT]@START"),
        (("--pty", "--port", "1"), "not allowed with argument"),
        (("--generation", "v9"), "invalid choice: 'v9'"),
    ],
)
def test_options_that_cannot_be(options, words, capsys):
    with pytest.raises(SystemExit) as ended:
        parsed(*options)
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_each_robot_on_a_pseudo_terminal(tmp_path):
    process = emulate("--pty", "--robots", "2", "--fault", "silence:r2@0.01+60", "--latency-ms", "1")
    told = [process.stdout.readline().split() for _ in range(2)]
    assert [(name, on, path[:9]) for name, on, path in told] == [("r1", "on", "/dev/pts/"), ("r2", "on", "/dev/pts/")]
    lines = [open_raw(path) for _, _, path in told]
    time.sleep(0.3)
    for line in lines:
        os.write(line, COMMANDS.encode("ping"))
    heard = b""
    while b"\x01A" not in heard:
        heard += os.read(lines[0], 999)
    termios.tcflush(lines[1], termios.TCIFLUSH)
    time.sleep(0.2)
    assert not select.select([lines[1]], [], [], 0)[0]
    process.send_signal(signal.SIGTERM)
    out, err = process.communicate(timeout=5)
    for line in lines:
        os.close(line)
    assert (process.returncode, out, err) == (0, "", "")


def open_raw(path):
    line = os.open(path, os.O_RDWR | os.O_NOCTTY)
    tty.setraw(line)
    return line


def test_trouble_of_a_robot_that_is_not_there():
    args = parsed("--fault", "load:r9@1", "--robots", "2")
    with pytest.raises(ConfigError, match="robot 'r9' does not exist; there are: r1, r2"):
        args.run(args)


def test_robots_that_live_by_somebody_elses_clock():
    async def whole():
        firmware = Firmware(places(1, Sheet(0.8, 0.4)), np.zeros(1), Sheet(0.8, 0.4), np.random.default_rng(0))
        clock = [0.0]
        emulator = Emulator(firmware, {ASH: "ash"}, now=lambda: clock[0])
        async with emulator.listening() as port:
            peer = Peer(*await asyncio.open_connection("127.0.0.1", port))
            peer.say(ASH, "setGoalVelocity", vx_mm_s=100, vy_mm_s=0, w_rad_s=0)
            await peer.listen(0.3)
            assert firmware.truth().xy[0, 0] == pytest.approx(0.4)
            for k in range(100):
                clock[0] = k / 100
                emulator.catch_up()
            await peer.listen(0.3)
            assert firmware.truth().xy[0, 0] > 0.43
            assert peer.names(ASH).count("poseChanged") >= 8
            peer.writer.close()

    play(whole)


def test_more_robots_than_fit():
    args = parsed("--robots", "99", "--sheet", "0.3x0.3")
    with pytest.raises(ConfigError, match=r"99 robots do not fit on a sheet of 0.3 x 0.3 m"):
        args.run(args)


def parsed(*options):
    parser = argparse.ArgumentParser()
    verb.add_parser(parser.add_subparsers())
    return parser.parse_args(["emulate", "cellulo", *options])
