import asyncio
import contextlib
import socket
import time

import numpy as np
import pytest

from armspan.devices.cellulo import relay
from armspan.devices.cellulo.driver import CelluloRelay
from armspan.devices.cellulo.emulator import Emulator, addresses
from armspan.devices.cellulo.firmware import Faults, Firmware
from armspan.devices.cellulo.flock import Traits
from armspan.devices.cellulo.wire import EVENTS
from armspan.errors import ConfigError, DeviceError, DeviceNotFound
from armspan.records import Drive, GoTo, Light, Link, Press, RobotState, Sheet, Stop
from armspan.session import Session
from armspan.simulation.bodies import Plant
from fast_time import hasten, now, run

ASH, ELM = addresses(2)
XY = ((0.2, 0.2), (0.4, 0.4))


@pytest.fixture(autouse=True)
def _fast(monkeypatch):
    hasten(monkeypatch)


@contextlib.asynccontextmanager
async def emulated(faults=None, **options):
    firmware = Firmware(XY, np.zeros(2), Sheet(0.8, 0.6), np.random.default_rng(0), Plant(gain=(1.0, 1.0)), faults)
    emulator = Emulator(firmware, {ASH: "ash", ELM: "elm"}, **options)
    port = asyncio.get_running_loop().create_future()
    task = asyncio.create_task(emulator.serve(0, port.set_result))
    emulator.port = await port
    try:
        yield emulator
    finally:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task


class Host:
    """A driver whose events are kept."""

    def __init__(self, port, **options):
        self.swarm = CelluloRelay({"ash": ASH, "elm": ELM}, port=port, **options)
        self.events, self.began = [], now()

    async def __aenter__(self):
        self._ears = asyncio.create_task(self._listen())
        return self

    async def __aexit__(self, *_):
        self._ears.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await self._ears

    async def _listen(self):
        async with contextlib.aclosing(self.swarm.source()) as source:
            async for event in source:
                self.events.append(event)

    async def until(self, true, seconds=6.0):
        async with asyncio.timeout(seconds):
            while not true():
                await asyncio.sleep(0.01)

    def states(self, robot="ash"):
        return [event for event in self.events if isinstance(event, RobotState) and event.robot == robot]

    def links(self, robot="ash"):
        return [event.up for event in self.events if isinstance(event, Link) and event.source == robot]

    async def go(self, seconds, robot="ash", lead=0.045):
        """Drive a robot to the right for a while."""
        end = now() + seconds
        while now() < end:
            x, y = self.states(robot)[-1].xy
            t = now() - self.began
            await self.swarm.send(GoTo(t, robot, (x + lead, y), 0.3, t + 0.3))
            await asyncio.sleep(0.05)


def speed(emulator, robot=0):
    return float(np.hypot(*emulator.firmware.bodies.velocity[:2, robot]))


def test_robots_are_met_seen_and_driven_by_goals():
    async def scene():
        async with emulated() as emulator, Host(emulator.port) as host:
            await host.until(lambda: len(host.states("ash")) > 60 and len(host.states("elm")) > 60)
            seen = host.states()
            assert seen[-1].xy == pytest.approx(XY[0], abs=3e-4)
            assert host.states("elm")[-1].xy == pytest.approx(XY[1], abs=3e-4)
            assert np.diff([state.t for state in seen[-15:]]) == pytest.approx(0.022, abs=0.003)
            assert host.links() == [True]
            await host.go(0.8)
            assert speed(emulator) > 0.1
            await host.until(lambda: host.states()[-1].battery == 0.5)
            assert speed(emulator, 1) == 0.0
            assert host.swarm.refused == 0

    run(scene)


def test_a_stop_stops_at_once():
    async def scene():
        async with emulated() as emulator, Host(emulator.port) as host:
            await host.until(lambda: host.states())
            await host.go(0.8)
            await host.swarm.send(Stop(1.0))
            await asyncio.sleep(0.6)
            assert speed(emulator) < 0.002

    run(scene)


