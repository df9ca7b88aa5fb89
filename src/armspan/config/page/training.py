"""Training in a process of its own, so that a session that goes on is not slowed."""

import asyncio
import contextlib
import multiprocessing
import os
import signal
from collections.abc import Iterator
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path

from armspan.config.model_files import write_model
from armspan.config.take_files import read_takes
from armspan.errors import ArmspanError
from armspan.gesture.model import Facts
from armspan.gesture.training import Wanted, train
from armspan.web.views.gestures_host import Job, Trained

POLL = 0.1
"""Seconds between two looks at how far it is."""

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
_NICE = 10


class Training:
    """One training at a time: ``job`` tells how far it is, ``trained`` what came out last."""

    def __init__(self) -> None:
        self.job = Job()
        self.trained: Trained | None = None
        self._process: SpawnProcess | None = None
        self._watch: asyncio.Task[None] | None = None

    def start(self, takes: Path, target: Path) -> None:
        """Begin to train on a folder of takes; the model is written to ``target``."""
        target.parent.mkdir(parents=True, exist_ok=True)
        context = multiprocessing.get_context("spawn")
        here, there = context.Pipe(duplex=False)
        self._process = context.Process(target=work, args=(takes, target, there), daemon=True)
        with _one_thread():
            self._process.start()
        there.close()
        self.job = Job(runs=True, what="reading the takes")
        self._watch = asyncio.create_task(self._follow(self._process, here, target))

    def cancel(self) -> None:
        """End the training that runs: nothing is written."""
        if self.job.runs and self._process is not None:
            self._process.terminate()
            self.job = Job(what="cancelled")

    async def close(self) -> None:
        """End the training that runs, and wait until it has ended."""
        self.cancel()
        if self._watch is not None:
            await self._watch

    async def _follow(self, process: SpawnProcess, line: Connection, target: Path) -> None:
        """Take what the process tells, until it has ended and closed the line."""
        with line:
            while not line.poll() or self._hear(line, target):
                if not line.poll():
                    await asyncio.sleep(POLL)
        while process.is_alive():
            await asyncio.sleep(POLL)
        if self.job.runs:
            self.job = Job(trouble=f"the training broke off (exit code {process.exitcode}): try again")

    def _hear(self, line: Connection, target: Path) -> bool:
        """Take one message; False when there will be no more."""
        try:
            message: tuple[str, float] | Facts | str = line.recv()
        except (EOFError, OSError):  # ended, or was ended
            return False
        if not self.job.runs:
            return True
        match message:
            case Facts():
                self.trained = Trained(str(target), message)
                self.job = Job(what="done", share=1.0)
            case str():
                self.job = Job(trouble=message)
            case what, share:
                self.job = Job(runs=True, what=what, share=share)
        return True


def work(takes: Path, target: Path, line: Connection) -> None:
    """Train, and tell how far it is as (what, share), at the end the model's facts or what is wrong in a sentence."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the page's to hear, and ends this too
    if hasattr(os, "nice"):
        os.nice(_NICE)
    try:
        model = train(read_takes(takes), Wanted(), lambda what, share: line.send((what, share)))
        write_model(target, model)
    except (ArmspanError, OSError) as error:
        line.send(str(error))
    else:
        line.send(model.facts)


@contextlib.contextmanager
def _one_thread() -> Iterator[None]:
    """What is begun here computes with one thread, as the numerical libraries read it when they are loaded."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
