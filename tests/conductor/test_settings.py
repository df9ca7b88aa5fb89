import msgspec
import pytest

from armspan.conductor import BandSettings, Settings
from armspan.errors import ConfigError
from armspan.records import Body, Zone
from puppet import settings

CORNERS = ((0.1, 0.1), (0.2, 0.1), (0.2, 0.2))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"robots": ("ash", "elm", "ash")}, "robot 'ash' is named twice; names tell robots apart"),
        ({"zones": (Zone("a", CORNERS), Zone("a", CORNERS))}, "zone 'a' is named twice"),
        ({"bands": (BandSettings("w"), BandSettings("w", "upperarm"))}, "band 'w' is named twice"),
        ({"bands": (BandSettings("a"), BandSettings("b"))}, "bands sit on forearm, forearm"),
        ({"bands": (BandSettings("a", "upperarm"),)}, "bands sit on upperarm"),
        ({"model": "two-band"}, "model two-band needs a band on the upper arm"),
        ({"model": "two-bands"}, "Model 'two-bands' does not exist; .* Did you mean 'two-band'?"),
    ],
)
def test_what_contradicts_itself_is_refused(changes, told):
    with pytest.raises(ConfigError, match=told):
        settings(**changes)


def test_settings_survive_the_header_of_a_log():
    body = Body(1.6, (0.06, 0.15, 0.22), 0.72, "left", 0.3, 0.42, (0.0001,) * 25)
    bands = (BandSettings("a", rate_hz=52.0), BandSettings("b", "upperarm", 100.0, (0.0, 0.6, 0.8, 0.0)))
    told = settings(body=body, bands=bands, model="two-band", posture="natural", table_height_m=0.7, feedback=True)
    assert msgspec.json.decode(msgspec.json.encode(msgspec.to_builtins(told)), type=Settings) == told


def test_unknown_settings_are_not_swallowed():
    raw = msgspec.to_builtins(settings()) | {"colour": "red"}
    with pytest.raises(msgspec.ValidationError, match="colour"):
        msgspec.convert(raw, Settings)
