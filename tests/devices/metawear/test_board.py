"""The emulated board, byte by byte: replies of the recorded boards, switches, ranges, processors, state."""

import json
import math
import struct
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from armspan.devices.metawear.board import MODELS, MetaWearBoard
from armspan.devices.metawear.board_models import Traits

VECTORS = Path(__file__).parents[3].parent / "shared" / "vectors" / "metawear.json"
TICK_S = 1.46484375e-3
FUSER = "09021305ffa00f05 09020304ffa01b01000000000000000000000000 090209030160113103"
FUSER_ON = "09070201 090301 13020100 03020100 130101 030101"
IMU_PLUS = "19020213 0303280c 13032800 190701 03020100 13020100 030101 130101 19030800 190101"


def vectors():
    if not VECTORS.exists():
        pytest.skip(f"the recorded vectors are not beside the repository: {VECTORS}")
    return json.loads(VECTORS.read_text())


def linked(model="mmrl_current", seed=0, t=0.0, **traits):
    board = MetaWearBoard(model, Traits(**traits), generator=np.random.default_rng(seed))
    board.linked(True)
    board.advance(t)
    return board


def tell(board, text, t=0.0):
    """Write commands, one by one, and hand over what is answered."""
    out = []
    for command in text.split():
        board.write(bytes.fromhex(command))
        out += [packet.hex() for packet in board.advance(t)]
    return out


def fed(board, t=0.0, acc=(0.0, 0.0, 9.80665), gyr=(0.0, 0.0, 0.0), mag=(0.0, 0.0, 0.0), quat=(1.0, 0.0, 0.0, 0.0)):
    board.sample(t, acc, gyr, mag, quat)


# --- handshake -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["mmr_fw113", "mmrl_fw113", "mms", "mmrl_current"])
def test_the_recorded_handshakes_are_reproduced(name):
    recorded = vectors()["handshake"][name]
    board = linked(name)
    for question in recorded["writes_in_order"][:-1]:
        answer = recorded["replies"].get(question, question)  # a module that is not there: two bytes
        assert tell(board, question) == [answer]
    assert tell(board, "0b84") == [recorded["log_time_reply"]]


def test_the_traced_board_answers_as_traced():
    board = linked("mmr_fw150")
    for answer in vectors()["real_device_trace"]["module_info_replies"]:
        assert tell(board, answer[:4]) == [answer]


def test_an_absent_module_can_be_silent():
    board = linked("mmrl_current", absent="silent")
    assert tell(board, "1680 1280 0680 fe80") == ["fe80000603"]
    assert tell(linked("mmrl_current"), "1680 1280 0680") == ["1680", "1280", "0680"]


def test_recorded_configurations_are_read_back():
    """The last write to 03 and to 02 of the fusion, whatever was recorded."""
    for told in vectors()["commands"]:
        board = linked(told["board"])
        written = {text[:4]: text for text in told["writes"] if text[:4] in ("0303", "1303", "1902")}
        tell(board, " ".join(told["writes"]))
        for key, text in written.items():
            question = key[:2] + f"{int(key[2:], 16) | 0x80:02x}"
            assert tell(board, question) == [question + text[4:]], told["id"]


# --- settings --------------------------------------------------------------------------------------------


def test_battery_and_address():
    board = linked(battery=99, millivolts=4148)
    assert tell(board, "118c") == ["118c633410"]
    assert tell(board, "118b") == ["118b01077b528fc9e8"]
    assert tell(linked(typed_mac=False), "118b") == ["118b077b528fc9e8"]


def test_a_silent_read_is_not_told():
    assert tell(linked(), "11cc 04c101") == []


def test_name_and_connection_parameters():
    board = linked()
    tell(board, "1101416e746957617265 11090600080000002c01")
    assert board.name == "AntiWare"
    assert board.wish == pytest.approx((0.0075, 3.0))


