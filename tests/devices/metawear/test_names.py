import json
from itertools import product
from pathlib import Path

import pytest

from armspan.devices.metawear import names
from armspan.errors import DeviceError

SHARED = Path(__file__).parents[4] / "shared" / "vectors" / "metawear.json"


def vectors():
    if not SHARED.is_file():
        pytest.skip("the recorded vectors are not beside this repository")
    return json.loads(SHARED.read_text())


def hexes(name, board=None, **args):
    return " ".join(write.hex() for _, writes in names.encode(name, board, args) for write in writes)


# Worked out by hand from the published protocol; most are asserted by the vendor's own tests as well.
@pytest.mark.parametrize(
    ("name", "board", "told"),
    [
        ("acc.bmi160.config.25Hz.2g", "mmr_fw113", "03032603"),
        ("acc.bmi160.config.100Hz.16g", "mmr_fw113", "0303280c"),
        ("acc.bmi160.config.0.78125Hz.2g", "mmr_fw113", "03038103"),
        ("acc.bmi160.packed.subscribe", "mmr_fw113", "031c01"),
        ("acc.bmi160.start", "mmr_fw113", "030101"),
        ("acc.bmi160.read_config", "mmr_fw113", "0383"),
        ("acc.bmi160.tap.enable_double", "mmr_fw113", "030c0100"),
        ("acc.bmi160.tap.disable", "mmr_fw113", "030c0003"),
        ("acc.bmi160.tap.unsubscribe", "mmr_fw113", "030e00"),
        ("acc.bmi270.config.12.5Hz.8g", "mms", "0303a502"),
        ("acc.bmi270.packed.subscribe", None, "030501"),
        ("acc.bmi270.disable_sampling", "mms", "03020001"),
        ("gyro.bmi160.config.3200Hz.2000dps", "mmr_fw113", "13032d00"),
        ("gyro.bmi160.packed.unsubscribe", "mmr_fw113", "130700"),
        ("gyro.bmi270.packed.subscribe", "mms", "130501"),
        ("gyro.bmi270.read_config", "mms", "1383"),
        ("mag.preset.enhanced_regular.rev1", "mmr_fw113", "1504071a 150300"),
        ("mag.preset.high_accuracy.rev2", "mms", "150100 15041752 150305"),
        ("mag.start", "mmr_fw113", "150101"),
        ("mag.packed.subscribe", "mmr_fw113", "150901"),
        ("fusion.subscribe.quaternion", "mmr_fw113", "190701"),
        ("fusion.subscribe.linear_acc", "mmr_fw113", "190a01"),
        ("fusion.read_calibration_state", "mms", "198b"),
        ("fusion.reset_orientation", "mms", "190f01"),
        ("fusion.calibration_data.write.imu_plus", "mms", "190cf6ff00000a00e8030300 190d04000800010000000300"),
        ("fusion.config.mms.ndof.16g.2000dps", None, "19020113 0303a803 13032800 150100 1504040e 150306"),
        ("led.stop", "mmr_fw113", "020200"),
        ("led.pattern.blink.green.rev1", "mms", "020300021f00000032000000f40188130a"),
        ("led.pattern.solid.blue.rev0", "mms", "020302021f1f0000f4010000e80300000a"),
        ("haptic.motor.100pct.5000ms", "mmr_fw113", "0801f8881300"),
        ("settings.ad_interval.417ms.180s.rev>=6", "mms", "11029b02b400"),
        ("settings.ad_interval.417ms.180s.rev<6", "mms", "11029b02b4"),
        ("settings.conn_params.7.5_7.5_0_6000", "mms", "11090600060000005802"),
        ("settings.tx_power.-20", "mms", "1103ec"),
        ("settings.start_advertising", "mms", "1105"),
        ("settings.battery.read", "mms", "118c"),
        ("settings.read_battery", "mms", "118c"),
        ("settings.charge_status.subscribe", "mms", "111201"),
        ("settings.name.Armspan 1", "mms", "110141726d7370616e2031"),
        ("debug.disconnect", "mms", "fe06"),
        ("debug.spoof_button.1", "mms", "fe0301010001"),
        ("switch.unsubscribe", None, "010100"),
        ("disconnect_event.buzz_1s", None, "0a02110aff080104 0a03f8e80300"),
        ("processor.accounter_time_on_gyro", "mms", "09021304ffa0113103"),
        ("temperature.read", None, "048100"),
        ("usb.frame.fe06", None, "1f02fe060a"),
        ("teardown", None, "0908 0a05 0b0a"),
    ],
)
def test_a_name(name, board, told):
    assert hexes(name, board) == told


