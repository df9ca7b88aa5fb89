import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.devices.cellulo.wire import COMMANDS, EVENTS, Decoder, Framer
from armspan.errors import DeviceError

SHARED = Path(__file__).parents[4] / "shared" / "vectors" / "cellulo.json"
NOT_TO_BE_SENT = {"014efffffc28000007b01388", "0156ff9cffff0000ffffffff"}  # negative: the original wraps them

# What EPFL's own client sends, run with its arguments (chili-epfl/CelluloV2).
SENT = [
    ("ping", {}, "0150"),
    ("setPoseBcastPeriod", {"period_ms": 20}, "01440014"),
    ("setPoseBcastPeriod", {"period_ms": 70000}, "0144ffff"),
    ("setTimestampingEnabled", {"enabled": 1}, "015401"),
    ("requestFrame", {}, "0146"),
    ("setExposureTime", {"pixels": 100}, "012a00000104"),
    ("setExposureTime", {"pixels": 460}, "012a000001cc"),
    ("queryBatteryState", {}, "0142"),
    ("setLEDResponseMode", {"mode": 2}, "014c02"),
    ("setLocomotionInteractivityMode", {"mode": 0}, "014900"),
    ("setGestureEnabled", {"enabled": 1}, "015501"),
    ("setCasualBackdriveAssistEnabled", {"enabled": 1}, "014b01"),
    ("setHapticBackdriveAssist", {"x_coeff": 0.6, "y_coeff": 0.6, "theta_coeff": 0}, "0159003c003c0000"),
    ("setHapticBackdriveAssist", {"x_coeff": 400, "y_coeff": -400, "theta_coeff": 0.005}, "01597fff80010000"),
    ("setVisualEffect", {"effect": 3, "red": 0, "green": 0, "blue": 255, "value": 50}, "0145030000ff32"),
    ("setVisualEffect", {"effect": 0, "red": 1, "green": 1, "blue": 1, "value": 300}, "014500010101ff"),
    ("setMotorOutput", {"motor": 2, "output": -4095}, "014d02f001"),
    ("setAllMotorOutputs", {"m1": 100, "m2": -100, "m3": 0}, "01410064ff9c0000"),
    ("setGoalVelocity", {"vx_mm_s": 0.019, "vy_mm_s": -0.019, "w_rad_s": 0.009}, "01430001ffff0000"),
    ("setGoalVelocity", {"vx_mm_s": 185, "vy_mm_s": -185, "w_rad_s": -7.5}, "01434844b7bcfd12"),
    (
        "setGoalPose",
        {"x_mm": 250.5, "y_mm": 333.25, "theta_deg": 359.99, "v_max_mm_s": 150, "w_max_rad_s": 5},
        "01470000c09f000100408c9f3a9801f4",
    ),
    (
        "setGoalPose",
        {"x_mm": 123.45, "y_mm": 67.89, "theta_deg": 123.45, "v_max_mm_s": 33.3, "w_max_rad_s": 1.11},
        "014700005eed0000343430390d02006f",
    ),
    ("setGoalPosition", {"x_mm": 600, "y_mm": 500, "v_max_mm_s": 100}, "014e0001cd5e000180792710"),
    ("setGoalXCoordinate", {"x_mm": 2.54, "v_max_mm_s": 100}, "012d000001f32710"),
    ("setGoalXCoordinate", {"x_mm": 1.27, "v_max_mm_s": 100}, "012d000000f92710"),
    ("setGoalYCoordinate", {"y_mm": 150, "v_max_mm_s": 80}, "017c000073571f40"),
    ("setGoalOrientation", {"theta_deg": 90, "w_max_rad_s": 3}, "014f2328012c"),
    (
        "setGoalXThetaCoordinate",
        {"x_mm": 150, "theta_deg": 45, "v_max_mm_s": 80, "w_max_rad_s": 3},
        "015c0000735711941f40012c",
    ),
    (
        "setGoalYThetaCoordinate",
        {"y_mm": 150, "theta_deg": 45, "v_max_mm_s": 80, "w_max_rad_s": 3},
        "012f0000735711941f40012c",
    ),
    ("clearTracking", {}, "0158"),
    (
        "simpleVibrate",
        {"i_x": 5, "i_y": 5, "i_theta": 0, "period_ms": 50, "duration_ms": 1000},
        "015601f401f40000003203e8",
    ),
    ("vibrateOnMotion", {"coeff": 0.25, "period_ms": 20}, "015a00190014"),
    ("clearHapticFeedback", {}, "0148"),
    ("polyBezierInit", {"x0_mm": 10, "y0_mm": 20}, "012e4120000041a00000"),
    (
        "polyBezierAppend",
        {"x1_mm": 30, "y1_mm": 20, "x2_mm": 40, "y2_mm": 25.5, "x3_mm": 50, "y3_mm": 60},
        "017e41f0000041a000004220000041cc00004248000042700000",
    ),
    ("setGoalPolyBezier", {"v_mm_s": 80, "w_rad_s": 0}, "014a1f400000"),
    ("setGoalPolyBezierAligned", {"v_mm_s": 80, "theta_deg": 90, "w_max_rad_s": 2}, "01511f40232800c8"),
    ("reset", {}, "0152"),
    ("shutdown", {}, "0153"),
    ("SetAddress", {"mac": "00:06:66:E7:8A:D8"}, "0140000666e78ad8"),
    ("SetConnectionStatus", {"status": 0, "local_adapter": None}, "012100000000000000"),
    ("Heartbeat", {}, "0126"),
]
# What the robot's firmware wrote, and what EPFL's client read in it.
HEARD = [
    ("014f", "bootComplete", {}),
    ("0157", "lowBattery", {}),
    ("014202", "batteryStateChanged", {"state": 2, "state_name": "charging"}),
    ("014c03", "longTouch", {"key": 3}),
    ("014801", "gestureChanged", {"gesture": 1, "gesture_name": "hold"}),
    ("014b01", "kidnapChanged", {"kidnapped": True}),
    ("0147", "trackingGoalReached", {}),
    ("01451234567800000001", "debug", {"a": 305419896, "b": 1}),
    ("013e01a0a4c5915e9b", "AnnounceLocalAdapter", {"added": 1, "local_adapter": "A0:A4:C5:91:5E:9B"}),
]


