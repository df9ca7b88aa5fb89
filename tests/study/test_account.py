import json

import pytest

from armspan.records import Body, Calibrated, Pointed, Press, RobotState, Selected, Sheet, Tick
from armspan.study.account import account
from armspan.study.picture import draw
from armspan.swarm.limits import Limits

BODY, SHEET = Body(1.6, (0.06, 0.15, 0.22), 0.72), Sheet(0.9, 0.6)
PLACE = Calibrated(1.0, "wrist", (0.45, 0.9, 0.75), 1.57, (0.0,) * 16, 0.0175, 0.02, 4)
REFINED = Calibrated(5.0, "wrist", (0.46, 0.9, 0.75), 1.57, (0.0,) * 16, 0.0175, 0.02, 4)
SPOT = Pointed(2.5, "wrist", (0.5, 0.31), ((1e-4, 0.0), (0.0, 4e-4)), "amber", None, 0.95, True)
SESSION = [
    RobotState(0.0, "amber", (0.5, 0.3), 0.0),
    PLACE,
    Press(2.0, "trial", "robot:amber"),
    SPOT,
    Selected(2.5, "wrist", "amber", None, 0.95, "dwell"),
    Press(3.0, "trial", ""),
    REFINED,
    Tick(9.0),
]


def told(records):
    return account(records, BODY, SHEET, [], Limits(), 0.045)


def test_the_account_of_a_session():
    document = told(SESSION).document()
    assert document["seconds"] == 9.0
    assert document["calibration"]["rms_deg"] == pytest.approx(1.0027, abs=1e-3)
    assert document["calibration"]["xyz_m"] == PLACE.xyz  # the set-up's own, not what use made of it
    assert document["selection"] == {"shown": 1, "decided": 1, "right": 1, "unasked": 0}
    assert document["pointing"]["without_feedback"]["median_mm"] == pytest.approx(10.0)
    assert document["pointing"]["with_feedback"]["trials"] == 0
    assert document["safety"] == {"violations": 0, "kinds": {}, "least_gap_mm": None}


def test_an_empty_session_is_told_as_such():
    document = told([]).document()
    assert document["calibration"] == {"found": False, "rms_deg": None, "pairs": 0, "sheet_rms_mm": None}
    assert document["pointing"]["without_feedback"]["median_mm"] is None


@pytest.mark.parametrize("records", [SESSION, []])
def test_the_picture_is_a_png_even_of_nothing(tmp_path, records):
    path = tmp_path / "session.png"
    draw(path, records, told(records), SHEET, [])
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    assert int.from_bytes(data[16:20]) > 500


@pytest.mark.parametrize("records", [SESSION, []])
def test_it_is_plain_json(records):
    json.dumps(told(records).document(), allow_nan=False)
