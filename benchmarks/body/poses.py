"""Bodies in a pose: T pose, pointing, arms that hang; with the landmarks that a measurement looks for."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from bodies import ACROMION, FORWARD, LEFTWARD, UPWARD, Array, Figure, axes, shortest, tip_vertex, unit
from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Pose:
    """Where both arms go (unit vectors in the scene); ``pointing`` arms close the other three fingers.

    ``girdle`` [rad] is how far the collarbone of a raised arm rises; an arm stretched forward takes it forward as far.
    """

    right: Array
    left: Array
    pointing: tuple[str, ...] = ()
    elbow_bend: float = 0.0
    bend_upward: bool = False
    girdle: float = 0.0


@dataclass(frozen=True)
class Posed:
    """A mesh in the scene [m], origin on the floor below the ankles, and its landmarks by name."""

    vertices: Array
    faces: npt.NDArray[np.int64]
    parts: tuple[str, ...]
    landmarks: Mapping[str, Array]
    sex: str


def hanging(side: str) -> Array:
    """An arm that hangs a hand's width off the thigh."""
    outward = LEFTWARD if side == "left" else -LEFTWARD
    return unit(0.22 * outward - UPWARD)


def level(side: str) -> Array:
    """An arm stretched out sideways, level."""
    return LEFTWARD if side == "left" else -LEFTWARD


def before_the_eye(side: str) -> Array:
    """An arm stretched forward, level and so far inward that the fingertip is about before the eye."""
    inward = -LEFTWARD if side == "left" else LEFTWARD
    return unit(FORWARD + 0.21 * inward)


def posed(figure: Figure, rest: tuple[Array, Array], pose: Pose, sex: str) -> Posed:
    """The body in a pose, legs nearly together, standing on the floor."""
    vertices, heads = rest
    tips = {
        f"{side[0]}{finger}tip": tip_vertex(figure, vertices, heads, f"finger{number}-3.{side[0].upper()}")
        for side in ("left", "right")
        for finger, number in (("idx", 2), ("mid", 3))
    }
    own = _legs(figure, heads)
    for side in ("left", "right"):
        own |= _girdle(side, pose) | _arm(figure, vertices, heads, side, pose)
    moved, joints = figure.skin(vertices, heads, own)
    feet = (joints[figure.bone("foot.L")] + joints[figure.bone("foot.R")]) / 2
    shift = -np.array([feet[0], feet[1], moved[:, 2].min()])
    landmarks = _landmarks(figure, moved + shift, joints + shift, tips)
    return Posed(moved + shift, figure.faces, _parts(figure, moved + shift, joints + shift), landmarks, sex)


def _legs(figure: Figure, heads: Array) -> dict[str, Array]:
    own: dict[str, Array] = {}
    for side, outward in (("L", 1.0), ("R", -1.0)):
        hip, ankle = heads[figure.bone(f"upperleg01.{side}")], heads[figure.bone(f"foot.{side}")]
        turn = shortest(ankle - hip, np.array([ankle[0] - hip[0], outward * 0.01, ankle[2] - hip[2]]))
        own[f"upperleg01.{side}"] = turn
        own[f"foot.{side}"] = np.eye(3)
    return own


def _girdle(side: str, pose: Pose) -> dict[str, Array]:
    direction, left = (pose.left, 1.0) if side == "left" else (pose.right, -1.0)
    if direction[2] < -0.5 or not pose.girdle:
        return {}
    rise, forth = Rotation.from_rotvec(FORWARD * left * pose.girdle), Rotation.identity()
    if direction[0] > 0.5:
        forth = Rotation.from_rotvec(-UPWARD * left * pose.girdle)
    return {f"clavicle.{side[0].upper()}": (forth * rise).as_matrix()}


def _arm(figure: Figure, vertices: Array, heads: Array, side: str, pose: Pose) -> dict[str, Array]:
    letter = side[0].upper()
    at = {name: heads[i] for i, name in enumerate(figure.bones)}
    direction = pose.left if side == "left" else pose.right
    radial = _radial(side, direction)
    toward = UPWARD if pose.bend_upward or abs(direction[0]) > 0.5 else FORWARD
    bend = Rotation.from_rotvec(np.cross(direction, toward) * pose.elbow_bend)
    far = bend.apply(direction)
    upper = shortest(at[f"lowerarm01.{letter}"] - at[f"upperarm01.{letter}"], direction)
    lower = shortest(at[f"wrist.{letter}"] - at[f"lowerarm01.{letter}"], far)
    hand_rest = axes(
        at[f"finger3-1.{letter}"] - at[f"wrist.{letter}"], at[f"finger2-1.{letter}"] - at[f"finger5-1.{letter}"]
    )
    hand = axes(far, radial) @ hand_rest.T
    own = {f"upperarm01.{letter}": upper, f"upperarm02.{letter}": upper, f"lowerarm01.{letter}": lower}
    own |= {f"lowerarm02.{letter}": _half(lower, hand), f"wrist.{letter}": hand}
    for number in range(2, 6):
        own |= _finger(figure, vertices, heads, number, letter, hand, far, side in pose.pointing and number > 2)
    return own


