import csv
import json
from pathlib import Path

import numpy as np
import pytest

from armspan.config.take_files import write_take
from command_line import code_of, refused
from gesture.made_takes import COLUMNS, made_null, made_stream, made_take, made_takes


def written(folder: Path, takes) -> Path:
    for take in takes:
        write_take(folder, take)
    return folder


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """A folder with takes, a model trained on them, and what the training printed."""
    home = tmp_path_factory.mktemp("trained")
    takes = written(home / "takes", [*made_takes(rest=1.0), made_null(60.0)])
    assert code_of("train", takes, "-o", home / "gestures.model") == 0
    return home


@pytest.fixture
def broken(tmp_path):
    """A folder with good takes, to be spoilt."""
    return written(tmp_path / "takes", made_takes(2))


def test_training_tells_how_good_it_is(trained, capsys):
    assert code_of("train", trained / "takes", "-o", trained / "again.model", "--json") == 0
    out, _ = capsys.readouterr()
    told = json.loads(out)
    assert told["labels"] == ["circle", "shake", "wave"]
    assert told["accuracy"] == told["macro_f1"] == 1.0
    assert told["columns"] == list(COLUMNS)
    assert sum(map(sum, told["cross_validation"]["by_take"]["confusion"])) == 18
    assert told["cross_validation"]["by_person"] is None
    assert told["spotting"]["null_hours"] > 0.01
    assert Path(told["picture"]).read_bytes().startswith(b"\x89PNG")
    assert (trained / "again.model").read_bytes() == (trained / "gestures.model").read_bytes()


def test_training_in_words_claims_no_more_than_was_seen(trained, capsys):
    code_of("train", trained / "takes", "-o", trained / "words.model")
    out, _ = capsys.readouterr()
    assert "18 takes of 3 gestures by 1 person, 1.0 min of everyday motion" in out
    assert "an hour (95 %)" in out
    assert "five to ten teach the model what is no gesture" in out


def test_evaluating_counts_takes_and_false_triggers(trained, tmp_path, capsys):
    fresh = [made_take(label, "q", number, rest=1.0) for label in ("wave", "shake") for number in (7, 8)]
    takes = written(tmp_path / "test", [*fresh, made_null(30.0, seed=2)])
    capsys.readouterr()
    picture = tmp_path / "confusion.png"
    assert code_of("evaluate", trained / "gestures.model", takes, "--json", "--picture", picture) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["accuracy"] == told["macro_f1"] == 1.0
    assert told["confusion"] == [[0, 0, 0], [0, 2, 0], [0, 0, 2]]
    assert told["null"]["below_per_hour"] >= 2.99 / told["null"]["hours"]
    assert picture.exists()
    assert code_of("evaluate", trained / "gestures.model", takes) == 0
    assert "4 takes: accuracy 100.0 %" in capsys.readouterr().out


def test_spotting_a_stream_with_its_truth(trained, tmp_path, capsys):
    stream, truth = made_stream(["wave", "shake", "circle"])
    table = write_take(tmp_path / "stream", stream)
    answers = tmp_path / "truth.csv"
    with answers.open("w", newline="") as file:
        csv.writer(file).writerows([("start_s", "end_s", "label"), *truth])
    capsys.readouterr()
    assert code_of("spot", trained / "gestures.model", table, "--truth", answers, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["event_f1"] == told["score"]["f1"] > 0.9
    assert [event["label"] for event in told["events"]] == ["wave", "shake", "circle"]
    for event, (start, end, _) in zip(told["events"], truth, strict=True):
        assert start < event["t"] < end + 0.5
    assert code_of("spot", trained / "gestures.model", table, "--truth", answers) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "start_s,end_s,label,score,recognised_s"
    assert lines[1].split(",")[2] == "wave"
    assert "3 of 3 gestures found" in lines[-1]


def spoil_text(path: Path, old: str, new: str) -> None:
    path.write_text(path.read_text().replace(old, new, 1))


def _nan(folder: Path) -> None:
    path = folder / "wave" / "p_01.csv"
    header, *rows = path.read_text().splitlines()
    path.write_text("\n".join([header, *(row.split(",")[0] + ",nan,nan,nan" for row in rows)]))


def _no_motion(folder: Path) -> None:
    path = folder / "wave" / "p_01.csv"
    header, *rows = path.read_text().splitlines()
    path.write_text("\n".join([header, *(row.split(",")[0] + ",1,2,3" for row in rows)]))


def _other_rate(folder: Path) -> None:
    path = folder / "wave" / "p_01.csv"
    header, *rows = path.read_text().splitlines()
    path.write_text("\n".join([header, *rows[::2]]))


def _band_missing(folder: Path) -> None:
    path = folder / "wave" / "p_01.csv"
    path.write_text("\n".join(row.rsplit(",", 1)[0] for row in path.read_text().splitlines()))


def _clock_back(folder: Path) -> None:
    path = folder / "wave" / "p_01.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], *lines[50:], *lines[1:50]]))


def _case(folder: Path) -> None:
    (folder / "wave").rename(folder / "Shake")


def _one_class(folder: Path) -> None:
    for label in ("wave", "shake"):
        for path in (folder / label).iterdir():
            path.unlink()


def _one_take(folder: Path) -> None:
    for path in [*folder.glob("*/p_02.*")]:
        path.unlink()


def _empty(folder: Path) -> None:
    for path in [*folder.glob("*/*")]:
        path.unlink()


def _words(folder: Path) -> None:
    spoil_text(folder / "wave" / "p_01.csv", "\n0.0200,", "\n0.0200,much")


def _sidecar(folder: Path) -> None:
    (folder / "wave" / "p_01.json").write_text("{")


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (_nan, "p_01.csv holds no number in right_ax, right_ay, right_az"),
        (_no_motion, "p_01.csv shows no motion"),
        (_other_rate, "p_01.csv was recorded at 25 Hz, the others at 50 Hz"),
        (_band_missing, "p_01.csv lacks right_az"),
        (_clock_back, "p_01.csv: the clock jumps back"),
        (_case, "differ by case"),
        (_one_class, "all takes are of one gesture, 'circle'"),
        (_one_take, "one take only of 'circle'"),
        (_empty, "holds no takes: they lie in DIR/LABEL/PERSON_NN.csv"),
        (_words, "p_01.csv, line 3: 'much"),
        (_sidecar, "p_01.json is not a take's sidecar"),
    ],
)
def test_bad_takes_are_one_sentence_and_the_old_model_stays(broken, capsys, spoil, words):
    model = broken.parent / "old.model"
    model.write_bytes(b"PK an older model")
    spoil(broken)
    assert words in refused(capsys, broken.parent, "train", broken, "-o", model)


