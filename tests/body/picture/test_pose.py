import os
import sys

import numpy as np
import pytest

from armspan.body.picture.bodies import share, silhouette
from armspan.body.picture.landmarks import Points
from armspan.body.picture.networks import BODY, DETECTOR, HAND, open_networks
from armspan.body.picture.pose import find_people, keypoint, named
from armspan.config.weights import missing_weights, weights_folder
from armspan.errors import DeviceError, MissingExtra
from body.picture.drawn_people import drawn_person, wall_and_floor


@pytest.fixture(scope="module")
def weights():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    pytest.importorskip("ai_edge_litert", reason="needs ai-edge-litert")
    folder = weights_folder()
    if missing_weights(folder):
        pytest.skip(f"the networks' weights are not in {folder}: `armspan body --set-up` fetches them")
    return folder


def standing(size: float = 100.0) -> Points:
    """33 points of somebody a few of ``size`` pixels tall; numbers as in the network's publication."""
    places = np.zeros((33, 2))
    places[:11] = 0, -1
    places[[11, 12, 13, 14, 15, 16]] = [[0.3, 0], [-0.3, 0], [0.8, 0], [-0.8, 0], [1.2, 0], [-1.2, 0]]
    places[17:23] = [[1.4, 0], [-1.4, 0]] * 3
    places[23:33] = [[0.2, 1], [-0.2, 1], [0.2, 2], [-0.2, 2]] + [[0.2, 3], [-0.2, 3]] * 3
    return Points(300 + size * places, np.linspace(0.5, 0.98, 33), 0.9)


def test_a_bodys_points_have_the_persons_own_sides():
    points = named(standing())
    assert points["lsh"][:2] == pytest.approx((330, 300))  # facing us: their left is our right
    assert points["rwr"][:2] == pytest.approx((180, 300))
    assert points["leye"][2] == pytest.approx(0.5 + 2 * 0.015)
    assert points["rtoe"][2] == pytest.approx(0.98)
    assert len(points) == 23


def test_a_fingertip_is_no_surer_than_its_wrist():
    assert keypoint(standing(), 32, 0.4) == (pytest.approx(280), pytest.approx(600), 0.4)


def test_a_body_found_again_lies_on_its_own_silhouette():
    pytest.importorskip("cv2", reason="needs opencv-python-headless")
    body = standing()
    mask = silhouette(body, (700, 900))
    assert share(body, mask) == 1
    away = Points(body.places + np.array([400, 0]), body.confidences, 0.9)
    assert share(away, mask) < 0.2
    outside = Points(body.places + np.array([4000, 0]), body.confidences, 0.9)
    assert share(outside, mask) == 0


def test_a_picture_without_weights_is_one_sentence(tmp_path):
    pytest.importorskip("ai_edge_litert", reason="needs ai-edge-litert")
    with pytest.raises(DeviceError, match=r"pose_detection.tflite is not there.*`armspan body --set-up`"):
        find_people(wall_and_floor(), tmp_path)


def test_weights_that_are_none_are_one_sentence(tmp_path):
    pytest.importorskip("ai_edge_litert", reason="needs ai-edge-litert")
    for name in (DETECTOR, BODY, HAND):
        (tmp_path / name).write_bytes(b"no network" * 100)
    with pytest.raises(DeviceError, match="no network that LiteRT can read"):
        open_networks(tmp_path)


def test_a_network_under_anothers_name_is_one_sentence(weights, tmp_path):
    for name, other in ((DETECTOR, DETECTOR), (BODY, HAND), (HAND, BODY)):
        (tmp_path / name).write_bytes((weights / other).read_bytes())
    with pytest.raises(DeviceError, match=r"landmark_full.tflite is another network than its name says"):
        open_networks(tmp_path)


def test_opening_the_networks_says_nothing(weights, monkeypatch, capfd):
    import ai_edge_litert.interpreter as litert

    class Talkative(litert.Interpreter):  # the library itself talks once in a process
        def allocate_tensors(self):
            os.write(2, b"INFO: Created a delegate.\n")
            super().allocate_tensors()

    monkeypatch.setattr(litert, "Interpreter", Talkative)
    open_networks(weights)
    assert capfd.readouterr() == ("", "")


def test_a_missing_package_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "ai_edge_litert.interpreter", None)
    with pytest.raises(MissingExtra, match=r"ai-edge-litert is not installed: pip install 'armspan\[picture\]'"):
        open_networks(tmp_path)


def test_nobody_in_the_picture(weights):
    assert find_people(wall_and_floor(), weights) == []


@pytest.mark.parametrize("turned", [0, 1, 2])
def test_a_person_in_the_picture(weights, turned):
    image = wall_and_floor()
    joints = drawn_person(image, 320)
    (person,) = find_people(np.ascontiguousarray(np.rot90(image, turned)), weights)
    assert person.size == (640, 640)
    assert person.score > 0.9
    for name, (right, down) in joints.items():
        for _ in range(turned):
            right, down = down, 640 - right
        found = person.points[name]
        assert found[2] > 0.5, name
        assert np.hypot(found[0] - right, found[1] - down) < 14, name  # a thirtieth of the body: it is a drawing


def test_a_photographs_size_makes_no_difference(weights):
    image = wall_and_floor()
    drawn_person(image, 320)
    (small,) = find_people(image, weights)
    (large,) = find_people(image.repeat(5, axis=0).repeat(5, axis=1), weights)
    assert large.size == (3200, 3200)
    for name in ("leye", "rsh", "lel", "rwr", "lhip", "ran"):
        assert np.array(large.points[name][:2]) / 5 == pytest.approx(np.array(small.points[name][:2]), abs=2.5)


def test_two_people_in_the_picture(weights):
    image = wall_and_floor(1000)
    drawn_person(image, 270)
    drawn_person(image, 740, top=140, tall=400)
    people = find_people(image, weights)
    assert sorted(round(person.points["nose"][0], -1) for person in people) == [270, 740]
