import tomllib

import pytest

from armspan.errors import ConfigError
from armspan.records import Zone
from armspan.web.views.master_zones import as_toml, corners, rectangle, size_words

POND = Zone("pond", ((0.1, 0.1), (0.3, 0.1), (0.2, 0.25)))


def test_what_the_page_drew_is_taken_to_a_millimetre():
    assert corners({"polygon": [[0.10049, 0.2], [0, 1], [0.5, 0.25]]}) == ((0.1, 0.2), (0.0, 1.0), (0.5, 0.25))


@pytest.mark.parametrize("args", [None, {}, {"polygon": [[1, 2, 3]]}, {"polygon": "round"}, {"polygon": [["a", "b"]]}])
def test_what_is_no_polygon_is_refused(args):
    with pytest.raises(ConfigError, match="no polygon"):
        corners(args)


def test_a_rectangle_by_its_numbers():
    assert rectangle(0.1, 0.2, 0.3, 0.1) == ((0.1, 0.2), (0.4, 0.2), (0.4, 0.3), (0.1, 0.3))
    assert size_words(Zone("box", rectangle(0.1, 0.2, 0.3, 0.1))) == "30 × 10 cm"


def test_the_lines_for_the_rooms_file_read_back_as_the_same_zones():
    quoted = Zone('the "deep" one, später', POND.polygon)
    read = tomllib.loads(as_toml([POND, quoted]))["zones"]
    assert [zone["name"] for zone in read] == ["pond", quoted.name]
    assert [tuple(map(tuple, zone["polygon_m"])) for zone in read] == [POND.polygon, POND.polygon]
