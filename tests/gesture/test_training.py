from dataclasses import replace

import msgspec
import numpy as np
import pytest

from armspan.errors import DataError, ModelError
from armspan.gesture.decision import Spotted
from armspan.gesture.evaluation import evaluate
from armspan.gesture.model import GestureModel, dump, load
from armspan.gesture.scoring import Truth, score_events
from armspan.gesture.stream import Spotter, signals_of, spot
from armspan.gesture.takes import Take
from armspan.gesture.training import Wanted, advice, train
from gesture.made_takes import made_null, made_stream, made_take, made_takes


@pytest.fixture(scope="module")
def model() -> GestureModel:
    return train([*made_takes(rest=1.0), made_null(90.0)], Wanted())


def test_takes_it_has_not_seen_are_told_apart(model: GestureModel) -> None:
    fresh = [made_take(label, "q", number, rest=1.0) for label in model.facts.labels for number in (21, 22, 23)]
    found = evaluate(model, [*fresh, made_null(60.0, seed=3)])
    assert found.document()["accuracy"] == 1.0
    assert found.document()["macro_f1"] == 1.0
    assert found.table.tolist() == [[3, 0, 0], [0, 3, 0], [0, 0, 3]]
    null = found.document()["null"]
    assert null["hours"] == pytest.approx(60 / 3600, rel=0.01)
    assert null["below_per_hour"] > 3 / null["hours"] * 0.99


def test_gestures_in_a_stream_are_spotted_once_each(model: GestureModel) -> None:
    stream, truth = made_stream(["wave", "shake", "circle", "wave", "shake", "circle"])
    events = spot(model, signals_of(stream, model))
    score = score_events(events, [Truth(*entry) for entry in truth], stream.seconds)
    assert score.f1 > 0.9
    assert all(event.start < event.t < (event.end or np.inf) for event in events)


@pytest.mark.parametrize("burst", [1, 7, 50])
def test_live_says_what_the_batch_says(model: GestureModel, burst: int) -> None:
    stream, _ = made_stream(["wave", "shake", "circle"])
    gone = (stream.times > 10.3) & (stream.times < 11.1)  # a gap, longer than can be bridged
    stream = replace(stream, times=stream.times[~gone], values=stream.values[~gone])
    batch = spot(model, signals_of(stream, model))
    times, rows = signals_of(stream, model)["right"]
    spotter, live = Spotter(model), list[Spotted]()
    for number, (t, row) in enumerate(zip(times.tolist(), rows.tolist(), strict=True)):
        spotter.push("right", t, tuple(row))
        if number % burst == 0:
            live += spotter.advance()
    live += spotter.advance()
    assert [(event.t, event.label, event.start) for event in live] == [(e.t, e.label, e.start) for e in batch]
    np.testing.assert_allclose([event.score for event in live], [event.score for event in batch], atol=1e-9)


def test_a_late_packet_changes_nothing(model: GestureModel) -> None:
    stream, _ = made_stream(["wave"])
    times, rows = signals_of(stream, model)["right"]
    found = []
    for late in (False, True):
        spotter, live = Spotter(model), list[Spotted]()
        for number, (t, row) in enumerate(zip(times.tolist(), rows.tolist(), strict=True)):
            spotter.push("right", t, tuple(row))
            if late and number % 10 == 9:
                spotter.push("right", t - 0.05, (9.0, 9.0, 9.0))
            live += spotter.advance()
        found.append(live)
    assert found[0] == found[1]


def test_a_model_survives_being_written_down(model: GestureModel) -> None:
    data = dump(model)
    again = load(data)
    assert again.facts == model.facts
    windows = np.random.default_rng(0).standard_normal((5, 3, model.window))
    np.testing.assert_array_equal(again.probabilities(windows), model.probabilities(windows))
    assert dump(again) == data


