import json
import math
import struct
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan.devices.metawear import notifications as n
from armspan.devices.metawear import programs, signals, wire
from armspan.devices.metawear import settings as board_settings
from armspan.devices.metawear.boards import ACC, LIGHT, MAG, NAMED, Board, board_from_replies, board_named, module_reply
from armspan.devices.metawear.reports import report
from armspan.devices.metawear.usb_frames import UsbFramer, usb_frame
from armspan.devices.metawear.wire import Ranges, decode
from armspan.errors import DeviceError

SHARED = Path(__file__).parents[4] / "shared" / "vectors" / "metawear.json"
MMR, MMRL, RL, MMS = (board_named(name) for name in ("mmr_fw113", "mmrl_fw113", "mmrl_current", "mms"))


def vectors():
    if not SHARED.is_file():
        pytest.skip("the recorded vectors are not beside this repository")
    return json.loads(SHARED.read_text())


def hexes(writes):
    return [write.hex() for write in writes]


# Worked out by hand from Bosch's register maps and MbientLab's published protocol, not by this code.
@pytest.mark.parametrize(
    ("write", "told"),
    [
        (wire.configure_acc(MMR, 0.78125, 2), "03038103"),
        (wire.configure_acc(MMR, 6.25, 4), "03038405"),
        (wire.configure_acc(MMR, 12.5, 16), "0303250c"),
        (wire.configure_acc(RL, 1600, 8), "03032c08"),
        (wire.configure_acc(MMS, 1.5625, 2), "03032200"),
        (wire.configure_acc(MMS, 12.5, 4), "0303a501"),
        (wire.configure_acc(MMS, 100, 16), "0303a803"),
        (wire.configure_gyro(MMR, 25, 2000), "13032600"),
        (wire.configure_gyro(MMS, 3200, 125), "13032d04"),
        (wire.gyro_offsets(1, 2, 255), "13060102ff"),
        (wire.subscribe(MMR, "gyro"), "130501"),
        (wire.subscribe(MMR, "gyro_packed"), "130701"),
        (wire.subscribe(MMS, "gyro"), "130401"),
        (wire.unsubscribe(MMS, "gyro_packed"), "130500"),
        (wire.subscribe(RL, "acc_packed"), "031c01"),
        (wire.subscribe(MMS, "acc_packed"), "030501"),
        (wire.subscribe(MMR, "mag_packed"), "150901"),
        (wire.subscribe(MMS, "charge_status"), "111201"),
        (wire.subscribe(MMS, "corrected_acc"), "190401"),
        (wire.subscribe(MMS, "linear_acc"), "190a01"),
        (wire.enable_sampling("mag"), "15020100"),
        (wire.disable_sampling("gyro"), "13020001"),
        (wire.start("acc"), "030101"),
        (wire.stop("mag"), "150100"),
        (wire.enable_taps(MMR, double=True), "030c0300"),
        (wire.enable_taps(MMR, single=False), "030c0003"),
        (wire.reset_orientation(RL), "190f01"),
        (wire.spoof(1, 1, b"\x00\x07"), "fe0301010007"),
        (wire.read("battery"), "118c"),
        (signals.motor(100, 5000), "0801f8881300"),
        (signals.motor(50, 200), "08017cc80000"),
        (signals.buzzer(7500), "08017f4c1d01"),
        (signals.led_preset(MMR, "pulse", "red"), "020301021f00d502f401d502d0070000ff"),
        (signals.led_preset(MMS, "solid", "blue", delay_ms=5000, repeat=3), "020302021f1f0000f4010000e803881303"),
        (board_settings.connection_parameters(7.5, 7.5, 0, 6000), "11090600060000005802"),
        (board_settings.advertising_interval(MMR, 417, 180), "11029b02b4"),
        (board_settings.advertising_interval(MMS, 417, 180), "11029b02b400"),
        (board_settings.transmit_power(-20), "1103ec"),
        (board_settings.transmit_power(4), "110304"),
        (board_settings.supply_3v(MMS), "111c01"),
        (board_settings.force_1m_phy(MMS, on=False), "111d00"),
        (board_settings.device_name("AntiWare"), "1101416e746957617265"),
        (programs.rate_limiter(programs.stream_source(RL, "quaternion"), 20), "09021907ffe0081714000000"),
        (programs.accounter(programs.stream_source(RL, "acc")), "09020304ffa0113103"),
        (programs.timer(1000, 3), "0c02e8030000030001"),
        (programs.download(414), "0b069e01000014000000"),
        (usb_frame(b"\x0b\x10\x01"), "1f030b10010a"),
    ],
)
def test_one_write(write, told):
    assert write.hex() == told


