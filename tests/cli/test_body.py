import json
import tomllib

import numpy as np
import pytest

from armspan.config.body_file import read_body
from command_line import code_of, contents, fresh
from filmed_person import Person, film
from skeleton_files import openpose

TOLD = ("body", "--height-m", "1.75", "--sex", "man")
MEASURES = ("eye height", "forward", "left", "up", "arm length")


def answer(capsys, *words):
    assert code_of(*words, "--json") == 0
    return json.loads(capsys.readouterr().out)


def refusal(capsys, *words):
    assert code_of(*words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1, err
    return err


def test_height_and_sex_alone(capsys):
    found = answer(capsys, *TOLD)
    # 0.9600 x 1750 - 43.9 + 0.3 mm (ANSUR II); the doubt is 8.3 mm of the survey and 5 mm of tape.
    assert found["body"]["eye_height_m"] == pytest.approx(1.6364, abs=0.001)
    assert found["sd_m"]["eye height"] == pytest.approx(np.hypot(0.0083, 0.96 * 0.005), abs=0.0003)
    assert tuple(found["sd_m"]) == MEASURES
    assert found["taken"] == found["rejected"] == []
    assert found["body"]["arm"] == "right"


def test_soles_lift_the_eye_only(capsys):
    bare, shod = answer(capsys, *TOLD)["body"], answer(capsys, *TOLD, "--sole-m", "0.03")["body"]
    assert shod["eye_height_m"] - bare["eye_height_m"] == pytest.approx(0.03)
    assert shod["shoulder_to_eye_m"] == bare["shoulder_to_eye_m"]


def test_the_body_file_holds_what_was_found(tmp_path, capsys):
    path = tmp_path / "me.toml"
    found = answer(capsys, *TOLD, "--arm", "left", "--eye", "left", "--out", str(path))
    body = read_body(path)
    assert body.arm == "left"
    assert body.shoulder_to_eye_m == pytest.approx(found["body"]["shoulder_to_eye_m"], abs=1e-4)
    assert body.covariance == pytest.approx(found["body"]["covariance_m2"], abs=1e-8)
    assert "height 1.75 m" in path.read_text()
    assert body.shoulder_to_eye_m[1] < 0.0  # the eye is to the right of a left shoulder
    assert tomllib.loads(path.read_text())["body"]["upper_arm_m"] == pytest.approx(body.upper_arm_m)


def test_an_existing_body_file_is_kept(tmp_path, capsys):
    path = tmp_path / "me.toml"
    path.write_text("mine")
    assert "exists and is kept" in refusal(capsys, *TOLD, "--out", str(path))
    assert path.read_text() == "mine"


@pytest.mark.parametrize(
    ("typed", "meant"), [("1750", "did you mean 1.75?"), ("5.9", "feet, did you mean 1.798"), ("175", "centimetres")]
)
def test_a_height_in_another_unit(typed, meant, capsys):
    assert meant in refusal(capsys, "body", "--height-m", typed)


def test_no_height(capsys):
    assert "The height is missing" in refusal(capsys, "body", "--sex", "woman")


def test_the_table_is_for_people(capsys):
    assert code_of(*TOLD) == 0
    out, err = capsys.readouterr()
    assert "floor to dominant eye" in out
    assert "1.637" in out
    assert "close the left eye" in err  # how to find the dominant one, as none was told


@pytest.fixture
def files(tmp_path):
    """A known person in skeleton files of their own: front.json, side.json."""
    person = Person()
    (tmp_path / "front.json").write_text(json.dumps(openpose(film(person.t_pose()))))
    (tmp_path / "side.json").write_text(json.dumps(openpose(film(person.pointing(), "right"))))
    return tmp_path, person


def views(folder):
    return ("--front", str(folder / "front.json"), "--side", str(folder / "side.json"))


def test_two_views_narrow_the_measures(files, capsys):
    folder, person = files
    found = answer(capsys, *TOLD, *views(folder))
    body, truth = found["body"], person.measures()
    values = (body["eye_height_m"], *body["shoulder_to_eye_m"], body["shoulder_to_fingertip_m"])
    for measure, value in zip(MEASURES, values, strict=True):
        assert abs(value - truth[measure]) < 2.0 * found["sd_m"][measure], measure
    for measure in ("forward", "up", "arm length"):
        assert found["sd_m"][measure] < 0.75 * found["prior"]["sd_m"][measure]
    assert {told["source"].split(" ")[0] for told in found["taken"]} == {"front", "side"}


def test_points_are_kept_and_can_be_read_again(files, tmp_path, capsys):
    folder, _ = files
    kept = tmp_path / "kept"
    first = answer(capsys, *TOLD, *views(folder), "--keep", str(kept))
    assert sorted(path.name for path in kept.iterdir()) == ["front.json", "side.json"]
    again = answer(capsys, *TOLD, *views(kept))
    assert again["body"] == first["body"]
    assert "exists and is kept" in refusal(capsys, *TOLD, *views(folder), "--keep", str(kept))


def test_a_file_is_deleted_only_when_asked(files, capsys):
    folder, _ = files
    answer(capsys, *TOLD, *views(folder))
    assert (folder / "front.json").exists()
    answer(capsys, *TOLD, *views(folder), "--delete-pictures")
    assert not (folder / "front.json").exists()
    assert not (folder / "side.json").exists()


def test_a_value_far_from_the_prior_is_left_out_and_said(files, capsys):
    folder, person = files
    assert answer(capsys, *TOLD, *views(folder))["rejected"] == []
    craned = {
        name: np.add(point, [0.25, 0.0, 0.0]) if name in ("leye", "reye", "nose", "lear", "rear") else point
        for name, point in person.pointing().items()
    }
    (folder / "side.json").write_text(json.dumps(openpose(film(craned, "right"))))
    assert code_of(*TOLD, "--side", str(folder / "side.json")) == 0
    assert "standard deviations from what this height tells" in capsys.readouterr().err
    found = answer(capsys, *TOLD, "--side", str(folder / "side.json"))
    assert "forward" in [odd["measure"] for odd in found["rejected"]]
    assert all(abs(odd["z"]) > 3.0 for odd in found["rejected"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"hello": 1}', "expected OpenPose"),
        ("[1, 2", "begins like JSON"),
        ("[" * 100_000, "begins like JSON"),
        ('{"people": "\udcff"}', "begins like JSON"),  # a byte that no UTF-8 holds
        ('\ufeff{"version": 1.3, "people": []}', "nobody"),  # as editors on Windows save it
        ('{"version": 1.3, "people": []}', "nobody"),
    ],
)
def test_files_of_another_kind(text, words, tmp_path, capsys):
    path = tmp_path / "odd.json"
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    assert words in refusal(capsys, *TOLD, "--front", str(path))


