"""The emulated phone itself: its bytes by hand, its faults by counting."""

import json
import math

import numpy as np
import pytest
import segno
from scipy.spatial.transform import Rotation

from armspan.devices.phone.emulator import EmulatedPhone, Faults
from armspan.devices.phone.joining import join_text
from armspan.devices.phone.voices import LoggerVoice, PageVoice, ServerVoice, browser_angles, lying_still
from armspan.records import ImuSample

G = 9.80665
FLAT = ImuSample(0.5, "phone", (0.0, 0.0, G), (math.radians(90), 0.0, 0.0), None, (1.0, 0.0, 0.0, 0.0))


def run_for(phone, seconds):
    """What leaves the phone, with the times [s]."""
    return [(k * 0.005, data) for k in range(int(seconds / 0.005)) for data in phone.advance(k * 0.005)]


def numbers(left):
    return [json.loads(data)["n"] for _, data in left]


def test_the_page_rounds_as_browsers_do():
    voice = PageVoice()
    voice.tell([FLAT], 0.5)
    [text] = voice.tell([FLAT], 0.6)
    assert json.loads(text) == {
        "n": 0, "t": 500.0, "a": [0, 0, 9.8], "r": [90, 0, 0], "o": [0, 0, 0], "u": 500.0,
    }  # fmt: skip
    assert json.loads(PageVoice(apple=True).tell([FLAT, FLAT], 0.5)[0])["a"] == [0, 0, -9.8]


@pytest.mark.parametrize("seed", range(20))
def test_angles_are_within_what_a_browser_says(seed):
    rotation = Rotation.random(random_state=seed)
    alpha, beta, gamma = browser_angles(tuple(rotation.as_quat(scalar_first=True)))
    assert 0 <= alpha < 360
    assert -180 <= beta <= 180
    assert -90 <= gamma <= 90
    again = Rotation.from_euler("ZXY", [alpha, beta, gamma], degrees=True)
    assert (again.inv() * rotation).magnitude() < 1e-9


def test_each_platform_pushes_in_its_own_sign_and_unit():
    def values(name, **voice):
        device = LoggerVoice(batch_s=0.0, **voice)
        device.tell([], 0.0)
        payload = json.loads(device.tell([FLAT], 0.5)[0])["payload"]
        return {item["name"]: item["values"] for item in payload}[name]

    assert values("gravity") == {"x": 0.0, "y": 0.0, "z": pytest.approx(G)}
    assert values("gravity", platform="ios")["z"] == pytest.approx(-G)
    assert values("gravity", platform="ios", standardised=True)["z"] == pytest.approx(G)
    assert values("wrist motion", platform="apple-watch")["gravityZ"] == pytest.approx(-1.0)
    assert values("wrist motion", platform="wear-os")["gravityZ"] == pytest.approx(G)
    assert values("totalacceleration")["z"] == pytest.approx(G)
    assert values("orientation")["qw"] == 1.0


def test_the_server_tells_only_what_was_asked_for():
    texts = ServerVoice(["android.sensor.gyroscope", "android.sensor.rotation_vector"]).tell([FLAT], 0.5)
    told = {json.loads(text)["type"]: json.loads(text)["values"] for text in texts}
    assert told == {
        "android.sensor.gyroscope": [math.radians(90), 0.0, 0.0],
        "android.sensor.rotation_vector": [0.0, 0.0, 0.0, 1.0, 0.05],
    }


def test_it_speaks_at_its_rate_whenever_it_is_asked():
    phone = EmulatedPhone(PageVoice(), lying_still(50.0))
    assert numbers(run_for(phone, 2.0)) == list(range(99))
    lazy = EmulatedPhone(PageVoice(), lying_still(50.0))
    assert len(lazy.advance(1.0)) == 50


def test_losses_silence_and_bursts_are_as_ordered():
    lossy = EmulatedPhone(PageVoice(), lying_still(100.0), Faults(lost=0.1))
    left = numbers(run_for(lossy, 20.0))
    assert len(left) == pytest.approx(1800, abs=60)
    assert lossy.dropped == 1999 - len(left)
    quiet = EmulatedPhone(PageVoice(), lying_still(100.0), Faults(silences=((1.0, 0.5),)))
    times = [t for t, _ in run_for(quiet, 3.0)]
    assert not [t for t in times if 1.0 <= t < 1.5]
    assert len(times) == 249
    bursty = EmulatedPhone(PageVoice(), lying_still(100.0), Faults(burst=0.1))
    times = {round(t, 3) for t, _ in run_for(bursty, 1.0)}
    assert len(times) == 9  # the first whole burst to the last but one


def test_one_line_keeps_the_order_and_requests_may_not():
    left = numbers(run_for(EmulatedPhone(PageVoice(), lying_still(100.0), Faults(jitter=0.1)), 3.0))
    assert left == sorted(left)
    loose = EmulatedPhone(PageVoice(), lying_still(100.0), Faults(jitter=0.1), ordered=False)
    left = numbers(run_for(loose, 3.0))
    assert left != sorted(left)


def test_a_still_phone_feels_gravity_in_its_attitude():
    attitude = tuple(Rotation.from_euler("x", 90, degrees=True).as_quat(scalar_first=True).tolist())
    [sample] = lying_still(60.0, attitude)(0.0)
    assert sample.acc == pytest.approx((0.0, G, 0.0))


def test_the_picture_shows_the_url():
    url = "https://192.168.1.4:8443/?token=quiet-river-9&band=wrist"
    *rows, last = join_text(url).split("\n")
    assert last == url
    plain = [plain_row(row) for row in rows]
    assert len({len(row) for row in plain}) == 1
    width = len(plain[0])
    modules = np.array([[c in "▀█", c in "▄█"] for row in plain for c in row]).reshape(len(plain), width, 2)
    grid = modules.transpose(0, 2, 1).reshape(-1, width)

    expected = np.array(
        [list(row) for row in segno.make(url, error="l", micro=False).matrix_iter(border=2)], dtype=bool
    )
    assert (grid[: len(expected)] == expected).all()
    assert not grid[len(expected) :].any()


def plain_row(row):
    """A row without its colours."""
    assert row.startswith("\x1b[30;107m")
    assert row.endswith("\x1b[0m")
    return row.removeprefix("\x1b[30;107m").removesuffix("\x1b[0m")