@pytest.mark.parametrize(
    ("writes", "told"),
    [
        (wire.preset_mag(MMR, "enhanced_regular"), "1504071a 150300"),
        (wire.preset_mag(MMS, "high_accuracy"), "150100 15041752 150305"),
        (wire.suspend_mag(MMR), ""),
        (wire.suspend_mag(RL), "150102"),
        (wire.configure_fusion(MMR, "imu_plus"), "19020213 0303280c 13032800"),
        (wire.configure_fusion(MMS, "m4g", 2, 250), "19020440 0303a700 150100 1504040e 150306"),
        (wire.start_fusion("imu_plus", ["quaternion"]), "03020100 13020100 030101 130101 19030800 190101"),
        (wire.stop_fusion("compass"), "190100 1903007f 030100 150100 03020001 15020001"),
        (wire.switch_feature(MMS, "step_counter", on=True), "03070200 03060200"),
        (wire.switch_feature(MMS, "step_detector", on=False), "03070080 03060080"),
        (wire.write_calibration("imu_plus", b"a" * 10, b"b" * 10), f"190c{'61' * 10} 190d{'62' * 10}"),
        (programs.fused_raw(RL), "09021305ffa00f05 09020304ffa01b01000000000000000000000000 090209030160113103"),
        (programs.on_disconnect((signals.motor(100, 3000),)), "0a02110aff080104 0a03f8b80b00"),
        (programs.log(programs.stream_source(RL, "quaternion")), "0b021907ff60 0b021907ff64 0b021907ff68 0b021907ff6c"),
        (programs.log(programs.stream_source(RL, "acc")), "0b020304ff60 0b020304ff24"),
        (programs.FACTORY_CLEAN, "0b0100 0b09ffffffff 0b0a 0a05 0908 0f08 fe05 fe01"),
    ],
)
def test_several_writes(writes, told):
    assert hexes(writes) == told.split()


def test_a_fused_packet_reads_the_gyro_where_the_board_has_it():
    newer = {**MMS.modules, 9: (0, 3, b"\x1c")}
    assert programs.fused_raw(Board(newer, "8"))[0].hex() == "09021304ffa00f05"