def shared():
    if not SHARED.exists():
        pytest.skip(f"the recorded vectors are not beside the repository: {SHARED} is absent")
    return json.loads(SHARED.read_text())


@pytest.mark.parametrize(("name", "args", "sent"), SENT)
def test_commands_are_the_bytes_that_epfls_client_sends(name, args, sent):
    assert COMMANDS.encode(name, **args).hex() == sent


def test_there_are_32_commands_to_a_robot_and_all_are_tried_here():
    own = [layout.name for layout in COMMANDS.by_name.values() if layout.number < 32]
    assert len(own) == 32
    assert set(own) <= {name for name, _, _ in SENT}


@pytest.mark.parametrize(("packet", "name", "args"), HEARD)
def test_events_mean_what_epfls_client_reads(packet, name, args):
    event = EVENTS.decode(bytes.fromhex(packet))
    assert (event.name, event.args) == (name, args)


def test_a_stamped_pose():
    event = EVENTS.decode(bytes.fromhex("015300004ce5000099ca23280001e240"))
    assert event.raw == (19685, 39370, 9000, 123456)
    assert event.args["x_mm"] == pytest.approx(99.9998, abs=1e-6)
    assert event.args["y_mm"] == pytest.approx(199.9996, abs=1e-6)
    assert (event.args["theta_deg"], event.args["timestamp_ms"]) == (90.0, 123456)


def test_every_recorded_command():
    vectors = shared()
    rows = vectors["commands"] + [row for row in vectors["relay"] if row["dir"] == "client->server"]
    for row in rows:
        if row["hex"] in NOT_TO_BE_SENT:
            with pytest.raises(DeviceError, match="expected zero or more"):
                COMMANDS.encode(row["name"], **row["args"])
        else:
            assert COMMANDS.encode(row["name"], **row["args"]).hex() == row["hex"], row
        packet = COMMANDS.decode(bytes.fromhex(row["hex"]))
        assert packet.name == row["name"]
        assert COMMANDS.by_name[row["name"]].number == row["type_id"]


def test_every_recorded_command_means_to_the_robot_what_its_firmware_read():
    for row in shared()["commands"]:
        packet = COMMANDS.decode(bytes.fromhex(row["hex"]))
        for call in row.get("firmware_calls", ()):
            if len(call["args"]) != len(packet.args):
                continue  # an answer, or one call for each motor
            for (key, mine), theirs in zip(packet.args.items(), call["args"], strict=True):
                scale = 0.00508 if key in ("x_mm", "y_mm") else 0.01 if key == "theta_deg" else 1.0
                assert mine == pytest.approx(theirs * scale, rel=1e-6, abs=1e-9), (row, key)


def test_every_recorded_event():
    vectors = shared()
    for row in vectors["events"]:
        event = EVENTS.decode(bytes.fromhex(row["hex"]))
        layout = EVENTS.by_name[row["name"]]
        assert (event.name, layout.number, layout.length) == (row["name"], row["type_id"], row["payload_len"])
        for key, value in row["decoded"].items():
            if key == "pixels":
                assert event.args[key] == bytes(range(188))
            else:
                assert event.args[key] == (pytest.approx(value, rel=1e-6) if isinstance(value, float) else value)
    for row in vectors["relay"]:
        if row["dir"] == "server->client":
            assert EVENTS.encode(row["name"], **row["args"]).hex() == row["hex"]


