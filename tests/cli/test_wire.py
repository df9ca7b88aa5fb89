import io
import json
import math
import sys
from pathlib import Path

import pytest

from command_line import code_of, refused

VECTORS = Path(__file__).parents[3] / "shared" / "vectors"
NOT_TO_BE_SENT = {"014efffffc28000007b01388", "0156ff9cffff0000ffffffff"}  # negative: the original wraps them


def vectors(name):
    file = VECTORS / f"{name}.json"
    if not file.is_file():
        pytest.skip("the recorded vectors are not beside this repository")
    return json.loads(file.read_text())


def printed(capsys, *words):
    assert code_of("wire", *words) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return out.splitlines()


def batch(capsys, tmp_path, lines, *words):
    """Exit code, answers, and what was said of refused lines."""
    file = tmp_path / "lines.jsonl"
    file.write_text("".join(f"{line if isinstance(line, str) else json.dumps(line)}\n" for line in lines))
    code = code_of("wire", *words, "--batch", file)
    out, err = capsys.readouterr()
    answers = [json.loads(line) for line in out.splitlines()]
    assert len(answers) == len(lines)
    return code, answers, err


def agrees(told, expected):
    """Whether an answer has what was recorded, numbers as single precision."""
    if isinstance(expected, dict):
        return all(key in told and agrees(told[key], value) for key, value in expected.items())
    if isinstance(expected, float):
        return math.isclose(told, expected, rel_tol=1e-7, abs_tol=1e-12)
    return told == expected


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("cellulo", "encode", "setGoalVelocity", "vx_mm_s=50", "vy_mm_s=0", "w_rad_s=0"), ["0143138800000000"]),
        (("cellulo", "encode", "SetAddress", "mac=00:06:66:E7:8A:D8"), ["0140000666e78ad8"]),
        (("cellulo", "encode", "SetConnectionStatus", "status=0", "local_adapter=null"), ["012100000000000000"]),
        (("cellulo", "encode", "kidnapChanged", "kidnapped=1"), ["014b01"]),
        (("metawear", "encode", "acc.config", "rate_hz=100", "range_g=8", "board=mms"), ["0303a802"]),
        (("metawear", "encode", "mag.preset.regular.rev2"), ["150100", "1504040e", "150300"]),
        (("metawear", "encode", "mag.suspend.rev1"), []),
        (("toio", "encode", "motor", "left=50", "right=-50"), ["01010132020232"]),
        (("cellulo", "decode", "01", "4b", "01", "--from", "robot"), ["from the robot: kidnapChanged kidnapped=True"]),
        (("cellulo", "decode", "0148 01"), ["from the robot: gestureChanged gesture=1 gesture_name=hold"]),
        (("cellulo", "decode", "0158"), ["from the host: clearTracking"]),
        (("metawear", "decode", "118c633410"), ["battery: voltage_mV=4148 charge_percent=99"]),
        (("metawear", "decode", "1f05118c6334100a"), ["battery: voltage_mV=4148 charge_percent=99"]),
        (("metawear", "decode", "030400408000c000", "range_g=8"), ["acc_xyz_g [g]: x=4 y=0.03125 z=0.046875"]),
        (("metawear", "decode", "111201"), ["charge_status: 1"]),
        (("metawear", "decode", "0303280c"), ["written by the host: acc.config.100Hz.16g"]),
        (("toio", "decode", "01010132020232"), ["motor: motor left=50 right=-50"]),
    ],
)
def test_one(capsys, words, told):
    assert [line for line in printed(capsys, *words) if line] == told


def test_what_both_sides_could_have_said_is_told_twice(capsys):
    told = printed(capsys, "cellulo", "decode", "014b01")
    assert told[0].startswith("from the robot: kidnapChanged")
    assert told[1] == "or from the host: setCasualBackdriveAssistEnabled enabled=1"


def test_a_stream_is_taken_apart_as_the_robot_does(capsys):
    told = printed(capsys, "cellulo", "decode", "--from", "host", "ffee0150010150014201440014aa014300")
    assert told == [
        "from the host: ping",
        "from the host: queryBatteryState",
        "from the host: setPoseBcastPeriod period_ms=20",
        "skipped: ffee",
        "skipped: 010150",
        "skipped: aa",
        "incomplete: 014300",
    ]


def test_a_relays_stream(capsys):
    told = printed(capsys, "cellulo", "decode", "0140000666e78ad8014101260141", "--json")
    answer = json.loads(told[0])
    names = [packet["name"] for packet in answer["packets"]]
    assert names == ["SetAddress", "acknowledged", "Heartbeat", "acknowledged"]
    assert [packet["end"] for packet in answer["packets"]] == [7, 9, 11, 13]