def test_lamp_and_motor_are_seen():
    board = linked()
    tell(board, "020201 020302021f00000032000000f40100000a 020101 0801f8b80b00 08017f4c1d01", t=2.0)
    assert board.lamp.playing
    assert board.lamp.patterns == {"blue": bytes.fromhex("021f00000032000000f40100000a")}
    motor, buzzer = board.haptics
    assert (motor.t, motor.strength, motor.duration, motor.buzzer) == (2.0, 1.0, 3.0, False)
    assert (buzzer.strength, buzzer.duration, buzzer.buzzer) == (1.0, 7.5, True)
    tell(board, "020201")
    assert not board.lamp.playing
    assert board.lamp.patterns == {}


def test_the_button_needs_a_subscription():
    board = linked()
    board.press()
    assert board.advance(0.1) == []
    assert tell(board, "0181") == ["018101"]
    tell(board, "010101")
    board.press(False)
    board.press()
    assert [packet.hex() for packet in board.advance(0.2)] == ["010100", "010101"]
    tell(board, "010100")
    board.press(False)
    assert board.advance(0.3) == []


def test_a_spoofed_notification():
    assert tell(linked(), "fe0301010007") == ["01010007"]


# --- raw data --------------------------------------------------------------------------------------------


def samples(board, prefix, t0, t1):
    head = bytes.fromhex(prefix)
    return [packet[len(head) :] for packet in run(board, t0, t1) if packet.startswith(head)]


def run(board, t0, t1, step=0.005):
    """Let time go on from t0 to t1 in small steps."""
    out = []
    for number in range(1, round((t1 - t0) / step) + 1):
        out += board.advance(t0 + number * step)
    return out


@pytest.mark.parametrize("missing", ["030401", "03020100", "030101"])
def test_raw_data_need_all_three_switches(missing):
    board = linked()
    tell(board, " ".join({"030401", "03020100", "030101"} - {missing}))
    assert run(board, 0.0, 0.5) == []
    tell(board, missing, 0.5)
    assert len(samples(board, "0304", 0.5, 1.5)) in (99, 100, 101)


@pytest.mark.parametrize("off", ["030400", "03020001", "030100"])
def test_each_switch_stops_them(off):
    board = linked()
    tell(board, "030401 03020100 030101")
    assert run(board, 0.0, 0.5)
    tell(board, off, 0.5)
    assert run(board, 0.5, 1.0) == []


@pytest.mark.parametrize(
    ("model", "code", "per_g"),
    [("mmrl_current", "03", 16384), ("mmrl_current", "05", 8192), ("mmrl_current", "08", 4096),
     ("mmrl_current", "0c", 2048), ("mms", "00", 16384), ("mms", "01", 8192), ("mms", "02", 4096), ("mms", "03", 2048)],
)  # fmt: skip
def test_acceleration_is_scaled_and_saturates_by_its_range(model, code, per_g):
    board = linked(model)
    tell(board, f"0303{'28' if model != 'mms' else 'a8'}{code} 030401 03020100 030101")
    fed(board, 0.0, acc=(9.80665, -2 * 9.80665, 20 * 9.80665))
    packet = samples(board, "0304", 0.0, 0.1)[-1]
    x, y, z = struct.unpack("<3h", packet)
    assert x == per_g
    assert y == -2 * per_g  # at 2 g exactly the last count
    assert z == 32767


@pytest.mark.parametrize(("code", "per_dps"), [(0, 16.4), (1, 32.8), (2, 65.6), (3, 131.2), (4, 262.4)])
@pytest.mark.parametrize(("model", "register"), [("mmrl_current", "05"), ("mms", "04")])
def test_turns_are_scaled_by_their_range(code, per_dps, model, register):
    board = linked(model)
    tell(board, f"1303280{code} 13{register}01 13020100 130101")
    fed(board, 0.0, gyr=(math.radians(100.0), -math.radians(50.0), math.radians(3000.0)))
    x, y, z = struct.unpack("<3h", samples(board, f"13{register}", 0.0, 0.1)[-1])
    assert (x, y, z) == (round(100 * per_dps), -round(50 * per_dps), 32767)


