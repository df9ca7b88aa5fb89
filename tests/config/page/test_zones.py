import msgspec
import pytest

from armspan.config.page.zones import entries, rezoned
from armspan.errors import ConfigError
from armspan.records import Body, Zone
from armspan.web.activities import Act
from small_rooms import small_room

BODY = Body(1.6, (0.06, 0.15, 0.22), 0.72)
POND = Zone("pond", ((0.1, 0.1), (0.3, 0.1), (0.2, 0.25)))


@pytest.fixture(scope="module")
def settings():
    room = small_room()
    return msgspec.structs.replace(room.settings(BODY), zones=(POND,), gestures={"a": "stop", "b": "sweep@pond"})


@pytest.mark.parametrize(
    ("zones", "words"),
    [
        ([POND, Zone("bow", ((0.1, 0.1), (0.3, 0.3), (0.3, 0.1), (0.1, 0.3)))], "crosses itself"),
        ([POND, Zone("far", ((0.1, 0.1), (9.0, 0.1), (0.1, 0.3)))], "outside the sheet"),
        ([POND, POND], "named twice"),
        ([POND, Zone(" ", POND.polygon)], "needs a name"),
        ([POND, Zone("a:b", POND.polygon)], "neither : nor @"),
        ([], "needed by the gesture 'b'"),
    ],
)
def test_zones_that_cannot_be_are_refused_with_the_reason(settings, zones, words):
    with pytest.raises(ConfigError, match=words):
        rezoned(settings, zones, [])


def test_a_zone_that_an_activity_is_for_cannot_go(settings):
    settings = msgspec.structs.replace(settings, gestures={"a": "stop"})
    with pytest.raises(ConfigError, match=r"zone 'pond' is needed by the activity 'Tidy'"):
        rezoned(settings, [], [Act("Tidy", "sweep@pond")])
    assert rezoned(settings, [], [Act("Tidy", "sweep")]) == "[]"


def test_what_is_pressed_reads_back_as_the_zones(settings):
    assert msgspec.json.decode(rezoned(settings, [POND], []), type=list[Zone]) == [POND]
    assert [(entry.name, entry.polygon_m) for entry in entries([POND])] == [(POND.name, POND.polygon)]