def test_every_recorded_stream_byte_by_byte():
    vectors = shared()
    for direction, cases, key in (
        (COMMANDS, "command_stream_cases", "parsed_types_and_last_byte_index"),
        (EVENTS, "event_stream_cases", "parsed"),
    ):
        for case in vectors[cases]:
            framer, seen = Framer(direction), []
            for end, byte in enumerate(bytes.fromhex(case["hex"])):
                seen += [(chr(packet[1]), end) for packet in framer.feed(bytes([byte]))]
            assert seen == [(row["char"], row["end"]) for row in case[key]], case["case"]


STREAMS = [  # the types that are heard, and at which byte each is complete
    ("0150ffee0142", [("P", 1), ("B", 5)]),
    ("010150", []),
    ("01440001500150", [("D", 3), ("P", 6)]),
    ("0101500150", [("P", 4)]),
    ("0170", []),
]


@pytest.mark.parametrize(("stream", "heard"), STREAMS)
def test_a_stream_is_cut_as_the_firmware_cuts_it(stream, heard):
    framer, seen = Framer(COMMANDS), []
    for end, byte in enumerate(bytes.fromhex(stream)):
        seen += [(chr(packet[1]), end) for packet in framer.feed(bytes([byte]))]
    assert seen == heard


def test_the_relays_packets_are_unknown_on_a_robots_own_link():
    beat = bytes.fromhex("01260150")
    assert Framer(COMMANDS).feed(beat) == [bytes.fromhex("0150")]
    assert Framer(COMMANDS, relay=True).feed(beat) == [bytes.fromhex("0126"), bytes.fromhex("0150")]


# --- what must not reach the wire ------------------------------------------------------------------------

NUMBERS = [(layout.name, key) for layout in COMMANDS.by_name.values() for key, q in layout.fields if q.code != "6s"]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, None, "1", b"1", 10**400])
@pytest.mark.parametrize(("name", "key"), NUMBERS)
def test_what_is_no_finite_number_is_refused(name, key, bad):
    args = dict.fromkeys((key for key, _ in COMMANDS.by_name[name].fields), 1)
    args |= {"local_adapter": None} if "local_adapter" in args else {}
    with pytest.raises(DeviceError, match=f"{name}'s {key} is"):
        COMMANDS.encode(name, **(args | {key: bad}))


@pytest.mark.parametrize("key", ["x_mm", "y_mm", "v_max_mm_s", "w_max_rad_s"])
def test_negative_places_and_limits_are_refused(key):
    args = {"x_mm": 1, "y_mm": 1, "theta_deg": 0, "v_max_mm_s": 1, "w_max_rad_s": 1}
    with pytest.raises(DeviceError, match=f"{key} is -0.001; expected zero or more"):
        COMMANDS.encode("setGoalPose", **(args | {key: -0.001}))


@pytest.mark.parametrize(
    ("degrees", "sent"), [(-90, 27000), (360, 0), (720.5, 50), (-1e-12, 0), (359.9999999, 0), (-0.004, 35999)]
)
def test_angles_come_into_the_circle(degrees, sent):
    packet = COMMANDS.encode("setGoalOrientation", theta_deg=degrees, w_max_rad_s=1)
    assert int.from_bytes(packet[2:4], "big") == sent


@pytest.mark.parametrize(
    ("effect", "value", "sent"), [(1, 5, 5), (1, 9, 5), (3, 0x2F, 0x25), (3, 0x34, 0x34), (4, 9, 9)]
)
def test_no_light_beyond_the_sixth_is_written_to(effect, value, sent):
    packet = COMMANDS.encode("setVisualEffect", effect=effect, red=0, green=0, blue=0, value=value)
    assert packet[-1] == sent


def test_names_that_do_not_exist_are_answered_with_those_that_do():
    with pytest.raises(DeviceError, match=r"'setGoalPositon' does not exist.*Did you mean 'setGoalPosition'"):
        COMMANDS.encode("setGoalPositon")
    with pytest.raises(DeviceError, match="needs y_mm, v_max_mm_s; its arguments are x_mm, y_mm, v_max_mm_s"):
        COMMANDS.encode("setGoalPosition", x_mm=1)
    with pytest.raises(DeviceError, match="argument 'speed' does not exist"):
        COMMANDS.encode("setGoalPosition", x_mm=1, y_mm=1, v_max_mm_s=1, speed=3)
    with pytest.raises(DeviceError, match="mac is '00:06'; expected six pairs of hexadecimal digits"):
        COMMANDS.encode("SetAddress", mac="00:06")
    with pytest.raises(DeviceError, match="effect is 12; expected a whole number from 0 to 9"):
        COMMANDS.encode("setVisualEffect", effect=12, red=0, green=0, blue=0, value=0)


