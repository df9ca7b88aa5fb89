import asyncio

import msgspec
import pytest

from armspan.devices.cellulo.driver import CelluloRelay
from armspan.devices.cellulo.entry import CelluloEntry, check_cellulos, open_cellulos, way_to
from armspan.devices.cellulo.faults import Trouble
from armspan.devices.cellulo.ring import Ring
from armspan.devices.cellulo.sockets import CelluloSockets
from armspan.errors import ConfigError, DeviceError, DeviceNotFound
from cellulo_lines import Host, emulated, speed
from devices.promises import check_events
from fast_time import hasten, run

ASH, ELM, FIR = (f"00:06:66:E7:8A:0{k}" for k in (1, 2, 3))
DONGLE = "00:1A:7D:DA:71:13"


def entry(name="ash", address=ASH, **told):
    return CelluloEntry(name, address, **told)


def test_from_words_as_a_room_file_has_them():
    words = {"kind": "cellulo", "name": "ash", "address": ASH, "door": "relay", "relay": "lab:2556", "scale": 0.98}
    found = msgspec.convert(words, CelluloEntry)
    assert (found.relay_at, found.traits.scale, found.traits.ring) == (("lab", 2556), 0.98, Ring())
    with pytest.raises(msgspec.ValidationError, match="unknown field `mac`"):
        msgspec.convert({**words, "mac": ASH}, CelluloEntry)
    with pytest.raises(msgspec.ValidationError, match="Invalid enum value 'left'"):
        msgspec.convert({**words, "led_turn": "left"}, CelluloEntry)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"address": "00:06:66"}, "robot 'ash' has the address '00:06:66'; expected six pairs"),
        ({"address": None}, "robot 'ash' has no address; expected six pairs"),
        ({"door": "usb"}, "robot 'ash' has the door 'usb'; expected 'rfcomm', 'relay', or a serial port's path"),
        ({"adapter": "hci0"}, "robot 'ash' has the adapter 'hci0'; expected six pairs"),
        ({"adapter": DONGLE, "door": "/dev/rfcomm0"}, "has an adapter and the door /dev/rfcomm0"),
        ({"relay": "h:1"}, "has a relay and the door 'rfcomm'; expected door = 'relay'"),
        ({"door": "relay", "relay": "h"}, "robot 'ash': 'h' is not a relay; expected host:port"),
        ({"door": "relay", "relay": "h:99999"}, "'h:99999' is not a relay"),
        ({"scale": 0.0}, "robot 'ash': scale is 0.0; expected a number above zero"),
        ({"scale": float("nan")}, "scale is nan"),
        ({"led_zero_deg": float("inf")}, "led_zero_deg is inf; expected degrees from -360 to 360"),
    ],
)
def test_values_that_cannot_be(told, words):
    with pytest.raises(ConfigError, match=words.replace("(", r"\(")):
        entry(**told)


def test_robots_that_get_in_each_others_way():
    with pytest.raises(ConfigError, match=f"robots 'ash' and 'elm' both have the address {ASH}"):
        check_cellulos([entry(), entry("elm", ASH.lower())])
    with pytest.raises(ConfigError, match="robots 'ash' and 'elm' both have the door /dev/rfcomm0"):
        check_cellulos([entry(door="/dev/rfcomm0"), entry("elm", ELM, door="/dev/rfcomm0")])
    eight = [entry(f"r{k}", f"00:06:66:00:00:0{k}") for k in range(8)]
    check_cellulos(eight[:7])
    with pytest.raises(
        ConfigError, match=r"8 robots are on one Bluetooth adapter, which holds 7; .* second adapter .* relay"
    ):
        check_cellulos(eight)
    split = [msgspec.structs.replace(one, adapter=DONGLE) if k > 3 else one for k, one in enumerate(eight)]
    check_cellulos(split)
    check_cellulos([msgspec.structs.replace(one, door="relay") for one in eight])
    with pytest.raises(ConfigError, match=f"8 robots are on the adapter {DONGLE}"):
        check_cellulos([msgspec.structs.replace(one, adapter=DONGLE) for one in eight])


