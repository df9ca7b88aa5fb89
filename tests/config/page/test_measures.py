import json
import tempfile

import numpy as np
import pytest

from armspan.body.measured import measure
from armspan.body.picture.image import Picture, read_image
from armspan.body.skeleton import Skeleton
from armspan.body.told import Told
from armspan.config import body_views
from armspan.config.demo_room import page_room
from armspan.config.house import open_house
from armspan.config.page import measures
from armspan.config.page.host import PageHost
from armspan.errors import ConfigError, DataError
from armspan.web.host import Portrait, Portraits
from filmed_person import SIZE, Person, film
from skeleton_files import openpose

TOLD = Told(height_m=1.75, sex="man")
FRONT = film(Person().t_pose())


def skeleton(*moves):
    """The JSON of one person several times, moved to the right [px]."""
    several = [openpose({name: (x + move, y, sure) for name, (x, y, sure) in FRONT.items()}) for move in moves]
    return json.dumps({"version": 1.3, "people": [one["people"][0] for one in several]}).encode()


def by_front(data, **wanted):
    return Portraits((Portrait("front", "holiday.json", data),), **wanted)


def test_typed_sizes_alone_are_measured_as_by_the_command():
    found = measures.measured(TOLD, Portraits())
    assert found.body == measure(TOLD).fused.body
    assert (found.notes, found.drawn) == ((), ())


def test_a_skeleton_file_narrows_the_measures_and_has_no_picture():
    found, typed = measures.measured(TOLD, by_front(skeleton(0.0))), measures.measured(TOLD, Portraits())
    assert found.body.covariance[12] < typed.body.covariance[12]
    assert found.drawn == ()
    assert found.notes


def test_complaints_name_the_uploaded_file_and_what_the_page_asks():
    with pytest.raises(DataError) as told:
        measures.measured(TOLD, by_front(skeleton(0.0, 700.0)))
    assert str(told.value).startswith("holiday.json shows 2 people")
    assert '"Which person"' in str(told.value)
    assert measures.measured(TOLD, by_front(skeleton(0.0, 700.0), person=1)).notes
    with pytest.raises(ConfigError, match="leave the marker sheet unticked"):
        measures.measured(TOLD, by_front(skeleton(0.0), marker=True))
    with pytest.raises(DataError, match=r"^holiday\.json is a text file"):
        measures.measured(TOLD, by_front(b"hello"))


def test_uploaded_files_are_gone_after_measuring_and_after_a_failure(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    measures.measured(TOLD, by_front(skeleton(0.0)))
    with pytest.raises(DataError):
        measures.measured(TOLD, by_front(b"hello"))
    assert list(tmp_path.iterdir()) == []


def test_a_picture_comes_back_with_its_points_drawn_in(monkeypatch):
    pytest.importorskip("cv2", reason="OpenCV is not installed: pip install opencv-python-headless")
    blank = Picture(np.full((SIZE[1], SIZE[0], 3), 200, np.uint8))
    monkeypatch.setattr(body_views, "read_image", lambda data, where: blank)
    monkeypatch.setattr(body_views, "find_people", lambda pixels, weights: [Skeleton(FRONT, SIZE, "a network")])
    found = measures.measured(TOLD, by_front(b"\xff\xd8..."))
    [(side, png)] = found.drawn
    drawn = read_image(png, "drawn").pixels
    assert side == "front"
    assert (drawn != 200).any()


def test_what_is_missing_for_pictures_is_said(tmp_path, monkeypatch):
    monkeypatch.setenv("ARMSPAN_WEIGHTS", str(tmp_path))
    monkeypatch.setattr(measures, "find_spec", lambda name: object())
    assert "armspan body --set-up" in measures.lacks()
    monkeypatch.setattr(measures, "find_spec", lambda name: None)
    assert "armspan[picture]" in measures.lacks()
    monkeypatch.setattr(measures, "find_spec", lambda name: object())
    monkeypatch.setattr(measures, "missing_weights", lambda folder: [])
    assert measures.lacks() == ""


def test_measures_are_kept_for_the_next_opening_to_a_tenth_of_a_millimetre(tmp_path):
    body = measures.measured(TOLD, Portraits()).body
    host = PageHost(page_room(1), "small", folder=tmp_path, sessions=tmp_path / "sessions")
    host.keep_body(body)
    kept = open_house(host.room).settings.body
    assert kept.eye_height_m == pytest.approx(body.eye_height_m, abs=6e-5)
    assert kept.covariance == pytest.approx(body.covariance, abs=1e-8)
    assert kept.arm == body.arm
