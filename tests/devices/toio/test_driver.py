import asyncio
import contextlib

import numpy as np
import pytest

from armspan.devices.toio import driver
from armspan.devices.toio.driver import ToioCubes
from armspan.devices.toio.entry import ToioEntry
from armspan.devices.toio.robot import STANDSTILL
from armspan.errors import ConfigError, DeviceError, DeviceNotFound
from armspan.links.ble_emulated import LinkFaults
from armspan.records import Drive, GoTo, Light, Stop
from devices.promises import check_events, check_lost_and_mended
from devices.toio.scenes import TRUE, Host, emulated
from fast_time import run

TWO = ((0.15, 0.2), (0.4, 0.4))


def test_cubes_are_met_seen_and_driven():
    async def scene():
        async with emulated(TWO, (0.0, 1.0), chassis=TRUE) as air, Host(air) as host:
            await host.met()
            await host.until(lambda: len(host.states("b")) > 60)
            assert host.links("a") == host.links("b") == [True]
            for name, xy in zip("ab", TWO, strict=True):
                seen = np.array([state.xy for state in host.states(name)])
                assert seen.mean(axis=0) == pytest.approx(xy, abs=5e-4)
            assert np.diff([state.t for state in host.states()[-30:]]) == pytest.approx(0.02, abs=0.011)
            assert host.states()[-1].battery == 1.0
            await host.go(1.0)
            assert host.speed() > 0.1
            assert host.speed(1) == 0.0
            assert air.mat.pose[0, 0] > 0.23
            check_events(host.events)

    run(scene, 60)


def test_a_goal_with_a_heading_is_reached_at_that_heading():
    async def scene():
        async with emulated(TWO, (3.0, 1.0)) as air, Host(air) as host:
            await host.met()
            for _ in range(60):
                await host.swarm.send(GoTo(host.t, "a", (0.18, 0.22), 0.15, host.t + 0.3, heading=5.0))
                await asyncio.sleep(0.05)
            places, headings, velocities = air.mat.truth()
            assert places[0] == pytest.approx((0.18, 0.22), abs=0.005)
            assert headings[0] == pytest.approx(5.0, abs=0.1)
            assert np.abs(velocities).max() < 0.005

    run(scene, 60)


def test_a_stop_stops_at_once_even_where_writes_get_lost():
    async def scene():
        faults = LinkFaults(write_loss=0.3, latency_s=0.01)
        async with emulated(TWO, chassis=TRUE, faults=faults) as air, Host(air) as host:
            await host.met()
            await host.go(0.8)
            before = air.mat.pose[0, 0]
            await host.swarm.send(Stop(host.t))
            await asyncio.sleep(0.6)
            assert host.speed() < 0.002
            assert air.mat.pose[0, 0] - before < 0.03

    run(scene, 60)


def test_a_lease_that_ends_is_a_stop_well_before_the_goal():
    async def scene():
        async with emulated(TWO, chassis=TRUE) as air, Host(air) as host:
            await host.met()
            await host.swarm.send(GoTo(host.t, "a", (0.5, 0.2), 0.1, host.t + 0.3))
            await asyncio.sleep(1.0)
            assert host.speed() < 0.001
            assert 0.165 < air.mat.pose[0, 0] < 0.185

    run(scene, 60)


def test_an_untimed_command_never_leaves_but_for_standstill(monkeypatch):
    written, write = [], driver._write
    monkeypatch.setattr(driver, "_write", lambda client, packet: (written.append(packet), write(client, packet))[1])

    async def scene():
        async with emulated(TWO) as air, Host(air) as host:
            await host.met()
            await host.go(1.0)
            await host.swarm.send(Stop(host.t))
            await asyncio.sleep(0.2)

    run(scene, 60)
    motors = [data for characteristic, data in written if characteristic == "motor"]
    pulses = [data for data in motors if ("motor", data) != STANDSTILL]
    assert len(pulses) >= 19
    assert all(data[0] == 2 and 1 <= data[7] <= 20 for data in pulses)  # timed, 10 to 200 ms


def test_closing_the_source_stops_the_cubes():
    async def scene():
        async with emulated(TWO, chassis=TRUE) as air:
            async with Host(air) as host:
                await host.met()
                await host.go(0.5)
                await host.swarm.send(GoTo(host.t, "a", (0.5, 0.2), 0.15, host.t + 9))
                await asyncio.sleep(0.02)
            assert air.mat.cubes[0].wheels == (0, 0)
            await host.swarm.send(GoTo(host.t, "a", (0.5, 0.2), 0.15, host.t + 9))  # too late: nothing happens
            await asyncio.sleep(0.5)
            assert np.hypot(*air.mat.velocity[:, 0]) < 0.002

    run(scene, 60)


def test_closing_leaves_no_task_behind():
    async def scene():
        async with emulated(TWO[:1]) as air:
            source = ToioCubes(air.entries, radio=air.radio).source()
            for _ in range(5):
                await anext(source)
            await asyncio.wait_for(source.aclose(), 5.0)
            left = {task.get_coro().__qualname__ for task in asyncio.all_tasks()}
            assert not [name for name in left if name.startswith(("ToioCubes", "Host", "_first_of"))]

    run(scene, 60)


