"""Robots each over a line of their own: socket pairs stand for the Bluetooth sockets, emulated robots behind them."""

import asyncio
import math

import numpy as np
import pytest

from armspan.devices.cellulo.faults import Faults, Trouble
from armspan.devices.cellulo.flock import Traits
from armspan.devices.cellulo.ring import Ring
from armspan.devices.cellulo.sockets import CelluloSockets, Way
from armspan.devices.cellulo.wire import COMMANDS, EVENTS, Framer
from armspan.errors import DeviceError, DeviceNotFound
from armspan.records import Drive, GoTo, Light, Link, Stop, Touch
from cellulo_lines import NAMES, XY, Host, emulated, paired, place, speed
from devices.promises import check_closes, check_events, check_lost_and_mended
from fast_time import hasten, now, run

GREETING = ["0158", "0158", "01440014", "015401", "0142"]


@pytest.fixture(autouse=True)
def _fast(monkeypatch):
    hasten(monkeypatch)


def test_robots_are_met_one_attempt_at_a_time_seen_and_driven():
    async def scene():
        async with emulated(n=3) as emulator, Host.of(emulator, origin_m=(0.5, 0.5)) as host:
            await host.until(lambda: all(len(host.states(name)) > 40 for name in NAMES))
            assert emulator.radio.most == 1
            for name, xy in zip(NAMES, XY, strict=True):
                assert host.states(name)[-1].xy == pytest.approx(np.array(xy) - 0.5, abs=3e-4)
                assert host.links(name) == [True]
            assert np.diff([state.t for state in host.states()[-15:]]) == pytest.approx(0.022, abs=0.003)
            await host.go(0.8)
            assert speed(emulator) > 0.1
            assert speed(emulator, 1) == 0.0
            await host.swarm.send(Stop(1.0))
            await asyncio.sleep(0.6)
            assert speed(emulator) < 0.002
            check_events(host.events)
            assert host.swarm.refused == 0

    run(scene)


def test_adapters_connect_beside_each_other():
    async def scene():
        async with emulated(n=3) as emulator:
            radio = emulator.radio
            ways = {"ash": radio.way("ash", "A"), "elm": radio.way("elm", "A"), "fir": radio.way("fir", "B")}
            async with Host(CelluloSockets(ways)) as host:
                await host.until(lambda: all(host.links(name) for name in NAMES))
                assert radio.most == 2
                assert [when - radio.attempts[0][0] for when, _ in radio.attempts] == pytest.approx(
                    [0, 0, 0.1], abs=0.03
                )

    run(scene)


def test_a_robot_that_is_away_holds_up_nobody_for_long_and_is_told():
    async def scene():
        async with emulated(troubles=[Trouble("link-loss", 0.01, 6.0, "elm")]) as emulator:
            await asyncio.sleep(0.1)
            async with Host.of(emulator) as host:
                await host.until(lambda: host.links("ash") == [True])
                await host.until(lambda: host.links("elm") == [False])
                await host.until(lambda: host.links("elm") == [False, True], 15)
                assert host.links("ash") == [True]
                tries = [when for when, name in emulator.radio.attempts if name == "elm"]
                assert np.diff(tries[:4]) == pytest.approx([1.5, 2.0, 3.0], abs=0.1)  # the attempt, and the pause

    run(scene)


@pytest.mark.parametrize("gain", [0.6, 1.0])
def test_a_lost_link_leaves_the_robot_at_rest_on_its_short_goal_and_is_mended(gain):
    async def scene():
        trouble = Trouble("link-loss", 2.0, 3.0, "ash")
        async with emulated(gain=(gain, gain), troubles=[trouble]) as emulator, Host.of(emulator) as host:
            await host.until(lambda: host.states())
            driving = asyncio.create_task(host.go(4.0, lead=0.045 if gain == 1.0 else 0.030))
            while emulator.now < 2.0:
                await asyncio.sleep(0.01)
            at = place(emulator)
            assert speed(emulator) > 0.055
            rested = await rest(emulator)
            assert rested < 1.0
            assert math.dist(at, place(emulator)) < 0.060
            await host.until(lambda: host.links() == [True, False])
            await host.until(lambda: host.links() == [True, False, True])
            assert emulator.now - 5.0 < 4.0
            seen = len(host.states())
            await host.until(lambda: len(host.states()) > seen)
            driving.cancel()
            check_lost_and_mended(host.events, "ash")
            assert host.links("elm") == [True]

    run(scene)


async def rest(emulator, slow=0.002):
    """Seconds until the first robot is slower for good."""
    began = last = now()
    while now() - began < 1.5:
        if speed(emulator) >= slow:
            last = now()
        await asyncio.sleep(0.01)
    return last - began


