"""One interface for all robots: the conductor's behaviours and last filter, made for robots that drive any way at once,
drive cubes with two wheels, one light and no keys."""

import asyncio

import numpy as np
import pytest

from armspan.links.ble_emulated import LinkFaults
from armspan.records import GoTo, Sheet, Stop, Zone
from armspan.study.safety import SafetyWatch
from devices.toio.scenes import LIMITS, SIDE, Host, emulated, mind
from fast_time import run

CORNERS = 2 * 0.0225
"""Nearer than this, two cubes may touch."""
XY = ((0.10, 0.12), (0.45, 0.15), (0.14, 0.45), (0.40, 0.40))
GARDEN = Zone("garden", ((0.1, 0.1), (0.4, 0.1), (0.4, 0.4), (0.1, 0.4)))
HEADINGS = (2.0, 4.5, 0.3, 6.0)


async def behave(host, name, seconds, spot="0.28 0.28"):
    """Play a behaviour to its end; how long it took [s]."""
    began = host.t
    await host.press("point", spot)
    await host.press("behaviour", name)
    await host.until(lambda: not host.mind.steering.director.running, seconds)
    return host.t - began


@pytest.mark.parametrize(
    ("faults", "seed"), [(LinkFaults(), 0), (LinkFaults(loss=0.02, write_loss=0.02, latency_s=0.015), 1)]
)
def test_cubes_gather_and_deploy_and_never_touch(faults, seed):
    async def scene():
        async with emulated(XY, HEADINGS, faults, seed=seed) as air, Host(air, mind(4)) as host:
            await host.met()
            assert await behave(host, "gather", 8) < 6
            middle = air.mat.pose[:2].mean(axis=1)
            assert middle == pytest.approx((0.28, 0.28), abs=0.01)
            assert np.hypot(*(air.mat.pose[:2] - middle[:, None])).max() < 0.1
            assert await behave(host, "deploy", 10) < 7
            quarters = {tuple(at > SIDE / 2) for at in air.mat.pose[:2].T}
            assert len(quarters) == 4  # a square sheet is shared by four equally
            await asyncio.sleep(0.6)
            assert max(host.speed(k) for k in range(4)) < 0.005
            assert air.mat.contacts == 0
            assert host.least > CORNERS + LIMITS.gap_m

    run(scene, 90)


def test_cubes_sweep_a_zone_and_the_filter_keeps_its_word():
    async def scene():
        watch = SafetyWatch(LIMITS, Sheet(SIDE, SIDE), body=0.0225)
        async with emulated(XY[:3], HEADINGS[:3], seed=2) as air, Host(air, mind(3, zones=(GARDEN,))) as host:
            await host.met()
            assert await behave(host, "sweep@garden", 20) < 15
            stopped = host.t
            await host.press("stop")
            await asyncio.sleep(0.5)
            assert max(host.speed(k) for k in range(3)) < 0.002
            assert air.mat.contacts == 0
            assert host.least > CORNERS + LIMITS.gap_m
            for record in host.told:
                watch.take(record)
            assert watch.violations == {}
            assert [r for r in host.told if isinstance(r, GoTo) and r.t > stopped] == []
            assert any(isinstance(r, Stop) and r.robot is None for r in host.told)

    run(scene, 90)
