"""A whole session with gestures: learnt, recognised live, obeyed, replayed, and equal to the batch."""

import asyncio
from dataclasses import dataclass, replace

import numpy as np
import pytest

from armspan.cli.replay import first_difference
from armspan.conductor.arm import Arm
from armspan.conductor.conductor import Conductor
from armspan.conductor.wrist import WRIST, wrist_row
from armspan.config.demo_room import demo_room
from armspan.config.house import open_house
from armspan.config.model_files import from_header, write_model
from armspan.config.recalled import settings_of
from armspan.frames import rotation_from_quaternion
from armspan.gesture.model import GestureModel, dump
from armspan.gesture.stream import spot
from armspan.gesture.takes import NULL, Take
from armspan.gesture.training import Wanted, train
from armspan.log import LogFile, LogWriter, read
from armspan.orientation import mount_from_poses
from armspan.records import EVENTS, Gesture, ImuSample, Press, Record, Say, Scores, Stop
from armspan.simulation.takes import SimulatedTake, simulate_takes
from armspan.study.gestures import gestures_of

LABELS = ("raise_both", "stop")


def as_take(made: SimulatedTake) -> Take:
    """A simulated take brought onto one clock of 50 Hz."""
    clock = np.arange(made.start - 0.8, made.end + 0.8, 0.02) if made.label != NULL else None
    columns, names = [], []
    for side, samples in made.samples.items():
        poses = ([sample.quat for sample in getattr(made.setup, pose)[side]] for pose in ("stretched", "hanging"))
        mount = mount_from_poses(*(rotation_from_quaternion(np.array(pose)) for pose in poses))
        band = _Worn(mount)
        rows = np.array([wrist_row(band.after(sample), sample) for sample in samples])
        times = np.array([sample.t for sample in samples])
        if clock is None:
            clock = np.arange(times[0] + 0.1, times[-1] - 0.1, 0.02)
        nearest = np.clip(np.searchsorted(times, clock), 0, len(times) - 1)
        columns.append(rows[nearest])
        names += [f"{side}_{name}" for name in WRIST]
    span = (made.start - clock[0], made.end - clock[0]) if made.label != NULL else None
    return Take(
        made.label, "p", made.number, tuple(names), clock - clock[0], np.concatenate(columns, axis=1), False, span
    )


@dataclass
class _Worn:
    mount: object
    quat: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)

    def after(self, sample: ImuSample) -> "_Worn":
        self.quat = sample.quat
        return self

    def quaternion(self) -> tuple[float, ...]:
        return self.quat


@pytest.fixture(scope="module")
def model() -> GestureModel:
    rng = np.random.default_rng(4)
    made = simulate_takes(rng, persons=3, takes=4, labels=LABELS, everyday_s=25.0)
    return train([as_take(one) for one in made], Wanted(folds=2, window_s=1.5))


@pytest.fixture(scope="module")
def session(model: GestureModel, tmp_path_factory: pytest.TempPathFactory) -> LogFile:
    folder = tmp_path_factory.mktemp("session")
    write_model(folder / "two.model", model)
    room = demo_room(3, trials=1, feedback="off", model="two.model", gestures=("raise_both", "everyday:5", "stop"))
    house = open_house(room, folder)
    with LogWriter(folder / "session.mcap", house.header) as log:
        asyncio.run(house.run(house.session([log]), live=False))
    return read(folder / "session.mcap")


def test_gestures_made_are_recognised_and_obeyed(session: LogFile) -> None:
    account = gestures_of(session.records)
    assert [entry.label for entry in account.made] == ["raise_both", "stop"]
    assert account.score is not None
    assert account.score.hits == 2
    assert any(isinstance(record, Say) and "come together" in record.text for record in session.records)
    stop = next(record for record in session.records if isinstance(record, Gesture) and record.label == "stop")
    stopped = [record for record in session.records if isinstance(record, Stop) and record.why == "gesture stop"]
    assert stopped[0].robot is None
    assert abs(stopped[0].t - stop.t) < 0.2
    assert any(isinstance(record, Scores) for record in session.records)


def test_the_log_replays_by_itself(session: LogFile, model: GestureModel) -> None:
    carried = from_header(session.header)
    assert carried is not None
    assert dump(carried) == dump(model)
    assert first_difference(session, settings_of(session)) is None


def test_live_is_the_batch_on_the_logs_samples(session: LogFile, model: GestureModel) -> None:
    live = [record for record in session.records if isinstance(record, Gesture)]
    batch = spot(model, felt_after_set_up(session))
    idle = next(r.t for r in session.records if isinstance(r, Say) and r.cue == "ready")
    wanted = [event for event in batch if event.t > idle]
    assert [(record.t, record.label) for record in live if record.t > idle] == [(e.t, e.label) for e in wanted]
    np.testing.assert_allclose([r.score for r in live if r.t > idle], [e.score for e in wanted], atol=1e-6)


def felt_after_set_up(session: LogFile) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Each wrist's rows, with the mounting that the session's own conductor found."""
    settings = settings_of(session)
    conductor, rows = Conductor(settings), {"right": [], "left": []}
    arm: Arm = conductor._arm
    for record in session.records:
        if not isinstance(record, EVENTS):
            continue
        conductor.step(record)
        if isinstance(record, ImuSample):
            side = next(side for side, band in arm.wrists.items() if band.settings.name == record.source)
            row = wrist_row(arm.wrists[side], record)
            if row is not None and (not rows[side] or record.t > rows[side][-1][0]):
                rows[side].append((record.t, row))
    return {side: (np.array([t for t, _ in found]), np.array([r for _, r in found])) for side, found in rows.items()}


def test_no_behaviour_begins_before_a_resume(model: GestureModel) -> None:
    room = demo_room(3, trials=1, feedback="off", gestures=())
    settings = open_house(room).settings
    conductor = Conductor(settings)
    conductor.step(Press(1.0, "stop"))
    said = conductor.step(Press(1.1, "behaviour", "gather"))
    assert [record.text for record in said] == ["gather: the robots are stopped; resume first"]
    conductor.step(Press(1.2, "resume"))
    said = conductor.step(Press(1.3, "behaviour", "gather"))
    assert "gather" in said[0].text
    said = conductor.step(Press(1.4, "behaviour", "dance"))
    assert "behaviour 'dance' does not exist" in said[0].text


def test_a_model_that_needs_a_band_that_is_not_there_is_refused(model: GestureModel) -> None:
    from armspan.errors import ModelError

    settings = open_house(demo_room(3, trials=1)).settings
    with pytest.raises(ModelError, match="needs a band on the left wrist"):
        Conductor(settings, model)
    other = replace(model, facts=type(model.facts)(**{**_fields(model), "columns": ("chest_ax",)}))
    with pytest.raises(ModelError, match="chest_ax, which no wristband delivers"):
        Conductor(settings, other)


def _fields(model: GestureModel) -> dict[str, object]:
    return {name: getattr(model.facts, name) for name in model.facts.__struct_fields__}


def test_a_threshold_set_at_run_time_holds(session: LogFile, model: GestureModel) -> None:
    mind, outputs = Conductor(settings_of(session), model), list[Record]()
    for event in (Press(0.0, "threshold", "0.99"), *session.records):
        if isinstance(event, EVENTS):
            outputs += mind.step(event)
    before = [record for record in session.records if isinstance(record, Gesture)]
    after = [record for record in outputs if isinstance(record, Gesture)]
    assert len(after) < len(before)
    assert all(gesture.score >= 0.99 * mind.model.facts.rule.early["stop"][0] for gesture in after)