def test_a_link_that_breaks_is_told_and_mended():
    async def scene():
        async with emulated(TWO, chassis=TRUE) as air, Host(air) as host:
            await host.met()
            air.cut(air.entries[0].address, 0.5)
            broke = host.t
            await host.until(lambda: host.links() == [True, False])
            assert host.t - broke < 1.0
            await host.until(lambda: host.links()[-1])
            await host.until(lambda: host.states()[-1].t > broke + 0.6)
            assert host.t - broke < 5.0
            check_lost_and_mended(host.events, "a")
            assert host.links("b") == [True]
            assert len([state for state in host.states("b") if state.t > broke]) > 25  # the other never faltered
            await host.go(0.6)
            assert host.speed() > 0.1

    run(scene, 60)


def test_a_cube_that_is_not_there_yet_is_waited_for():
    async def scene():
        async with emulated(TWO, chassis=TRUE) as air:
            later = air.entries[1].address
            air.cut(later, 6.0)
            async with Host(air, connect_s=2.0) as host:
                await host.until(lambda: host.states("a") and host.links("b") == [False], 20)
                await host.until(lambda: host.states("b"), 30)
                assert host.links("b") == [False, True]

    run(scene, 90)


def test_a_lifted_cube_is_held_and_stands_when_it_is_put_down():
    async def scene():
        async with emulated(TWO, chassis=TRUE) as air, Host(air) as host:
            await host.met()
            await host.go(0.5)
            await host.swarm.send(GoTo(host.t, "a", (0.5, 0.2), 0.15, host.t + 9))
            await asyncio.sleep(0.1)
            air.mat.lift(0)
            await host.until(lambda: host.states()[-1].held)
            air.mat.put_down(0, (0.1, 0.5), 2.0)
            await host.until(lambda: not host.states()[-1].held)
            await asyncio.sleep(0.5)
            assert host.states()[-1].xy == pytest.approx((0.1, 0.5), abs=0.004)
            assert host.states()[-1].heading == pytest.approx(2.0, abs=0.08)
            assert air.mat.cubes[0].wheels == (0, 0)

    run(scene, 60)


def test_the_button_and_the_light():
    async def scene():
        async with emulated(TWO) as air, Host(air) as host:
            await host.met()
            air.mat.cubes[0].press(True)
            await asyncio.sleep(1.2)
            air.mat.cubes[0].press(False)
            await asyncio.sleep(0.1)
            assert host.touches() == ["began", "long", "released"]
            await host.swarm.send(Light(host.t, "b", (10, 20, 30)))
            await asyncio.sleep(0.2)
            assert [cube.light for cube in air.mat.cubes] == [(0, 0, 0), (10, 20, 30)]

    run(scene, 60)


def test_lights_do_not_hold_motions_back():
    async def scene():
        faults = LinkFaults(latency_s=0.03)  # a light waits for its confirmation: 60 ms and more
        async with emulated(TWO, chassis=TRUE, faults=faults) as air, Host(air) as host:
            await host.met()

            async def flicker():
                while True:
                    await host.swarm.send(Light(host.t, "a", (int(1000 * host.t) % 255, 0, 0)))
                    await asyncio.sleep(0.02)

            task = asyncio.create_task(flicker())
            await host.go(1.0)
            task.cancel()
            assert air.mat.pose[0, 0] > 0.24

    run(scene, 60)


def test_old_system_software_is_one_sentence(monkeypatch):
    monkeypatch.setattr("armspan.devices.toio.cube.VERSION", "2.1.0")

    async def scene():
        async with emulated(TWO[:1]) as air, contextlib.aclosing(ToioCubes(air.entries, radio=air.radio).source()) as s:
            async for _ in s:
                pass

    with pytest.raises(DeviceError, match=r"'a'.*speaks protocol 2\.1\.0; 2\.2 or later"):
        run(scene, 60)


def test_what_cannot_be_sent_is_refused():
    async def scene():
        async with emulated(TWO) as air, Host(air) as host:
            with pytest.raises(DeviceNotFound, match="'c' does not exist; there are: a, b"):
                await host.swarm.send(Light(0.0, "c", (0, 0, 0)))
            with pytest.raises(DeviceError, match="sideways"):
                await host.swarm.send(Drive(0.0, "a", (0.1, 0.0), 0.0, 1.0))

    run(scene, 60)


def test_two_of_one_name_or_address():
    with pytest.raises(ConfigError, match="two toio cubes have the address D0:8B:7F:00:00:01"):
        ToioCubes([ToioEntry("a", "D0:8B:7F:00:00:01"), ToioEntry("b", "d0:8b:7f:00:00:01")])
    with pytest.raises(ConfigError, match="the name a"):
        ToioCubes([ToioEntry("a", "D0:8B:7F:00:00:01"), ToioEntry("a", "D0:8B:7F:00:00:02")])
