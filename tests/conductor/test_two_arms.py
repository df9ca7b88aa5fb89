import numpy as np
import pytest

from armspan.conductor.arm import Arm
from armspan.conductor.settings import BandSettings, Settings
from armspan.errors import ConfigError
from armspan.records import Body, Calibrated, Event, ImuSample, Output, Pointed, Say, Selected, Sheet
from puppet import FORWARD, PLACE, Puppet

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


class TwoArms(Puppet):
    """A puppet whose left arm can be silent or restless by itself."""

    left_silent = left_restless = False

    def _sample(self, t: float, band: str, moving: bool) -> ImuSample:
        return super()._sample(t, band, moving or (band == "l" and self.left_restless))

    def tell(self, event: Event) -> list[Output]:
        if self.left_silent and isinstance(event, ImuSample) and event.source == "l":
            return []
        return super().tell(event)


def test_the_set_up_asks_for_both_arms_and_mounts_both() -> None:
    puppet = TwoArms(bands=(BandSettings("r"), LEFT)).set_up()
    words = [said.text for said in puppet.of(Say)]
    assert words[:2] == [
        "Stretch both arms straight forward, level, palm down, and hold still",
        "Now let both arms hang straight down, and hold still",
    ]
    puppet.pose(FORWARD)
    puppet.run(0.2)
    for band in puppet.conductor._arm.wrists.values():
        np.testing.assert_allclose(band.in_user(), FORWARD, atol=1e-6)
    np.testing.assert_allclose(puppet.of(Calibrated)[0].xyz, PLACE[0], atol=1e-6)


def test_the_set_up_waits_for_both_arms_to_be_still_and_heard() -> None:
    puppet = TwoArms(bands=(BandSettings("r"), LEFT))
    puppet.left_restless = True
    puppet.press("setup")
    puppet.run(13)
    assert puppet.said() == ["stretch", "stretch"]
    puppet.left_restless, puppet.left_silent = False, True
    puppet.run(12)
    assert puppet.of(Say)[-1].text == "Nothing is heard of l: is the band on and near?"
    puppet.left_silent = False
    puppet.run(1.8)
    assert puppet.said()[-1] == "hang"


def test_pointing_does_not_mind_the_other_arm() -> None:
    puppet = TwoArms(bands=(BandSettings("r"), LEFT)).set_up()
    alone = Puppet(bands=(BandSettings("r"),)).set_up()
    puppet.left_silent = True
    puppet.left_restless = True
    for one in (puppet, alone):
        one.point_at("elm")
    pointed, expected = (one.run(1.5) for one in (puppet, alone))
    assert [o for o in pointed if isinstance(o, Pointed)][-1].xy == pytest.approx(
        [o for o in expected if isinstance(o, Pointed)][-1].xy, abs=1e-9
    )
    assert [o.refused for o in pointed if isinstance(o, Pointed)] == [
        o.refused for o in expected if isinstance(o, Pointed)
    ]
    assert [o.robot for o in pointed if isinstance(o, Selected)] == [
        o.robot for o in expected if isinstance(o, Selected)
    ]
