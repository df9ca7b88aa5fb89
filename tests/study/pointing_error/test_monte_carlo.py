import json

import numpy as np
import pytest

from armspan.errors import ConfigError
from armspan.frames import yaw_rotation
from armspan.pointing.calibration import calibrate
from armspan.pointing.pairs import moving_pairs
from armspan.study.pointing_error.monte_carlo import (
    BELIEVED,
    FEWEST,
    FLOOR,
    TABLE,
    TARGETS,
    Task,
    all_but,
    believed_rays,
    chunk_errors,
    chunks,
    run,
    stop_shares,
)
from armspan.study.pointing_error.sources import NAMES, SOURCES, Wrongs, draw_wrongs
from straight_arms import pointing_at, with_x

LAYOUTS = (TABLE, FLOOR)


def nothing_wrong(gestures):
    return Wrongs(
        aim=np.zeros((1, gestures, 2)),
        elbow=np.zeros((1, gestures, 2)),
        yaw=np.zeros((1, gestures)),
        pitch=np.zeros((1, gestures)),
        sway=np.zeros((1, gestures, 3)),
        body=np.zeros((1, 5)),
        light=np.zeros(1),
    )


def with_one(field, value, gestures=5):
    wrongs = nothing_wrong(gestures)
    getattr(wrongs, field)[:] = value
    return wrongs


def rays(wrongs, layout=TABLE):
    places = layout.places(stop_shares(5))
    origins, directions = believed_rays(BELIEVED, wrongs, places[None])
    return places, origins[0], directions[0]


def angle(one, other):
    return np.arctan2(np.linalg.norm(np.cross(one, other), axis=-1), (one * other).sum(axis=-1))


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_layout_is_a_square_before_the_user(layout):
    corners = layout.places(stop_shares(4))
    assert corners[:, 2] == pytest.approx(layout.height)
    assert corners.mean(axis=0)[:2] == pytest.approx([layout.distance, 0.0])
    assert np.linalg.norm(np.diff(corners, axis=0), axis=1) == pytest.approx(layout.side)


@pytest.mark.parametrize("count", [3, 4, 5, 8, 9, 16, 25])
def test_stops_are_as_many_as_asked_for_and_span_the_sheet(count):
    shares = stop_shares(count)
    assert len({tuple(share) for share in shares.round(6).tolist()}) == count
    assert np.abs(shares).max() == 1.0
    assert shares.max(axis=0) == pytest.approx([1.0, 1.0])
    assert shares.min(axis=0) == pytest.approx([-1.0, -1.0])


def test_eight_stops_leave_out_the_middle_and_five_have_it():
    assert (np.abs(stop_shares(8)).max(axis=1) == 1.0).all()
    assert (stop_shares(5) == 0.0).all(axis=1).sum() == 1


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_flawless_arm_points_where_it_should(layout):
    assert chunk_errors(Task(layout, 0, 0, 50, sources=())).max() < 1e-9


def test_a_flawless_ray_runs_through_its_place():
    places, origins, directions = rays(nothing_wrong(5))
    assert angle(directions, places - origins).max() < 1e-12


def test_an_aim_that_is_off_turns_the_ray_by_as_much():
    places, origins, directions = rays(with_one("aim", np.radians([3.0, 4.0])))
    assert np.degrees(angle(directions, places - origins)) == pytest.approx(5.0, abs=0.02)
    level = np.arctan2(directions[:, 1], directions[:, 0]) - np.arctan2(places[:, 1], places[:, 0])
    assert (level > 0).all()  # to the left


def test_a_body_that_sways_carries_its_rays_along():
    places, origins, directions = rays(with_one("sway", [0.05, 0.02, 0.0]))
    eye = origins + np.array([0.05, 0.02, 0.0])
    assert angle(directions, places - eye).max() < 1e-12