def test_options_that_do_not_go_together(files, capsys):
    folder, _ = files
    assert "leave --marker out" in refusal(capsys, *TOLD, *views(folder), "--marker")
    assert "There is no picture" in refusal(capsys, *TOLD, "--marker")
    assert "--checkpoint" in refusal(capsys, *TOLD, *views(folder), "--backend", "openpifpaf")
    assert "go with --backend" in refusal(capsys, *TOLD, *views(folder), "--checkpoint", "net.pkl")
    assert "1920x1080" in refusal(capsys, *TOLD, *views(folder), "--size", "big")
    assert "--person 2 does not exist" in refusal(capsys, *TOLD, *views(folder), "--person", "2")
    assert "--person 0 does not exist" in refusal(capsys, *TOLD, *views(folder), "--person", "0")
    assert "There is no picture" in refusal(capsys, *TOLD, "--person", "1")


def test_where_nothing_can_be_written_nothing_is(files, capsys):
    folder, _ = files
    before = contents(folder)
    front, out = str(folder / "front.json"), str(folder / "me.toml")
    for place in (front, front + "/kept"):
        assert "--keep" in refusal(capsys, *TOLD, *views(folder), "--keep", place, "--out", out, "--delete-pictures")
    assert "is no folder" in refusal(capsys, *TOLD, *views(folder), "--out", str(folder / "none" / "me.toml"))
    assert "cannot be written" in refusal(capsys, "body", "--print-marker", str(folder / "none" / "sheet.pdf"))
    assert contents(folder) == before


def test_the_marker_sheet(tmp_path, capsys):
    path = tmp_path / "marker.pdf"
    assert code_of("body", "--print-marker", str(path)) == 0
    assert path.read_bytes().startswith(b"%PDF")
    assert "100 %" in capsys.readouterr().out
    assert "exists and is kept" in refusal(capsys, "body", "--print-marker", str(path))


def test_a_missing_file(tmp_path, capsys):
    assert "does not exist" in refusal(capsys, *TOLD, "--front", str(tmp_path / "me.jpg"))


def test_pictures_are_not_needed_for_the_numbers():
    process = fresh("-m", "armspan", *TOLD, "--json")
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")
    assert json.loads(out)["body"]["arm"] == "right"
