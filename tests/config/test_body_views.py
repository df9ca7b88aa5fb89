import json

import numpy as np
import pytest

from armspan.body.anthropometry import prior
from armspan.body.measured import measure
from armspan.body.picture.image import Picture, read_image
from armspan.body.skeleton_formats import read_skeletons
from armspan.body.told import Told
from armspan.config import body_views
from armspan.config.body_views import View, Wanted, check_free, read_view
from armspan.errors import ConfigError, DataError
from filmed_person import SIZE, Person, film
from skeleton_files import mediapipe_tasks, openpifpaf, openpose

MAN = Told(height_m=1.75, sex="man")
FRONT, SIDE = film(Person().t_pose()), film(Person().pointing(), "right")
PNG = b"\x89PNG..."


def wanted(tmp_path, **options):
    return Wanted(tmp_path / "weights", **options)


def skeleton_file(tmp_path, document, name="front.json", before=""):
    path = tmp_path / name
    path.write_text(before + json.dumps(document), encoding="utf-8")
    return path


def people(*moves):
    """One person several times, moved to the right [px]."""
    several = [openpose({name: (x + move, y, sure) for name, (x, y, sure) in FRONT.items()}) for move in moves]
    return {"version": 1.3, "people": [one["people"][0] for one in several]}


# --- skeleton files -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("before", ["", "\n  \t", "\ufeff"])  # the last is what editors on Windows write
def test_a_skeleton_file_is_told_by_its_first_sign(before, tmp_path):
    path = skeleton_file(tmp_path, openpose(FRONT), before=before)
    view = read_view(path, "front", wanted(tmp_path))
    assert (view.path, view.side, view.picture, view.marker) == (path, "front", None, None)
    assert view.skeleton.source == "front.json"
    assert view.skeleton.points["rwr"] == pytest.approx(FRONT["rwr"])


def test_shares_of_a_picture_need_its_size(tmp_path):
    path = skeleton_file(tmp_path, mediapipe_tasks(FRONT, SIZE))
    view = read_view(path, "front", wanted(tmp_path, size=SIZE))
    assert view.skeleton.points["rwr"][:2] == pytest.approx(FRONT["rwr"][:2])
    with pytest.raises(DataError, match="size"):
        read_view(path, "front", wanted(tmp_path))


def test_people_are_numbered_from_the_left(tmp_path):
    path = skeleton_file(tmp_path, people(0.0, -600.0, 700.0))
    lefts = [read_view(path, "front", wanted(tmp_path, person=n)).skeleton.points["nose"][0] for n in (1, 2, 3)]
    assert np.diff(lefts) == pytest.approx([600.0, 700.0])
    with pytest.raises(DataError, match=r"front\.json shows 3 people: choose one with --person, from 1 on the left"):
        read_view(path, "front", wanted(tmp_path))


@pytest.mark.parametrize("number", [0, -1, 4])
def test_a_person_who_does_not_exist(number, tmp_path):
    path = skeleton_file(tmp_path, people(0.0, -600.0, 700.0))
    with pytest.raises(ConfigError, match=rf"--person {number} does not exist: \S+ shows 3, numbered from the left"):
        read_view(path, "front", wanted(tmp_path, person=number))


def test_a_skeleton_file_shows_no_marker(tmp_path):
    with pytest.raises(ConfigError, match="no marker can be seen: leave --marker out"):
        read_view(skeleton_file(tmp_path, openpose(FRONT)), "front", wanted(tmp_path, marker=True))


def test_what_cannot_be_read(tmp_path):
    (tmp_path / "half.json").write_text('[{"keypoints": [1,')
    (tmp_path / "deep.json").write_text("[" * 100_000)
    (tmp_path / "latin.json").write_bytes(b'{"name": "M\xfcller"}')
    for name, words in (
        ("none.jpg", r"none\.jpg does not exist: name a picture, or a skeleton file"),
        ("", r"cannot be read \(.+\): name a picture, or a skeleton file"),
        ("half.json", r"half\.json begins like JSON but is none"),
        ("deep.json", r"deep\.json begins like JSON but is none"),
        ("latin.json", r"latin\.json begins like JSON but is none"),
    ):
        with pytest.raises(DataError, match=words):
            read_view(tmp_path / name, "front", wanted(tmp_path))