def test_a_silence_without_a_lost_link_is_noticed_and_over_when_it_ends():
    async def scene():
        trouble = Trouble("silence", 1.0, 5.0, "ash")
        async with emulated(troubles=[trouble]) as emulator, Host.of(emulator) as host:
            await host.until(lambda: host.links() == [True, False])
            assert emulator.now == pytest.approx(4.0, abs=0.4)
            await host.until(lambda: host.links() == [True, False, True])
            assert emulator.now == pytest.approx(6.0, abs=0.3)
            assert len([name for _, name in emulator.radio.attempts if name == "ash"]) == 1

    run(scene)


def test_a_link_that_is_stuck_for_long_is_opened_anew():
    async def scene():
        trouble = Trouble("silence", 1.0, 16.0, "ash")
        async with emulated(troubles=[trouble]) as emulator, Host.of(emulator) as host:
            await host.until(lambda: host.links() == [True, False], 8)
            await host.until(lambda: len([name for _, name in emulator.radio.attempts if name == "ash"]) == 2, 15)
            await host.until(lambda: host.links()[-1] and emulator.now > 17, 20)

    run(scene, 60.0)


def test_a_lifted_robot_is_held_and_does_not_resume():
    async def scene():
        trouble = Trouble("kidnap", 1.0, 0.6, "ash")
        async with emulated(troubles=[trouble]) as emulator, Host.of(emulator) as host:
            await host.until(lambda: host.states())
            t = now() - host.began
            await host.swarm.send(GoTo(t, "ash", (2.0, 1.0), 0.1, t + 9))
            await host.until(lambda: host.states()[-1].held)
            await host.until(lambda: not host.states()[-1].held)
            await asyncio.sleep(0.5)
            assert speed(emulator) < 0.002
            assert host.links() == [True]

    run(scene)


def test_closing_stops_the_robots_and_leaves_nothing_behind():
    async def scene():
        async with emulated() as emulator:
            async with Host.of(emulator) as host:
                await host.until(lambda: host.states())
                await host.go(0.6)
                t = now() - host.began
                await host.swarm.send(GoTo(t, "ash", (2.0, 1.0), 0.1, t + 9))
                await asyncio.sleep(0.1)
            at = place(emulator)
            await asyncio.sleep(0.7)
            assert speed(emulator) < 0.002
            assert math.dist(at, place(emulator)) < 0.03
            await host.swarm.send(GoTo(9.0, "ash", (2.0, 1.0), 0.1, 99.0))  # too late, and no error
            swarm = Host.of(emulator).swarm
            await check_closes(swarm.source(), 5)

    run(scene)


class Wire:
    """A robot that only listens, and says what it is told to."""

    def __init__(self):
        self.heard, self.framer, self.line, self.opened = [], Framer(COMMANDS), None, 0

    def way(self, carrier=True):
        async def connect():
            ours, self.line = paired()
            self.opened += 1
            self.ears = asyncio.create_task(self._listen(self.line))
            return ours

        return Way(connect, carrier=carrier)

    async def _listen(self, line):
        while data := await line.read():
            self.heard += [packet.hex() for packet in self.framer.feed(data)]

    def say(self, name, **args):
        self.line.write(EVENTS.encode(name, **args))

    async def close(self):
        self.line.close()
        await self.ears


def hosted(scene, carrier=True, **options):
    async def whole():
        wire = Wire()
        async with Host(CelluloSockets({"ash": wire.way(carrier)}, **options)) as host:
            await host.until(lambda: wire.heard)
            await scene(wire, host)
        await wire.close()

    run(whole)


def test_tracking_is_cleared_before_anything_else_is_said_and_at_the_end_thrice():
    async def whole():
        wire = Wire()
        async with Host(CelluloSockets({"ash": wire.way()})) as host:
            await host.until(lambda: len(wire.heard) >= 5)
            assert wire.heard[:5] == GREETING
            wire.say("acknowledged")
            await asyncio.sleep(0.3)
            wire.heard.clear()
            wire.line.close()
            await host.until(lambda: wire.opened == 2 and len(wire.heard) >= 5)
            assert host.links() == [True, False, True]
            assert wire.heard[:5] == GREETING
            await asyncio.sleep(0.3)
            wire.heard.clear()
        await asyncio.sleep(0.1)
        assert wire.heard.count("0158") == 3
        await wire.close()

    run(whole)


def test_a_quiet_link_is_kept_alive():
    async def scene(wire, host):
        for _ in range(60):
            wire.say("batteryStateChanged", state=0)  # nothing more to be asked
            wire.say("poseChangedTimestamped", x_raw=1000, y_raw=1000, theta_raw=0, timestamp_ms=round(1000 * now()))
            await asyncio.sleep(0.1)
        assert wire.heard.count("0150") == 1

    hosted(scene)


def test_a_robot_that_is_connected_and_never_answers_is_told_in_a_sentence():
    async def scene():
        async with emulated(Faults(generation="old"), n=1) as emulator, Host.of(emulator) as host:
            await host.until(lambda: host.error)
            assert emulator.now == pytest.approx(3.2, abs=0.4)
            assert isinstance(host.error, DeviceError)
            told = str(host.error)
            assert told.startswith(
                "robot 'ash' is connected and answers nothing, not even a ping; firmware from before"
            )
            assert "switch it off and on" in told

    run(scene)