def test_wrong_measures_make_the_rays_that_the_wrong_measures_make():
    """Worked out with `straight_arms`: the true arm's attitude, read with the believed sizes."""
    off = np.array([0.03, -0.02, 0.01, 0.025, -0.04])
    places, _, directions = rays(with_one("body", off))
    true = type(BELIEVED)(
        BELIEVED.eye_height_m + off[0],
        tuple(np.array(BELIEVED.shoulder_to_eye_m) + off[1:4]),
        BELIEVED.shoulder_to_fingertip_m + off[4],
    )
    forearm = pointing_at(places, true)[:, :, 0]
    seen = BELIEVED.shoulder_to_fingertip_m * forearm - np.array(BELIEVED.shoulder_to_eye_m)
    assert angle(directions, seen).max() < 1e-9


def test_a_band_that_is_off_turns_the_arm_it_reads():
    wrongs = with_one("yaw", 0.1)
    wrongs.pitch[:] = -0.05
    places, _, directions = rays(wrongs)
    arm = pointing_at(places, BELIEVED)[:, :, 0] @ yaw_rotation(0.1).T
    up = np.arctan2(arm[:, 2], np.hypot(arm[:, 0], arm[:, 1])) - 0.05
    level = arm[:, :2] / np.linalg.norm(arm[:, :2], axis=1, keepdims=True) * np.cos(up)[:, None]
    read = np.column_stack([level, np.sin(up)])
    seen = BELIEVED.shoulder_to_fingertip_m * read - np.array(BELIEVED.shoulder_to_eye_m)
    assert angle(directions, seen).max() < 1e-9


def test_the_errors_are_those_of_the_single_calibration():
    task = Task(FLOOR, 5, 0, 6)
    rng = np.random.default_rng([5, 0])
    wrongs = draw_wrongs(rng, 6, 4, TARGETS)
    shares = rng.uniform(-1.0, 1.0, (6, TARGETS, 2))
    found = chunk_errors(task)
    for number in range(6):
        told = FLOOR.places(np.concatenate([stop_shares(4), shares[number]]))
        true = told + np.where(np.arange(len(told)) < 4, wrongs.light[number], 0.0)[:, None] * [0.0, 0.0, 1.0]
        own = Wrongs(**{name: getattr(wrongs, name)[number : number + 1] for name in Wrongs.__dataclass_fields__})
        _, directions = believed_rays(BELIEVED, own, true[None])
        attitudes = with_x(straight_arm_of(directions[0]))
        pairs = moving_pairs(attitudes[:4], None, told[:4], np.arange(4.0))
        fit = calibrate(BELIEVED, pairs, "head-finger", z_up=True)
        origin, ray = fit.rays(attitudes[4:])
        eye, ahead = fit.transform().points(origin), fit.transform().directions(ray)
        hits = eye - ahead * (eye[:, 2:] / ahead[:, 2:])
        assert np.linalg.norm(hits - told[4:], axis=1) == pytest.approx(found[number], abs=1e-6)


def straight_arm_of(directions):
    """The arm's directions (n, 3) that make these rays."""
    b = directions @ np.array(BELIEVED.shoulder_to_eye_m)
    offset = np.array(BELIEVED.shoulder_to_eye_m)
    reach = -b + np.sqrt(b**2 - offset @ offset + BELIEVED.shoulder_to_fingertip_m**2)
    return (offset + reach[:, None] * directions) / BELIEVED.shoulder_to_fingertip_m


def test_a_drifting_heading_turns_the_spots_round_the_user():
    """2 deg/min; the stops' middle lies at 12 s, use at 32 to 92 s: root mean square 52.9 s.

    The arm turns about the shoulder, which lies behind the eye: the ray turns by more than the arm does.
    """
    errors = chunk_errors(Task(TABLE, 1, 0, 4000, sources=("band: drift",)))
    side = TABLE.side / 2.0
    away = np.sqrt(TABLE.distance**2 + 2.0 * side**2 / 3.0)
    middle = TABLE.places(np.zeros((1, 2)))
    fingers = [
        BELIEVED.shoulder_to_fingertip_m * pointing_at(middle, BELIEVED)[0, :, 0] @ yaw_rotation(turn).T
        - np.array(BELIEVED.shoulder_to_eye_m)
        for turn in (-0.01, 0.01)
    ]
    more = (np.arctan2(fingers[1][1], fingers[1][0]) - np.arctan2(fingers[0][1], fingers[0][0])) / 0.02
    assert 1.1 < more < 1.5
    expected = more * np.radians(2.0) * 52.9 / 60.0 * away
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(expected, rel=0.1)


