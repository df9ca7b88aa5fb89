import numpy as np
import pytest

from armspan.conductor.arm import Arm
from armspan.conductor.settings import BandSettings, Settings
from armspan.errors import ConfigError
from armspan.records import Body, ImuSample, Sheet

BODY = Body(1.6, (0.06, 0.15, 0.22), 0.72)
RIGHT, LEFT = BandSettings("r"), BandSettings("l", arm="left")


def settings(*bands: BandSettings, body: Body = BODY) -> Settings:
    return Settings(body, Sheet(0.9, 0.6), bands, ("amber",))


def test_the_other_arms_band_takes_no_part_in_pointing() -> None:
    arm = Arm.from_settings((LEFT, RIGHT), "right")
    assert arm.forearm.settings.name == "r"
    assert list(arm.pointing) == ["r"]
    assert {side: band.settings.name for side, band in arm.wrists.items()} == {"right": "r", "left": "l"}
    assert arm.both
    for name, rate in (("r", 0.0), ("l", 3.0)):
        arm.by_name[name].feel(ImuSample(0.1, name, (0.0, 0.0, 9.8), (rate, 0.0, 0.0), None, (1.0, 0.0, 0.0, 0.0)))
    for band in arm.bands:
        band.tick()
    assert not arm.moving
    assert arm.any_moving
    arm.by_name["r"].heard = 5.0
    assert arm.silent(5.1) == []
    assert arm.any_silent(5.1) == ["l"]


def test_a_left_handed_user_points_with_the_left() -> None:
    arm = Arm.from_settings((LEFT, BandSettings("r", arm="right")), "left")
    assert arm.forearm.settings.name == "l"
    assert set(arm.wrists) == {"left", "right"}
    assert np.isinf(arm.rate)


@pytest.mark.parametrize(
    ("bands", "words"),
    [
        ((LEFT,), "sit on nothing; pointing needs one"),
        ((RIGHT, LEFT, BandSettings("l2", arm="left")), "on the other arm sit on forearm, forearm"),
        ((RIGHT, BandSettings("u", "upperarm", arm="left")), "on the other arm sit on upperarm"),
    ],
)
def test_bands_that_serve_nothing_are_refused(bands: tuple[BandSettings, ...], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        settings(*bands)