@pytest.mark.parametrize(
    "wrong", ["", "01", "0250", "0170", "015000", "0153", "015000000001000000018ca0", "014207", "015406"]
)
def test_what_is_not_one_event_is_refused(wrong):
    with pytest.raises(DeviceError):
        EVENTS.decode(bytes.fromhex(wrong))


def test_a_heading_of_360_degrees_is_refused_and_what_follows_is_heard():
    decoder = Decoder(EVENTS)
    heard = decoder.feed(bytes.fromhex("0150000000010000000d8ca0" + "0150000000010000000d8c9f" + "0141"))
    assert [packet.name for packet in heard] == ["poseChanged", "acknowledged"]
    assert heard[0].raw == (1, 13, 35999)
    assert decoder.refused == 1


# --- properties ------------------------------------------------------------------------------------------

STEP = {"x_mm": 0.00508, "y_mm": 0.00508}
WHOLE = {
    "enabled": (0, 1),
    "mode": (0, 1),
    "motor": (1, 3),
    "effect": (4, 9),
    "status": (0, 2),
    "pixels": (260, 1 << 31),
    "period_ms": (0, 65535),
    "duration_ms": (0, 65535),
    **dict.fromkeys(("output", "m1", "m2", "m3"), (-4095, 4095)),
    **dict.fromkeys(("red", "green", "blue", "value"), (0, 255)),
}


def value(key, quantity):
    if quantity.code == "6s":
        return st.sampled_from(["00:06:66:E7:8A:D8", "FF:00:01:01:00:FF"])
    if key in WHOLE:
        return st.integers(*WHOLE[key])
    if quantity.code == "f":
        return st.floats(0, 1e5, width=32)
    return st.floats(-327, 327) if quantity.code == "h" else st.floats(0, 359)


@given(st.sampled_from(sorted(COMMANDS.by_name)), st.data())
@settings(max_examples=300, deadline=None, derandomize=True)
def test_what_is_sent_is_what_is_heard_within_one_count(name, data):
    args = {key: data.draw(value(key, quantity), label=key) for key, quantity in COMMANDS.by_name[name].fields}
    heard = COMMANDS.decode(COMMANDS.encode(name, **args))
    assert heard.name == name
    for key, sent in args.items():
        count = STEP.get(key, 0.01) * 1.001
        assert heard.args[key] == (sent if isinstance(sent, int | str) else pytest.approx(sent, rel=2e-7, abs=count))


@given(st.sampled_from(sorted(EVENTS.by_name)), st.binary(max_size=200))
@settings(max_examples=300, deadline=None, derandomize=True)
def test_an_events_bytes_come_back_or_are_refused(name, payload):
    layout = EVENTS.by_name[name]
    packet = bytes([1, ord(layout.char)]) + (payload * 200 + bytes(200))[: layout.length]
    try:
        event = EVENTS.decode(packet)
    except DeviceError:
        return
    fields = [key for key, _ in layout.fields]
    assert EVENTS.encode(name, **{key: event.args[key] for key in fields}) == packet


@pytest.mark.parametrize("direction", [COMMANDS, EVENTS])
@pytest.mark.parametrize("seed", range(4))
def test_noise_raises_nothing_and_is_over_when_it_ends(direction, seed):
    rng = np.random.default_rng(seed)
    decoder, packet = Decoder(direction), bytes.fromhex("0142")
    packet = packet if direction is COMMANDS else bytes.fromhex("0141")
    for _ in range(300):
        noise = rng.integers(0, 256, size=rng.integers(0, 60), dtype=np.uint8)
        noise[rng.random(noise.size) < 0.2] = 1
        decoder.feed(noise.tobytes())
    decoder.feed(bytes(200))  # longer than any payload: whatever had begun is over
    heard = decoder.feed(packet)
    assert [(found.name, found.args) for found in heard] == [(direction.decode(packet).name, {})]


@given(st.binary(max_size=40), st.integers(1, 39))
@settings(max_examples=200, deadline=None, derandomize=True)
def test_it_does_not_matter_how_a_stream_is_cut(stream, cut):
    stream = stream.replace(b"\x00", b"\x01")
    whole, cuts = Framer(COMMANDS, relay=True), Framer(COMMANDS, relay=True)
    pieces = cuts.feed(stream[:cut]) + cuts.feed(stream[cut:])
    assert whole.feed(stream) == pieces
