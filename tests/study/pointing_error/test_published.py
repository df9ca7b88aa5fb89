from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.frames import yaw_rotation
from armspan.records import Body
from armspan.study.pointing_error.published import ANGLE_MM, as_published, compare, maps, wrong_by
from armspan.study.pointing_error.readings import errors_mm, fit_wrong, unfitted
from armspan.study.pointing_error.scene import ideal_circle, published_circle

CENTRE, RADIUS = -0.540j, 1.0875
AZIMUTHS = np.linspace(-np.pi, np.pi, 30)
OFF_THE_LINE = (2.0, -7.0, -9.0)
"""Angles whose published points lie below the line of all others; nobody knows why."""


def twice_turned(degrees):
    """Median error [mm] when the circle turns by twice the angle about itself and by once about the origin."""
    once = np.exp(1j * np.radians(degrees))
    ring = RADIUS * np.exp(1j * AZIMUTHS)
    return float(np.median(np.abs(once**2 * ring + once * CENTRE - ring - CENTRE)) * 1000)


@pytest.mark.parametrize("degrees", sorted(ANGLE_MM))
def test_the_supposed_reading_turns_the_arm_twice_and_the_user_once(degrees):
    scene = published_circle()
    errors = errors_mm(scene, as_published(scene, wrong_by(scene, "deg", degrees)))
    assert abs(np.median(errors) - twice_turned(degrees)) < 1e-6


def test_it_lands_on_the_published_angles():
    rows = [row for row in compare(published_circle()) if row.figure == "1.3.3b"]
    assert len(rows) == 18
    for row in rows:
        if row.size in OFF_THE_LINE:
            assert row.published_mm < row.as_published_mm - 2.0
        else:
            assert abs(row.published_mm - row.as_published_mm) < 0.2


def test_it_lands_on_the_published_measures():
    rows = [row for row in compare(published_circle()) if row.figure == "1.3.3a"]
    assert len(rows) == 18
    for row in rows:
        assert_allclose(row.as_published_mm, row.published_mm, rtol=0.001)
        assert_allclose(row.as_published_mm, 10 * abs(row.size) * np.hypot(1.0875, 0.540), rtol=1e-4)


def test_with_measures_wrong_it_is_the_place_without_a_calibration():
    scene = ideal_circle()
    errors = errors_mm(scene, as_published(scene, wrong_by(scene, "%", 1.0)))
    assert abs(np.median(errors) - 11.71) < 0.01


def test_it_was_found_before_with_the_measures_of_the_published_code():
    """41.8 mm a degree with eye 1.66 m, shoulder 0.20 and 0.22 m from it, arm 0.75 m: a circle of 1.173 m radius."""
    body = Body(eye_height_m=1.66, shoulder_to_eye_m=(0.0, 0.20, 0.22), shoulder_to_fingertip_m=0.75)
    scene = replace(ideal_circle(), body=body, eye_left=-0.03)
    x = scene.points()[:, 0]
    assert abs((x.max() - x.min()) / 2 - 1.173) < 0.005
    errors = errors_mm(scene, as_published(scene, wrong_by(scene, "deg", 1.0)))
    assert_allclose(np.median(errors), 41.8, rtol=0.005)
    assert_allclose(np.median(errors) * 1.0875 / 1.173, 38.7, rtol=0.005)


def test_other_ways_round_do_not_land_on_the_published_map():
    """Undoing the whole calibration leaves the circle's centre where it is; it is published turned by 9 degrees."""
    scene = published_circle()
    wrong = wrong_by(scene, "deg", 9.0)
    correction = fit_wrong(scene, wrong).transform() @ scene.place().inverse()  # from where the user is thought to be
    undone = correction.inverse().points(unfitted(scene, wrong))
    centre = undone[:-1].mean(axis=0)
    assert_allclose(centre, [0.0, -0.540, 0.0], atol=1e-9)
    assert np.linalg.norm(centre[:2] - np.mean(maps(scene)[1].published, axis=0) / 1000) > 0.05


def test_maps_have_the_published_geometry():
    body, angle = maps(published_circle())
    true, told = np.array(body.true), np.array(body.published)
    assert_allclose(told, 0.910 * true)
    assert_allclose(body.as_published, told, atol=1e-6)
    assert_allclose(body.refitted, true, atol=1e-6)
    turned = np.array(angle.published) @ np.array([1.0, 1j])
    centre = turned[:-1].mean()
    assert abs(np.degrees(np.angle(centre / CENTRE)) - 9.0) < 1e-9
    first = turned[0] - centre
    assert abs(np.degrees(np.angle(first / -RADIUS)) - 18.0) < 1e-9
    assert abs(abs(first) - 1087.5) < 1e-6
    assert_allclose(angle.as_published, angle.published, atol=1e-6)
    assert_allclose(angle.refitted, angle.true, atol=1e-6)


def test_the_map_without_a_calibration_turns_the_circle_about_itself_only():
    _, angle = maps(published_circle())
    centre = np.array([0.0, -540.0])
    turned = (np.array(angle.true) - centre) @ yaw_rotation(np.radians(9.0))[:2, :2].T + centre
    assert_allclose(angle.unfitted, turned, atol=1e-6)