@pytest.mark.parametrize(("code", "rate"), [("25", 12.5), ("26", 25.0), ("27", 50.0), ("28", 100.0), ("29", 200.0)])
def test_rates_are_those_written_and_drift_with_the_crystal(code, rate):
    board = linked(drift=0.01)
    tell(board, f"0303{code}08 030401 03020100 030101")
    assert len(samples(board, "0304", 0.0, 8.0)) == pytest.approx(8.0 * rate * 1.01, abs=1)


@pytest.mark.parametrize(("code", "rate"), list(enumerate([10, 2, 6, 8, 15, 20, 25, 30])))
def test_the_field_comes_at_its_rates_in_sixteenths_of_a_microtesla(code, rate):
    board = linked("mmr_fw113")
    tell(board, f"1504040e 15030{code} 150501 15020100 150101")
    fed(board, 0.0, mag=(32.5, -14.8125, 29.6875))
    packets = samples(board, "1505", 0.0, 5.0)
    assert len(packets) == pytest.approx(5 * rate, abs=1)
    assert struct.unpack("<3h", packets[-1]) == (520, -237, 475)


def test_a_cold_magnetometer_streams_zeros_until_it_has_settled():
    board = linked("mms")
    fed(board, 0.0, mag=(32.5, 0.0, 0.0))
    tell(board, "150100 1504040e 150306 150501 15020100 150101")
    assert set(samples(board, "1505", 0.0, 0.5)) == {bytes(6)}
    tell(board, "150100", 0.5)
    tell(board, "150101", 0.75)
    assert struct.unpack("<3h", samples(board, "1505", 0.75, 1.0)[-1])[0] == 520


@pytest.mark.parametrize(("model", "acc", "gyro"), [("mmrl_current", "1c", "07"), ("mms", "05", "05")])
def test_packed_data_hold_three_samples(model, acc, gyro):
    board = linked(model)
    tell(board, f"03{acc}01 13{gyro}01 03020100 13020100 030101 130101")
    fed(board, 0.0, acc=(0.0, 0.0, 0.0))
    fed(board, 1.0, acc=(9.80665, 0.0, 0.0))
    packets = run(board, 0.0, 0.9)
    plain = [packet[2:] for packet in packets if packet[:2] == bytes([3, int(acc, 16)])]
    assert all(len(packet) == 18 for packet in plain)
    assert len(plain) == 29 or len(plain) == 30
    counts = [struct.unpack("<9h", packet)[::3] for packet in plain]
    steps = [b - a for a, b in pairwise([count for packet in counts for count in packet])]
    scale = 16384 if model == "mmrl_current" else 4096
    assert all(abs(step - scale / 100) <= 1 for step in steps)  # 1 g in a second, at 100 Hz
    assert [packet for packet in packets if packet[:2] == bytes([0x13, int(gyro, 16)])]


def test_lying_still_is_gravity_with_noise():
    board = linked()
    tell(board, "03032808 030401 03020100 030101 130501 13020100 130101")
    packets = run(board, 0.0, 5.0)
    acc = np.array([struct.unpack("<3h", each[2:]) for each in packets if each[:2] == b"\x03\x04"]) / 4096
    gyr = np.array([struct.unpack("<3h", each[2:]) for each in packets if each[:2] == b"\x13\x05"]) / 16.4
    assert np.abs(acc.mean(axis=0) - [0, 0, 1]).max() < 1e-3
    assert 0.001 < acc.std(axis=0).mean() < 0.003  # 0.02 m/s2 are 2 mg
    assert np.abs(gyr.mean(axis=0)).max() < 0.02
    assert 0.08 < gyr.std(axis=0).mean() < 0.15  # 0.002 rad/s are 0.115 deg/s


# --- processors ------------------------------------------------------------------------------------------