@pytest.mark.parametrize(
    ("refused", "words"),
    [
        (lambda: wire.configure_acc(MMR, 99, 2), "99 Hz does not exist"),
        (lambda: wire.configure_acc(MMR, math.nan, 2), "nan"),
        (lambda: wire.configure_acc(MMR, 100, 3), "2, 4, 8, 16 g"),
        (lambda: wire.configure_gyro(MMR, 12.5, 2000), "25, 50, 100"),
        (lambda: wire.configure_gyro(MMR, 100, math.inf), "inf"),
        (lambda: wire.configure_fusion(MMR, "imu", 2, 2000), "compass, imu_plus, m4g, ndof"),
        (lambda: wire.configure_fusion(MMR, "ndof", 2, 125), "250, 500, 1000, 2000"),
        (lambda: wire.start_fusion("ndof", ["quaternions"]), "Did you mean 'quaternion'"),
        (lambda: wire.subscribe(MMR, "acceleration"), "does not exist"),
        (lambda: wire.start("barometer"), "acc, gyro, mag"),
        (lambda: wire.enable_taps(MMS), "bmi270"),
        (lambda: wire.switch_feature(RL, "gesture", on=True), "bmi160"),
        (lambda: wire.reset_orientation(MMR), "revision 3"),
        (lambda: wire.write_calibration("ndof", b"a" * 10, b"a" * 9, b"a" * 10), "gyro has 9 bytes"),
        (lambda: wire.preset_mag(Board({}, "8"), "regular"), "MetaMotion S has no magnetometer"),
        (lambda: wire.configure_mag(MMR, 0, 1, 10), "from 1 to 511"),
        (lambda: wire.spoof(1, 1, bytes(17)), "at most 16"),
        (lambda: signals.motor(101, 5), "0 to 100"),
        (lambda: signals.motor(math.nan, 5), "nan"),
        (lambda: signals.buzzer(-1), "0 to 65535"),
        (lambda: signals.led_preset(MMR, "flash", "red"), "blink, pulse, solid"),
        (lambda: signals.led_pattern(MMR, "red", (32, 0), (0, 0, 0, 0)), "0 to 31"),
        (lambda: board_settings.connection_parameters(math.nan, 10, 0, 100), "nan"),
        (lambda: board_settings.connection_parameters(20, 10, 0, 100), "the shorter first"),
        (lambda: board_settings.device_name("Grün"), "A-Z a-z"),
        (lambda: board_settings.device_name("x" * 19), "1 to 18"),
        (lambda: board_settings.supply_3v(MMR), "revision 9"),
        (lambda: programs.fused_raw(MMS), "too old"),
        (lambda: programs.timer(0), "from 1"),
        (lambda: programs.event(1, 1, 255, b"\x01"), "1 bytes"),
        (lambda: usb_frame(b""), "1 to 255"),
        (lambda: board_named("mmx"), "mmr_fw113"),
        (lambda: board_from_replies([b"\x03\x81\x01\x01"]), "03810101"),
        (lambda: Board({ACC: (9, 0, b"")}, "8").acc_chip, "implementation 9"),
    ],
)
def test_what_must_not_reach_the_wire_is_one_sentence(refused, words):
    with pytest.raises(DeviceError, match=words) as error:
        refused()
    assert "\n" not in str(error.value)


def test_boards_are_what_their_modules_say():
    assert (MMR.name, MMRL.name, RL.name, MMS.name) == (
        "MetaMotion R",
        "MetaMotion RL",
        "MetaMotion RL",
        "MetaMotion S",
    )
    assert (RL.acc_chip, MMS.acc_chip, RL.gyro_chip, MMS.gyro_chip) == ("bmi160", "bmi270", "bmi160", "bmi270")
    assert (MMR.revision(MAG), RL.revision(MAG), RL.has(LIGHT), MMR.has(LIGHT)) == (1, 2, False, True)


def test_an_absent_module_answers_two_bytes_or_not_at_all():
    both = board_from_replies([b"\x03\x80\x01\x02", b"\x15\x80"], "5")
    assert both == board_from_replies([b"\x03\x80\x01\x02"], "5")
    assert module_reply(both, 0x15) == b"\x15\x80"
    assert module_reply(both, 0x03) == b"\x03\x80\x01\x02"


def test_named_boards_answer_as_recorded():
    for name, handshake in vectors()["handshake"].items():
        board = board_named(name)
        for question, reply in handshake["replies"].items():
            assert module_reply(board, int(question[:2], 16)).hex() == reply
        assert len(board.modules) == sum(len(reply) > 4 for reply in handshake["replies"].values())


def test_a_real_boards_replies():
    replies = [bytes.fromhex(reply) for reply in vectors()["real_device_trace"]["module_info_replies"]]
    board = board_from_replies(replies, "5")
    assert board.acc_chip == "bmi160"
    assert board.has(9, 3)


def both(sample):
    return tuple(float(value) for value in sample)


