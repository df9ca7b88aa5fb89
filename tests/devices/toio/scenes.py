"""Emulated cubes, the driver and a mind between them, for the tests beside this file."""

import asyncio
import contextlib
import math

import numpy as np
from scipy.spatial.distance import pdist

from armspan.conductor.robots_only import RobotsOnly
from armspan.conductor.settings import Settings
from armspan.devices.toio.driver import ToioCubes
from armspan.devices.toio.entry import ToioEntry
from armspan.devices.toio.mat import Chassis, Mat
from armspan.devices.toio.peripheral import peripherals
from armspan.devices.toio.quantities import UNIT_M
from armspan.links.ble_emulated import emulated_radio
from armspan.records import Body, GoTo, Link, Press, RobotState, Sheet, Tick, Touch
from armspan.session import latest
from armspan.swarm.limits import Limits
from fast_time import now

SIDE = 410 * UNIT_M
LIMITS = Limits(body_radius_m=0.024)
"""A cube of 31.8 mm has its corners 22.5 mm from its middle; a position ID is 1.4 mm."""
TRUE = Chassis(gain=(1.0, 1.0), mismatch=0.0)


@contextlib.asynccontextmanager
async def emulated(xy, heading=None, faults=None, chassis=None, seed=0):
    """The air with cubes on a ring mat; ``air.mat`` is what is true, ``air.entries`` names them a, b, c ..."""
    rng = np.random.default_rng(seed)
    mat = Mat(xy, np.zeros(len(xy)) if heading is None else heading, rng, chassis)
    cubes = peripherals(mat)
    async with emulated_radio(rng) as air:
        for cube in cubes:
            await air.add(cube, faults)
        air.mat, air.began = mat, now()
        air.entries = [ToioEntry(chr(97 + k), cube.address) for k, cube in enumerate(cubes)]
        yield air


class Host:
    """A driver whose events are kept, and a mind that listens to it where there is one.

    ``told`` is what that mind heard and said, ``least`` [m] the least distance of two cubes.
    """

    def __init__(self, air, mind=None, **options):
        self.air, self.mind = air, mind
        self.swarm = ToioCubes(air.entries, radio=air.radio, **options)
        self.events, self.told, self.least = [], [], math.inf
        self.began = now()
        self._tasks = []

    async def __aenter__(self):
        self.swarm._now = lambda: now() - self.began
        self._tasks = [asyncio.create_task(self._listen())]
        if self.mind:
            self._tasks.append(asyncio.create_task(self._tick()))
        return self

    async def __aexit__(self, *_):
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    @property
    def t(self):
        return now() - self.began

    async def _listen(self):
        async with contextlib.aclosing(self.swarm.source()) as source:
            async for event in source:
                self.events.append(event)
                await self._decide(event)

    async def _tick(self):
        while True:
            await asyncio.sleep(0.05)
            await self._decide(Tick(self.t))
            if len(self.air.mat.cubes) > 1:
                self.least = min(self.least, float(pdist(self.air.mat.pose[:2].T).min()))

    async def _decide(self, event):
        if self.mind:
            self.told.append(event)
            for command in latest(self.mind.step(event)):
                self.told.append(command)
                await self.swarm.send(command)

    async def press(self, name, value=""):
        await self._decide(Press(self.t, name, value))

    async def until(self, true, seconds=6.0):
        async with asyncio.timeout(seconds):
            while not true():
                await asyncio.sleep(0.01)

    def states(self, robot="a"):
        return [event for event in self.events if isinstance(event, RobotState) and event.robot == robot]

    def links(self, robot="a"):
        return [event.up for event in self.events if isinstance(event, Link) and event.source == robot]

    def touches(self):
        return [event.kind for event in self.events if isinstance(event, Touch)]

    async def met(self, seconds=30.0):
        """Wait until all cubes tell where they are."""
        await self.until(lambda: all(self.states(entry.name) for entry in self.air.entries), seconds)

    async def go(self, seconds, robot="a", lead=0.045, speed=0.15):
        """Drive a cube to the right for a while."""
        end = now() + seconds
        while now() < end:
            x, y = self.states(robot)[-1].xy
            await self.swarm.send(GoTo(self.t, robot, (x + lead, y), speed, self.t + 0.3))
            await asyncio.sleep(0.05)

    def speed(self, cube=0):
        return float(np.hypot(*self.air.mat.velocity[:, cube]))


def mind(n, limits=LIMITS, zones=()):
    """The conductor's steering for n cubes on the ring mat, by presses alone."""
    names = tuple(chr(97 + k) for k in range(n))
    body = Body(1.6, (0.06, 0.15, 0.22), 0.72)
    return RobotsOnly(Settings(body=body, sheet=Sheet(SIDE, SIDE), bands=(), robots=names, limits=limits, zones=zones))
