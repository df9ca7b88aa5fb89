"""The product ends at full speed, in every way that it can: its robots come to rest.

Emulator and product are processes of their own; what the robots did is read from the emulator's truth log. A frozen
process is one that is gone with its socket left open: nobody tells the robots' end that it is over.
"""

import json
import os
import signal
import time
from types import SimpleNamespace

import numpy as np
import pytest

from command_line import fresh

pytestmark = pytest.mark.skipif(os.name != "posix", reason="kill -9 and frozen processes are POSIX")

NAMES = ("r1", "r2", "r3", "r4")
ENDINGS = {
    "kill": signal.SIGKILL,
    "freeze": signal.SIGSTOP,
    "terminate": signal.SIGTERM,
    "raise": signal.SIGUSR1,
}
STOPPED = ("terminate", "raise")
FAST, FASTEST = 0.045, 0.080
"""What all robots, and what the fastest one, exceed [m/s] when the product ends: the weakest answers to 0.6."""
PATIENCE = 60.0

# The product with a behaviour that goes wrong when it is told to.
PRODUCT = """
import signal, sys
from armspan.cli import main
from armspan.swarm.behaviours.random_walk import RandomWalk

step, told = RandomWalk.step, []
signal.signal(signal.SIGUSR1, lambda *_: told.append(1))

def wrong(self, t, states, pointed):
    if told:
        raise ZeroDivisionError("a behaviour went wrong")
    return step(self, t, states, pointed)

RandomWalk.step = wrong
sys.exit(main(sys.argv[1:]))
"""


class Room:
    """An emulator, and the product driving its robots."""

    def __init__(self, folder, ending):
        self.ending, self.truth = ending, folder / f"{ending}.jsonl"
        self.emulator = fresh(
            "-m", "armspan", "emulate", "cellulo", "--robots", 4, "--port", 0, "--seed", 4, "--truth", self.truth
        )
        self.product = None
        self.after = ""

    def open(self):
        where = self.emulator.stdout.readline().split()[-1]
        words = ("swarm", "random-walk", "--relay", where, "--seconds", "60", "--seed", 2)
        product = ("-c", PRODUCT) if self.ending == "raise" else ("-m", "armspan")
        self.product = fresh(*product, *words)

    def end(self):
        """End the product at a moment when all its robots are fast; the system's time of it."""
        began = time.monotonic()
        while min(speeds := self.speeds()) < FAST or max(speeds) < FASTEST:
            assert self.product.poll() is None, self.product.communicate()
            assert time.monotonic() - began < PATIENCE, "the robots were never fast together"
            time.sleep(0.01)
        self.product.send_signal(ENDINGS[self.ending])
        return time.monotonic()

    def speeds(self):
        """How fast the robots are [m/s], from the last whole line of the truth."""
        with self.truth.open("rb") as file:
            file.seek(-min(1000, file.seek(0, os.SEEK_END)), os.SEEK_END)
            lines = file.read().splitlines(keepends=True)
        whole = [line for line in lines if line.endswith(b"}\n") and line.startswith(b'{"t"')]
        return [row[2] for row in json.loads(whole[-1])["robots"].values()] if whole else [0.0]

    def close(self):
        for process in (self.product, self.emulator):
            if process is not None:
                if process is self.product and self.ending in STOPPED:
                    self.after = process.communicate(timeout=20)[1]
                process.kill()
                process.communicate()


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """All endings: what the robots did, by ending."""
    folder, found = tmp_path_factory.mktemp("killed"), {}
    rooms = [Room(folder, ending) for ending in ENDINGS]
    try:
        for room in rooms:
            room.open()
        ends = {room.ending: room.end() for room in rooms}
        time.sleep(1.8)
    finally:
        for room in rooms:
            room.close()
    for room in rooms:
        found[room.ending] = read(room.truth, ends[room.ending], room.ending)
        found[room.ending].code, found[room.ending].err = room.product.returncode, room.after
    return found


def read(path, end, ending):
    lines = [json.loads(line) for line in path.read_text().splitlines() if line.endswith("}")]
    start, lines = lines[0]["monotonic"], lines[1:]
    rows = np.array([[line["robots"][name] for name in NAMES] for line in lines])
    # what was sent before the end may be heard a little after it; who could still stop is judged from the end
    ended = end - start if ending in STOPPED else max(end - start, lines[-1]["heard"])
    t = np.array([line["t"] for line in lines])
    k = int(np.searchsorted(t, ended))
    # whether a host was there is asked 1.5 s later: the relay itself gives a silent one up after 6 s
    later = lines[min(int(np.searchsorted(t, ended + 1.5)), len(lines) - 1)]
    return SimpleNamespace(
        t=t - ended, xy=rows[..., :2], speed=rows[..., 2], k=k, late=ended - (end - start), host=later["host"]
    )


def last(run, robot, speed):
    """Seconds after the end until a robot stays slower than ``speed`` [m/s]."""
    return run.t[(run.speed[:, robot] >= speed) & (run.t >= 0)].max(initial=0.0)


def way(run, robot):
    """How far [m] a robot got after the end."""
    return np.hypot(*(run.xy[run.k :, robot] - run.xy[run.k, robot]).T).max()


@pytest.mark.parametrize("robot", range(4), ids=NAMES)
@pytest.mark.parametrize("ending", ENDINGS)
def test_every_robot_comes_to_rest(runs, ending, robot):
    run = runs[ending]
    assert run.t[-1] > 1.0
    assert run.speed[max(run.k - 8, 0) : run.k + 1, robot].max() >= FAST
    assert last(run, robot, 0.025) <= 0.5
    assert last(run, robot, 0.002) <= 1.0
    assert way(run, robot) <= 0.060


def test_the_strongest_robots_were_at_full_speed(runs):
    for run in runs.values():
        assert run.speed[max(run.k - 8, 0) : run.k + 1].max() >= FASTEST


def test_what_was_on_its_way_was_heard_at_once(runs):
    assert all(run.late < 0.2 for run in runs.values())


def test_a_frozen_process_keeps_its_socket(runs):
    assert runs["freeze"].host
    assert not any(runs[ending].host for ending in ENDINGS if ending != "freeze")


@pytest.mark.parametrize("ending", STOPPED)
def test_who_can_still_stop_its_robots_does_not_wait_for_their_goals(runs, ending):
    run = runs[ending]
    assert all(last(run, robot, 0.025) <= 0.4 for robot in range(4))
    assert all(way(run, robot) <= 0.035 for robot in range(4))


def test_the_way_out_is_told(runs):
    assert runs["terminate"].code == 130
    assert "the robots were stopped" in runs["terminate"].err
    assert runs["raise"].code == 1
    assert "a behaviour went wrong" in runs["raise"].err