@pytest.mark.parametrize(
    ("board", "told", "ranges", "meaning"),
    [
        (RL, "030400408000c000", Ranges(acc_g=2), n.Samples("acc", (both((1, 0.0078125, 0.01171875)),))),
        (MMS, "0304ff7f00800000", Ranges(acc_g=16), n.Samples("acc", (both((15.99951171875, -16, 0)),))),
        (MMS, "1304a400a4ff0000", Ranges(gyro_dps=2000), n.Samples("gyro", (both((10, -5.609756, 0)),))),
        (RL, "130500000000ffff", Ranges(gyro_dps=125), n.Samples("gyro", (both((0, 0, -1 / 262.4)),))),
        (MMR, "15051000f0ff0100", Ranges(), n.Samples("mag", (both((1, -1, 0.0625)),))),
        (MMR, "1509" + "1000f0ff0100" * 3, Ranges(), n.Samples("mag", (both((1, -1, 0.0625)),) * 3)),
        (RL, "0903020a00000000080000000000000000a400", Ranges(8), n.Fused(2, 10, both((0.5, 0, 0)), both((0, 0, 10)))),
        (RL, "090305" + "0000803f" + "00000000" * 3, Ranges(processors={5: "quaternion"}), n.Quaternion(1, 0, 0, 0)),
        (
            RL,
            "090300ec0100000000000040000040",
            Ranges(processors={0: "raw"}),
            n.Output(0, bytes.fromhex("ec0100000000000040000040")),
        ),
        (RL, "090300ec010000000000400040", Ranges(processors={0: "acc"}), n.Timed(0, 492, "acc", both((0, 1, 1)))),
        (RL, "030e21", Ranges(), n.Tap("double", 1)),
        (MMS, "030a0e", Ranges(), n.Gesture(2, 3)),
        (MMS, "030c04", Ranges(), n.Activity(2)),
        (MMR, "118b077b528fc9e8", Ranges(), n.Mac("E8:C9:8F:52:7B:07")),
        (MMR, "118b01077b528fc9e8", Ranges(), n.Mac("E8:C9:8F:52:7B:07")),
        (MMR, "0b841504000005", Ranges(), n.LogTime(1045, 5)),
        (MMR, "0b859e010000", Ranges(), n.LogLength(414)),
        (MMR, "0b07a1cc4d00006c010000", Ranges(), n.LogEntries((n.LogEntry(1, 5, 0x4DCC, 0x16C),))),
        (MMR, "0b0d", Ranges(), n.LogProgress(None)),
        (MMR, "03800101", Ranges(), n.ModuleInfo(3, 1, 1, b"")),
        (MMR, "1680", Ranges(), n.ModuleInfo(0x16, None, None, b"")),
        (MMR, "0c0203", Ranges(), n.Created("timer", 3)),
        (RL, "0383280c", Ranges(), n.ChipConfig("acc", 100.0, 16)),
        (MMS, "0383a800", Ranges(), n.ChipConfig("acc", 100.0, 2)),
        (MMS, "13832803", Ranges(), n.ChipConfig("gyro", 100.0, 250)),
        (MMS, "19820110", Ranges(), n.FusionConfig("ndof", 2, 2000)),
        (MMS, "1982010f", Ranges(), n.FusionConfig("ndof", None, None)),
        (MMS, "198cf6ff00000a00e8030300", Ranges(), n.CalibrationData("acc", bytes.fromhex("f6ff00000a00e8030300"))),
        (MMS, "048101ac00", Ranges(), n.Temperature(1, 21.5)),
        (MMS, "010101", Ranges(), n.Switch(1)),
        (MMS, "111201", Ranges(), n.Status("charge_status", 1)),
    ],
)
def test_a_notification(board, told, ranges, meaning):
    said = decode(bytes.fromhex(told), board, ranges)
    assert type(said) is type(meaning)
    if isinstance(meaning, n.Samples):
        assert said.sensor == meaning.sensor
        for sample, expected in zip(said.samples, meaning.samples, strict=True):
            assert sample == pytest.approx(expected, rel=1e-6)
    elif isinstance(meaning, n.Fused | n.Timed):
        assert report(said)["decoded"]["tick"] == meaning.tick
        assert getattr(said, "acc", None) == getattr(meaning, "acc", None)
        assert said == meaning
    else:
        assert said == meaning