def test_a_lease_that_ends_is_a_stop_well_before_the_goal():
    async def scene():
        async with emulated() as emulator, Host(emulator.port) as host:
            await host.until(lambda: host.states())
            t = now() - host.began
            await host.swarm.send(GoTo(t, "ash", (0.7, 0.2), 0.1, t + 0.3))
            await asyncio.sleep(1.2)
            assert speed(emulator) < 0.002
            assert 0.205 < emulator.firmware.bodies.pose[0, 0] < 0.28

    run(scene)


def test_closing_the_source_stops_the_robots():
    async def scene():
        async with emulated() as emulator:
            async with Host(emulator.port) as host:
                await host.until(lambda: host.states())
                await host.go(0.6)
                t = now() - host.began
                await host.swarm.send(GoTo(t, "ash", (0.7, 0.2), 0.1, t + 9))
                await asyncio.sleep(0.1)
            await asyncio.sleep(0.7)
            assert speed(emulator) < 0.002
            assert emulator.firmware.bodies.pose[0, 0] < 0.4
            await host.swarm.send(GoTo(9.0, "ash", (0.7, 0.2), 0.1, 99.0))  # too late, and no error
            await host.swarm.send(Stop(9.0))

    run(scene)


def test_commands_are_lost_and_a_stop_is_not():
    async def scene():
        async with emulated(Faults(drop=0.3)) as emulator, Host(emulator.port) as host:
            await host.until(lambda: len(host.states()) > 5)
            await host.go(0.8)
            assert speed(emulator) > 0.08
            await host.swarm.send(Stop(1.0))
            await asyncio.sleep(0.7)
            assert speed(emulator) < 0.002

    run(scene)


def test_a_lost_robot_link_is_told_and_mended_and_nothing_resumes(monkeypatch):
    monkeypatch.setattr("armspan.devices.cellulo.emulator.OUTAGE", 0.5)

    async def scene():
        async with emulated(outage_at=0.5) as emulator, Host(emulator.port) as host:
            await host.until(lambda: host.links() == [True, False])
            await host.until(lambda: host.links() == [True, False, True])
            seen = len(host.states())
            await host.until(lambda: len(host.states()) > seen + 5)
            assert speed(emulator) == 0.0

    run(scene)


def test_a_lifted_robot_is_told_as_held_and_does_not_resume(monkeypatch):
    monkeypatch.setattr("armspan.devices.cellulo.emulator.ASIDE", 0.5)

    async def scene():
        async with emulated(kidnap_at=0.5) as emulator, Host(emulator.port) as host:
            await host.until(lambda: host.states())
            t = now() - host.began
            await host.swarm.send(GoTo(t, "ash", (0.7, 0.2), 0.1, t + 9))
            await host.until(lambda: host.states()[-1].held)
            await host.until(lambda: not host.states()[-1].held)
            await asyncio.sleep(0.5)
            assert speed(emulator) < 0.002
            assert host.links() == [True]

    run(scene)


def test_a_relay_that_comes_late_and_goes_and_comes_again():
    async def scene():
        async with emulated() as emulator:
            port = emulator.port
        async with Host(port, retry_s=0.2, patience_s=9.0) as host:
            await host.until(lambda: host.links() == [False])
            for met in (1, 2):
                firmware = Firmware(XY, np.zeros(2), Sheet(0.8, 0.6), np.random.default_rng(0))
                again = Emulator(firmware, {ASH: "ash", ELM: "elm"})
                task = asyncio.create_task(again.serve(port, lambda _: None))
                await host.until(lambda met=met: host.links() == [False] + [True, False] * (met - 1) + [True])
                task.cancel()
                await asyncio.gather(task, return_exceptions=True)
                await host.until(lambda met=met: host.links() == [False] + [True, False] * met)

    run(scene)