def test_the_fused_packet_has_a_tick_and_one_instant():
    board = linked(drift=100e-6, first_tick=1000)
    tell(board, "03032808 13032800")
    assert tell(board, FUSER) == ["090200", "090201", "090202"]
    tell(board, FUSER_ON)
    fed(board, 0.0, acc=(0.0, 0.0, 0.0))
    fed(board, 10.0, acc=(9.80665, 0.0, 0.0), gyr=(1.0, 0.0, 0.0))
    packets = run(board, 0.0, 9.0)
    assert all(packet[:3] == b"\x09\x03\x02" and len(packet) == 19 for packet in packets)
    assert len(packets) == pytest.approx(900, abs=2)
    for packet in packets[10:]:
        tick, ax, _, _, gx, _, _ = struct.unpack("<I6h", packet[3:])
        at = (tick - 1000) * TICK_S / (1 + 100e-6)  # host time of the tick, up to one tick
        assert ax / 4096 == pytest.approx(at / 10.0, abs=4e-4)
        assert math.radians(gx / 16.4) == pytest.approx(at / 10.0, abs=1.3e-3)


def test_the_bmi270_fuses_its_own_gyro_register():
    board = linked("mms_current")
    assert tell(board, FUSER.replace("09021305", "09021304")) == ["090200", "090201", "090202"]
    tell(board, FUSER_ON)
    assert len(run(board, 0.0, 1.0)) in (99, 100)
    board = linked("mms_current")
    tell(board, FUSER + " " + FUSER_ON)  # the BMI160's: nothing ever reaches the buffer
    assert run(board, 0.0, 1.0) == []


@pytest.mark.parametrize("off", ["09070200", "090300", "0908", "130100", "030100"])
def test_the_fused_packet_stops_with_any_of_its_parts(off):
    board = linked()
    tell(board, FUSER + " " + FUSER_ON)
    assert run(board, 0.0, 0.5)
    tell(board, off, 0.5)
    later = run(board, 0.5, 1.0)
    assert later == [] or off == "130100"  # the buffer keeps its last: acc goes on with an old gyro
    assert tell(board, "0908", 1.0) == []
    assert run(board, 1.0, 1.5) == []


def test_old_firmware_makes_no_fuser():
    board = linked("mmr_fw113")
    assert tell(board, FUSER) == ["090200"]  # the buffer; neither fuser nor accounter
    assert tell(board, "0980") == ["098000001c"]


def test_a_count_and_a_limiter():
    board = linked()
    told = tell(
        board, "09021305ffa00f05 09020304ffa01b01000000000000000000000000 090209030160081314000000 090209030260113003"
    )
    assert told == ["090200", "090201", "090202", "090203"]
    tell(board, "09070301 090301 13020100 03020100 130101 030101")
    packets = run(board, 0.0, 2.0)
    assert len(packets) == pytest.approx(100, abs=1)  # one per 20 ms
    assert [struct.unpack("<I", packet[3:7])[0] for packet in packets] == list(range(len(packets)))


def test_quaternions_can_be_limited_and_have_no_room_for_a_tick():
    board = linked()
    assert tell(board, "09021907ffe0081714000000") == ["090200"]
    assert tell(board, "09021907ffe0113103") == ["090201"]
    tell(board, IMU_PLUS.replace("190701 ", "") + " 09070001 09070101 090301")
    packets = run(board, 0.0, 2.0)
    assert all(packet[:3] == b"\x09\x03\x00" and len(packet) == 19 for packet in packets)
    assert len(packets) == pytest.approx(100, abs=1)


def test_only_so_many_processors_fit():
    board = linked()
    assert len(tell(board, "09021305ffa00f05 " * 40)) == 28


# --- fusion ----------------------------------------------------------------------------------------------


def quaternions(board, t0, t1):
    return [struct.unpack("<4f", each) for each in samples(board, "1907", t0, t1)]


@pytest.mark.parametrize(
    "missing", ["190701", "03020100", "13020100", "030101", "130101", "19030800", "190101", "19020213"]
)
def test_fusion_needs_everything(missing):
    board = linked()
    tell(board, IMU_PLUS.replace(missing, ""))
    assert run(board, 0.0, 0.5) == []
    tell(board, missing, 0.5)
    assert len(quaternions(board, 0.5, 1.5)) in (99, 100, 101)


