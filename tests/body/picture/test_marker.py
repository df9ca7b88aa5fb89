"""A pinhole camera, a floor with the printed sheet and a person behind it, drawn here from their own geometry."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from armspan.body.marker_sheet import MARKER_ID, marker_png
from armspan.body.picture.marker import Marker, find_marker, marker_scale
from armspan.body.scale import ANKLE_HEIGHT
from armspan.body.skeleton import Skeleton
from armspan.errors import DataError

cv2 = pytest.importorskip("cv2", reason="the marker is found by OpenCV (extra 'picture')")

SIZE = (1512, 2016)
EYE, UP, ARM = 1.640, 0.220, 0.740
BODY = {  # right in the picture and up [m]
    "leye": (0.03, EYE),
    "reye": (-0.03, EYE),
    "nose": (0.0, EYE - 0.04),
    "lsh": (0.18, EYE - UP),
    "rsh": (-0.18, EYE - UP),
    "lidxtip": (0.18 + ARM, EYE - UP),
    "ridxtip": (-0.18 - ARM, EYE - UP),
    "lan": (0.1, ANKLE_HEIGHT),
    "ran": (-0.1, ANKLE_HEIGHT),
}


def turn(axis, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


@pytest.fixture(scope="module")
def printed():
    """The sheet at 10 pixels a millimetre."""
    return cv2.imdecode(np.frombuffer(marker_png(dpi=254.0), np.uint8), cv2.IMREAD_GRAYSCALE)


@dataclass
class Scene:
    """The world has x to the right, y away from the camera, z up, and the camera at height ``high`` above 0, 0."""

    size: tuple[int, int] = SIZE
    focal_mm: float = 27.0
    high: float = 1.3
    distance: float = 3.0
    pitch: float = 8.0
    roll: float = 0.0
    yaw: float = 0.0
    sheet_turn: float = 0.0
    sheet_lean: float = 0.0
    aside: float = 0.0
    focal: float = field(init=False)

    def __post_init__(self):
        self.focal = self.focal_mm * max(self.size) / 34.61

    @classmethod
    def drawn(cls, rng, size=SIZE, **fixed):
        high, distance = rng.uniform(1.0, 1.5), rng.uniform(2.6, 3.4)
        pitch = np.degrees(np.arctan2(high - 0.85, distance)) + rng.uniform(-2, 2)
        roll, yaw, sheet_turn = rng.uniform(-3, 3), rng.uniform(-3, 3), rng.uniform(-25, 25)
        aside = rng.uniform(-0.1, 0.1)
        drawn = {
            "aside": aside,
            "high": high,
            "distance": distance,
            "pitch": pitch,
            "roll": roll,
            "yaw": yaw,
            "sheet_turn": sheet_turn,
        }
        return cls(size, **(drawn | fixed))

    def pixels(self, points):
        camera = turn(2, self.roll) @ turn(0, self.pitch) @ turn(1, self.yaw) @ [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
        seen = (np.asarray(points, float) - [0, 0, self.high]) @ camera.T
        return seen[..., :2] / seen[..., 2:] * self.focal + (np.array(self.size) - 1) / 2

    def skeleton(self, before=0.0, ankle=0.0, points=BODY):
        """The person facing the camera, eyes, shoulders and hands ``before`` the ankles [m]."""
        placed = {}
        for name, (right, up) in points.items():
            foot = name in ("lan", "ran")
            place = [self.aside + right, self.distance - (0.0 if foot else before), up + (ankle if foot else 0.0)]
            placed[name] = (*map(float, self.pixels(place)), 1.0)
        return Skeleton(points=placed, size=self.size, source="drawn")

    def on_sheet(self, mm):
        """World of points on the page, (n, 2) mm right and down from its middle, half a metre before the toes."""
        flat = np.column_stack([mm[:, 0], -mm[:, 1], np.zeros(len(mm))]) / 1e3
        return flat @ (turn(2, self.sheet_turn) @ turn(0, self.sheet_lean)).T + [self.aside, self.distance - 0.75, 0.0]

    def corners(self):
        """The marker's corners as they truly are: 85 mm about a point 43.5 mm above the page's middle [px]."""
        return self.pixels(self.on_sheet(np.array([[-85, -128.5], [85, -128.5], [85, 41.5], [-85, 41.5]])))

    def picture(self, printed, rng, blur=0.8, noise=4.0):
        """A photograph: blurred in light, then through the tone curve, with noise."""
        height, width = printed.shape
        rim = np.array([[-0.5, -0.5], [width - 0.5, -0.5], [width - 0.5, height - 0.5], [-0.5, height - 0.5]])
        seen = self.pixels(self.on_sheet(np.array([[-105, -148.5], [105, -148.5], [105, 148.5], [-105, 148.5]])))
        start, end = np.floor(seen.min(axis=0)).astype(int) - 20, np.ceil(seen.max(axis=0)).astype(int) + 20
        fine = 6
        to = ((seen - start + 0.5) * fine - 0.5).astype(np.float32)
        warp = cv2.getPerspectiveTransform(rim.astype(np.float32), to)
        ink = printed.astype(np.float32) * 0.8 + 20
        patch = cv2.warpPerspective(ink, warp, tuple((end - start) * fine), borderValue=110.0)
        patch = cv2.resize(patch, tuple(end - start), interpolation=cv2.INTER_AREA)
        light = np.full((self.size[1], self.size[0]), 110.0, np.float32)
        light[start[1] : end[1], start[0] : end[0]] = patch
        light = cv2.GaussianBlur((light / 255) ** 2.2, (0, 0), blur)
        levels = 255 * light ** (1 / 2.2) + rng.normal(0, noise, light.shape)
        return np.repeat(np.clip(levels, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def measured(scale, skeleton):
    """Eye height, eye above shoulder, arm length (mean of both), less the truth [m]."""
    at = dict(zip(skeleton.points, scale.place(np.array([p[:2] for p in skeleton.points.values()])), strict=True))
    arms = [np.linalg.norm(at[side + "idxtip"] - at[side + "sh"]) for side in "lr"]
    return np.array([at["leye"][1] - EYE, at["leye"][1] - at["lsh"][1] - UP, np.mean(arms) - ARM])


def seen_in(scene, printed, rng, focal_share=1.0, **body):
    marker = find_marker(scene.picture(printed, rng), "front.jpg")
    skeleton = scene.skeleton(**body)
    return measured(marker_scale(marker, skeleton, scene.size, focal_share * scene.focal), skeleton)


# --- geometry alone ---------------------------------------------------------------------------------------


def test_exact_corners_give_exact_places():
    rng = np.random.default_rng(0)
    for _ in range(20):
        scene = Scene.drawn(rng, aside=0.0)
        skeleton = scene.skeleton()
        scale = marker_scale(Marker(scene.corners(), MARKER_ID), skeleton, SIZE, scene.focal)
        places = scale.place(np.array([point[:2] for point in skeleton.points.values()]))
        assert places == pytest.approx(np.array(list(BODY.values())), abs=2e-4)
        assert scale.camera_height == pytest.approx(scene.high, abs=1e-3)
        assert scale.distance == pytest.approx(scene.distance, abs=1e-3)
        assert scale.notes == ()


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_picture_on_its_side_gives_the_same(quarters):
    scene = Scene(roll=2.0, sheet_turn=10.0)
    expected = marker_scale(Marker(scene.corners(), MARKER_ID), scene.skeleton(), SIZE, scene.focal)
    middle = (np.array(SIZE) - 1) / 2
    size = SIZE if quarters == 2 else SIZE[::-1]
    way = np.rint(turn(2, 90 * quarters)[:2, :2])

    def turned(points):
        return (np.asarray(points) - middle) @ way.T + (np.array(size) - 1) / 2

    points = {name: (*map(float, turned(p[:2])), 1.0) for name, p in scene.skeleton().points.items()}
    skeleton = Skeleton(points=points, size=size, source="turned")
    scale = marker_scale(Marker(turned(scene.corners()), MARKER_ID), skeleton, size, scene.focal)
    assert measured(scale, skeleton) == pytest.approx(measured(expected, scene.skeleton()), abs=1e-4)


def test_the_near_arm_is_measured_in_its_own_plane():
    scene = Scene()
    skeleton = scene.skeleton(before=0.18)
    scale = marker_scale(Marker(scene.corners(), MARKER_ID), skeleton, SIZE, scene.focal)
    assert measured(scale, skeleton)[2] == pytest.approx(ARM * 0.18 / (3.0 - 0.18), abs=1e-3)  # 47 mm too long
    assert measured(scale.nearer(0.18), skeleton) == pytest.approx([0, 0, 0], abs=2e-4)
    assert scale.nearer(0.18).sd_share == scale.sd_share


def test_shoes_raise_the_ankles():
    scene = Scene()
    skeleton = scene.skeleton(ankle=0.030)
    marker = Marker(scene.corners(), MARKER_ID)
    assert measured(marker_scale(marker, skeleton, SIZE, scene.focal, sole=0.030), skeleton) == pytest.approx(
        [0, 0, 0], abs=2e-4
    )
    # a ray that is taken for 30 mm lower reaches 30 / (1300 - 80 - 30) = 2.5 % further
    assert measured(marker_scale(marker, skeleton, SIZE, scene.focal), skeleton)[2] == pytest.approx(
        ARM * 0.030 / 1.19, abs=2e-3
    )


def test_one_ankle_is_enough():
    scene = Scene()
    points = {name: place for name, place in BODY.items() if name != "ran"}
    skeleton = scene.skeleton(points=points)
    scale = marker_scale(Marker(scene.corners(), MARKER_ID), skeleton, SIZE, scene.focal)
    assert measured(scale, skeleton) == pytest.approx([0, 0, 0], abs=3e-3)  # its plane faces the camera from there


def test_a_pixel_whose_ray_leaves_the_plane_behind_is_nowhere():
    # a camera that looks 8 degrees down sees level at 8 degrees above its axis, and straight up at 98
    scene = Scene()
    scale = marker_scale(Marker(scene.corners(), MARKER_ID), scene.skeleton(), SIZE, scene.focal)
    middle = (np.array(SIZE) - 1) / 2
    steep = middle - [0.0, scene.focal * np.tan(np.radians(81.0))]  # 73 degrees up, in 3 m distance
    assert scale.place(steep[None])[0] == pytest.approx([0.0, 1.3 + 3 * np.tan(np.radians(73.0))], rel=1e-3, abs=1e-3)
    assert scale.place(np.empty((0, 2))).shape == (0, 2)
    behind = middle + np.array([0.0, scene.focal * np.tan(np.radians(87.0))])  # 95 degrees below level
    assert np.isnan(scale.place(behind[None])).all()


def test_the_doubt_is_that_of_what_is_not_known():
    # the geometry again with focal length, ankles, body's depth and the paper's corners drawn as they are doubted
    rng, scene = np.random.default_rng(2), Scene()
    scale = marker_scale(Marker(scene.corners(), MARKER_ID), scene.skeleton(), SIZE, scene.focal)
    px = np.linalg.norm(np.diff(scene.corners(), axis=0), axis=1).max() / 0.170
    errors = []
    for _ in range(300):
        tilted = Scene(sheet_lean=np.degrees(rng.normal(0, 0.005)))
        corners = tilted.corners() + rng.normal(0, np.hypot(0.1, 0.0005 * px), (4, 2))
        skeleton = scene.skeleton(before=rng.normal(0, 0.025), ankle=rng.normal(0, 0.012))
        focal = scene.focal * (1 + rng.normal(0, 0.02))
        errors.append(measured(marker_scale(Marker(corners, MARKER_ID), skeleton, SIZE, focal), skeleton))
    eye, _, arm = np.std(errors, axis=0)
    assert scale.sd_share == pytest.approx(arm / ARM, rel=0.15)
    assert eye < np.hypot(scale.height_sd, scale.sd_share * EYE) < 3 * eye


# --- the focal length -------------------------------------------------------------------------------------


def test_a_wrong_focal_length_costs_a_little():
    scene = Scene()
    marker, skeleton = Marker(scene.corners(), MARKER_ID), scene.skeleton()
    for share in (0.98, 1.02):
        eye, up, arm = measured(marker_scale(marker, skeleton, SIZE, share * scene.focal), skeleton)
        assert abs(eye) < 0.015
        assert abs(up) < 0.004
        assert abs(arm) < 0.010


@pytest.mark.parametrize("focal_mm", [22.0, 27.0, 36.0])
def test_without_exif_the_sheet_s_perspective_tells_the_focal_length(focal_mm):
    scene = Scene(focal_mm=focal_mm)
    marker, skeleton = Marker(scene.corners(), MARKER_ID), scene.skeleton()
    scale, told = (marker_scale(marker, skeleton, SIZE, focal) for focal in (None, scene.focal))
    assert scale.focal == pytest.approx(scene.focal, rel=0.07)
    assert len(scale.notes) == 1
    assert f"{scale.focal:.0f} px" in scale.notes[0]
    assert scale.sd_share > 1.4 * told.sd_share


# --- in pictures ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("size", "px"), [(SIZE, 0.06), ((720, 1280), 0.12), ((1280, 960), 0.12)])
def test_corners_are_found_to_fractions_of_a_pixel(printed, size, px):
    rng, errors = np.random.default_rng(3), []
    for _ in range(5):
        scene = Scene.drawn(rng, size, distance=3.0, high=1.2, pitch=7.0)
        found = find_marker(scene.picture(printed, rng), "front.jpg")
        assert found.id == MARKER_ID
        errors.append(found.corners - scene.corners())
    assert np.sqrt(np.mean(np.square(errors))) < px
    assert np.abs(np.mean(errors, axis=(0, 1))) == pytest.approx([0, 0], abs=px / 2)


def test_measures_in_pictures_are_those_of_the_person(printed):
    rng = np.random.default_rng(4)
    errors = [seen_in(Scene.drawn(rng), printed, rng) for _ in range(5)]
    eye, up, arm = np.sqrt(np.mean(np.square(errors), axis=0))
    assert eye < 0.003
    assert up < 0.001
    assert arm < 0.002


def test_measures_with_the_focal_length_2_percent_off(printed):
    rng = np.random.default_rng(5)
    errors = [seen_in(Scene.drawn(rng), printed, rng, rng.choice([0.98, 1.02])) for _ in range(5)]
    eye, up, arm = np.sqrt(np.mean(np.square(errors), axis=0))
    assert eye < 0.015
    assert up < 0.004
    assert arm < 0.010


def test_a_blurred_noisy_and_overexposed_picture_still_does(printed):
    rng, scene = np.random.default_rng(6), Scene(sheet_turn=12.0)
    picture = scene.picture(printed, rng, blur=2.0, noise=8.0)
    bright = np.clip(picture.astype(float) * 1.6, 0, 255).astype(np.uint8)
    for pixels in (picture, bright):
        skeleton = scene.skeleton()
        scale = marker_scale(find_marker(pixels, "p"), skeleton, SIZE, scene.focal)
        assert np.abs(measured(scale, skeleton)).max() < 0.008


# --- what cannot be used ----------------------------------------------------------------------------------


def refused(match, pixels):
    with pytest.raises(DataError, match=match) as told:
        find_marker(pixels, "front.jpg")
    assert str(told.value).startswith("front.jpg")
    assert "\n" not in str(told.value)


def test_no_marker_two_markers_and_a_mirrored_picture(printed):
    rng, scene = np.random.default_rng(7), Scene()
    picture = scene.picture(printed, rng)
    refused("no printed marker.*flat on the floor", np.full((400, 300, 3), 128, np.uint8))
    refused("mirrored", picture[:, ::-1])
    refused("2 of the printed markers", _side_by_side(scene, picture))


def _side_by_side(scene, picture):
    lower = scene.corners().min(axis=0).astype(int) - 60
    upper = scene.corners().max(axis=0).astype(int) + 60
    twice = picture.copy()
    sheet = picture[lower[1] : upper[1], lower[0] : upper[0]]
    twice[lower[1] : upper[1], lower[0] - 400 : upper[0] - 400] = sheet
    return twice


def test_another_marker_of_the_dictionary_is_no_sheet():
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_50)
    other = cv2.aruco.generateImageMarker(dictionary, MARKER_ID + 1, 200)
    page = np.full((400, 400), 255, np.uint8)
    page[100:300, 100:300] = other
    refused("no printed marker", np.repeat(page[..., None], 3, axis=2))


def test_a_marker_of_few_pixels_is_refused_or_not_seen(printed):
    scene = Scene(size=(240, 320))
    refused("marker", scene.picture(printed, np.random.default_rng(8), blur=0.5))


def test_a_sheet_on_the_wall_or_in_the_hand_is_refused():
    scene = Scene(sheet_lean=90.0)
    with pytest.raises(DataError, match="does not lie flat on the floor"):
        marker_scale(Marker(scene.corners(), MARKER_ID), scene.skeleton(), SIZE, scene.focal)


def test_a_person_who_is_not_all_in_the_picture_is_refused():
    scene = Scene()
    marker = Marker(scene.corners(), MARKER_ID)
    without_feet = {name: place for name, place in BODY.items() if name not in ("lan", "ran")}
    with pytest.raises(DataError, match="no ankle is seen"):
        marker_scale(marker, scene.skeleton(points=without_feet), SIZE, scene.focal)
    only_feet = {name: BODY[name] for name in ("lan", "ran")}
    with pytest.raises(DataError, match="neither shoulders nor head"):
        marker_scale(marker, scene.skeleton(points=only_feet), SIZE, scene.focal)


def test_a_skeleton_of_another_picture_is_refused():
    scene = Scene()
    with pytest.raises(DataError, match=r"\(1512, 2016\).*\(640, 480\)"):
        marker_scale(Marker(scene.corners(), MARKER_ID), scene.skeleton(), (640, 480), scene.focal)