def test_models_that_cannot_be_used_are_one_sentence(trained, tmp_path, capsys):
    takes = written(tmp_path / "takes", [made_take("wave")])
    model = tmp_path / "damaged.model"
    model.write_bytes((trained / "gestures.model").read_bytes()[:-200])
    assert "damaged.model: it is damaged" in refused(capsys, tmp_path, "evaluate", model, takes)
    missing = tmp_path / "none.model"
    assert "none.model cannot be read" in refused(capsys, tmp_path, "spot", missing, takes)
    whole = trained / "gestures.model"
    assert "is not a folder" in refused(capsys, tmp_path, "evaluate", whole, tmp_path / "nowhere")
    other = made_take("wave").picked(COLUMNS[:2])
    table = write_take(tmp_path / "other", other)
    assert "lacks right_az" in refused(capsys, tmp_path, "spot", whole, table)
    assert "lacks right_az" in refused(capsys, tmp_path, "evaluate", whole, tmp_path / "other")


def test_truth_that_cannot_be_used_is_one_sentence(trained, tmp_path, capsys):
    table = write_take(tmp_path / "stream", made_stream(["wave"])[0])
    truth = tmp_path / "truth.csv"
    for text, words in (
        ("begin,end,label\n", "line 1: expected the columns start_s,end_s,label"),
        ("start_s,end_s,label\n1,x,wave\n", "line 2"),
        ("start_s,end_s,label\n3,1,wave\n", "a gesture ends after it starts"),
    ):
        truth.write_text(text)
        said = refused(capsys, tmp_path, "spot", trained / "gestures.model", table, "--truth", truth)
        assert words in said


def test_a_place_where_no_model_can_be_written_is_refused_before_the_work(broken, capsys):
    assert "is a folder" in refused(capsys, broken.parent, "train", broken, "-o", broken)
    assert "is not a folder" in refused(capsys, broken.parent, "train", broken, "-o", broken / "no" / "m.model")
    said = refused(capsys, broken.parent, "train", broken, "-o", broken.parent / "m", "--onnx", broken.parent / "x")
    assert "--onnx writes a network, and kernels is none" in said
    take = broken / "wave" / "p_01.csv"
    assert "p_01.csv exists and is no model: it is kept" in refused(capsys, broken.parent, "train", broken, "-o", take)
    said = refused(capsys, broken.parent, "train", broken, "-o", broken.parent / "m", "--picture", "x.txt")
    assert "x.txt: pictures are PNG files" in said
    said = refused(capsys, broken.parent, "train", broken, "-o", broken.parent / "m", "--seed", "-1")
    assert "'-1' is not a whole number from 0" in said
    said = refused(capsys, broken.parent, "train", broken, "-o", broken.parent / "m.png")
    assert "m.png would be both the model and its picture" in said
    model = broken.parent / "m.model"
    said = refused(capsys, broken.parent, "train", broken, "-o", model, "--window", "1000")
    assert "--window 1000 s: expected 0.25 to 10 s" in said
    said = refused(capsys, broken.parent, "train", broken, "-o", model, "--with", broken)
    assert "is the folder of the own takes" in said


def test_gaps_are_written_as_empty_cells_and_read_again(tmp_path):
    take = made_take("wave")
    take.values[10:12, 1] = np.nan
    path = write_take(tmp_path, take)
    assert ",," in path.read_text()
    assert "nan" not in path.read_text()
