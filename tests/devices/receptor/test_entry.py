import msgspec
import pytest

from armspan.devices.receptor.entry import HttpReceptor, ReceptorEntry, SerialReceptor, UdpReceptor, robots_of
from armspan.errors import ConfigError


def test_entries_are_told_apart_by_their_kind():
    table = [
        {"kind": "serial", "name": "tops", "path": "/dev/ttyUSB0"},
        {"kind": "udp", "name": "tops", "listen": "0.0.0.0:4000", "token": "quiet-river-9"},
        {"kind": "http", "name": "tops", "robots": ["amber"]},
    ]
    serial, udp, http = msgspec.convert(table, tuple[ReceptorEntry, ...])
    assert serial == SerialReceptor("tops", "/dev/ttyUSB0")
    assert (serial.baud, serial.expire_s) == (115200, 0.0)
    assert udp == UdpReceptor("tops", "0.0.0.0:4000", "quiet-river-9")
    assert udp.address == ("0.0.0.0", 4000)
    assert http.address == ("127.0.0.1", 47702)
    assert http.expire_s == 1.0


@pytest.mark.parametrize("kind", [UdpReceptor, HttpReceptor])
def test_a_door_to_strangers_needs_a_token_or_a_list(kind):
    with pytest.raises(ConfigError, match=r"receptor 'tops': listening on 0\.0\.0\.0 would let anybody"):
        kind("tops", listen="0.0.0.0:4000")
    kind("tops", listen="0.0.0.0:4000", token="quiet-river-9")
    kind("tops", listen="0.0.0.0:4000", allow=("192.168.1.0/24",))
    kind("tops", listen="127.0.0.1:4000")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: SerialReceptor("", "/dev/x"), "no name"),
        (lambda: SerialReceptor("tops", ""), "path is empty"),
        (lambda: SerialReceptor("tops", "/dev/x", chatter_s=float("nan")), "chatter_s is nan"),
        (lambda: SerialReceptor("tops", "/dev/x", expire_s=-1.0), "expire_s is -1.0; expected seconds from 0"),
        (lambda: SerialReceptor("tops", "/dev/x", expire_s=0.02), "must outlast the chatter"),
        (lambda: UdpReceptor("tops", listen="4000"), "receptor 'tops': listen is '4000'; expected HOST:PORT"),
        (lambda: UdpReceptor("tops", token="short"), "receptor 'tops': token is 'short'"),
        (lambda: HttpReceptor("tops", allow=("nowhere",)), "receptor 'tops': allow holds 'nowhere'"),
    ],
)
def test_what_cannot_be_used_is_one_sentence(make, words):
    with pytest.raises(ConfigError, match=words):
        make()


def test_a_door_speaks_of_its_robots_or_of_all():
    assert robots_of(SerialReceptor("tops", "/dev/x"), ("amber", "birch")) == ("amber", "birch")
    assert robots_of(SerialReceptor("tops", "/dev/x", robots=("birch",)), ("amber", "birch")) == ("birch",)
    with pytest.raises(ConfigError, match="receptor 'tops': robot 'birk' does not exist; there are: amber, birch"):
        robots_of(SerialReceptor("tops", "/dev/x", robots=("birk",)), ("amber", "birch"))