def test_json_of_a_session_has_its_steps(capsys):
    (line,) = printed(capsys, "metawear", "encode", "--json", "fusion.startstop.mms.imu_plus.quaternion")
    answer = json.loads(line)
    assert [step["step"] for step in answer["steps"]] == ["start", "stop"]
    assert answer["writes"] == [write for step in answer["steps"] for write in step["writes"]]
    assert answer["writes"][-1] == "13020001"


@pytest.mark.parametrize("device", ["cellulo", "metawear", "toio"])
def test_names_are_listed(capsys, device):
    listed = printed(capsys, device, "encode", "--list")
    assert len(listed) > 30
    assert {"cellulo": "ping", "metawear": "acc.config.{rate_hz}Hz.{range_g}g", "toio": "motor left= right="}[
        device
    ] in listed


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("cellulo",), "--list"),
        (("cellulo", "fly"), "decode, encode"),
        (("cellulo", "encode", "fly"), "'fly' does not exist"),
        (("cellulo", "encode", "ping", "name=1"), "no argument name"),
        (("cellulo", "encode", "ping", "pong"), "expected key=value"),
        (("cellulo", "encode", "setGoalVelocity", "vx_mm_s=nan", "vy_mm_s=0", "w_rad_s=0"), "finite"),
        (("cellulo", "decode", "xyz"), "not hexadecimal"),
        (("cellulo", "decode", "ffff"), "no whole Cellulo packet"),
        (("cellulo", "decode", "0153000230c10000949ac83600000000"), "theta_raw"),
        (("metawear", "encode", "acc.config", "rate_hz=101", "range_g=8"), "101 Hz does not exist"),
        (("metawear", "encode", "acc.config", "rate_hz=100", "range_g=8", "board=x"), "mmrl_current"),
        (("metawear", "decode", "ff01"), "means nothing"),
        (("metawear", "decode", "118c633410", "board=5"), "expected one of"),
        (("metawear", "decode", "030400408000c000", "range_g=big"), "expected a number"),
        (("toio", "encode", "motor", "left=50"), "needs right"),
        (("toio", "decode", "ff"), "no toio packet"),
        (("toio", "decode", "64", "characteristic=7"), "10B20102"),
        (("cellulo", "encode", "ping", "--batch", "x"), "no place"),
    ],
)
def test_bad_input_is_one_sentence(capsys, tmp_path, words, said):
    assert said in refused(capsys, tmp_path, "wire", *words)


def test_a_missing_file_is_one_sentence(capsys, tmp_path):
    assert "No such file" in refused(capsys, tmp_path, "wire", "cellulo", "--batch", tmp_path / "none.jsonl")


def test_every_line_of_a_batch_has_its_answer(capsys, tmp_path):
    lines = [
        {"name": "ping", "args": {}, "more": 1},
        "not json",
        "",
        "[1]",
        {"name": "ping", "args": [1]},
        {"name": 7, "args": {}},
        {"hex": "0141"},
        {"hex": "0141", "from": "moon"},
        "[" * 100_000,
        {"name": "setMotorOutput", "args": {"motor": 2, "output": {"a": 1}}},
        {"name": "frameLine", "args": {"line": 1, "pixels": 3}},
    ]
    code, answers, err = batch(capsys, tmp_path, lines, "cellulo")
    assert code == 2
    assert [list(answer) == ["error"] for answer in answers] == [False, *[True] * 5, False, *[True] * 4]
    assert answers[0] == {"name": "ping", "args": {}, "hex": "0150"}
    assert answers[6]["name"] == "acknowledged"
    assert err == "armspan wire: 9 of 11 lines could not be understood\n"


@pytest.mark.parametrize(
    "line",
    [
        {"id": "acc.start", "board": ["mms"]},
        {"id": "acc.start", "args": 1},
        {"id": "acc.config", "args": {"rate_hz": None, "range_g": {}}},
        {"id": ["acc"]},
        {"notification": None},
        {"notification": "118c633410", "board": {}},
        {"notification": "118c633410", "processor": {}},
        {"notification": "118c633410", "processor": "all"},
        {"payload": 3},
        {"payload": ""},
        {"frame": "1f02"},
        {},
    ],
)
def test_wrong_lines_of_a_batch_are_answered(capsys, tmp_path, line):
    code, [answer], _ = batch(capsys, tmp_path, [line], "metawear")
    assert (code, list(answer)) == (2, ["error"])


def test_a_batch_may_come_from_stdin(capsys, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b'{"id": "debug.reset"}\n{"id": "led.play"}')))
    told = [json.loads(line) for line in printed(capsys, "metawear", "encode", "--batch", "-")]
    assert [answer["writes"] for answer in told] == [["fe01"], ["020101"]]