def _finger(
    figure: Figure, vertices: Array, heads: Array, number: int, letter: str, hand: Array, along: Array, closed: bool
) -> dict[str, Array]:
    """Straight along the hand, or closed into the palm by 75, 165 and 215 degrees."""
    names = [f"finger{number}-{i}.{letter}" for i in (1, 2, 3)]
    joints = [heads[figure.bone(name)] for name in names] + [vertices[tip_vertex(figure, vertices, heads, names[2])]]
    lateral = hand @ unit(heads[figure.bone(f"finger2-1.{letter}")] - heads[figure.bone(f"finger5-1.{letter}")])
    lateral = unit(lateral - along * (lateral @ along)) * (1 if letter == "R" else -1)
    own = {}
    for i, name in enumerate(names):
        angle = np.radians((75, 165, 215)[i]) if closed else 0.0
        target = Rotation.from_rotvec(lateral * angle).apply(along)
        own[name] = shortest(hand @ (joints[i + 1] - joints[i]), target, nearby=lateral) @ hand
    return own


def _radial(side: str, direction: Array) -> Array:
    """Where the thumb's side looks: forward for arms that hang or lie level, inward for an arm stretched forward."""
    if direction[0] > 0.5:
        return -LEFTWARD if side == "left" else LEFTWARD
    return FORWARD


def _landmarks(figure: Figure, vertices: Array, joints: Array, tips: Mapping[str, int]) -> dict[str, Array]:
    names = {"sh": "upperarm01", "el": "lowerarm01", "wr": "wrist", "idxknuckle": "finger2-1", "hip": "upperleg01"}
    names |= {"kn": "lowerleg01", "an": "foot", "eye": "eye"}
    points = {f"{s}{k}": joints[figure.bone(f"{b}.{s.upper()}")] for k, b in names.items() for s in "lr"}
    points |= {name: vertices[index] for name, index in tips.items()}
    surface = {"nose": "nose"} | {f"{s[0]}ear": f"{s}_ear" for s in ("left", "right")}
    surface |= {f"{s[0]}heel": f"{s}_heel" for s in ("left", "right")}
    surface |= {f"{s[0]}toe": f"{s}_big_toe" for s in ("left", "right")}
    points |= {name: figure.coco[label] @ vertices for name, label in surface.items()}
    points["neck"] = (points["lsh"] + points["rsh"]) / 2
    points["crown"] = vertices[np.argmax(vertices[:, 2])]
    return points


def with_acromia(figure: Figure, rest: tuple[Array, Array], body: Posed) -> dict[str, Array]:
    """Landmarks and both acromia, which keep their place over the joint whatever the arm does."""
    vertices, heads = rest
    over = vertices[list(ACROMION)].mean(axis=0) - heads[figure.bone("upperarm01.L")]
    mirror = over * [1, -1, 1]
    points = dict(body.landmarks)
    return points | {"lacromion": points["lsh"] + over, "racromion": points["rsh"] + mirror}


def _parts(figure: Figure, vertices: Array, joints: Array) -> tuple[str, ...]:
    """What covers each vertex: skin, shirt, trousers, shoe, hair, eye, iris, lip, brow."""
    cover = np.array([_cloth(name) for name in figure.vertex_bones], dtype=object)
    eyes = (joints[figure.bone("eye.L")] + joints[figure.bone("eye.R")]) / 2
    front, side, up = (vertices - eyes).T
    side = np.abs(side)
    head = cover == "head"
    ear = (side > 0.062) & (up < 0.02) & (front > -0.105)
    hair = head & ~ear & ((up > 0.062 + 0.3 * np.minimum(front, 0)) | ((front < -0.075) & (up > -0.08)))
    brow = head & (np.abs(up - 0.019) < 0.005) & (side > 0.012) & (side < 0.047) & (front > -0.02)
    lip = head & (np.abs(up + 0.072) < 0.008) & (side < 0.024) & (front > 0.0)
    for name, mask in (("skin", head), ("hair", hair), ("brow", brow), ("lip", lip)):
        cover[mask] = name
    for eye in ("eye.L", "eye.R"):
        ball = cover == eye
        offset = vertices[ball] - joints[figure.bone(eye)]
        cover[np.flatnonzero(ball)] = np.where(np.hypot(offset[:, 1], offset[:, 2]) < 0.0062, "iris", "eye")
    return tuple(cover)


def _cloth(bone: str) -> str:
    if bone.startswith("eye"):
        return bone
    for part, starts in (
        ("shoe", ("foot", "toe")),
        ("trousers", ("pelvis", "root", "upperleg", "lowerleg", "spine05")),
        ("shirt", ("spine", "clavicle", "shoulder", "upperarm01", "breast")),
        ("head", ("head",)),
    ):
        if bone.startswith(starts):
            return part
    return "skin"


def _half(first: Array, second: Array) -> Array:
    between = Rotation.from_matrix(second @ first.T).as_rotvec()
    return Rotation.from_rotvec(between / 2).as_matrix() @ first