def test_every_mode_needs_its_chips_and_has_its_rate():
    for mode, chips, rate in ((1, "03 13 15", 100), (2, "03 13", 100), (3, "03 15", 25), (4, "03 15", 50)):
        board = linked()
        needed = chips.split()
        for chip in needed:
            tell(board, f"{chip}020100 {chip}0101")
        tell(board, f"19020{mode}13 190701 19030800 190101")
        assert len(quaternions(board, 0.0, 2.0)) == pytest.approx(2 * rate, abs=1)
        for chip in needed:
            tell(board, f"{chip}0100", 2.0)
            assert quaternions(board, 2.0, 2.5) == []
            tell(board, f"{chip}0101", 2.0)


def test_recorded_sessions_stream_what_they_say_and_end():
    register = {
        "corrected_acc": (4, 13), "corrected_gyro": (5, 13), "corrected_mag": (6, 13), "quaternion": (7, 16),
        "euler": (8, 16), "gravity": (9, 12), "linear_acc": (10, 12),
    }  # fmt: skip
    modes = {"ndof": (1, 100), "imu_plus": (2, 100), "compass": (3, 25), "m4g": (4, 50)}
    for told in vectors()["sequences"]:
        if not told["id"].startswith("fusion.startstop"):
            continue
        _, _, name, mode, output = told["id"].split(".")
        board = linked(name)
        number, size = register[output]
        steps = {step["step"]: step["writes"] for step in told["steps"]}
        tell(board, f"19020{modes[mode][0]}13 19{number:02x}01 " + " ".join(steps["start"]))
        packets = run(board, 0.0, 1.0)
        assert len(packets) == pytest.approx(modes[mode][1], abs=1), told["id"]
        assert all(packet[:2] == bytes([0x19, number]) and len(packet) == 2 + size for packet in packets)
        tell(board, " ".join(steps["stop"]), 1.0)
        assert run(board, 1.0, 1.5) == []
        assert board.due() is None


def test_payloads_of_the_fusion():
    board = linked()
    half = math.sqrt(0.5)
    fed(
        board, 0.0, acc=(3.0, -9.80665, 0.5), gyr=(0.1, -0.2, 0.3), mag=(20.0, -10.0, 5.0), quat=(half, -half, 0.0, 0.0)
    )
    tell(board, "150100")
    tell(board, "15020100 150101 " + IMU_PLUS.replace("19020213", "19020113").replace("19030800", "19037f00"), 0.3)
    tell(board, " ".join(f"19{register:02x}01" for register in range(4, 11)), 0.3)
    last = {packet[1]: packet[2:] for packet in run(board, 0.3, 0.5)}
    assert struct.unpack("<3f", last[4][:12]) == pytest.approx((305.9, -1000.0, 51.0), abs=0.5)  # mg, 2048 counts per g
    assert struct.unpack("<3f", last[5][:12]) == pytest.approx((5.73, -11.46, 17.19), abs=0.04)  # deg/s
    assert struct.unpack("<3f", last[6][:12]) == pytest.approx((20.0, -10.0, 5.0), abs=0.04)
    assert struct.unpack("<4f", last[7]) == pytest.approx((half, -half, 0.0, 0.0), abs=1e-6)
    assert struct.unpack("<3f", last[9]) == pytest.approx((0.0, -9.80665, 0.0), abs=1e-4)  # y lies up
    assert struct.unpack("<3f", last[10]) == pytest.approx((3.0, 0.0, 0.5), abs=0.01)
    assert {last[register][12] for register in (4, 5, 6)} <= {0, 1, 2, 3}


def test_ranges_that_do_not_agree_give_wrong_values():
    """The firmware does not set up the chips: told 2 g while the chip is at 16 g, an eighth is seen."""
    board = linked()
    fed(board)
    tell(board, IMU_PLUS.replace("19020213", "19020210").replace("19030800", "19030100") + " 190401")
    acc = struct.unpack("<3f", samples(board, "1904", 0.0, 0.2)[-1][:12])
    assert acc[2] == pytest.approx(125.0, abs=0.5)