def test_arguments_may_be_given_beside_a_name():
    assert hexes("acc.config", "mms", rate_hz=100, range_g=8) == "0303a802"
    assert hexes("acc.config", "mms", rate_hz="100", range_g="8") == "0303a802"
    assert hexes("led.pattern.pulse.red", "mmr_fw113", repeat=1) == "020301021f00d502f401d502d007000001"
    assert hexes("led.pattern", "mms", preset="blink", colour="red", delay_ms=1).endswith("f4010100ff")
    assert hexes("fusion.start", None, mode="imu_plus", outputs="quat+linacc").endswith("19034800 190101")
    assert names.encode("settings.name", None, {"name": "A"}) == (("", (b"\x11\x01A",)),)


def test_every_recorded_command():
    recorded = vectors()
    programs = [entry for entry in recorded["on_board_programs"]["entries"] if "writes" in entry]
    for case in recorded["commands"] + programs:
        assert hexes(case["id"], case.get("board")).split() == case["writes"], case["id"]


def test_every_recorded_sequence():
    for case in vectors()["sequences"]:
        steps = names.encode(case["id"], case["board"])
        told = [{"step": title, "writes": [write.hex() for write in writes]} for title, writes in steps]
        assert told == case["steps"], case["id"]


def test_every_board_mode_and_range_of_the_fusion():
    modes = {"ndof": 1, "imu_plus": 2, "compass": 3, "m4g": 4}
    every = list(product(("mmr_fw113", "mmrl_current", "mms"), modes, (2, 4, 8, 16), (2000, 1000, 500, 250)))
    for board, mode, g, dps in every:
        first = hexes(f"fusion.config.{board}.{mode}.{g}g.{dps}dps", board).split()[0]
        code = (2, 4, 8, 16).index(g) | (2000, 1000, 500, 250).index(dps) + 1 << 4
        assert first == f"1902{modes[mode]:02x}{code:02x}"
    assert len(every) == 192


@pytest.mark.parametrize(
    ("name", "board", "args", "words"),
    [
        ("acc.confg", None, {}, "acc.config"),
        ("warp", None, {}, "first word 'warp' does not exist"),
        ("acc.config", None, {"rate_hz": 100}, "needs range_g"),
        ("acc.config.100Hz.2g", None, {"speed": 1}, "'speed' does not exist"),
        ("acc.config.100Hz.2g", "mmx", {}, "'mmx' does not exist"),
        ("acc.bmi270.config.100Hz.2g", "mmr_fw113", {}, "of a bmi270"),
        ("fusion.config.mms.ndof.2g.250dps", "mmr_fw113", {}, "another is asked for"),
        ("acc.config", None, {"rate_hz": "fast", "range_g": 2}, "expected a number"),
        ("acc.config", None, {"rate_hz": "nan", "range_g": 2}, "nan"),
        ("acc.config", None, {"rate_hz": [], "range_g": 2}, "expected a number"),
        ("acc.start", None, {"rate_hz": 1}, "takes no rate_hz"),
        ("haptic.motor.133pct.5ms", None, {}, "0 to 100"),
        ("debug.spoof_button.700", None, {}, "0 to 255"),
        ("usb.frame.fe0", None, {}, "hexadecimal"),
        ("settings.conn_params.0_10_0_100", None, {}, "7.5"),
        ("led.pattern.blink.green.rev99999999999", None, {"repeat": 999}, "255"),
        ("processor.subscribe", None, {"number": 1e300}, "0 to 254"),
        ("fusion.start.ndof.quat+warp", None, {}, "'warp' does not exist"),
        ("", None, {}, "does not exist"),
    ],
)
def test_a_wrong_name_is_one_sentence(name, board, args, words):
    with pytest.raises(DeviceError, match=words) as error:
        names.encode(name, board, args)
    assert "\n" not in str(error.value)


def test_every_form_is_listed_once():
    forms = names.forms()
    assert len(set(forms)) == len(forms)
    assert "acc.config.{rate_hz}Hz.{range_g}g" in forms
