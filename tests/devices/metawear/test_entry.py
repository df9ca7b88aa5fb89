"""A MetaWear band in ROOM.toml."""

import msgspec
import numpy as np
import pytest

from armspan.devices.metawear.entry import STRAPS, MetaWearEntry
from armspan.errors import ConfigError
from armspan.frames import rotation_from_quaternion

MAC = "E8:C9:8F:52:7B:07"
TOML = """
kind = "metawear"
name = "right"
address = "e8:c9:8f:52:7b:07"
"""


def entry(**settings):
    return MetaWearEntry(**({"name": "right", "address": MAC} | settings))


def test_a_name_and_an_address_are_enough():
    read = msgspec.toml.decode(TOML, type=MetaWearEntry)
    assert read == entry()
    assert (read.address, read.profile, read.mode, read.rate_hz, read.port) == (MAC, "fusion", "imu_plus", 100.0, None)


@pytest.mark.parametrize("address", [MAC, "usb:/dev/ttyACM0", "5C9E2A4B-3E0A-4C7A-9F5B-0D6E6A1F2B3C"])
def test_addresses_by_radio_by_cable_and_on_a_mac(address):
    assert entry(address=address).address == address
    assert entry(address=address).port == ("/dev/ttyACM0" if address.startswith("usb:") else None)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"address": "E8:C9:8F:52:7B"}, "'right' has the address 'E8:C9:8F:52:7B'; expected one such as"),
        ({"address": "usb:"}, "usb:/dev/ttyACM0"),
        ({"address": ""}, "has the address ''"),
        ({"name": ""}, "has no name"),
        ({"rate_hz": 50.0}, "rate_hz with the profile fusion = 50; expected 100"),
        ({"rate_hz": 200.0, "profile": "raw"}, "rate_hz with the profile raw = 200; expected 25, 50, 100"),
        ({"rate_hz": float("nan")}, "expected 100"),
        ({"acc_range_g": 3}, "acc_range_g = 3; expected 2, 4, 8, 16"),
        ({"gyro_range_dps": 125}, "gyro_range_dps with the profile fusion = 125; expected 250, 500, 1000, 2000"),
        ({"profile": "raw", "mode": "ndof"}, "leave these out, or choose the profile fusion"),
        ({"strap": "hand-at-minus-y", "wrist_from_sensor": (1.0, 0.0, 0.0, 0.0)}, "leave one out"),
        ({"strap": "hand-at-minus-z"}, "hand-at-minus-y"),
        ({"wrist_from_sensor": (1.0, 1.0, 0.0, 0.0)}, "of length 1.41421; expected a unit quaternion"),
    ],
)
def test_what_cannot_be_is_told_in_a_sentence(settings, sentence):
    with pytest.raises(ConfigError) as told:
        entry(**settings)
    assert sentence in str(told.value)


@pytest.mark.parametrize(
    ("strap", "hand_sensor"),
    [
        ("hand-at-minus-y", (0, -1, 0)),
        ("hand-at-plus-y", (0, 1, 0)),
        ("hand-at-plus-x", (1, 0, 0)),
        ("hand-at-minus-x", (-1, 0, 0)),
    ],
)
def test_a_strap_says_where_the_hand_is(strap, hand_sensor):
    wrist_from_sensor = rotation_from_quaternion(entry(strap=strap).wrist_from_sensor)
    np.testing.assert_allclose(wrist_from_sensor @ hand_sensor, (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(wrist_from_sensor @ (0, 0, 1), (0, 0, 1), atol=1e-12)
    assert strap in STRAPS