def test_a_serial_port_with_nobody_there_is_a_lost_link_and_no_more():
    async def scene(wire, host):
        await host.until(lambda: host.links() == [False])
        await asyncio.sleep(4.0)
        assert wire.heard.count("0150") >= 5  # it is asked again and again
        assert host.error is None
        wire.heard.clear()
        wire.say("acknowledged")
        await host.until(lambda: host.links() == [False, True])
        await host.until(lambda: "0142" in wire.heard)
        assert wire.heard[wire.heard.index("0158") :][:4] == ["0158", "01440014", "015401", "0142"]

        wire.line.close()  # a port that hung up is opened again
        await host.until(lambda: host.links() == [False, True, False] and wire.opened == 2)

    hosted(scene, carrier=False)


@pytest.mark.parametrize("error", [DeviceError("there is no adapter"), DeviceNotFound("no answer")])
def test_what_a_person_must_mend_is_raised_at_once_and_what_may_pass_is_not(error):
    async def scene():
        async def connect():
            raise error

        async with Host(CelluloSockets({"ash": Way(connect)})) as host:
            await asyncio.sleep(1.0)
            if isinstance(error, DeviceNotFound):
                assert (host.error, host.links()) == (None, [False])
            else:
                assert host.error is error

    run(scene)


def test_a_line_that_is_stuck_holds_no_old_goals():
    async def scene():
        ours, theirs = paired()

        async def connect():
            return ours

        async with Host(CelluloSockets({"ash": Way(connect)})) as host:
            await host.until(lambda: host.links() == [True])
            for k in range(300):  # nobody reads
                t = now() - host.began
                await host.swarm.send(GoTo(t, "ash", (0.001 * k, 0.1), 0.1, t + 0.3))
                await host.swarm.send(Light(t, "ash", (k % 256, 0, 0)))
                await asyncio.sleep(0.004)
            heard, framer = [], Framer(COMMANDS)
            for _ in range(20):
                heard += [COMMANDS.decode(packet) for packet in framer.feed(await theirs.read())]
                await asyncio.sleep(0.01)
            goals = [packet.args["x_mm"] for packet in heard if packet.name == "setGoalPosition"]
            assert goals[-1] > 290  # the latest one comes,
            assert len(goals) < 30  # and of the older ones no more than the system itself held
            theirs.close()

    run(scene)


def test_lights_and_keys_are_counted_from_the_front_clockwise():
    async def scene(wire, host):
        wire.say("poseChanged", x_raw=1000, y_raw=1000, theta_raw=0)
        await host.until(lambda: host.states())
        wire.heard.clear()
        await host.swarm.send(Light(1.0, "ash", (255, 0, 0), 1))
        await host.swarm.send(Light(1.0, "ash", (36, 36, 36)))
        await host.until(lambda: len([text for text in wire.heard if text.startswith("0145")]) == 2)
        # Unity's count: number 0 at the USB side, behind; 60 degrees clockwise from the front is its number 2
        assert [text for text in wire.heard if text.startswith("0145")] == ["014501ff000002", "01450024242500"]
        wire.say("touchBegan", key=5)
        await host.until(lambda: any(isinstance(event, Touch) for event in host.events))
        (touch,) = [event for event in host.events if isinstance(event, Touch)]
        assert (touch.key, touch.kind) == (4, "began")

    hosted(scene, traits={"ash": Traits(ring=Ring(180.0, "counterclockwise"))})


def test_what_cannot_be_sent():
    async def scene(wire, host):
        with pytest.raises(DeviceNotFound, match="robot 'oak' does not exist; there are: ash"):
            await host.swarm.send(Stop(0.0, "oak"))
        with pytest.raises(DeviceError, match="'ash' was told a velocity"):
            await host.swarm.send(Drive(0.0, "ash", (0.1, 0.0), 0.0, 1.0))

    hosted(scene)


def test_a_robot_that_loses_its_first_commands_is_set_up_in_the_end():
    async def scene():
        async with emulated(Faults(deaf=3), n=1) as emulator, Host.of(emulator) as host:
            emulator.firmware.met(0)
            await host.until(lambda: bool(emulator.firmware.localisation.stamped[0]))
            await host.until(lambda: host.states()[-1].battery == 0.5)
            assert host.links() == [True]

    run(scene)


def test_bursts_and_latency_and_loss_are_borne():
    async def scene():
        faults = Faults(latency_s=0.05, drop=0.1, burst_s=0.1, sniff_s=0.2)
        async with emulated(faults, n=1) as emulator, Host.of(emulator) as host:
            await host.until(lambda: len(host.states()) > 20)
            await host.go(1.5)
            assert speed(emulator) > 0.05
            await host.swarm.send(Stop(1.0))
            await asyncio.sleep(1.0)
            assert speed(emulator) < 0.002
            assert Link(pytest.approx(0.0, abs=99), "ash", False) not in host.events
            check_events(host.events)

    run(scene)
