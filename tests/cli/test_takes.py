import json

import pytest

from command_line import code_of, contents, refused
from recorded_takes import wrote


@pytest.fixture
def folder(tmp_path):
    """Two takes of one gesture, the first for practice, and a minute's share of everyday motion."""
    home = tmp_path / "takes"
    wrote(home, "mixing", number=1, practice=True)
    wrote(home, "mixing", number=2)
    wrote(home, "null", number=1, note="loud")
    return home


def test_a_list_in_words(folder, capsys):
    assert code_of("takes", "list", folder) == 0
    head, *rows, summary = capsys.readouterr().out.splitlines()
    assert head.split() == ["take", "label", "person", "no.", "seconds", "Hz", "gesture", "[s]", "bands", "remarks"]
    assert rows[0].split() == [
        *(str(folder / "mixing" / "ada_01.csv"), "mixing", "ada", "1", "4.00", "100", "1.00", "to", "3.00"),
        *("right+left", "practice,", "simulated"),
    ]
    assert rows[2].endswith("simulated, loud")
    assert summary == "takes (+ for practice): mixing 1 (+1), null 1; 0.1 min of everyday motion"


def test_a_list_for_programs(folder, capsys):
    assert code_of("takes", "list", folder, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["folder"] == str(folder)
    assert told["takes"][1] == {
        "path": str(folder / "mixing" / "ada_02.csv"),
        "label": "mixing",
        "person": "ada",
        "number": 2,
        "seconds": 4.0,
        "rate_hz": 100.0,
        "practice": False,
        "gesture_s": [1.0, 3.0],
        "bands": ["right", "left"],
        "simulated": True,
        "note": "",
    }


def test_an_empty_folder_is_told(tmp_path, capsys):
    assert code_of("takes", "list", tmp_path) == 0
    assert "holds no takes; record some with `armspan record`" in capsys.readouterr().out


def test_a_take_is_looked_at(folder, tmp_path, capsys):
    take, picture = folder / "mixing" / "ada_01.csv", tmp_path / "take.png"
    assert code_of("takes", "show", take, "--picture", picture) == 0
    out = capsys.readouterr().out
    assert "practice, simulated" in out
    assert f"drawn into {picture}" in out
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "exists: name another picture" in refused(capsys, tmp_path, "takes", "show", take, "--picture", picture)
    picture.write_bytes(b"old")
    assert code_of("takes", "show", take, "--picture", picture, "--overwrite", "--json") == 0
    assert json.loads(capsys.readouterr().out)["picture"] == str(picture)
    assert picture.read_bytes() != b"old"


def test_takes_are_deleted_trimmed_and_relabelled(folder, capsys):
    first, second = folder / "mixing" / "ada_01.csv", folder / "mixing" / "ada_02.csv"
    assert code_of("takes", "trim", second, "0.5", "3.5") == 0
    assert "now lasts 3.00 s; the whole take is kept" in capsys.readouterr().out
    assert code_of("takes", "relabel", second, "stop", "--json") == 0
    moved = json.loads(capsys.readouterr().out)
    assert moved == {"from": str(second), "to": str(folder / "stop" / "ada_01.csv")}
    assert code_of("takes", "delete", first, moved["to"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 2
    assert code_of("takes", "list", folder, "--json") == 0
    assert [take["label"] for take in json.loads(capsys.readouterr().out)["takes"]] == ["null"]
    kept = sorted(str(path.relative_to(folder)) for path in folder.rglob(".deleted/*/*.csv"))
    assert kept == [".deleted/mixing/ada_01.csv", ".deleted/mixing/ada_02.csv", ".deleted/stop/ada_01.csv"]


def test_bad_input_is_one_sentence_and_nothing_changes(folder, tmp_path, capsys):
    take = folder / "mixing" / "ada_01.csv"
    for words, told in (
        (["list", tmp_path / "nowhere"], "nowhere is not a folder"),
        (["show", folder], "does not exist"),
        (["show", take.with_suffix(".json")], "is not a take"),
        (["show", take, "--picture", folder], "is a folder"),
        (["show", take, "--picture", folder / "no" / "p.png"], "is not a folder"),
        (["delete", folder / "mixing" / "bob_01.csv"], "does not exist"),
        (["trim", take, "3", "1"], "trim less"),
        (["relabel", take, "no/folder"], "cannot be a folder's name"),
        (["relabel", take, "Null"], "differs by case only from 'null'"),
    ):
        assert told in refused(capsys, tmp_path, "takes", *words)


@pytest.mark.parametrize("words", [[], ["fly"], ["list"], ["trim", "a.csv", "x", "1"], ["list", ".", "--loud"]])
def test_a_wrong_command_line_is_refused(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    assert code_of("takes", *words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert contents(tmp_path) == {}


def test_deleting_several_is_all_or_nothing(folder, tmp_path, capsys):
    take = folder / "mixing" / "ada_01.csv"
    assert "does not exist" in refused(capsys, tmp_path, "takes", "delete", take, folder / "mixing" / "bob_01.csv")
    assert take.exists()
