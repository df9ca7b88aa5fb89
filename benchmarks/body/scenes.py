"""Twenty-four people before a camera, with everything known that a measurement must find."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from bodies import LEFTWARD, Array, Figure, Wanted, stretched
from clothes import SOLE, dressed
from drawing import Camera, Mesh, Pixels, Sheet, draw
from poses import Pose, Posed, before_the_eye, hanging, level, posed, with_acromia

from armspan.body.marker_sheet import PAGE_HEIGHT, PAGE_WIDTH, marker_png

PEOPLE = (
    ("man", 1.619, 1.296, 1.520, 0.1920, 0.731, 19.2, 23),
    ("man", 1.655, 1.355, 1.552, 0.2125, 0.768, 27.8, 20),
    ("man", 1.678, 1.362, 1.576, 0.1975, 0.760, 26.7, 38),
    ("man", 1.715, 1.387, 1.616, 0.1940, 0.758, 20.7, 21),
    ("man", 1.749, 1.461, 1.634, 0.2220, 0.809, 33.6, 40),
    ("man", 1.770, 1.442, 1.656, 0.2055, 0.790, 24.4, 24),
    ("man", 1.803, 1.469, 1.668, 0.2210, 0.862, 30.8, 19),
    ("man", 1.825, 1.510, 1.709, 0.2155, 0.854, 30.4, 42),
    ("man", 1.853, 1.515, 1.729, 0.2265, 0.805, 34.8, 45),
    ("man", 1.897, 1.565, 1.762, 0.2145, 0.844, 20.0, 21),
    ("man", 1.928, 1.603, 1.809, 0.2120, 0.887, 24.9, 35),
    ("man", 1.955, 1.614, 1.850, 0.2270, 0.881, 28.8, 26),
    ("woman", 1.507, 1.212, 1.399, 0.1730, 0.652, 23.4, 18),
    ("woman", 1.529, 1.258, 1.409, 0.1740, 0.677, 18.5, 19),
    ("woman", 1.564, 1.281, 1.464, 0.1700, 0.715, 25.4, 22),
    ("woman", 1.583, 1.278, 1.457, 0.1875, 0.692, 29.3, 26),
    ("woman", 1.611, 1.286, 1.493, 0.1760, 0.677, 21.7, 22),
    ("woman", 1.645, 1.360, 1.535, 0.1845, 0.720, 26.6, 22),
    ("woman", 1.662, 1.372, 1.552, 0.1840, 0.745, 19.8, 26),
    ("woman", 1.681, 1.361, 1.569, 0.1900, 0.740, 22.3, 45),
    ("woman", 1.716, 1.422, 1.605, 0.1985, 0.764, 33.7, 26),
    ("woman", 1.749, 1.462, 1.646, 0.2025, 0.831, 31.2, 44),
    ("woman", 1.768, 1.464, 1.651, 0.1805, 0.833, 20.1, 21),
    ("woman", 1.809, 1.473, 1.688, 0.1950, 0.845, 27.4, 38),
)
"""Sex; stature, acromion height, eye height, half the biacromial breadth, acromion to fingertip [m]; kg/m^2; age.

The lengths are those of persons of ANSUR II, two dozen drawn by stature; the body mass index is spread a little more.
"""
SKINS = ((0.87, 0.67, 0.55), (0.78, 0.57, 0.44), (0.55, 0.37, 0.27), (0.36, 0.24, 0.18))
HAIRS = ((0.20, 0.14, 0.10), (0.08, 0.07, 0.06), (0.55, 0.42, 0.25), (0.30, 0.18, 0.10))
FIXED = {"eye": (0.95, 0.95, 0.95), "iris": (0.18, 0.13, 0.09), "shoe": (0.14, 0.12, 0.12)}
POINTING_DOWN = np.array([np.cos(np.pi / 6), 0.0, -np.sin(np.pi / 6)])
"""An arm that points 30 degrees down, at a robot some steps ahead."""


@dataclass(frozen=True)
class Scene:
    """A picture's name, what is to be seen ("front", "side" or why it must fail) and what is true of it."""

    name: str
    view: str
    person: int
    arm: str
    sheet: bool
    camera: Camera
    pixels: Pixels
    bodies: tuple[Posed, ...]
    truth: Mapping[str, float] = field(default_factory=dict)
    landmarks: Mapping[str, Array] = field(default_factory=dict)


def wanted(person: int) -> Wanted:
    """One of `PEOPLE` as a body to be made; weight and age on the scales of MakeHuman."""
    sex, stature, acromion, eye, half_width, arm, mass_index, age = PEOPLE[person]
    weight, years = np.clip((mass_index - 14) / 22, 0.1, 0.9), 0.6 + (age - 18) / 150
    return Wanted(sex, stature, acromion, eye, half_width, arm, float(weight), 0.55, years)