def test_one_driver_for_each_relay_and_one_for_all_others():
    entries = [
        entry(door="relay"),
        entry("elm", ELM, door="relay", relay="127.0.0.1:2556", scale=0.5),
        entry("fir", FIR, door="relay", relay="lab:7"),
        entry("oak", "00:06:66:E7:8A:04"),
        entry("yew", None, door="/dev/rfcomm0"),
    ]
    near, far, direct = open_cellulos(entries, (1.0, 2.0))
    assert isinstance(near, CelluloRelay)
    assert isinstance(far, CelluloRelay)
    assert isinstance(direct, CelluloSockets)
    assert [driver.names for driver in (near, far, direct)] == [("ash", "elm"), ("fir",), ("oak", "yew")]
    assert near._flock.robots["elm"].placement.mm_from_sheet((0.5, 0.0)) == (3000.0, 4000.0)
    assert [(way_to(one).queue, way_to(one).carrier) for one in entries[3:]] == [("ANY", True), ("/dev/rfcomm0", False)]
    assert open_cellulos([]) == []


def test_a_python_without_bluetooth_sockets_ends_the_session_in_a_sentence(monkeypatch):
    monkeypatch.delattr("socket.AF_BLUETOOTH", raising=False)

    async def scene():
        (driver,) = open_cellulos([entry()])
        with pytest.raises(DeviceError, match="this Python has no Bluetooth sockets"):
            await anext(driver.source())

    run(scene)


def test_a_serial_port_that_is_not_there_ends_the_session_in_a_sentence():
    async def scene():
        (driver,) = open_cellulos([entry(address=None, door="/dev/rfcomm77")])
        with pytest.raises(DeviceNotFound, match=r"/dev/rfcomm77 cannot be opened: .* plugged in or bound"):
            await anext(driver.source())

    run(scene)


def test_a_robot_on_a_pseudo_terminal_is_met_driven_and_lost_and_found(monkeypatch):
    hasten(monkeypatch)

    async def scene():
        troubles = [Trouble("link-loss", 3.0, 4.0)]
        async with emulated(n=2, troubles=troubles) as emulator, emulator.on_ptys() as paths:
            named = zip(("ash", "elm"), paths, strict=True)
            (driver,) = open_cellulos([entry(name, None, door=path) for name, path in named])
            async with Host(driver) as host:
                await host.until(lambda: len(host.states("ash")) > 30 and len(host.states("elm")) > 30)
                assert host.links("ash") == [True]
                assert host.states("elm")[-1].xy == pytest.approx((1.4, 1.4), abs=3e-4)
                await host.go(0.8)
                assert speed(emulator) > 0.1
                await host.until(lambda: host.links("elm") == [True, False, True], 12)
                assert emulator.now < 7.0 + 2.0
                check_events(host.events)
            assert driver.refused == 0

    run(scene, 60.0)


@pytest.mark.parametrize(
    ("zero", "turn", "corners"),
    [
        (0.0, "clockwise", [0, 1, 2, 3, 4, 5]),
        (-90.0, "clockwise", [2, 3, 4, 5, 0, 1]),  # EPFL's plugin: 0 at the top; 30 degrees is its number 2
        (180.0, "counterclockwise", [3, 2, 1, 0, 5, 4]),  # EPFL's Unity template
        (60.0, "counterclockwise", [1, 0, 5, 4, 3, 2]),
    ],
)
def test_the_corners_by_number(zero, turn, corners):
    ring = Ring(zero, turn)
    assert [ring.robots_own(k) for k in range(6)] == corners
    assert [ring.armspans(ring.robots_own(k)) for k in range(6)] == list(range(6))
    for k, own in enumerate(corners):
        at = zero + (60 if turn == "clockwise" else -60) * own
        assert (at - (ring.first_deg + 60 * k)) % 360 == 0


def test_nothing_is_opened_before_it_is_asked_for():
    async def scene():
        before = asyncio.all_tasks()
        open_cellulos([entry(door="/dev/rfcomm0")])
        assert asyncio.all_tasks() == before

    run(scene)
