"""The virtual laser, its dot, and the receptors that notice it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.records import Hit, Say, Sheet
from armspan.simulation.bands import VirtualBand, draw_band
from armspan.simulation.beam import Beam
from armspan.simulation.dot import EYE_DELAY, TAKEN_ALONG, Dot
from armspan.simulation.laser import LaserTraits, VirtualLaser, draw_laser
from armspan.simulation.person import VirtualPerson, draw_person
from armspan.simulation.receptors import SAMPLE_S, ReceptorTraits, VirtualReceptors
from armspan.simulation.robots import VirtualRobots
from armspan.simulation.script import Phase, Script, Target, Trial
from armspan.simulation.world import World

PLAIN = ReceptorTraits(missed=0.0, stray=0.0, late=(0.0, 0.0), response=(0.03, 0.03))
LEVEL = 0.8


def rng(seed=1):
    return np.random.default_rng(seed)


# --- the laser -----------------------------------------------------------------------------------------------


def test_the_beam_begins_and_goes_where_it_sits():
    person = VirtualPerson(draw_person(rng()), (0.0, 0.0), 0.3, rng())
    person.point(0.0, (1.0, 0.2, 0.8))
    pose = person.pose(np.array([2.0, 2.5]))
    origins, directions = VirtualLaser(LaserTraits((0.02, 0.01, -0.03), (0.0, 0.0))).rays(pose)
    turn = pose.room_from_forearm
    assert_allclose(directions, turn[:, :, 0])
    assert_allclose(origins - pose.wrist, 0.02 * turn[:, :, 0] + 0.01 * turn[:, :, 1] - 0.03 * turn[:, :, 2])
    _, down = VirtualLaser(LaserTraits(aim=(0.0, -np.radians(30.0)))).rays(pose)
    assert_allclose(down, np.sqrt(0.75) * turn[:, :, 0] - 0.5 * turn[:, :, 2])


def test_a_laser_is_strapped_on_a_little_off():
    drawn = [draw_laser(rng(seed), (0.0, 0.0, 0.03), (0.1, -0.2)) for seed in range(300)]
    aims, places = np.array([d.aim for d in drawn]), np.array([d.position for d in drawn])
    assert_allclose(np.degrees(aims.std(axis=0)), 2.0, rtol=0.15)
    assert_allclose(aims.mean(axis=0), (0.1, -0.2), atol=0.01)
    assert_allclose(places.std(axis=0), 0.004, rtol=0.15)
    assert_allclose(places.mean(axis=0), (0.0, 0.0, 0.03), atol=0.001)


# --- receptors -----------------------------------------------------------------------------------------------


def beam_at(xy, elevation_deg=40.0, origin_height=LEVEL + 0.4):
    """A beam (3,), (3,) that meets the level of the receptors at (x, y) from the side of -y."""
    elevation = np.radians(elevation_deg)
    direction = np.array([0.0, np.cos(elevation), -np.sin(elevation)])
    at = np.array([*xy, LEVEL])
    return at - (origin_height - LEVEL) / np.sin(elevation) * direction, direction


def looked(receptors, beams, start=0.0):
    """What arrives when the beam is in these places, one look each."""
    times = start + SAMPLE_S * np.arange(len(beams))
    origins, directions = (np.array(part) for part in zip(*beams, strict=True))
    places = np.array([[0.3, 0.2, LEVEL], [0.6, 0.2, LEVEL]])
    return receptors.advance(times, VirtualLaser(LaserTraits()), (origins, directions), places)


def test_a_receptor_notices_the_spot_and_its_end_a_little_later():
    receptors = VirtualReceptors(("ash", "elm"), PLAIN, rng())
    on, off = beam_at((0.305, 0.2)), beam_at((0.45, 0.2))
    told = [hit for _, hit in looked(receptors, [off] * 10 + [on] * 20 + [off] * 20)]
    assert [(hit.robot, hit.on) for hit in told] == [("ash", True), ("ash", False)]
    assert [hit.t for hit in told] == pytest.approx([0.13, 0.33])


def test_a_spot_that_passes_too_fast_is_not_noticed():
    receptors = VirtualReceptors(("ash", "elm"), PLAIN, rng())
    assert looked(receptors, [beam_at((0.3, 0.2))] * 2 + [beam_at((0.4, 0.2))] * 20) == []


@pytest.mark.parametrize(
    ("beside", "elevation", "seen"),
    [(0.0, 40, True), (0.015, 40, True), (0.026, 40, False), (0.0, 12, True), (0.0, 7, False), (0.0, 80, True)],
)
def test_what_is_noticed_depends_on_place_and_slant(beside, elevation, seen):
    receptors = VirtualReceptors(("ash", "elm"), PLAIN, rng())
    told = looked(receptors, [beam_at((0.3 + beside, 0.2), elevation)] * 20)
    assert bool(told) is seen


def test_a_beam_that_goes_up_is_not_noticed():
    receptors = VirtualReceptors(("ash", "elm"), PLAIN, rng())
    origin, direction = beam_at((0.3, 0.2))
    assert looked(receptors, [(origin, -direction)] * 20) == []


def test_messages_come_after_what_they_tell():
    receptors = VirtualReceptors(("ash", "elm"), ReceptorTraits(stray=0.0), rng())
    told = looked(receptors, ([beam_at((0.3, 0.2))] * 50 + [beam_at((0.6, 0.2))] * 50) * 5)
    assert len(told) > 10
    for arrived, hit in told:
        assert 0.003 <= arrived - hit.t <= 0.015
    per_robot = {robot: [hit.on for _, hit in told if hit.robot == robot] for robot in ("ash", "elm")}
    assert all(on == (k % 2 == 0) for said in per_robot.values() for k, on in enumerate(said))


def test_stray_lights_come_at_their_rate():
    traits = ReceptorTraits(stray=0.5)
    receptors = VirtualReceptors(("ash", "elm"), traits, rng(3))
    dark = [beam_at((0.45, 0.4))] * 1000
    told = [hit for k in range(20) for _, hit in looked(receptors, dark, start=10.0 * k)]
    begun = sum(hit.on for hit in told)
    assert begun == pytest.approx(2 * 0.5 * 200, rel=0.25)  # two receptors, half a one a second, 200 s


# --- the dot -------------------------------------------------------------------------------------------------

EYE, SHOULDER, GOAL = np.array([0.0, 0.0, 1.6]), np.array([0.1, -0.2, 1.4]), np.array([0.9, 0.1, 0.8])


def seen_from_eye(dot, target):
    knows = Dot()
    wrist = np.array([0.4, 0.0, 1.2])
    knows.look(0.0, wrist, (dot - wrist) / np.linalg.norm(dot - wrist))
    return knows.beside(EYE, SHOULDER, target)


def test_a_dot_on_its_target_needs_nothing():
    assert_allclose(seen_from_eye(GOAL, GOAL), 0.0, atol=1e-12)


def test_a_dot_to_the_left_is_an_aim_to_the_left_by_the_same_angle():
    away = GOAL - SHOULDER
    for angle in (0.05, -0.05):
        c, s = np.cos(angle), np.sin(angle)
        turned = SHOULDER + np.array([c * away[0] - s * away[1], s * away[0] + c * away[1], away[2]])
        offset = seen_from_eye(turned, GOAL)
        sideways = np.cross([0.0, 0.0, 1.0], GOAL - EYE)
        assert float(offset @ sideways) / (sideways @ sideways) == pytest.approx(angle, rel=0.3)


def test_the_hand_knows_of_the_dot_with_the_eyes_delay():
    knows = Dot()
    wrist = np.array([0.4, 0.0, 1.2])
    for k in range(11):
        dot = GOAL + np.array([0.0, 0.01 * k, 0.0])
        knows.look(0.05 * k, wrist, (dot - wrist) / np.linalg.norm(dot - wrist))
    late = seen_from_eye(GOAL + np.array([0.0, 0.01 * (10 - EYE_DELAY / 0.05), 0.0]), GOAL)
    assert_allclose(knows.beside(EYE, SHOULDER, GOAL), late, atol=1e-12)


def test_most_of_a_turn_is_taken_along():
    knows = Dot()
    knows.begin()
    assert_allclose(knows.shifted(EYE, GOAL), GOAL)
    step = np.array([0.0, 0.05, 0.0])
    across = step - (step @ (GOAL - EYE)) * (GOAL - EYE) / ((GOAL - EYE) @ (GOAL - EYE))
    knows.turn(EYE, GOAL, step)
    assert_allclose(knows.shifted(EYE, GOAL), GOAL)  # the gesture that learnt it has it already
    knows.begin()
    assert_allclose(knows.shifted(EYE, GOAL) - GOAL, TAKEN_ALONG * across, atol=1e-9)
    knows.begin()
    assert_allclose(knows.shifted(EYE, GOAL) - GOAL, TAKEN_ALONG**2 * across, atol=1e-9)


# --- all together --------------------------------------------------------------------------------------------


def world(seed=3, laser=True, posture="straight"):
    dice = rng(seed)
    person = VirtualPerson(draw_person(dice, posture=posture), (0.45, -0.85), np.pi / 2, dice)
    bands = [VirtualBand("wrist", "forearm", draw_band(dice), dice)]
    places = np.array([[0.3, 0.3], [0.6, 0.3]])
    robots = VirtualRobots(("ash", "elm"), places, np.zeros(2), Sheet(0.9, 0.6), dice)
    script = Script([Trial(Target("robot:elm"), False)], patience=12.0)
    own = rng(seed + 100)
    beam = Beam(
        VirtualLaser(draw_laser(own, (0.0, 0.0, 0.035), (0.0, 0.15))),
        VirtualReceptors(("ash", "elm"), ReceptorTraits(stray=0.0), own),
    )
    return World(person, bands, robots, {}, script, dice, table_height=0.7, beam=beam if laser else None)


def spot_misses(shown):
    """How far [m] the dot is from elm's light, step by step, while elm is asked for."""
    shown.advance(0.5)
    shown.take(Say(0.5, "", "ready"))
    misses, events = [], []
    for k in range(11, 240):
        events += shown.advance(0.05 * k)
        if shown.script.phase is Phase.POINT:
            origin, direction = (part[0] for part in shown._beam.laser.rays(shown.person.pose(np.array([0.05 * k]))))
            goal = shown._light_of("elm")
            at = origin + (goal[2] - origin[2]) / direction[2] * direction
            misses.append(float(np.hypot(*(at - goal)[:2])))
    return np.array(misses), events


@pytest.mark.parametrize("posture", ["straight", "natural"])
@pytest.mark.parametrize("seed", [3, 4])
def test_the_person_brings_the_dot_onto_the_target(seed, posture):
    misses, events = spot_misses(world(seed, posture=posture))
    assert np.median(misses[35:40]) > 0.04  # the first reach goes beside
    assert np.median(misses[-80:]) < 0.02
    hits = [event for event in events if isinstance(event, Hit)]
    assert any(hit.robot == "elm" and hit.on for hit in hits)


def test_a_laser_changes_nothing_of_what_is_drawn_for_the_others():
    with_it, without = world(), world(laser=False)
    a, b = (shown.advance(3.0) for shown in (with_it, without))
    assert [event for event in a if not isinstance(event, Hit)] == b