@pytest.mark.parametrize(
    "spoil", [lambda d: d[: len(d) // 2], lambda d: b"", lambda d: b"PK" + d[5:], lambda d: d[::-1]]
)
def test_a_damaged_model_is_refused(model: GestureModel, spoil: object) -> None:
    with pytest.raises(ModelError, match="damaged"):
        load(spoil(dump(model)))  # type: ignore[operator]


def test_one_flipped_byte_is_noticed(model: GestureModel) -> None:
    data = bytearray(dump(model))
    for at in range(200, len(data) - 2000, len(data) // 12):
        spoilt = data.copy()
        spoilt[at] ^= 0xFF
        with pytest.raises(ModelError):
            load(bytes(spoilt))


def test_parts_that_do_not_fit_together_are_refused(model: GestureModel) -> None:
    spoilt = replace(model, facts=msgspec.structs.replace(model.facts, columns=(*model.facts.columns, "right_gx")))
    with pytest.raises(ModelError):
        load(dump(spoilt))
    fewer = replace(model, facts=msgspec.structs.replace(model.facts, labels=model.facts.labels[:1]))
    with pytest.raises(ModelError):
        load(dump(fewer))


def test_training_twice_gives_the_same_bytes() -> None:
    takes = [*made_takes(3), made_null(30.0)]
    assert dump(train(takes, Wanted(folds=3))) == dump(train(takes, Wanted(folds=3)))


def test_the_account_tells_other_thresholds(model: GestureModel) -> None:
    spotting, rule = model.facts.scores["spotting"], model.facts.rule
    tried = spotting["thresholds"]
    same = next(entry for entry in tried if entry["threshold"] == rule.threshold)
    assert (same["recognised"], same["false_triggers"]) == (spotting["recognised"], spotting["false_triggers"])
    false = [entry["false_triggers"] for entry in tried]
    assert false[0] >= false[-1]
    assert tried[0]["recognised"] + tried[0]["wrong_or_twice"] >= tried[-1]["recognised"]


def test_the_account_is_honest_about_null(model: GestureModel) -> None:
    spotting = model.facts.scores["spotting"]
    hours = spotting["null_hours"]
    assert 0.01 < hours < 90 / 3600
    assert (
        spotting["below_per_hour"] == pytest.approx(3.0 / hours, rel=0.01) if not spotting["false_triggers"] else True
    )
    bare = train(made_takes(3), Wanted(folds=3))
    assert bare.facts.scores["spotting"]["false_per_hour"] is None
    assert any("everyday motion" in line for line in advice(bare.facts))
    assert any("fewer than five takes" in line for line in advice(bare.facts))


def test_persons_are_held_out_where_there_are_two() -> None:
    model = train(made_takes(3, ("ann", "bo")), Wanted(folds=3))
    assert model.facts.persons == ("ann", "bo")
    assert model.facts.scores["by_person"]["accuracy"] > 0.5
    assert sum(map(sum, model.facts.scores["by_person"]["confusion"])) == 18


@pytest.mark.parametrize(
    ("takes", "words"),
    [
        ([], "no take"),
        ([made_take("wave", number=k) for k in range(4)], "all takes are of one gesture, 'wave'"),
        ([made_take("wave"), made_take("shake"), made_take("shake", number=2)], "one take only of 'wave'"),
        ([made_null()], "null recordings only"),
    ],
)
def test_too_little_to_learn_from_is_said(takes: list[Take], words: str) -> None:
    with pytest.raises(DataError, match=words):
        train(takes, Wanted())


def test_other_channels_than_the_models_are_refused(model: GestureModel) -> None:
    stream, _ = made_stream(["wave"])
    other = replace(stream, columns=("left_ax", "left_ay", "left_az"))
    with pytest.raises(ModelError, match=r"lacks right_ax, right_ay, right_az.*right \(ax ay az\)"):
        signals_of(other, model)
    with pytest.raises(ModelError, match="lacks right_ax"):
        evaluate(model, [replace(other, label="wave")])
    with pytest.raises(DataError, match="labelled 'jump', which the model does not know; it knows circle, shake, wave"):
        evaluate(model, [replace(stream, label="jump")])


def test_a_slow_stream_is_refused(model: GestureModel) -> None:
    stream, _ = made_stream(["wave"])
    with pytest.raises(DataError, match=r"comes at 12\.5 Hz; the model needs 32 Hz"):
        signals_of(replace(stream, times=stream.times * 4), model)


def test_others_takes_help_and_only_own_ones_are_held_out() -> None:
    own, others = made_takes(2, ("ann",)), made_takes(3, ("ann", "bo"))
    model = train([*own, made_null(30.0)], Wanted(folds=3), others=others)
    assert model.facts.persons == ("ann",)
    assert sum(map(sum, model.facts.scores["by_take"]["confusion"])) == 6
    assert model.facts.scores["spotting"]["takes"] == 6
    assert model.facts.takes == {"circle": 8, "shake": 8, "wave": 8}
    fresh = [made_take(label, "ann", number) for label in model.facts.labels for number in (31, 32)]
    assert evaluate(model, fresh).document()["accuracy"] == 1.0
    wrong = [replace(take, columns=("left_ax", "left_ay", "left_az")) for take in others]
    with pytest.raises(DataError, match="lacks"):
        train(own, Wanted(), others=wrong)
