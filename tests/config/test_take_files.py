"""Takes as files: what is written is read back, and what cannot be read is told in one sentence."""

import json

import msgspec
import numpy as np
import pytest

from armspan.config.take_files import (
    COLUMNS,
    Sidecar,
    next_number,
    of_band,
    read_columns,
    read_sidecar,
    read_take,
    read_takes,
    write_take,
)
from armspan.errors import DataError
from armspan.gesture.takes import Take

HEADER = (
    "t_s,right_qx,right_qy,right_qz,right_qw,right_ax,right_ay,right_az,right_gx,right_gy,right_gz,"
    "left_qx,left_qy,left_qz,left_qw,left_ax,left_ay,left_az,left_gx,left_gy,left_gz"
)


def take(label="wave", person="ann", number=1, **more):
    values = np.arange(5 * 20).reshape(5, 20) / 7.0
    values[2, 10:] = np.nan
    return Take(label, person, number, COLUMNS, np.arange(5) / 100.0, values, **more)


def test_the_table_is_as_the_report_wrote_it(tmp_path):
    path = write_take(tmp_path, take())
    assert path == tmp_path / "wave" / "ann_01.csv"
    lines = path.read_text().splitlines()
    assert lines[0] == HEADER
    assert len(lines) == 6
    assert lines[1].startswith("0.0000,0,0.142857,")
    assert lines[3].endswith("," * 10)
    assert lines[3].startswith("0.0200,5.71429,")


def test_a_take_is_read_back(tmp_path):
    given = take(practice=True, gesture=(0.01, 0.03))
    path = write_take(tmp_path, given)
    back = read_take(path)
    assert (back.label, back.person, back.number, back.columns) == ("wave", "ann", 1, COLUMNS)
    assert (back.practice, back.gesture) == (True, (0.01, 0.03))
    assert back.times == pytest.approx(given.times)
    assert back.values == pytest.approx(given.values, rel=1e-5, nan_ok=True)
    assert read_sidecar(path) == Sidecar(
        label="wave", person="ann", number=1, practice=True, rate_hz=100.0, gesture_s=(0.01, 0.03)
    )


def test_a_sidecar_says_what_it_is_given(tmp_path):
    side = Sidecar(label="wave", person="ann", number=1, simulated=True, recorded="2026-11-24", note="nothing moved")
    path = write_take(tmp_path, take(), side)
    assert json.loads(path.with_suffix(".json").read_text()) == msgspec.to_builtins(side)


def test_nothing_is_overwritten_and_no_part_is_left(tmp_path):
    path = write_take(tmp_path, take())
    before = path.read_bytes()
    with pytest.raises(DataError, match=r"ann_01\.csv exists"):
        write_take(tmp_path, take(gesture=(0.0, 0.01)))
    assert path.read_bytes() == before
    assert sorted(p.name for p in path.parent.iterdir()) == ["ann_01.csv", "ann_01.json"]


def test_numbers_go_on_after_the_highest(tmp_path):
    assert next_number(tmp_path, "wave", "ann") == 1
    for number in (1, 7):
        write_take(tmp_path, take(number=number))
    write_take(tmp_path, take(person="ann_b", number=30))
    assert next_number(tmp_path, "wave", "ann") == 8
    assert next_number(tmp_path, "wave", "ann_b") == 31
    assert next_number(tmp_path, "stop", "ann") == 1


def test_takes_of_a_folder_come_in_order(tmp_path):
    for label, person, number in (("wave", "bob", 1), ("stop", "bob", 2), ("wave", "ann", 10), ("wave", "ann", 2)):
        write_take(tmp_path, take(label, person, number))
    assert [t.name.removeprefix(f"{tmp_path}/") for t in read_takes(tmp_path)] == [
        "stop/bob_02.csv",
        "wave/ann_02.csv",
        "wave/ann_10.csv",
        "wave/bob_01.csv",
    ]
    assert {t.columns for t in read_takes(tmp_path, bands="left")} == {COLUMNS[10:]}


def test_what_was_deleted_is_no_take(tmp_path):
    write_take(tmp_path, take())
    write_take(tmp_path / ".deleted", take(number=2))
    assert [t.number for t in read_takes(tmp_path)] == [1]


def test_columns_of_bands():
    assert of_band(take(), "right").columns == COLUMNS[:10]
    assert of_band(take(), "right").values.shape == (5, 10)
    with pytest.raises(DataError, match="no column of the band 'middle'"):
        of_band(take(), "middle")


def test_other_peoples_tables_are_read_too(tmp_path):
    path = tmp_path / "wave" / "someone.csv"
    path.parent.mkdir()
    path.write_text("\ufeff acc_x , t_s\n1,0\n\n,0.02\ninf,0.04\n", encoding="utf-8")
    back = read_take(path)
    assert (back.person, back.number, back.columns, back.practice) == ("someone", 0, ("acc_x",), False)
    assert back.times == pytest.approx([0.0, 0.02, 0.04])
    assert back.values[:, 0] == pytest.approx([1.0, np.nan, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1: no column t_s"),
        ("a,b\n1,2\n", "line 1: no column t_s in 'a,b'"),
        ("t_s\n0\n", "one named column or more"),
        ("t_s,a,\n0,1,2\n", "one named column or more"),
        ("t_s,a,a\n0,1,2\n", "column 'a' is there twice"),
        ("t_s,a\n", "no rows"),
        ("t_s,a\n0,1\n0.1\n", "line 3: 1 fields, but line 1 names 2"),
        ("t_s,a\n0,one\n", "line 2: 'one' is not a number"),
        ("t_s,a\n0,1\n,2\n", "line 3: t_s is missing"),
    ],
)
def test_a_table_that_is_none_is_told(text, words, tmp_path):
    path = tmp_path / "x.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=words) as told:
        read_columns(path)
    assert str(path) in str(told.value)
    assert "\n" not in str(told.value)


def test_files_that_cannot_be_read_are_told(tmp_path):
    with pytest.raises(DataError, match="No such file"):
        read_columns(tmp_path / "none.csv")
    (tmp_path / "odd.csv").write_bytes(b"t_s,a\n\xff\xfe,1\n")
    with pytest.raises(DataError, match="not text"):
        read_columns(tmp_path / "odd.csv")
    path = write_take(tmp_path, take())
    path.with_suffix(".json").write_text('{"label": 3}')
    with pytest.raises(DataError, match=r"ann_01\.json is not a take's sidecar"):
        read_take(path)


def test_folders_without_takes_are_told(tmp_path):
    with pytest.raises(DataError, match="is not a folder"):
        read_takes(tmp_path / "none")
    with pytest.raises(DataError, match="holds no takes"):
        read_takes(tmp_path)
    (tmp_path / "loose.csv").write_text("t_s,a\n0,1\n")
    with pytest.raises(DataError, match=r"loose\.csv lies beside such folders"):
        read_takes(tmp_path)