def test_a_leds_note_tells_what_its_name_has_no_room_for(capsys, tmp_path):
    line = {"id": "led.pattern.pulse.red.rev1", "note": "delay=100 ms, repeat=5"}
    code, [answer], _ = batch(capsys, tmp_path, [line], "metawear")
    assert (code, answer["writes"]) == (0, ["020301021f00d502f401d502d007640005"])


@pytest.mark.parametrize("verb", ["encode", None])
def test_recorded_cellulo_commands(capsys, tmp_path, verb):
    recorded = vectors("cellulo")
    for lines in (recorded["commands"], recorded["relay"]):
        code, answers, _ = batch(capsys, tmp_path, lines, "cellulo", *([verb] if verb else []))
        for line, answer in zip(lines, answers, strict=True):
            assert answer.get("hex", "refused") == ("refused" if line["hex"] in NOT_TO_BE_SENT else line["hex"])
        assert code == (2 if any(line["hex"] in NOT_TO_BE_SENT for line in lines) else 0)


def test_recorded_cellulo_bytes(capsys, tmp_path):
    recorded = vectors("cellulo")
    for lines in (recorded["commands"], recorded["relay"], recorded["events"]):
        code, answers, _ = batch(capsys, tmp_path, lines, "cellulo", "decode")
        assert code == 0
        for line, answer in zip(lines, answers, strict=True):
            assert answer["name"] == line["name"]
            assert agrees(answer["decoded"], line.get("decoded", {})), line


def test_recorded_cellulo_events_are_found_by_their_bytes_alone(capsys, tmp_path):
    lines = [{"hex": event["hex"]} for event in vectors("cellulo")["events"]]
    _, answers, _ = batch(capsys, tmp_path, lines, "cellulo", "decode")
    for event, answer in zip(vectors("cellulo")["events"], answers, strict=True):
        assert answer["name"] == event["name"]


def test_recorded_cellulo_streams(capsys, tmp_path):
    recorded = vectors("cellulo")
    for key, field in (("command_stream_cases", "parsed_types_and_last_byte_index"), ("event_stream_cases", "parsed")):
        code, answers, _ = batch(capsys, tmp_path, recorded[key], "cellulo", "decode")
        assert code == 0
        for case, answer in zip(recorded[key], answers, strict=True):
            told = [(bytes.fromhex(packet["hex"])[1:2].decode(), packet["end"]) for packet in answer["packets"]]
            assert told == [(one["char"], one["end"]) for one in case[field]], case["case"]


@pytest.mark.parametrize("verb", ["encode", None])
def test_recorded_metawear_commands(capsys, tmp_path, verb):
    recorded = vectors("metawear")
    lines = recorded["commands"] + recorded["sequences"]
    code, answers, _ = batch(capsys, tmp_path, lines, "metawear", *([verb] if verb else []))
    assert code == 0
    for line, answer in zip(lines, answers, strict=True):
        writes = [write for step in line.get("steps", [line]) for write in step["writes"]]
        assert answer["writes"] == writes, line["id"]
        assert answer.get("steps") == line.get("steps")


@pytest.mark.parametrize("verb", ["decode", None])
def test_recorded_metawear_notifications(capsys, tmp_path, verb):
    lines = vectors("metawear")["decodes"]
    code, answers, _ = batch(capsys, tmp_path, lines, "metawear", *([verb] if verb else []))
    assert code == 0
    for line, answer in zip(lines, answers, strict=True):
        assert (answer["kind"], answer["decoded"]) == (line["kind"], line["decoded"]), line["id"]


def test_recorded_outputs_of_data_processors(capsys, tmp_path):
    lines = [line for line in vectors("metawear")["on_board_programs"]["entries"] if "count" in line]
    code, answers, _ = batch(capsys, tmp_path, lines, "metawear", "decode")
    assert code == 0
    assert [answer["decoded"]["tick"] for answer in answers] == [line["count"] for line in lines] == [492, 542]


def test_recorded_usb_frames(capsys, tmp_path):
    lines = vectors("metawear")["usb"]["examples"]
    _, answers, _ = batch(capsys, tmp_path, lines, "metawear")
    assert answers == lines


def test_recorded_toio_packets(capsys, tmp_path):
    lines = vectors("cellulo")["toio_reference"]
    code, answers, _ = batch(capsys, tmp_path, lines, "toio", "decode")
    assert (code, [answer["name"] for answer in answers]) == (0, ["motor", "motorTarget"])
    again = [{"name": answer["name"], "args": answer["args"]} for answer in answers]
    _, encoded, _ = batch(capsys, tmp_path, again, "toio", "encode")
    assert [answer["hex"] for answer in encoded] == [line["hex"] for line in lines]