# --- pictures -----------------------------------------------------------------------------------------------


@pytest.fixture
def picture(tmp_path, monkeypatch):
    """A file that is taken for a grey picture of `SIZE`."""
    pytest.importorskip("cv2", reason="pictures are written by OpenCV (extra 'picture')")
    shown = Picture(np.full((SIZE[1], SIZE[0], 3), 90, np.uint8), 1800.0)
    monkeypatch.setattr(body_views, "read_image", lambda data, where: shown)
    path = tmp_path / "front.png"
    path.write_bytes(PNG)
    return path


def by_another_program(path, upright):
    return openpifpaf(FRONT)


def test_a_picture_is_searched_by_the_networks(picture, tmp_path, monkeypatch):
    asked = []

    def find_people(pixels, weights):
        asked.append((pixels.shape, weights))
        return read_skeletons(openpifpaf(FRONT), "networks", size=SIZE)

    monkeypatch.setattr(body_views, "find_people", find_people)
    view = read_view(picture, "front", wanted(tmp_path))
    assert asked == [((SIZE[1], SIZE[0], 3), tmp_path / "weights")]
    assert view.skeleton.source == "front.png"
    assert view.picture.focal_px == 1800.0
    monkeypatch.setattr(body_views, "find_people", lambda pixels, weights: [])
    with pytest.raises(DataError, match=r"front\.png shows nobody who can be made out: stand wholly in the picture"):
        read_view(picture, "front", wanted(tmp_path))


def test_another_program_that_answers_something_else(picture, tmp_path):
    with pytest.raises(DataError, match="openpifpaf's answer to"):
        read_view(picture, "front", wanted(tmp_path, backend=lambda path, upright: {"hello": 1}))


def test_another_backend_gets_the_picture_upright(tmp_path):
    cv2 = pytest.importorskip("cv2", reason="pictures are read by OpenCV (extra 'picture')")
    lying = np.zeros((300, 400, 3), np.uint8)
    lying[:, :200] = 255
    jpeg = cv2.imencode(".jpg", lying)[1].tobytes()
    # EXIF's orientation 6: what is left in the file is the picture's top
    tiff = b"MM\x00*\x00\x00\x00\x08\x00\x01\x01\x12\x00\x03\x00\x00\x00\x01\x00\x06\x00\x00\x00\x00\x00\x00"
    exif = b"\xff\xe1" + (len(tiff) + 8).to_bytes(2, "big") + b"Exif\x00\x00" + tiff
    path = tmp_path / "me.jpg"
    path.write_bytes(jpeg[:2] + exif + jpeg[2:])
    given = []

    def backend(file, png):
        assert file == path
        given.append(read_image(png, "given"))
        return openpifpaf({name: (x / 8, y / 8, sure) for name, (x, y, sure) in film(Person().t_pose()).items()})

    view = read_view(path, "front", Wanted(tmp_path, backend=backend))
    assert given[0].size == view.skeleton.size == (300, 400)
    assert given[0].pixels[:190].min() > 240
    assert given[0].pixels[210:].max() < 15


def test_a_marker_is_searched_only_where_asked(picture, tmp_path, monkeypatch):
    monkeypatch.setattr(body_views, "find_marker", lambda pixels, where: ("marker in", where))
    options = {"backend": by_another_program}
    assert read_view(picture, "front", wanted(tmp_path, **options)).marker is None
    assert read_view(picture, "front", wanted(tmp_path, **options, marker=True)).marker == ("marker in", str(picture))


# --- measuring and keeping ----------------------------------------------------------------------------------


