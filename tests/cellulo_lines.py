"""Emulated Cellulo robots at the ends of lines of their own, as a radio would give them: for tests."""

import asyncio
import contextlib
import socket

import numpy as np

from armspan.devices.cellulo.doors import LineDoor
from armspan.devices.cellulo.emulator import Emulator, addresses
from armspan.devices.cellulo.firmware import Firmware
from armspan.devices.cellulo.sockets import CelluloSockets, Way
from armspan.errors import DeviceNotFound
from armspan.links.line import Line
from armspan.records import GoTo, Link, RobotState, Sheet
from armspan.simulation.bodies import Plant
from fast_time import now

NAMES = ("ash", "elm", "fir")
XY = ((1.0, 1.0), (1.4, 1.4), (1.0, 1.6))


def paired():
    """Two ends of one line; each sends no more than a radio may hold."""
    ends = socket.socketpair()
    for end in ends:
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 2304)
    return tuple(Line(end.fileno(), end.close) for end in ends)


class Radio:
    """Bluetooth sockets to emulated robots: a pair for each attempt, which takes its time."""

    def __init__(self, emulator, page_s=0.1, absent_s=1.0):
        self.emulator, self.page_s, self.absent_s = emulator, page_s, absent_s
        self.door = LineDoor(emulator)
        emulator.doors.append(self.door)
        self.paging = self.most = 0
        self.attempts = []

    def way(self, name, queue="any", carrier=True):
        robot = self.emulator.names.index(name)

        async def connect():
            self.attempts.append((round(now(), 2), name))
            self.paging += 1
            self.most = max(self.most, self.paging)
            try:
                await asyncio.sleep(self.page_s)
                if not self.emulator.up(robot):
                    await asyncio.sleep(self.absent_s - self.page_s)
                    raise DeviceNotFound(f"{name} does not answer")
            finally:
                self.paging -= 1
            ours, theirs = paired()
            self.door.give(robot, theirs)
            return ours

        return Way(connect, queue, carrier)


@contextlib.asynccontextmanager
async def emulated(faults=None, n=2, gain=(1.0, 1.0), **options):
    firmware = Firmware(XY[:n], np.zeros(n), Sheet(3, 3), np.random.default_rng(0), Plant(gain=gain), faults)
    names = dict(zip(addresses(n), NAMES, strict=False))
    emulator = Emulator(firmware, names, **options)
    emulator.begin()
    task = asyncio.create_task(emulator.live())
    emulator.radio = Radio(emulator)
    try:
        yield emulator
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        await emulator.radio.door.close()


class Host:
    """A driver whose events are kept."""

    def __init__(self, swarm):
        self.swarm, self.events, self.began, self.error = swarm, [], now(), None

    @classmethod
    def of(cls, emulator, **options):
        return cls(CelluloSockets({name: emulator.radio.way(name) for name in emulator.names}, **options))

    async def __aenter__(self):
        self._ears = asyncio.create_task(self._listen())
        return self

    async def __aexit__(self, *_):
        self._ears.cancel()
        await asyncio.gather(self._ears, return_exceptions=True)

    async def _listen(self):
        try:
            async with contextlib.aclosing(self.swarm.source()) as source:
                async for event in source:
                    self.events.append(event)
        except Exception as error:
            self.error = error

    async def until(self, true, seconds=10.0):
        async with asyncio.timeout(seconds):
            while not true():
                await asyncio.sleep(0.01)

    def states(self, robot="ash"):
        return [event for event in self.events if isinstance(event, RobotState) and event.robot == robot]

    def links(self, robot="ash"):
        return [event.up for event in self.events if isinstance(event, Link) and event.source == robot]

    async def go(self, seconds, robot="ash", lead=0.045):
        """Drive a robot to the right for a while, as the session does: short goals, renewed."""
        end = now() + seconds
        while now() < end:
            x, y = self.states(robot)[-1].xy
            t = now() - self.began
            await self.swarm.send(GoTo(t, robot, (x + lead, y), 0.3, t + 0.3))
            await asyncio.sleep(0.05)


def speed(emulator, robot=0):
    return float(np.hypot(*emulator.firmware.bodies.velocity[:2, robot]))


def place(emulator, robot=0):
    return tuple(emulator.firmware.bodies.pose[:2, robot].tolist())
