import asyncio
import time

import pytest

from armspan.config.model_files import read_model
from armspan.config.page.training import Training, work
from armspan.config.take_files import write_take
from armspan.web.views.gestures_host import Job
from gesture.made_takes import made_null, made_takes


class Line:
    """What a training tells."""

    def __init__(self):
        self.told = []

    def send(self, message):
        self.told.append(message)


@pytest.fixture(scope="module")
def takes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("training") / "takes"
    for take in [*made_takes(2, rest=1.0), made_null(8.0)]:
        write_take(folder, take)
    return folder


@pytest.fixture
def kind(monkeypatch):
    """This process stays as it is."""
    monkeypatch.setattr("os.nice", lambda more: 0)
    monkeypatch.setattr("signal.signal", lambda number, what: None)


def test_the_work_tells_how_far_it_is_and_writes_the_model(takes, tmp_path, kind):
    line = Line()
    work(takes, tmp_path / "a.model", line)
    *steps, facts = line.told
    assert {what for what, _ in steps} >= {"cross-validation by take", "cross-validation of spotting", "done"}
    assert all(0.0 <= share <= 1.0 for _, share in steps)
    assert facts == read_model(tmp_path / "a.model").facts
    assert len(facts.scores["spotting"]["thresholds"]) == 16


def test_the_work_tells_what_is_wrong(tmp_path, kind):
    line = Line()
    work(tmp_path / "nothing", tmp_path / "a.model", line)
    assert "is not a folder" in line.told[-1]


def test_a_process_trains_while_the_loop_goes_on(takes, tmp_path):
    async def run():
        training, longest = Training(), 0.0
        training.start(takes, tmp_path / "models" / "a.model")
        assert training.job == Job(runs=True, what="reading the takes")
        while training.job.runs:
            before = time.perf_counter()
            await asyncio.sleep(0.005)
            longest = max(longest, time.perf_counter() - before)
        await training.close()
        return training, longest

    training, longest = asyncio.run(run())
    assert training.job == Job(what="done", share=1.0)
    assert training.trained.facts == read_model(tmp_path / "models" / "a.model").facts
    assert longest < 0.5


def test_a_cancelled_training_writes_nothing(takes, tmp_path):
    async def run():
        training = Training()
        training.start(takes, tmp_path / "models" / "a.model")
        await asyncio.sleep(0.2)
        await training.close()
        return training

    training = asyncio.run(run())
    assert training.job == Job(what="cancelled")
    assert training.trained is None
    assert list((tmp_path / "models").iterdir()) == []
    assert not training._process.is_alive()


def test_a_training_that_breaks_off_is_told(takes, tmp_path):
    async def run():
        training = Training()
        training.start(takes, tmp_path / "models" / "a.model")
        training._process.kill()
        await training._watch
        return training.job

    assert "broke off" in asyncio.run(run()).trouble
