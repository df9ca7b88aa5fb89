import math

import msgspec
import pytest

from armspan.devices.phone.entry import STRAPPED, PhoneEntry
from armspan.errors import ConfigError
from armspan.frames import rotation_from_quaternion


def entry(**table):
    return msgspec.convert({"kind": "phone", "name": "wrist"} | table, PhoneEntry)


def test_the_least_entry_is_a_browser_on_this_machine():
    least = entry()
    assert (least.app, least.address, least.rate_hz, least.segment) == ("browser", ("127.0.0.1", 8443), 60.0, "forearm")


def test_each_app_may_be_said_in_full():
    entry(app="browser", listen="0.0.0.0:8443", token="quiet-river-9", arm="left", segment="upperarm")
    entry(
        app="sensor-logger", listen="[::]:8001", allow=["192.168.1.0/24"], device="ab-12", stream="watch", rate_hz=100
    )
    entry(app="sensor-server", url="ws://192.168.1.23:8080", wrist_from_sensor=[0.5, 0.5, 0.5, 0.5])
    entry(app="sensor-server", url="ws://localhost:8081/")


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"listen": "0.0.0.0:8443"}, "anybody on the network.*token.*allow"),
        ({"listen": "8443"}, "listen is '8443'; expected HOST:PORT"),
        ({"listen": "0.0.0.0:8443", "token": "x"}, "token is 'x'; expected 8 to 64"),
        ({"allow": ["everybody"]}, "allow holds 'everybody'; expected an address"),
        ({"rate_hz": 0}, "rate_hz is 0"),
        ({"rate_hz": math.nan}, "rate_hz is nan"),
        ({"rate_hz": -60.0}, "rate_hz is -60"),
        ({"wrist_from_sensor": [1.0, 1.0, 0.0, 0.0]}, "length 1.414; a unit quaternion"),
        ({"wrist_from_sensor": [math.nan, 0.0, 0.0, 0.0]}, "length nan"),
        ({"device": "ab-12"}, "device and stream are for app = 'sensor-logger'"),
        ({"stream": "watch"}, "device and stream are for app = 'sensor-logger'"),
        ({"url": "ws://192.168.1.23:8080"}, "url is for app = 'sensor-server'"),
        ({"app": "sensor-server"}, "url is missing; expected 'ws://192.168.1.23:8080'"),
        ({"app": "sensor-server", "url": "http://192.168.1.23:8080"}, "url is 'http://192.168.1.23:8080'; expected"),
        ({"app": "sensor-server", "url": "ws://"}, "url is 'ws://'; expected"),
        ({"app": "sensor-server", "url": "ws://a:99999"}, "url is 'ws://a:99999'; expected"),
        ({"app": "sensor-server", "url": "ws://a:8080/sensor/connect?type=x"}, "expected 'ws://"),
        ({"app": "sensor-server", "url": "ws://[a"}, "expected 'ws://"),
    ],
)
def test_what_cannot_be_used_is_one_sentence_with_the_bands_name(table, words):
    with pytest.raises((ConfigError, msgspec.ValidationError), match=words) as caught:
        entry(**table)
    text = str(caught.value.__cause__ or caught.value)
    assert text.startswith("band 'wrist': ")
    assert "\n" not in text


@pytest.mark.parametrize(
    "table", [{"app": "telnet"}, {"segment": "head"}, {"arm": "both"}, {"port": 3}, {"stream": "ring"}]
)
def test_what_is_unknown_is_refused(table):
    with pytest.raises(msgspec.ValidationError):
        entry(**table)


def test_a_strapped_phone_points_with_its_top_edge_and_shows_its_screen():
    wrist_from_sensor = rotation_from_quaternion(STRAPPED)
    top, screen, right = [0, 1, 0], [0, 0, 1], [1, 0, 0]
    assert wrist_from_sensor @ top == pytest.approx([1, 0, 0], abs=1e-12)  # to the hand
    assert wrist_from_sensor @ screen == pytest.approx([0, 0, 1], abs=1e-12)  # out of the back of the hand
    assert wrist_from_sensor @ right == pytest.approx([0, -1, 0], abs=1e-12)  # y is left
