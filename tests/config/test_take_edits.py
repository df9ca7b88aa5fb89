"""Takes in their folder: nothing that is deleted, trimmed or relabelled is lost."""

import msgspec
import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.config.take_edits import checked_label, delete_take, list_takes, relabel_take, trim_take
from armspan.config.take_files import next_number, read_sidecar, read_take, read_takes
from armspan.errors import ConfigError, DataError
from recorded_takes import SPAN, wrote


def test_takes_are_listed_in_order_with_what_is_known_of_them(tmp_path):
    wrote(tmp_path, "stop", number=2)
    wrote(tmp_path, "stop", number=1, practice=True, note="nothing moved")
    wrote(tmp_path, "mixing", person="zoe")
    (tmp_path / "mixing" / ".zoe_02.csv").write_text("an unfinished one")
    first, second, third = list_takes(tmp_path)
    assert [(take.label, take.person, take.number) for take in (first, second, third)] == [
        ("mixing", "zoe", 1),
        ("stop", "ada", 1),
        ("stop", "ada", 2),
    ]
    assert (first.seconds, first.rate_hz, first.gesture_s, first.bands) == (4.0, 100.0, SPAN, ("right", "left"))
    assert (second.practice, second.note, third.practice, third.note) == (True, "nothing moved", False, "")
    assert first.simulated
    assert first.path == str(tmp_path / "mixing" / "zoe_01.csv")


def test_takes_of_others_are_listed_too(tmp_path):
    (tmp_path / "wave").mkdir()
    (tmp_path / "wave" / "bob_07.csv").write_text("t_s,wrist_ax,force\n0,1,2\n0.02,3,4\n")
    [take] = list_takes(tmp_path)
    assert (take.number, take.seconds, take.rate_hz, take.bands) == (7, 0.02, 50.0, ("wrist", "force"))
    assert (take.practice, take.gesture_s, take.simulated) == (False, None, False)


def test_an_empty_folder_lists_nothing_and_a_missing_one_is_told(tmp_path):
    assert list_takes(tmp_path) == []
    with pytest.raises(DataError, match="nowhere is not a folder"):
        list_takes(tmp_path / "nowhere")


def test_a_deleted_take_is_kept_whole_and_never_read(tmp_path):
    path = wrote(tmp_path)
    other = wrote(tmp_path, number=2)
    data, side = path.read_bytes(), path.with_suffix(".json").read_bytes()
    kept = delete_take(path)
    assert kept == tmp_path / ".deleted" / "mixing" / "ada_01.csv"
    assert (kept.read_bytes(), kept.with_suffix(".json").read_bytes()) == (data, side)
    assert not path.exists()
    assert not path.with_suffix(".json").exists()
    assert [take.source for take in read_takes(tmp_path)] == [str(other)]


def test_takes_of_one_name_do_not_replace_each_other_among_the_deleted(tmp_path):
    kept = [delete_take(wrote(tmp_path)) for _ in range(3)]
    assert [path.name for path in kept] == ["ada_01.csv", "ada_01_2.csv", "ada_01_3.csv"]
    assert all(path.exists() and path.with_suffix(".json").exists() for path in kept)
    assert list(tmp_path.iterdir()) == [tmp_path / ".deleted"]  # the label's folder was empty


def test_trimming_keeps_the_rows_between_and_starts_their_clock_at_zero(tmp_path):
    path = wrote(tmp_path)
    before = read_take(path)
    told = trim_take(path, 0.5, 2.5)
    after = read_take(path)
    assert_allclose(after.times, np.arange(201) / 100.0, atol=1e-12)
    assert_allclose(after.values, before.values[50:251], atol=0)
    assert after.gesture == told.gesture_s == (0.5, 2.0)
    assert (after.number, after.practice, read_sidecar(path).simulated) == (1, False, True)
    kept = read_take(tmp_path / ".deleted" / "mixing" / "ada_01.csv")
    assert_allclose(kept.values, before.values, atol=0)
    assert kept.gesture == SPAN