def yaw(quat):
    w, x, y, z = quat
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def test_each_start_of_imu_plus_has_a_heading_of_its_own():
    board = linked()
    fed(board)
    tell(board, IMU_PLUS)
    headings = []
    for start in range(6):
        quats = quaternions(board, float(start), start + 0.5)
        assert max(yaw(each) for each in quats) - min(yaw(each) for each in quats) < 1e-5
        headings.append(yaw(quats[-1]))
        tell(board, "190100 190101" if start % 2 else "19020113 19020213", start + 0.5)
        run(board, start + 0.5, start + 1.0)
    assert min(abs(a - b) for a, b in pairwise(headings)) > 0.02
    assert max(headings) - min(headings) > 1.0


def test_ndof_keeps_its_heading():
    board = linked()
    fed(board, quat=(math.cos(0.3), 0.0, 0.0, math.sin(0.3)))
    tell(board, "15020100 150101 " + IMU_PLUS.replace("19020213", "19020113"))
    for start in range(3):
        assert yaw(quaternions(board, float(start), start + 1.0)[-1]) == pytest.approx(0.6, abs=1e-5)
        tell(board, "190100 190101", start + 1.0)


def test_the_orientation_can_be_reset():
    board = linked()
    fed(board, quat=(math.cos(0.3), 0.0, 0.0, math.sin(0.3)))
    tell(board, IMU_PLUS)
    run(board, 0.0, 0.5)
    tell(board, "190f01", 0.5)
    assert yaw(quaternions(board, 0.5, 1.0)[-1]) == pytest.approx(0.0, abs=1e-5)


def test_without_an_attitude_it_follows_the_turns_itself():
    board = linked()
    for number in range(16):
        board.sample(number * 0.1, (0.0, 0.0, 9.80665), (0.0, 0.0, 1.0))
    tell(board, IMU_PLUS)
    quats = quaternions(board, 0.0, 1.0)
    turn = (yaw(quats[-1]) - yaw(quats[0]) + math.pi) % (2 * math.pi) - math.pi
    assert turn == pytest.approx(len(quats) / 100 - 0.01, abs=0.02)


def test_raw_data_do_not_come_beside_the_fusion():
    board = linked()
    tell(board, IMU_PLUS + " 030401 130501")
    assert {packet[:2].hex() for packet in run(board, 0.0, 0.5)} == {"1907"}
    tell(board, "190100", 0.5)
    assert {packet[:2].hex() for packet in run(board, 0.5, 1.0)} == {"0304", "1305"}


def test_calibration_rises_while_the_fusion_runs_is_read_and_written_back():
    board = linked(calibrated_after_s=(4.0, 1.0, 6.0))
    assert tell(board, "198b") == ["198b000000"]
    tell(board, "150100 15020100 150101 " + IMU_PLUS.replace("19020213", "19020113"))
    states = []
    for start in range(7):
        states.append(tell(board, "198b", float(start))[0])
        run(board, float(start), start + 1.0)
    assert states[0] == "198b000000"
    assert states[1] == "198b000300"
    assert states[-1] == "198b030303"
    assert states == sorted(states)
    data = tell(board, "198c 198d 198e", 7.0)
    assert [each[:4] for each in data] == ["198c", "198d", "198e"]
    assert all(len(each) == 24 for each in data)
    tell(board, "fe01", 7.0)
    board.advance(20.0)
    assert tell(board, "198b", 20.0) == ["198b000000"]
    tell(board, " ".join(f"19{number}{each[4:]}" for number, each in zip(("0c", "0d", "0e"), data, strict=True)), 20.0)
    assert tell(board, "198b", 20.0) == ["198b030303"]


def test_poor_calibration_of_the_magnetometer_crashes_the_fusion():
    board = linked()
    data = tell(board, "198e")[0]
    tell(board, f"190e{data[4:]} 150100 15020100 150101 " + IMU_PLUS.replace("19020213", "19020113"))
    assert quaternions(board, 0.0, 0.5) == []


