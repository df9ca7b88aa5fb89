import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.devices.toio.wire import COMMANDS, EVENTS, UUIDS, characteristic_name, decode, decodings, encode
from armspan.errors import DeviceError

SHARED = Path(__file__).parents[4] / "shared" / "vectors" / "cellulo.json"
SPOT = {"x": 700, "y": 386, "angle_deg": 90, "angle_mode": 0}
AIM = {"id": 0, "timeout_s": 5, "movement": 0, "max_speed": 80, "change": 0}

# The worked examples of the toio core cube specification, and what its tables say of the rest.
PACKETS = [
    ("motor", {"left": 100, "right": -20}, "motor", "01010164020214"),
    ("motor", {"left": 0, "right": 0}, "motor", "01010100020100"),
    ("motor", {"left": -255, "right": 255}, "motor", "010102ff0201ff"),
    ("motorTimed", {"left": 100, "right": -20, "duration_ms": 100}, "motor", "020101640202140a"),
    ("motorTarget", AIM | SPOT, "motor", "03000500500000bc0282015a00"),
    ("motorTarget", AIM | SPOT | {"angle_mode": 5, "angle_deg": 0}, "motor", "03000500500000bc02820100a0"),
    (
        "motorTargets",
        AIM
        | {
            "add": True,
            "targets": [
                {"x": 100, "y": 100, "angle_deg": 0, "angle_mode": 0},
                {"x": 200, "y": 100, "angle_deg": 90, "angle_mode": 0},
                {"x": 200, "y": 200, "angle_deg": 180, "angle_mode": 0},
            ],
        },
        "motor",
        "0400050050000001640064000000c80064005a00c800c800b400",
    ),
    (
        "motorAcceleration",
        {
            "speed": 50,
            "acceleration": 5,
            "turn_deg_s": 15,
            "turn_back": False,
            "back": False,
            "turn_first": False,
            "duration_ms": 1000,
        },
        "motor",
        "0532050f0000000064",
    ),
    ("light", {"duration_ms": 160, "red": 255, "green": 0, "blue": 0}, "light", "03100101ff0000"),
    (
        "lightSequence",
        {
            "repeat": 0,
            "operations": [
                {"duration_ms": 300, "red": 0, "green": 255, "blue": 0},
                {"duration_ms": 300, "red": 0, "green": 0, "blue": 255},
            ],
        },
        "light",
        "0400021e010100ff001e01010000ff",
    ),
    ("lightsOff", {}, "light", "01"),
    ("lightOff", {}, "light", "020101"),
    ("soundEffect", {"effect": 4, "volume": 255}, "sound", "0204ff"),
    (
        "soundNotes",
        {
            "repeat": 0,
            "notes": [
                {"duration_ms": 300, "note": 60, "volume": 30},
                {"duration_ms": 300, "note": 62, "volume": 255},
                {"duration_ms": 300, "note": 64, "volume": 255},
            ],
        },
        "sound",
        "0300031e3c1e1e3eff1e40ff",
    ),
    ("soundStop", {}, "sound", "01"),
    ("requestMotion", {}, "sensor", "81"),
    ("requestMagnet", {}, "sensor", "82"),
    ("requestPosture", {"form": 1}, "sensor", "8301"),
    ("requestVersion", {}, "configuration", "0100"),
    ("setHorizontalThreshold", {"threshold_deg": 10}, "configuration", "05000a"),
    ("setCollisionThreshold", {"level": 10}, "configuration", "06000a"),
    ("setDoubleTapInterval", {"level": 7}, "configuration", "170007"),
    ("setIdNotification", {"interval_ms": 10, "condition": 1}, "configuration", "18000101"),
    ("setIdNotification", {"interval_ms": 20, "condition": 255}, "configuration", "180002ff"),
    ("setIdMissed", {"sensitivity_ms": 100}, "configuration", "19000a"),
    ("setMagnet", {"mode": 1, "interval_ms": 20, "condition": 1}, "configuration", "1b00010101"),
    ("setMotorSpeed", {"enabled": True}, "configuration", "1c0001"),
    ("setPosture", {"form": 1, "interval_ms": 10, "condition": 1}, "configuration", "1d00010101"),
    ("setSerialized", {"interval_ms": 10, "condition": 1}, "configuration", "1e000101"),
    ("setConnectionInterval", {"least": 8, "most": 80}, "configuration", "300008005000"),
    ("requestWantedInterval", {}, "configuration", "3100"),
    ("requestInterval", {}, "configuration", "3200"),
    ("powerOff", {"after_s": 10}, "configuration", "34000a"),
    (
        "idPosition",
        {"x": 709, "y": 383, "angle_deg": 306, "sensor_x": 700, "sensor_y": 386, "sensor_angle_deg": 306},
        "id",
        "01c5027f013201bc0282013201",
    ),
    ("idStandard", {"value": 3670016, "angle_deg": 21}, "id", "02000038001500"),
    ("idMissed", {}, "id", "03"),
    ("standardMissed", {}, "id", "04"),
    ("motorSpeeds", {"left": 50, "right": 0}, "motor", "e03200"),
    ("magnet", {"state": 0, "strength": 7, "x": -10, "y": 0, "z": 10}, "sensor", "020007f6000a"),
    ("postureEuler", {"roll_deg": 180, "pitch_deg": 0, "yaw_deg": -178}, "sensor", "0301b40000004eff"),
    ("postureQuaternion", {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0}, "sensor", "03020000803f" + "00" * 12),
    ("postureEulerFine", {"roll_deg": 180.0, "pitch_deg": 0.0, "yaw_deg": 0.0}, "sensor", "030300003443" + "00" * 8),
    ("button", {"pressed": True}, "button", "0180"),
    ("button", {"pressed": False}, "button", "0100"),
    ("battery", {"percent": 80}, "battery", "50"),
    ("version", {"version": "2.4.0"}, "configuration", "8100322e342e30"),
    ("idNotificationSet", {"result": 0}, "configuration", "980000"),
    ("idMissedSet", {"result": 0}, "configuration", "990000"),
    ("magnetSet", {"result": 0}, "configuration", "9b0000"),
    ("motorSpeedSet", {"result": 0}, "configuration", "9c0000"),
    ("postureSet", {"result": 0}, "configuration", "9d0000"),
    ("serializedSet", {"result": 1}, "configuration", "9e0001"),
    ("connectionIntervalSet", {"result": 0}, "configuration", "b00000"),
    ("wantedInterval", {"least": 8, "most": 80}, "configuration", "b10008005000"),
    ("interval", {"units": 8}, "configuration", "b2000800"),
    ("poweringOff", {"result": 0}, "configuration", "b40000"),
    ("serialized", {"data": "5a" * 19}, "configuration", "f0" + "5a" * 19),
]
WORDS = [
    ("motor", "830700", "motorReply", {"id": 7, "result": 0, "result_name": "reached"}),
    ("motor", "830002", "motorReply", {"id": 0, "result": 2, "result_name": "off the mat"}),
    ("motor", "840907", "motorTargetsReply", {"id": 9, "result": 7, "result_name": "cannot be added"}),
    (
        "sensor",
        "010100000103",
        "motion",
        {
            "horizontal": True,
            "collision": False,
            "double_tap": False,
            "posture": 1,
            "shake": 3,
            "posture_name": "upright",
        },
    ),
]


