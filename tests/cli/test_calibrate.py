import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.cli import main
from straight_arms import BODY, SQUARE, place_before, pointing_at, seen_from

XYZ, YAW = place_before(SQUARE, np.array([1.0, 0.2, 0.75]), 0.7), 0.7
SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
ARM = "forearm_qw,forearm_qx,forearm_qy,forearm_qz"
KEYS = [
    "model",
    "method",
    "sheet_from_user",
    "covariance",
    "rms_deg",
    "stops",
    "residual_deg",
    "condition",
    "solve_ms",
]


def quaternions(attitudes):
    """Quaternions of attitudes with no turn about x beyond what yaw and pitch need."""
    x = attitudes[:, :, 0]
    yaw, pitch = np.arctan2(x[:, 1], x[:, 0]) / 2, -np.arcsin(x[:, 2]) / 2
    cy, sy, cp, sp = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    return np.column_stack([cy * cp, -sy * sp, cy * sp, sy * cp])


def table(header, *columns):
    rows = zip(*columns, strict=True)
    cells = ([str(value) for cell in row for value in np.atleast_1d(cell)] for row in rows)
    return "\n".join([header, *map(",".join, cells)]) + "\n"


@pytest.fixture
def files(tmp_path):
    """PAIRS.csv, RAYS.csv and BODY.toml of a stiff arm that points exactly."""
    arm = quaternions(pointing_at(seen_from(SQUARE, XYZ, YAW)))
    (tmp_path / "PAIRS.csv").write_text(table(f"t_s,stop,{ARM},x_m,y_m,z_m", range(4), "0123", arm, SQUARE))
    targets = np.array([[0.4, 0.3, 0.0], [0.1, 0.5, 0.0]])
    rays = quaternions(pointing_at(seen_from(targets, XYZ, YAW)))
    level = [[np.cos(0.25), 0, -np.sin(0.25), 0]]  # the arm raised by half a radian
    (tmp_path / "RAYS.csv").write_text(table(f"t_s,{ARM},z_m", range(3), np.vstack([rays, level]), np.zeros(3)))
    left = ", ".join(map(str, BODY.shoulder_to_eye_m))
    (tmp_path / "BODY.toml").write_text(
        f"[body]\neye_height_m = {BODY.eye_height_m}\nshoulder_to_eye_m = [{left}]\n"
        f"shoulder_to_fingertip_m = {BODY.shoulder_to_fingertip_m}\n"
    )
    return tmp_path


def run(files, *more):
    return main(["calibrate", str(files / "PAIRS.csv"), "--body", str(files / "BODY.toml"), *more])


def refusal(capsys, files, *more):
    before = {path: path.read_bytes() for path in files.iterdir()}
    assert run(files, *more) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert {path: path.read_bytes() for path in files.iterdir()} == before
    return err


def test_json_holds_the_place_and_nothing_else_on_stdout(files, capsys):
    assert run(files, "--json") == 0
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert list(document) == KEYS
    assert err == ""
    assert_allclose(document["sheet_from_user"]["xyz_m"], XYZ, atol=1e-6)
    assert_allclose(document["sheet_from_user"]["yaw_rad"], YAW, atol=1e-6)
    assert np.shape(document["covariance"]) == (4, 4)
    assert [stop["stop"] for stop in document["stops"]] == [0, 1, 2, 3]
    assert [stop["pairs"] for stop in document["stops"]] == [1, 1, 1, 1]
    assert_allclose(document["residual_deg"], 0.0, atol=1e-5)
    assert document["model"] == "head-finger"
    assert document["solve_ms"] > 0


def test_predictions_are_spots_or_sentences(files, capsys):
    assert run(files, "--json", "--predict", str(files / "RAYS.csv"), "--anywhere") == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document) == [*KEYS, "predictions"]
    first, second, high = document["predictions"]
    assert_allclose(first["xy_m"], [0.4, 0.3], atol=1e-5)
    assert_allclose(second["xy_m"], [0.1, 0.5], atol=1e-5)
    assert np.shape(first["covariance"]) == (2, 2)
    assert first["refused"] is None
    assert (high["t_s"], high["xy_m"], high["covariance"]) == (2.0, None, None)
    assert "degrees" in high["refused"]


