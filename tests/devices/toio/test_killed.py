"""Cubes whose host dies, freezes, or whose link breaks come to rest by themselves: within 1.0 s and 60 mm."""

import asyncio
import math

import numpy as np
import pytest

from armspan.devices.toio import driver
from armspan.devices.toio.mat import Chassis
from armspan.links.ble_emulated import LinkFaults
from armspan.records import GoTo, Stop
from devices.toio.scenes import Host, emulated
from fast_time import now, run

AT_REST = 0.005
RESTS_S, RESTS_M = 1.0, 0.060


async def rested(host, seconds=2.0):
    """How long [s] the first cube drove on from now, and how far [m]."""
    mat, start, began = host.air.mat, host.air.mat.pose[:2, 0].copy(), now()
    last, way, before = 0.0, 0.0, start
    while now() - began < seconds:
        await asyncio.sleep(0.01)
        here = mat.pose[:2, 0].copy()
        way, before = way + float(np.hypot(*(here - before))), here
        if host.speed() > AT_REST:
            last = now() - began
    return last, way


async def full_speed(host, speed):
    """Drive until it is as fast as it gets, then tell a goal far ahead with a long lease, as bad as can be."""
    await host.go(1.0, speed=speed)
    assert host.speed() > 0.13
    await host.swarm.send(GoTo(host.t, "a", (0.55, 0.2), speed, host.t + 0.3))
    await asyncio.sleep(0.02)


@pytest.mark.parametrize(("speed", "lag"), [(0.15, 0.05), (0.15, 0.1), (0.15, 0.15), (0.2, 0.1), (0.3, 0.1)])
def test_a_cube_whose_link_breaks_rests(speed, lag):
    async def scene():
        chassis = Chassis(lag=lag, gain=(1.02, 1.02))
        async with emulated([(0.08, 0.2)], chassis=chassis) as air, Host(air, retry_s=30.0) as host:
            await host.met()
            await full_speed(host, speed)
            air.cut(air.entries[0].address, 30.0)
            seconds, way = await rested(host)
            assert 0.05 < seconds < RESTS_S
            assert 0.01 < way < RESTS_M

    run(scene, 60)


@pytest.mark.parametrize("dead", ["killed", "frozen"])
def test_a_cube_whose_host_writes_no_more_rests(monkeypatch, dead):
    async def nothing(client, packet):
        if dead == "frozen":
            await asyncio.sleep(math.inf)

    async def scene():
        async with emulated([(0.08, 0.2)], chassis=Chassis(gain=(1.02, 1.02))) as air, Host(air) as host:
            await host.met()
            await full_speed(host, 0.15)
            with monkeypatch.context() as patch:
                patch.setattr(driver, "_write", nothing)  # the link holds, and the cube hears nothing
                seconds, way = await rested(host)
            assert 0.05 < seconds < RESTS_S
            assert 0.01 < way < RESTS_M

    run(scene, 60)


def test_a_stop_under_loss_and_latency():
    async def scene():
        faults = LinkFaults(loss=0.05, write_loss=0.05, latency_s=0.04)
        async with emulated([(0.08, 0.2)], faults=faults) as air, Host(air) as host:
            await host.met()
            await full_speed(host, 0.15)
            await host.swarm.send(Stop(host.t))
            seconds, way = await rested(host)
            assert seconds < 0.5
            assert way < 0.035

    run(scene, 60)


def test_a_cube_that_comes_back_does_not_drive_on():
    async def scene():
        async with emulated([(0.08, 0.2)]) as air, Host(air) as host:
            await host.met()
            await full_speed(host, 0.15)
            air.cut(air.entries[0].address, 0.5)
            await host.until(lambda: host.links() == [True, False, True])
            at = air.mat.pose[0, 0]
            await asyncio.sleep(1.0)
            assert abs(air.mat.pose[0, 0] - at) < 0.002

    run(scene, 60)


def test_a_cube_that_still_obeyed_another_host_stands_still_once_it_is_met():
    async def scene():
        async with emulated([(0.08, 0.2)]) as air:
            air.mat.cubes[0].write(0.0, "motor", bytes.fromhex("01010109020209"))  # turns on the spot, for ever
            async with Host(air) as host:
                await host.met()
                await asyncio.sleep(0.5)
                assert air.mat.cubes[0].wheels == (0, 0)

    run(scene, 60)