@pytest.mark.parametrize(("name", "args", "characteristic", "text"), PACKETS)
def test_a_packet_is_written_and_read(name, args, characteristic, text):
    assert encode(name, **args) == (characteristic, bytes.fromhex(text))
    packet = decode(characteristic, bytes.fromhex(text))
    assert (packet.name, packet.characteristic, packet.args) == (name, characteristic, args)


@pytest.mark.parametrize(("characteristic", "text", "name", "args"), WORDS)
def test_results_are_told_in_words(characteristic, text, name, args):
    packet = decode(characteristic, bytes.fromhex(text))
    assert (packet.name, packet.args) == (name, args)


def test_every_packet_is_tried():
    tried = {name for name, *_ in PACKETS} | {name for _, _, name, _ in WORDS}
    assert tried == set(COMMANDS) | set(EVENTS)


def test_the_shared_vectors():
    if not SHARED.exists():
        pytest.skip("needs ../shared/vectors/cellulo.json")
    vectors = {row["name"]: row for row in json.loads(SHARED.read_text())["toio_reference"]}
    sent = {
        "motor stop": encode("motor", left=0, right=0),
        "motor with target": encode("motorTarget", **AIM, **SPOT),
    }
    for name, (characteristic, data) in sent.items():
        assert data.hex() == vectors[name]["hex"]
        assert characteristic_name(vectors[name]["char"]) == characteristic
    assert decode("10B20102", bytes.fromhex(vectors["motor with target"]["hex"])).args == AIM | SPOT


def test_either_wheel_may_come_first():
    packet = decode("motor", bytes.fromhex("020202140101640a"))
    assert packet.args == {"left": 100, "right": -20, "duration_ms": 100}


def test_characteristics_by_name_number_and_uuid():
    uuid = "10B201FF-5B3B-4571-9508-CF3EFCD7BBAE"
    assert UUIDS["configuration"] == uuid.lower()
    assert [characteristic_name(text) for text in (uuid, "10B201FF", "configuration")] == ["configuration"] * 3
    with pytest.raises(DeviceError, match=r"'motors'.*'motor'"):
        decode("motors", b"\1")


