import numpy as np
from numpy.testing import assert_allclose

from armspan.conductor import BandSettings
from armspan.frames import sheet_from_user
from puppet import FORWARD, PLACE, Puppet
from straight_arms import BODY


def test_before_the_set_up_nothing_is_known():
    sight = Puppet().conductor.sight()
    assert (sight.step, sight.limbs, sight.place, sight.ray, sight.seen) == ("idle", (), None, None, ())
    assert not sight.stopped


def test_the_arm_is_where_it_is_stretched():
    puppet = Puppet().set_up()
    puppet.pose(FORWARD)
    puppet.run(1)
    [limb] = puppet.conductor.sight().limbs
    shoulder, _, finger = np.array(limb.points)
    forward, left, up = BODY.shoulder_to_eye_m
    assert limb.side == "right"
    assert_allclose(shoulder, [-forward, -left, BODY.eye_height_m - up], atol=1e-9)
    assert_allclose(finger - shoulder, [BODY.shoulder_to_fingertip_m, 0, 0], atol=1e-6)


def test_the_ray_meets_what_is_pointed_at():
    puppet = Puppet().set_up()
    puppet.point_at("elm")
    puppet.run(2)
    sight = puppet.conductor.sight()
    placed = sheet_from_user(np.array(sight.place[:3]), sight.place[3])
    origin, direction = placed.points(sight.ray[0]), placed.directions(sight.ray[1])
    hit = origin - direction * (origin[2] + 0.045) / direction[2]
    assert_allclose(hit, [*puppet.robots["elm"], -0.045], atol=1e-3)
    assert_allclose(sight.place[:3], PLACE[0], atol=1e-4)


def test_both_arms_are_seen_and_the_stops_with_their_residuals():
    bands = (BandSettings("wrist"), BandSettings("other", arm="left"))
    sight = Puppet(bands=bands).set_up().conductor.sight()
    assert [limb.side for limb in sight.limbs] == ["right", "left"]
    right, left = (limb.points[0] for limb in sight.limbs)
    assert left[1] == -right[1] > 0
    assert [stop.number for stop in sight.seen] == [1, 2, 3, 4]
    assert all(stop.used and stop.residual < 1e-6 for stop in sight.seen)
    assert (sight.quality, sight.stops) == ("good", 4)


def test_what_the_robots_are_at_is_seen():
    puppet = Puppet().set_up()
    puppet.press("behaviour", "random-walk:elm")
    puppet.run(0.2)
    assert puppet.conductor.sight().running == (("random-walk", ("elm",)),)
    puppet.press("stop")
    puppet.run(0.2)
    assert (puppet.conductor.sight().stopped, puppet.conductor.sight().running) == (True, ())


def test_how_well_stops_fit_is_seen_as_soon_as_they_can_be_compared():
    puppet = Puppet()
    puppet.press("setup")
    counts = []
    for _ in range(1200):
        puppet.step()
        counts.append((puppet.conductor.sight().stop, len(puppet.conductor.sight().seen)))
        if counts[-1][1] == 4:
            break
    assert list(dict.fromkeys(counts)) == [(1, 0), (2, 0), (3, 0), (4, 3), (4, 4)]
    puppet.press("setup")
    assert puppet.conductor.sight().seen == ()