def test_by_default_predictions_are_drawn_a_little_to_the_area(files, capsys):
    assert run(files, "--json", "--predict", str(files / "RAYS.csv")) == 0
    corner = json.loads(capsys.readouterr().out)["predictions"][1]["xy_m"]
    assert 0.001 < np.linalg.norm(np.subtract(corner, [0.1, 0.5])) < 0.06


def test_a_person_reads_tables_and_a_verdict(files, capsys):
    assert run(files, "--predict", str(files / "RAYS.csv")) == 0
    out = capsys.readouterr().out
    assert "head-finger rays, least-squares" in out
    assert "The rays of 4 stops pass their points by 0.0 degrees (rms), which is good." in out


def test_the_baselines_run(files, capsys):
    assert run(files, "--json", "--method", "nelder-mead") == 0
    assert json.loads(capsys.readouterr().out)["method"] == "nelder-mead"
    assert run(files, "--json", "--method", "nelder-mead-report") == 0


def test_a_known_table_height_is_kept(files, capsys):
    assert run(files, "--json", "--table-height-m", "0.80", "--free-pitch") == 0
    z = json.loads(capsys.readouterr().out)["sheet_from_user"]["xyz_m"][2]
    assert 0.751 < z < 0.80


def doubt(files, variances):
    rows = ", ".join(str(v) for v in np.diag(variances).ravel())
    (files / "BODY.toml").write_text((files / "BODY.toml").read_text() + f"covariance_m2 = [{rows}]\n")


def test_freed_measures_come_with_what_the_data_said_of_them(files, capsys):
    doubt(files, [0.000064, 0.0, 0.000064, 0.000529, 0.000625])  # forward was measured: a singular covariance
    assert run(files, "--json", "--free-body") == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document) == [*KEYS, "parameters", "body"]
    found = {parameter["name"]: parameter for parameter in document["parameters"]}
    assert list(found) == ["x", "y", "z", "yaw", "pitch", "eye height", "forward", "left", "up", "arm length"]
    assert_allclose(found["up"]["prior_sd"], 0.023)
    assert found["forward"]["verdict"] == found["pitch"]["verdict"] == "as given"
    assert found["eye height"]["verdict"] == "not told apart from the sheet's height"
    assert document["body"]["eye_height_m"] == BODY.eye_height_m
    assert document["body"]["shoulder_to_eye_m"][2] == found["up"]["value"]
    assert run(files, "--free-body", "--free-pitch") == 0
    out = capsys.readouterr().out
    assert "arm length [m]" in out
    assert "prior only" in out


def test_measures_without_doubt_cannot_be_freed_and_it_is_said_who_knows_it(files, capsys):
    message = refusal(capsys, files, "--free-body")
    assert f"{files / 'BODY.toml'} has no covariance_m2" in message
    assert "`armspan body --height-m 1.75 --out BODY.toml`" in message


def test_the_other_way_up_is_noticed(files, capsys):
    assert run(files, "--json", "--z-up") == 0
    assert "fit twice as well without --z-up" in capsys.readouterr().err


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_centimetres_in_the_body_file(files, capsys):
    edit(files / "BODY.toml", "1.65", "165")
    assert "did you mean 1.65?" in refusal(capsys, files, "--json")


def test_fewer_than_three_stops_and_stops_on_one_line_name_the_file(files, capsys):
    pairs = files / "PAIRS.csv"
    lines = pairs.read_text().splitlines()
    pairs.write_text("\n".join(lines[:3]))
    message = refusal(capsys, files)
    assert f"{pairs}: The pairs hold 2 distinct points" in message
    pairs.write_text("\n".join(line.replace("0.6,0.0", "0.0,0.0") for line in lines))
    assert "2 distinct points" in refusal(capsys, files)
    pairs.write_text("\n".join([*lines[:3], lines[3].replace("0.8,0.6,", "0.4,0.0,")]))
    assert f"{pairs}: The 3 points lie on one line" in refusal(capsys, files)