def test_bytes_without_a_characteristic():
    assert decode(None, bytes.fromhex("01010100020100")).name == "motor"
    assert decode(None, bytes.fromhex("830000")).name == "motorReply"
    assert decode(None, bytes.fromhex("01c5027f013201bc0282013201")).name == "idPosition"
    assert {packet.name for packet in decodings(None, b"\x01")} == {"lightsOff", "soundStop", "battery"}
    with pytest.raises(DeviceError, match="name the characteristic"):
        decode(None, b"\x01")


@pytest.mark.parametrize(
    ("name", "args", "words"),
    [
        ("motr", {}, "'motor'"),
        ("motor", {"left": 1}, "needs right"),
        ("motor", {"left": 1, "right": 1, "rigth": 2}, "rigth"),
        ("motor", {"left": math.nan, "right": 1}, "left is nan; expected a number from -255 to 255"),
        ("motor", {"left": 256, "right": 1}, "256"),
        ("motor", {"left": "1", "right": 1}, "'1'"),
        ("motorTimed", {"left": 1, "right": 1, "duration_ms": -10}, "from 0 to 2550"),
        ("motorTimed", {"left": 1, "right": 1, "duration_ms": 2560}, "2560"),
        ("motorTarget", AIM | SPOT | {"max_speed": 9}, "from 10 to 255"),
        ("motorTarget", AIM | SPOT | {"angle_mode": 7}, "angle_mode is 7"),
        ("motorTarget", AIM | SPOT | {"x": math.inf}, "inf"),
        ("motorTargets", AIM | {"add": False, "targets": []}, "1 to 29"),
        ("motorTargets", AIM | {"add": False, "targets": [SPOT] * 30}, "1 to 29"),
        ("motorTargets", AIM | {"add": False, "targets": [7]}, "7"),
        ("motorTargets", AIM | {"add": False, "targets": [{"x": 1}]}, "needs y"),
        ("lightSequence", {"repeat": 0, "operations": [{"duration_ms": 0, "red": 0, "green": 0, "blue": 0}]}, "10"),
        ("soundEffect", {"effect": 11, "volume": 1}, "from 0 to 10"),
        ("setIdNotification", {"interval_ms": 10, "condition": 2}, "one of 0, 1, 255"),
        ("setMotorSpeed", {"enabled": None}, "None"),
        ("version", {"version": "2.4"}, "5 printable"),
        ("serialized", {"data": "xy"}, "38 hexadecimal"),
        ("light", {"duration_ms": 0, "red": True, "green": [], "blue": 0}, r"green is \[\]"),
    ],
)
def test_what_must_not_reach_the_wire(name, args, words):
    with pytest.raises(DeviceError, match=words):
        encode(name, **args)


def test_a_little_time_is_not_for_ever():
    assert encode("motorTimed", left=9, right=9, duration_ms=3)[1][-1] == 1
    assert encode("motorTimed", left=9, right=9, duration_ms=0)[1][-1] == 0
    assert encode("motorTimed", left=9, right=9, duration_ms=119.9)[1][-1] == 11


@pytest.mark.parametrize(
    ("characteristic", "text"),
    [
        ("motor", ""),
        ("motor", "010101640101"),
        ("motor", "01010164010114"),
        ("motor", "01010364020214"),
        ("motor", "0101016402021400"),
        ("motor", "03000500500001bc0282015a00"),
        ("motor", "04000500500000016400"),
        ("motor", "03000500500000bc028201ffff"),
        ("light", "0400031e010100ff001e01010000ff"),
        ("light", "040000"),
        ("id", "01c5027f016901bc0282013201"),
        ("sensor", "0302" + "0000c07f" * 4),
        ("button", "0140"),
        ("battery", "65"),
        ("configuration", "8100322e34ff30"),
        ("id", "7f"),
    ],
)
def test_what_means_nothing(characteristic, text):
    with pytest.raises(DeviceError, match="no toio packet"):
        decode(characteristic, bytes.fromhex(text))


@settings(derandomize=True, max_examples=400)
@given(st.sampled_from([None, *UUIDS]), st.binary(max_size=24), st.integers(0, len(PACKETS) - 1), st.integers(0, 30))
def test_any_bytes_mean_something_or_nothing(characteristic, noise, k, cut):
    for data in (noise, bytes.fromhex(PACKETS[k][3])[:cut] + noise):
        try:
            readings = decodings(characteristic, data)
        except DeviceError:
            continue
        for packet in readings:
            back = {key: value for key, value in packet.args.items() if not key.endswith("_name")}
            assert decode(packet.characteristic, encode(packet.name, **back)[1]) == packet


def test_strange_packets_are_refused_in_words():
    dice, refused = np.random.default_rng(5), 0
    for data in (dice.bytes(int(n)) for n in dice.integers(2, 30, 3000)):
        try:
            decodings(None, data)
        except DeviceError as error:
            refused += "no toio packet" in str(error)
    assert refused > 2950