def test_a_relay_that_is_not_there_is_told_at_once():
    async def scene():
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        began = now()
        with pytest.raises(DeviceNotFound, match=f"the relay at 127.0.0.1:{port} was not heard .*refused"):
            await anext(CelluloRelay({"ash": ASH}, port=port).source())
        assert now() - began < 0.1

    run(scene)


def test_a_robot_that_is_connected_and_never_answers():
    async def scene():
        pool = Pool()
        server = await asyncio.start_server(pool.take, "127.0.0.1", 0)
        async with server:
            source = CelluloRelay({"ash": ASH, "elm": ELM}, port=server.sockets[0].getsockname()[1], now=now).source()
            waiting = asyncio.ensure_future(anext(source))
            while not pool.heard:
                await asyncio.sleep(0.01)
            pool.writer.write(pool.stream.status(ASH, relay.CONNECTED))
            assert await waiting == Link(pytest.approx(now()), "ash", True)
            began = now()
            assert (await anext(source)).up is False
            with pytest.raises(DeviceError, match="robot 'ash' is connected and answers nothing, not even a ping"):
                await anext(source)
            assert now() - began == pytest.approx(3.0, abs=0.3)
            assert [packet for mac, packet in pool.heard].count("0150") >= 2

    run(scene)


def test_a_robot_that_never_answers_later_on_is_only_lost(monkeypatch):
    monkeypatch.setattr("armspan.devices.cellulo.flock.OPENING_S", 2.0)

    async def scene():
        pool = Pool()
        server = await asyncio.start_server(pool.take, "127.0.0.1", 0)
        async with server, Host(server.sockets[0].getsockname()[1]) as host:
            await host.until(lambda: pool.writer is not None)
            pool.writer.write(pool.stream.status(ASH, relay.CONNECTED))
            await host.until(lambda: host.links() == [True, False])
            await asyncio.sleep(1.0)
            assert not host._ears.done()

    run(scene)


def test_a_robot_is_asked_for_by_its_adapter():
    async def scene():
        pool = Pool()
        server = await asyncio.start_server(pool.take, "127.0.0.1", 0)
        traits = {"elm": Traits(adapter="00:1A:7D:DA:71:13")}
        async with server, Host(server.sockets[0].getsockname()[1], traits=traits) as host:
            await host.until(lambda: len(pool.heard) >= 4)
            assert (ASH, "012102000000000000") in pool.heard
            assert (ELM, "012102001a7dda7113") in pool.heard
            assert host.swarm.names == ("ash", "elm")

    run(scene)


class Mind:
    """Drives to the right, then is not itself any more."""

    def __init__(self, began):
        self.began, self.states = began, 0

    def step(self, event):
        if isinstance(event, Press):
            return [Stop(event.t)]
        if not isinstance(event, RobotState) or event.robot != "ash":
            return []
        self.states += 1
        if self.states == 40:
            raise ZeroDivisionError("a behaviour went wrong")
        x, y = event.xy
        return [GoTo(event.t, "ash", (x + 0.3, y), 0.15, now() - self.began + 9.0)]


def test_an_exception_in_the_mind_of_a_session_leaves_the_robots_at_rest():
    async def scene():
        async with emulated() as emulator:
            swarm = CelluloRelay({"ash": ASH, "elm": ELM}, port=emulator.port)
            with pytest.raises(ZeroDivisionError, match="a behaviour went wrong"):
                await Session(Mind(now()), swarm).run([swarm.source()])
            at = emulator.firmware.bodies.pose[0, 0]
            assert at > 0.23
            await asyncio.sleep(0.6)
            assert speed(emulator) < 0.002
            assert emulator.firmware.bodies.pose[0, 0] < at + 0.03

    run(scene)


class Pool:
    """A relay that keeps what it hears, and says only what it is told to."""

    def __init__(self):
        self.heard, self.stream, self.writer = [], relay.server_side(), None

    async def take(self, reader, writer):
        self.writer = writer
        self.stream = relay.server_side()
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(4096):
                self.heard += [(mac, packet.hex()) for mac, packet in self.stream.feed(data, 0.0)]
        writer.close()