def test_trimming_keeps_other_peoples_digits_and_columns(tmp_path):
    folder = tmp_path / "wave"
    folder.mkdir()
    path = folder / "bob_01.csv"
    rows = "".join(f"0.123456789,{k},\n" for k in range(20))
    path.write_text(f"\ufeffforce,t_s,gap\n{rows}", encoding="utf-8")
    trim_take(path, 5, 15)
    assert path.read_text().splitlines() == ["force,t_s,gap", *(f"0.123456789,{k}," for k in range(11))]
    assert not path.with_suffix(".json").exists()


def test_a_gesture_that_is_cut_away_is_no_longer_told(tmp_path):
    path = wrote(tmp_path)
    assert trim_take(path, 3.2, 4.0).gesture_s is None
    assert read_take(path).span == (0.0, 0.8)


@pytest.mark.parametrize(("start", "end"), [(3.0, 1.0), (2.0, 2.05), (10.0, 12.0), (2.0, 2.0)])
def test_trimming_to_nothing_is_refused_and_changes_nothing(tmp_path, start, end):
    path = wrote(tmp_path)
    data = path.read_bytes()
    with pytest.raises(DataError, match="lasts from 0 to 4 s"):
        trim_take(path, start, end)
    assert path.read_bytes() == data
    assert not (tmp_path / ".deleted").exists()


def test_a_new_label_gives_the_next_free_number_and_the_sidecar_follows(tmp_path):
    wrote(tmp_path, "stop", number=4)
    path = wrote(tmp_path, "mixing", number=1, note="a note")
    table = path.read_bytes()
    target = relabel_take(path, "stop")
    assert target == tmp_path / "stop" / "ada_05.csv"
    assert target.read_bytes() == table
    side = read_sidecar(target)
    assert (side.label, side.number, side.note, side.gesture_s, side.simulated) == ("stop", 5, "a note", SPAN, True)
    assert not (tmp_path / "mixing").exists()
    assert next_number(tmp_path, "stop", "ada") == 6


def test_everyday_motion_has_no_gesture(tmp_path):
    target = relabel_take(wrote(tmp_path), "null")
    assert read_sidecar(target).gesture_s is None
    assert read_take(target).label == "null"


def test_a_take_without_sidecar_gets_none(tmp_path):
    path = wrote(tmp_path)
    path.with_suffix(".json").unlink()
    target = relabel_take(path, "new_one")
    assert target == tmp_path / "new_one" / "ada_01.csv"
    assert read_sidecar(target) is None
    kept = delete_take(target)
    assert not kept.with_suffix(".json").exists()


@pytest.mark.parametrize("label", ["", "a/b", "..", "mix ing", "mïxing", ".deleted", "-x", "a.b", "mixing\n"])
def test_a_label_that_is_no_folder_is_refused(tmp_path, label):
    path = wrote(tmp_path)
    with pytest.raises(ConfigError, match="cannot be a folder's name"):
        relabel_take(path, label)
    assert path.exists()


def test_a_label_that_differs_by_case_is_refused(tmp_path):
    path = wrote(tmp_path)
    wrote(tmp_path, "Stop")
    with pytest.raises(ConfigError, match="'stop' differs by case only from 'Stop'"):
        relabel_take(path, "stop")
    assert checked_label("Stop", tmp_path) == "Stop"
    assert checked_label("new", tmp_path / "nowhere") == "new"


def test_what_is_no_take_is_left_alone(tmp_path):
    path = wrote(tmp_path)
    with pytest.raises(DataError, match="is labelled 'mixing' already"):
        relabel_take(path, "mixing")
    for deed in (delete_take, lambda p: trim_take(p, 0, 1), lambda p: relabel_take(p, "stop")):
        with pytest.raises(DataError, match="is not a take"):
            deed(path.with_suffix(".json"))
        with pytest.raises(DataError, match="does not exist"):
            deed(tmp_path / "mixing" / "ada_99.csv")
    assert msgspec.json.decode(path.with_suffix(".json").read_bytes())["label"] == "mixing"
    assert sorted(p.name for p in path.parent.iterdir()) == ["ada_01.csv", "ada_01.json"]