def truth(points: Mapping[str, Array], arm: str) -> dict[str, float]:
    """The measures of the right or left arm and the eye of its side [m].

    ``up``, ``left``, ``forward`` and ``arm length`` run from the pivot 15 mm below the acromion; those "from joint"
    from the rig's shoulder joint. The rig turns about the joint, so the pivot's arm length depends on where it points:
    here ahead and `POINTING_DOWN`. ``arm sum`` is acromion to index fingertip segment by segment as the arm hangs,
    less the 15 mm: what a tape and ANSUR II measure. Left is the person's own left.
    """
    s, outward = arm[0], -1.0 if arm == "right" else 1.0
    eye, joint, tip = points[f"{s}eye"], points[f"{s}sh"], points[f"{s}idxtip"]
    acromion = points[f"{s}acromion"]
    pivot = acromion - [0, 0, 0.015]
    chain = [joint] + [points[f"{s}{name}"] for name in ("el", "wr", "idxtip")]
    segments = sum(float(np.linalg.norm(b - a)) for a, b in pairwise(chain))
    return {
        "eye height": float(eye[2]),
        "forward": float(eye[0] - pivot[0]),
        "left": float(eye[1] - pivot[1]),
        "up": float(eye[2] - pivot[2]),
        "arm length": float(np.linalg.norm(joint + segments * POINTING_DOWN - pivot)),
        "forward from joint": float(eye[0] - joint[0]),
        "left from joint": float(eye[1] - joint[1]),
        "up from joint": float(eye[2] - joint[2]),
        "arm length from joint": segments,
        "arm sum": segments + float(pivot[2] - joint[2]),
        "acromion over joint": float(acromion[2] - joint[2]),
        "acromion outside joint": float(outward * (acromion[1] - joint[1])),
        "stature": float(points["crown"][2]),
        "hand": float(np.linalg.norm(tip - points[f"{s}wr"])),
        "upper arm": float(np.linalg.norm(points[f"{s}el"] - joint)),
    }


def mesh(body: Posed, rng: np.random.Generator, apart: float = 0.0) -> Mesh:
    """The body in clothes of some colour, ``apart`` [m] to its left."""
    skin, hair = SKINS[rng.integers(len(SKINS))], HAIRS[rng.integers(len(HAIRS))]
    tones = FIXED | {"skin": skin, "hair": hair, "brow": hair, "lip": (0.75 * skin[0], 0.6 * skin[1], 0.6 * skin[2])}
    tones |= {"shirt": tuple(rng.uniform(0.1, 0.9, 3)), "trousers": tuple(rng.uniform(0.08, 0.4) * np.ones(3))}
    colours = np.array([tones[part] for part in body.parts])[body.faces].mean(axis=1)
    return Mesh(body.vertices + apart * LEFTWARD, body.faces, colours)


def sheet_before(camera: Camera, rng: np.random.Generator) -> Sheet:
    """The printed page 0.5 m from the ankles toward the camera, up to 8 degrees askew."""
    import cv2

    page = cv2.imdecode(np.frombuffer(marker_png(127.0), np.uint8), cv2.IMREAD_GRAYSCALE)
    toward = camera.place[:2] / np.linalg.norm(camera.place[:2])
    centre = 0.5 * toward + rng.uniform(-0.05, 0.05, 2)
    turn = np.arctan2(-toward[1], -toward[0]) + np.radians(rng.uniform(-8, 8))
    return Sheet((float(centre[0]), float(centre[1])), float(turn), page, (PAGE_WIDTH, PAGE_HEIGHT))


def camera_at(azimuth: float, distance: float, height: float, aim: float, sideways: float = 0.0) -> Camera:
    """A camera on the circle round the person [m, rad from where the person looks], at ``aim`` height on the person."""
    place = np.array([distance * np.cos(azimuth), distance * np.sin(azimuth), height])
    across = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return Camera(place + sideways * across, np.array([0.0, 0.0, aim]) + sideways * across)


def near_camera(azimuth: float, rng: np.random.Generator, tall: float, sideways: float = 0.0) -> Camera:
    """2.6 to 3.4 m off at 1.0 to 1.5 m, tilted so that crown and sheet are both in the picture."""
    distance, height = rng.uniform(2.6, 3.4), rng.uniform(1.0, 1.5)
    crown = np.arctan2(tall + 0.05 - height, distance)
    sheet = np.arctan2(-height, distance - 0.5 - 0.2)
    return camera_at(azimuth, distance, height, height + distance * np.tan((crown + sheet) / 2), sideways)