def test_the_oldest_fusion_knows_no_calibration():
    assert tell(linked("mmr_fw113"), "198b 198c") == []


# --- state -----------------------------------------------------------------------------------------------


def test_state_outlives_a_disconnection_but_nothing_is_told_meanwhile():
    board = linked()
    tell(board, IMU_PLUS)
    board.linked(False)
    assert run(board, 0.0, 3.0) == []
    board.linked(True)
    board.advance(3.0)
    assert len(quaternions(board, 3.0, 4.0)) == pytest.approx(100, abs=1)


def test_a_reset_forgets_everything_and_is_away():
    board = linked(boot_s=1.5)
    tell(board, IMU_PLUS + " " + FUSER + " 010101 020302021f00000032000000f40100000a 020101")
    tick = math.floor(10.0 * (1 + 20e-6) / TICK_S)
    assert tell(board, "0b84", 10.0)[-1] == f"0b84{(1045 + tick).to_bytes(4, 'little').hex()}05"
    tell(board, "fe01", 10.0)
    assert board.leaving == 1.5
    assert tell(board, "0b84", 11.0) == []  # it boots
    board.linked(False)
    board.linked(True)
    assert tell(board, "0b84", 20.0) == [f"0b84{tick.to_bytes(4, 'little').hex()}06"]
    assert run(board, 20.0, 21.0) == []
    assert board.lamp.patterns == {}
    assert tell(board, "1982 0181", 21.0) == ["19820013", "018100"]
    board.press()
    assert board.advance(21.1) == []


def test_who_ends_the_link():
    board = linked()
    assert (tell(board, "fe06"), board.leaving) == ([], 0.0)
    board.advance(0.1)
    assert board.leaving is None
    tell(board, "fe05", 0.2)
    assert board.leaving == 2.0
    stubborn = linked("mms", ignores_collection_reset=True)
    tell(stubborn, "fe05")
    assert stubborn.leaving is None


def test_the_program_for_a_lost_link_runs():
    board = linked()
    program = (
        "0a02110aff02030f 0a0302021f00000032000000f40100000a 0a02110aff020101 0a0301 0a02110aff080104 0a03f8b80b00"
    )
    assert tell(board, program) == ["0a0200", "0a0201", "0a0202"]
    assert not board.lamp.playing
    board.linked(False)
    board.advance(4.0)
    assert board.lamp.playing
    assert board.lamp.patterns["blue"].hex() == "021f00000032000000f40100000a"
    assert [(buzz.t, buzz.strength, buzz.duration) for buzz in board.haptics] == [(4.0, 1.0, 3.0)]
    board.linked(True)
    tell(board, "0a05", 5.0)
    board.linked(False)
    board.advance(6.0)
    assert len(board.haptics) == 1


def test_creations_are_numbered():
    board = linked()
    assert tell(board, "0c0264b005a250b301 0c0264b005a250b301") == ["0c0200", "0c0201"]
    assert tell(board, "0b021907ff60 0b021907ff64 0b0a 0b021907ff60") == ["0b0200", "0b0201", "0b0200"]


def test_in_bootloader_mode_it_obeys_nobody():
    board = linked()
    tell(board, "fe02")
    assert board.bootloader
    assert tell(board, "0180 0b84") == []


@pytest.mark.parametrize("model", sorted(MODELS))
def test_nonsense_is_survived(model):
    board, generator = linked(model), np.random.default_rng(1)
    for number in range(3000):
        data = bytearray(generator.integers(0, 256, generator.integers(0, 21), dtype=np.uint8))
        if number % 2 and len(data) > 1:
            data[0] = int(generator.choice(list(board.model.modules)))
            data[1] %= 0x20
        if data[:2] != b"\xfe\x02":
            board.write(bytes(data))
        for packet in board.advance(number * 1e-3):
            assert len(packet) <= 20
    board.write(bytes.fromhex("0180"))
    board.linked(True)
    board.advance(100.0)
    assert tell(board, "0180", 110.0) == ["01800000"]