def test_two_bands_cannot_be_asked_of_one(files, capsys):
    assert "upper arm" in refusal(capsys, files, "--model", "two-band")


def test_missing_files_and_wrong_cells(files, capsys):
    assert main(["calibrate", "none.csv", "--body", str(files / "BODY.toml")]) == 2
    assert "none.csv does not exist" in capsys.readouterr().err
    edit(files / "PAIRS.csv", "0.8,0.6,0.0", "0.8,oops,0.0")
    assert "PAIRS.csv, line 4: y_m is 'oops'" in refusal(capsys, files)


def test_predicting_with_two_bands_needs_both_in_the_rays(files, capsys):
    edit(files / "BODY.toml", "[body]", "[body]\nupper_arm_m = 0.36\nelbow_to_fingertip_m = 0.36")
    header, *rows = (files / "PAIRS.csv").read_text().splitlines()
    doubled = [header.replace(",x_m", "," + ARM.replace("forearm", "upperarm") + ",x_m")]
    for row in rows:
        cells = row.split(",")
        doubled.append(",".join(cells[:6] + cells[2:6] + cells[6:]))
    (files / "PAIRS.csv").write_text("\n".join(doubled))
    message = refusal(capsys, files, "--predict", str(files / "RAYS.csv"))
    assert "RAYS.csv, line 1: the columns upperarm_qw..qz are missing" in message
    assert run(files, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["model"] == "two-band"
    assert_allclose(document["sheet_from_user"]["xyz_m"], XYZ, atol=1e-6)


def test_people_point_within_their_ellipses(capsys):
    folder = SHARED / "people" / "p02"
    if not folder.is_dir():
        pytest.skip(f"no recordings at {folder}")
    command = ["calibrate", str(folder / "pairs.csv"), "--body", str(folder / "body.toml"), "--z-up", "--json"]
    assert main([*command, "--predict", str(folder / "rays.csv")]) == 0
    document = json.loads(capsys.readouterr().out)
    truth = np.loadtxt(folder / "truth.csv", delimiter=",", skiprows=1)[:, 1:]
    off = np.array([p["xy_m"] for p in document["predictions"]]) - truth
    assert np.median(np.hypot(*off.T)) < 0.20
    covariances = np.array([p["covariance"] for p in document["predictions"]])
    inside = np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariances), off) < 4.605
    assert inside.mean() > 0.8


def test_a_recorded_session_places_the_head(capsys):
    folder = SHARED / "pointing"
    if not folder.is_dir():
        pytest.skip(f"no recordings at {folder}")
    command = ["calibrate", str(folder / "triangle_3.csv"), "--body", str(folder / "body.toml"), "--z-up", "--json"]
    assert main(command) == 0
    document = json.loads(capsys.readouterr().out)
    head = np.loadtxt(folder / "triangle_3_head.csv", delimiter=",", skiprows=1)[:, 1:3].mean(axis=0)
    assert np.linalg.norm(document["sheet_from_user"]["xyz_m"][:2] - head) < 0.35
    assert document["stops"] == []


@pytest.mark.parametrize("scale", [100.0, 1000.0])
def test_points_in_another_unit_are_noticed(tmp_path, capsys, scale):
    """The example's pairs with points in centimetres or millimetres."""
    examples = Path(__file__).parents[2] / "examples"
    header, *rows = (examples / "pairs.csv").read_text().splitlines()
    scaled = [
        ",".join([*row.split(",")[:-3], *(f"{scale * float(v):.6g}" for v in row.split(",")[-3:])]) for row in rows
    ]
    path = tmp_path / "pairs.csv"
    path.write_text("\n".join([header, *scaled]) + "\n")
    assert main(["calibrate", str(path), "--body", str(examples / "body.toml"), "--json"]) == 2
    assert "are x_m, y_m and z_m in metres" in capsys.readouterr().err


def test_a_table_in_centimetres_is_refused(capsys):
    examples = Path(__file__).parents[2] / "examples"
    words = ["calibrate", str(examples / "pairs.csv"), "--body", str(examples / "body.toml"), "--table-height-m", "75"]
    assert main(words) == 2
    assert "expected metres between 0 and 3" in capsys.readouterr().err