def test_views_measure_a_known_person(tmp_path):
    known, truth = prior(MAN), Person().measures()
    for side, points, told in (("front", FRONT, {"left", "up", "arm length"}), ("side", SIDE, {"forward", "up"})):
        view = read_view(skeleton_file(tmp_path, openpose(points), f"{side}.json"), side, wanted(tmp_path))
        seen = {each.measure: each for each in view.measured(known).observations}
        assert told <= set(seen)
        for name, each in seen.items():
            assert abs(each.value - truth[name]) < 2.0 * each.sd, name
            assert each.source == f"{side} picture, {side}.json"


def test_a_picture_of_known_focal_length_tells_its_distance(picture, tmp_path):
    view = read_view(picture, "front", wanted(tmp_path, backend=by_another_program))
    bare = View(view.path, "front", view.skeleton)
    with_focal, without = (" ".join(each.measured(prior(MAN)).notes) for each in (view, bare))
    assert with_focal != without


def test_a_person_in_another_pose_is_told_with_the_file(tmp_path):
    path = skeleton_file(tmp_path, openpose(SIDE), "wrong.json")
    with pytest.raises(DataError, match=r"wrong\.json: .+front picture"):
        read_view(path, "front", wanted(tmp_path)).measured(prior(MAN))


def test_what_is_told_of_one_view_is_not_told_of_the_other(tmp_path):
    unsure = {"ridxtip": (900.0, 700.0, 0.1)}
    for side, pixels in (("front", film(Person().t_pose())), ("side", film(Person().pointing(), "right") | unsure)):
        (tmp_path / f"{side}.json").write_text(json.dumps(openpose(pixels)))
    views = [read_view(tmp_path / f"{side}.json", side, Wanted(tmp_path)) for side in ("front", "side")]
    found = measure(Told(height_m=1.75, sex="man"), [view.measured for view in views])
    front, side = (" ".join(seen.notes) for seen in found.seen)
    assert "ridxtip" in side
    assert "ridxtip" not in front
    assert set(found.notes) == {note for seen in found.seen for note in seen.notes}
    assert len(set(found.notes)) == len(found.notes)


def test_points_that_are_kept_can_be_read_again(tmp_path):
    view = read_view(skeleton_file(tmp_path, openpose(FRONT)), "front", wanted(tmp_path))
    folder = tmp_path / "deep" / "kept"
    assert view.keep(folder, view.measured(prior(MAN)), "right") == [folder / "front.json"]
    assert (folder / "front.json").read_text().count("\n") > 10  # for an editor
    again = read_view(folder / "front.json", "front", wanted(tmp_path))
    assert again.skeleton == view.skeleton


def test_a_picture_is_kept_with_the_points_drawn_in(picture, tmp_path):
    view = read_view(picture, "front", wanted(tmp_path, backend=by_another_program))
    folder = tmp_path / "kept"
    kept = view.keep(folder, view.measured(prior(MAN)), "right")
    assert kept == [folder / "front.json", folder / "front.png"]
    assert kept[1].read_bytes().startswith(b"\x89PNG\r\n")
    assert picture.read_bytes() == PNG


def test_kept_points_replace_nothing(tmp_path):
    check_free(tmp_path / "not there yet", ["front", "side"])
    for name in ("side.json", "side.png"):
        (tmp_path / name).write_text("mine")
        check_free(tmp_path, ["front"])
        with pytest.raises(ConfigError, match=rf"{name} exists and is kept: name another folder with --keep"):
            check_free(tmp_path, ["front", "side"])
        (tmp_path / name).unlink()


def test_points_are_kept_in_a_folder_only(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(ConfigError, match=r"file is a file, not a folder: name a folder with --keep"):
        check_free(tmp_path / "file", ["front"])
    view = read_view(skeleton_file(tmp_path, openpose(FRONT)), "front", wanted(tmp_path))
    with pytest.raises(ConfigError, match=r"cannot be written \(.+\): name another folder with --keep"):
        view.keep(tmp_path / "file", view.measured(prior(MAN)), "right")
    assert (tmp_path / "file").read_text() == "mine"