@pytest.mark.parametrize(
    "told",
    [
        "",
        "03",
        "0304",
        "03040000",
        "ff01",
        "0303280c",
        "198b0001",
        "030e00",
        "0380ff",
        "190700000000000000000000000000",
        "1907" + "0000c07f" * 4,
        "1909" + "0000807f" * 3,
        "19820700",
        "0383ff00",
        "0383280f",
        "1383200f",
        "090300",
        "0b07ff",
        "118b00",
    ],
)
def test_what_means_nothing_is_one_sentence(told):
    with pytest.raises(DeviceError) as error:
        decode(bytes.fromhex(told), RL, Ranges(processors={0: "acc"}))
    assert "\n" not in str(error.value)


def test_the_order_of_the_gyros_registers_tells_nothing_without_the_chip():
    packed = bytes.fromhex("1305" + "a4000000ffff" * 3)
    assert len(decode(packed, MMS).samples) == 3
    with pytest.raises(DeviceError, match="expected 6"):
        decode(packed, RL)


def test_recorded_notifications():
    for case in vectors()["decodes"]:
        board = board_named(case["board"])
        told = case["id"].rsplit(".", 1)[-1]
        ranges = Ranges(8 if told == "8g" else 2, 1000 if told == "1000dps" else 2000)
        said = report(decode(bytes.fromhex(case["notification"]), board, ranges))
        assert (said["kind"], said["decoded"]) == (case["kind"], case["decoded"]), case["id"]


def test_a_clocks_ticks_make_the_recorded_times():
    entry = next(e for e in vectors()["on_board_programs"]["entries"] if "epoch_differences_ms" in e)
    ranges = Ranges(processors={0: "acc"})
    said = [decode(bytes.fromhex(told), MMR, ranges) for told in entry["notifications"]]
    since = 0x000D3304
    times_ms = [math.floor((one.tick - since) * n.TICK_S * 1000) for one in said]
    differences = [later - earlier for earlier, later in pairwise(times_ms)]
    assert all(abs(a - b) <= 1 for a, b in zip(differences, entry["epoch_differences_ms"], strict=True))
    assert said[0].vector == pytest.approx(tuple(entry["first_decoded"].values()), abs=5e-4)


@settings(derandomize=True, max_examples=200)
@given(st.lists(st.integers(-32768, 32767), min_size=3, max_size=3), st.sampled_from([2, 4, 8, 16]))
def test_any_sample_is_its_count_times_its_range(counts, range_g):
    (sample,) = decode(b"\x03\x04" + struct.pack("<3h", *counts), RL, Ranges(acc_g=range_g)).samples
    assert sample == pytest.approx([count * range_g / 32768 for count in counts], rel=1e-7)


@settings(derandomize=True, max_examples=100)
@given(st.lists(st.binary(min_size=1, max_size=20), max_size=5), st.lists(st.integers(1, 9), max_size=40))
def test_usb_frames_come_out_however_they_are_cut(payloads, cuts):
    stream, framer, heard = b"".join(map(usb_frame, payloads)), UsbFramer(), []
    for cut in cuts:
        heard += framer.feed(stream[:cut])
        stream = stream[cut:]
    assert heard + framer.feed(stream) == payloads


def test_usb_junk_before_a_frame_is_skipped():
    assert UsbFramer().feed(b"\x1f\x02zzz\x00" + usb_frame(b"\xfe\x06")) == [b"\xfe\x06"]


def test_all_named_boards_have_what_a_band_needs():
    assert all({1, 2, 3, 0x11, 0x13, 0x19} <= set(board.modules) for board in NAMED.values())