def test_what_is_constant_is_absorbed_and_what_is_not_stays():
    for absorbed in ("aim: bias", "band: heading", "elbow: bias"):
        errors = chunk_errors(Task(TABLE, 0, 0, 500, sources=(absorbed,)))
        assert np.median(errors) < 0.005, absorbed
    stays = chunk_errors(Task(TABLE, 0, 0, 500, sources=("aim: gesture",)))
    sight = np.hypot(TABLE.distance, BELIEVED.eye_height_m - TABLE.height)
    assert np.median(stays) > np.radians(0.65) * sight  # more than one gesture's own noise


def test_a_source_that_is_left_out_changes_no_other_dice():
    everything = draw_wrongs(np.random.default_rng(3), 10, 4, 8)
    without = draw_wrongs(np.random.default_rng(3), 10, 4, 8, all_but("sway"))
    assert (without.sway == 0.0).all()
    assert (everything.sway != 0.0).all()
    for field in ("aim", "elbow", "yaw", "pitch", "body", "light"):
        assert np.array_equal(getattr(everything, field), getattr(without, field)), field


def test_sources_have_the_sizes_they_tell():
    wrongs = draw_wrongs(np.random.default_rng(0), 20_000, 4, 4)
    spread = np.degrees(wrongs.aim[:, 5].std(axis=0))
    assert spread == pytest.approx(
        [np.sqrt(2.0**2 + 0.7**2 + 0.65**2 + 0.45**2), np.sqrt(1.3**2 + 0.7**2 + 0.65**2 + 0.16**2)], rel=0.03
    )
    assert wrongs.sway[:, 0].std(axis=0) == pytest.approx([0.017, 0.014, 0.006], rel=0.03)
    assert 1000 * wrongs.body.std(axis=0) == pytest.approx([9.6, 22.0, 7.8, 23.3, 28.7], rel=0.03)
    assert np.degrees(wrongs.elbow[:, 5].mean(axis=0)) == pytest.approx([2.5, -0.8], abs=0.05)


def test_five_gestures_at_a_stop_average_what_is_drawn_for_each():
    several = draw_wrongs(np.random.default_rng(0), 4000, 4, 4, ("aim: gesture",), gestures=5)
    assert np.degrees(several.aim[:, :4].std()) == pytest.approx(0.65 / np.sqrt(5.0), rel=0.05)
    assert np.degrees(several.aim[:, 4:].std()) == pytest.approx(0.65, rel=0.05)


def test_an_unknown_source_is_refused():
    with pytest.raises(ConfigError, match=r"'swey' does not exist.*Did you mean 'sway'"):
        draw_wrongs(np.random.default_rng(0), 1, 4, 1, ("swey",))


def test_chunks_hold_all_set_ups_with_dice_of_their_own():
    tasks = chunks(TABLE, 6001, 7)
    assert sum(task.count for task in tasks) == 6001
    assert len({(task.seed, task.number) for task in tasks}) == len(tasks)


def test_the_result_does_not_depend_on_who_computes_it():
    def backwards(function, tasks):
        return [function(task) for task in list(tasks)[::-1]][::-1]

    one, other = run(TABLE, 60, 1), run(TABLE, 60, 1, mapper=backwards)
    assert np.array_equal(one.errors, other.errors)
    assert one.budget == other.budget
    assert not np.array_equal(one.errors, run(TABLE, 60, 2).errors)


def test_the_account_is_whole():
    told = []
    found = run(TABLE, 100, 0, progress=lambda done, total: told.append((done, total)))
    assert len(found.errors) == 100 * TARGETS
    assert told[-1][0] == told[-1][1] == 100 + 2 * len(NAMES) * FEWEST
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    document = json.loads(json.dumps(found.document()))
    assert document["median_mm"] == pytest.approx(1000 * np.median(found.errors))
    assert document["median_mm"] < document["p90_mm"] < document["p99_mm"]
    assert [part["source"] for part in document["budget"]] == [source.name for source in SOURCES]
    assert sum(part["share"] for part in document["budget"]) == pytest.approx(1.0)