def test_tracking_is_cleared_before_anything_else_is_said():
    async def scene():
        pool = Pool()
        server = await asyncio.start_server(pool.take, "127.0.0.1", 0)
        async with server, Host(server.sockets[0].getsockname()[1], retry_s=0.1) as host:
            await host.until(lambda: len(pool.heard) == 4)
            hello = [(ASH, "0158"), (ASH, "012102000000000000"), (ELM, "0158"), (ELM, "012102000000000000")]
            assert pool.heard == hello
            pool.writer.write(pool.stream.status(ASH, relay.CONNECTED))
            await host.until(lambda: host.links() == [True])
            await host.until(lambda: len(pool.heard) >= 8)
            assert [packet for _, packet in pool.heard[4:8]] == ["0158", "01440014", "015401", "0142"]
            pool.writer.write(pool.stream.pack(ASH, EVENTS.encode("poseChanged", x_raw=1, y_raw=1, theta_raw=0)))
            await host.until(lambda: host.states())
            pool.heard.clear()
            pool.writer.close()
            await host.until(lambda: host.links() == [True, False])
            await host.until(lambda: len(pool.heard) >= 4)
            assert pool.heard[:4] == hello
            pool.heard.clear()
        await asyncio.sleep(0.1)
        assert [mac for mac, packet in pool.heard if packet == "0158"] == [ASH, ELM] * 3  # the end

    run(scene)


def test_a_relay_without_a_heartbeat_is_given_up(monkeypatch):
    monkeypatch.setattr(relay, "SILENCE_S", 0.6)

    async def scene():
        pool = Pool()
        server = await asyncio.start_server(pool.take, "127.0.0.1", 0)
        async with server, Host(server.sockets[0].getsockname()[1], retry_s=0.1) as host:
            await host.until(lambda: pool.writer is not None)
            pool.writer.write(pool.stream.status(ASH, relay.CONNECTED))
            await host.until(lambda: host.links() == [True, False])

    run(scene)


def test_a_relay_that_does_not_read_does_not_hold_up_the_session():
    async def scene():
        over = asyncio.Event()

        async def deaf(reader, writer):
            writer.write(relay.server_side().status(ASH, relay.CONNECTED))
            await over.wait()
            writer.transport.abort()

        server = await asyncio.start_server(deaf, "127.0.0.1", 0, limit=1)
        async with Host(server.sockets[0].getsockname()[1]) as host:
            await host.until(lambda: host.links() == [True])
            began, late = time.perf_counter(), 0.0
            for k in range(2000):
                at = time.perf_counter()
                await host.swarm.send(Light(0.0, "ash", (k % 256, 0, 0)))
                await host.swarm.send(GoTo(0.0, "ash", (0.1, 0.1), 0.1, 1e9))
                late = max(late, time.perf_counter() - at)
                if k % 10 == 0:
                    await asyncio.sleep(0)
            assert time.perf_counter() - began < 2.0
            assert late < 0.2
            over.set()
        server.close()

    run(scene)


def test_what_cannot_be_sent():
    async def scene():
        async with emulated() as emulator, Host(emulator.port) as host:
            with pytest.raises(DeviceNotFound, match="robot 'oak' does not exist; there are: ash, elm"):
                await host.swarm.send(Stop(0.0, "oak"))
            with pytest.raises(DeviceError, match="'ash' was told a velocity"):
                await host.swarm.send(Drive(0.0, "ash", (0.1, 0.0), 0.0, 1.0))

    run(scene)


def test_addresses_that_are_none():
    with pytest.raises(ConfigError, match="robot 'ash' has the address '00:06:66'; expected six pairs"):
        CelluloRelay({"ash": "00:06:66"})
    with pytest.raises(ConfigError, match=r"robot 'elm' has the address .* of another one"):
        CelluloRelay({"ash": ASH, "elm": ASH.lower()})
    with pytest.raises(ConfigError, match="scale is 0"):
        CelluloRelay({"ash": ASH}, scale=0.0)