class Studio:
    """Makes scenes; the same seed gives the same pictures."""

    def __init__(self, seed: int = 6, clothes: bool = False) -> None:
        """Load the figure; with ``clothes`` people wear loose ones, hair and shoes."""
        self.figure = Figure()
        self.seed = seed
        self.clothes = clothes

    def body(self, person: int, pose: Pose) -> tuple[Posed, dict[str, Array]]:
        """A person in a pose, and the landmarks with the acromia."""
        rest = stretched(self.figure, wanted(person))
        body = posed(self.figure, rest, pose, wanted(person).sex)
        if self.clothes:
            body = dressed(body, np.random.default_rng([self.seed, person, 99]))
        return body, with_acromia(self.figure, rest, body)

    def front(self, person: int, near: bool, arm: str = "right") -> Scene:
        """T pose toward the camera."""
        rng = np.random.default_rng([self.seed, person, near, 0])
        body, points = self.body(person, Pose(level("right"), level("left")))
        camera = near_camera(0.0, rng, points["crown"][2]) if near else camera_at(0.0, 5.0, 1.3, 1.3)
        return self._scene(f"{person:02d}_front_{_where(near)}", "front", person, arm, near, camera, body, points, rng)

    def side(self, person: int, near: bool, arm: str = "right") -> Scene:
        """The arm stretched forward, the fingertip before the eye, the camera on its side."""
        rng = np.random.default_rng([self.seed, person, near, 1])
        azimuth = -np.pi / 2 if arm == "right" else np.pi / 2
        other = "left" if arm == "right" else "right"
        pose = Pose(**{arm: before_the_eye(arm), other: hanging(other)}, pointing=(arm,))
        body, points = self.body(person, pose)
        sideways = 0.25 if arm == "right" else -0.25
        camera = near_camera(azimuth, rng, points["crown"][2], sideways) if near else camera_at(azimuth, 5.0, 1.3, 1.3)
        return self._scene(f"{person:02d}_side_{_where(near)}", "side", person, arm, near, camera, body, points, rng)

    def _scene(
        self,
        name: str,
        view: str,
        person: int,
        arm: str,
        near: bool,
        camera: Camera,
        body: Posed,
        points: dict[str, Array],
        rng: np.random.Generator,
    ) -> Scene:
        sheet = sheet_before(camera, rng) if near else None
        pixels = draw(camera, [mesh(body, rng)], sheet, rng)
        true = truth(points, arm)
        true["sole"] = SOLE if self.clothes else 0.0
        true["stature"] -= true["sole"]
        return Scene(name, view, person, arm, near, camera, pixels, (body,), true, points)

    def failing(self) -> Iterator[Scene]:
        """What must be refused in one sentence: see the names."""
        camera = camera_at(0.0, 4.0, 1.3, 1.0)
        t_pose = Pose(level("right"), level("left"))
        down = Pose(hanging("right"), hanging("left"))
        bent = Pose(level("right"), level("left"), elbow_bend=np.radians(60))
        raised = Pose(level("right"), level("left"), elbow_bend=np.radians(60), bend_upward=True)
        close = camera_at(0.0, 2.0, 1.3, 1.0, sideways=1.1)
        for name, pose, eyepiece, people in (
            ("nobody", None, camera, ()),
            ("two", t_pose, camera_at(0.0, 5.0, 1.3, 1.0), (5, 17)),
            ("arms_hanging", down, camera, (5,)),
            ("elbows_bent_forward", bent, camera, (5,)),
            ("elbows_bent_upward", raised, camera, (5,)),
            ("arm_out_of_frame", t_pose, close, (5,)),
            ("feet_out_of_frame", t_pose, camera_at(0.0, 1.6, 1.5, 1.5), (5,)),
            ("back", t_pose, camera_at(np.pi, 4.0, 1.3, 1.0), (5,)),
            ("no_sheet", t_pose, camera_at(0.0, 3.0, 1.3, 0.9), (5,)),
        ):
            yield self._failing(name, pose, eyepiece, people)

    def _failing(self, name: str, pose: Pose | None, camera: Camera, people: tuple[int, ...]) -> Scene:
        rng = np.random.default_rng([self.seed, len(name)])
        bodies = tuple(self.body(person, pose)[0] for person in people) if pose else ()
        spread = (-1.1, 1.1) if len(bodies) == 2 else (0.0,)
        meshes = [mesh(body, rng, apart) for body, apart in zip(bodies, spread, strict=False)]
        pixels = draw(camera, meshes, None, rng)
        return Scene(
            f"fail_{name}", name, people[0] if people else -1, "right", name == "no_sheet", camera, pixels, bodies
        )


def png(pixels: Pixels) -> bytes:
    """The picture as a PNG file."""
    import cv2

    return bytes(cv2.imencode(".png", pixels[..., ::-1])[1])


def _where(near: bool) -> str:
    return "near" if near else "far"
