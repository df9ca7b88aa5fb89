import msgspec
import pytest

from armspan.devices.toio.entry import ToioEntry
from armspan.errors import ConfigError

ADDRESS = "D0:8B:7F:00:00:01"


def read(**more):
    table = {"kind": "toio", "name": "ash", "address": ADDRESS} | more
    return msgspec.convert(table, ToioEntry)


def test_a_cube_stands_on_the_ring_side_where_not_told():
    assert read() == ToioEntry("ash", ADDRESS)
    assert read().corner == (45.0, 45.0)
    assert read(mat="tile").corner == (545.0, 45.0)
    assert read(mat="simple").corner == (98.0, 142.0)
    assert read(mat=[1050, 45]).corner == (1050, 45)  # another mat of Sony's


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"address": "D0:8B:7F:00:00"}, "'ash'.*six pairs of hexadecimal digits"),
        ({"address": "toio-M0p"}, "'toio-M0p' is not a Bluetooth address"),
        ({"name": ""}, "has no name"),
        ({"mat": (float("nan"), 45)}, r"mat = \(nan, 45.*'ring', 'tile', 'simple'"),
        ({"mat": (-1, 45)}, "0 to 65534"),
        ({"mat": (45, 65535)}, "65535"),
    ],
)
def test_what_cannot_be_is_said_in_one_sentence(more, words):
    with pytest.raises((ConfigError, msgspec.ValidationError), match=words):
        read(**more)


@pytest.mark.parametrize("more", [{"mat": "carpet"}, {"mat": [45]}, {"colour": "red"}])
def test_other_tables_are_refused(more):
    with pytest.raises(msgspec.ValidationError):
        read(**more)
