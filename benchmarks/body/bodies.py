"""Bodies whose measures are known exactly: MakeHuman shapes (package anny), stretched to people of ANSUR II."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

Array = npt.NDArray[np.float64]

ACROMION = (8259, 8260)
"""Vertices over the left shoulder's outer edge, at 0.82 of the stature as the acromion is."""
FORWARD, LEFTWARD, UPWARD = np.eye(3)
"""The scene's axes: x is where the person looks, y the person's left, z up from the floor."""
ARM_BONES = ("upperarm01", "upperarm02", "lowerarm01", "lowerarm02", "wrist")


@dataclass(frozen=True)
class Wanted:
    """A person: sex ("man", "woman") and measures [m] as ANSUR II takes them, shape from 0 to 1."""

    sex: str
    stature: float
    acromion: float
    eye: float
    half_width: float
    arm: float
    weight: float = 0.5
    muscle: float = 0.5
    age: float = 0.67


class Figure:
    """The rigged model of anny as arrays, in the scene's axes."""

    def __init__(self) -> None:
        """Load it (two seconds; the very first time a minute)."""
        import anny
        import torch

        torch.set_num_threads(1)
        warnings.simplefilter("ignore")
        self._model = anny.Anny()
        self.bones: list[str] = list(self._model.bone_labels)
        self.parents: list[int] = list(self._model.bone_parents)
        self.faces = self._model.faces.numpy().astype(np.int64)
        self._weights = self._model.vertex_bone_weights.numpy()
        self._indices = self._model.vertex_bone_indices.numpy()
        coco = anny.KeypointsRegressor.coco(self._model)
        self.coco = dict(zip(coco.labels, coco.regression_weights.numpy(), strict=True))
        strongest = self._indices[np.arange(len(self._weights)), self._weights.argmax(axis=1)]
        self.vertex_bones = [self.bones[i] for i in strongest]

    def shape(self, wanted: Wanted) -> tuple[Array, Array]:
        """Vertices (v, 3) and bone heads (b, 3) of the rest pose, of the stature wanted."""
        low, high = 0.0, 1.0
        for _ in range(12):
            height = (low + high) / 2
            vertices, heads = self._rest(wanted, height)
            low, high = (height, high) if np.ptp(vertices[:, 2]) < wanted.stature else (low, height)
        return vertices, heads

    def _rest(self, wanted: Wanted, height: float) -> tuple[Array, Array]:
        shape = {"gender": float(wanted.sex == "woman"), "age": wanted.age, "muscle": wanted.muscle}
        shape |= {"weight": wanted.weight, "height": height, "proportions": 0.6}
        out = self._model(phenotype_kwargs=shape)
        vertices, heads = (scene_axes(out[k][0].numpy()) for k in ("rest_vertices", "rest_bone_heads"))
        floor = vertices[:, 2].min()
        return vertices - [0, 0, floor], heads - [0, 0, floor]

    def bone(self, name: str) -> int:
        """The index of a bone."""
        return self.bones.index(name)

    def skin(self, vertices: Array, heads: Array, own: Mapping[str, Array]) -> tuple[Array, Array]:
        """Move a rest pose: ``own`` are bones' matrices (3, 3) in the scene, rotation and stretch; others follow.

        A bone without its own matrix takes its parent's rotation, without the parent's stretch.
        """
        matrices, turns = np.zeros((len(self.bones), 3, 3)), np.zeros((len(self.bones), 3, 3))
        moved = heads.copy()
        for i, (name, parent) in enumerate(zip(self.bones, self.parents, strict=True)):
            if parent >= 0:
                moved[i] = moved[parent] + matrices[parent] @ (heads[i] - heads[parent])
            inherited = turns[parent] if parent >= 0 else np.eye(3)
            matrices[i] = own.get(name, inherited)
            turns[i] = rotation(matrices[i]) if name in own else inherited
        offsets = moved - np.einsum("bij,bj->bi", matrices, heads)
        near = np.einsum("vkij,vj->vki", matrices[self._indices], vertices) + offsets[self._indices]
        return np.einsum("vk,vki->vi", self._weights, near), moved


def stretched(figure: Figure, wanted: Wanted) -> tuple[Array, Array]:
    """The rest pose with the trunk, neck, head, collarbones and arms of the person wanted."""
    vertices, heads = figure.shape(wanted)
    at = {name: heads[i] for i, name in enumerate(figure.bones)}
    acromion = vertices[list(ACROMION)].mean(axis=0)
    eye, crown = at["eye.L"][2], vertices[:, 2].max()
    trunk = 1 + (wanted.acromion - acromion[2]) / (at["clavicle.L"][2] - at["spine05"][2])
    head = (wanted.stature - wanted.eye) / (crown - eye)
    neck_foot = at["spine05"][2] + trunk * (at["neck01"][2] - at["spine05"][2])
    head_foot = wanted.eye - head * (eye - at["head"][2])
    neck = (head_foot - neck_foot) / (at["head"][2] - at["neck01"][2])
    wide = 1 + (wanted.half_width - acromion[1]) / (at["upperarm01.L"][1] - at["clavicle.L"][1])
    own = {f"spine0{i}": np.diag([1, 1, trunk]) for i in range(1, 6)}
    own |= {f"neck0{i}": np.diag([1, 1, neck]) for i in range(1, 4)} | {"head": np.diag([1, 1, head])}
    for side in "LR":
        own |= dict.fromkeys((f"clavicle.{side}", f"shoulder01.{side}"), np.diag([1, wide, 1]))
    vertices, heads = figure.skin(vertices, heads, own)
    return _with_arms(figure, vertices, heads, wanted)


def _with_arms(figure: Figure, vertices: Array, heads: Array, wanted: Wanted) -> tuple[Array, Array]:
    """Arms stretched so that acromion to middle fingertip, segment by segment, is as wanted."""
    at = {name: heads[i] for i, name in enumerate(figure.bones)}
    upper = float(np.linalg.norm(at["lowerarm01.L"] - at["upperarm01.L"]))
    lower = float(np.linalg.norm(at["wrist.L"] - at["lowerarm01.L"]))
    drop = wanted.acromion - at["upperarm01.L"][2]
    hand = _hand_length(figure, vertices, heads)
    factor = (wanted.arm - drop - hand) / (upper + lower)
    own = {}
    for side in "LR":
        for bones, tip in ((ARM_BONES[:2], "lowerarm01"), (ARM_BONES[2:4], "wrist")):
            along = unit(at[f"{tip}.{side}"] - at[f"{bones[0]}.{side}"])
            stretch = np.eye(3) + (factor - 1) * np.outer(along, along)
            own |= {f"{bone}.{side}": stretch for bone in bones}
        own[f"wrist.{side}"] = np.eye(3)
    return figure.skin(vertices, heads, own)


def _hand_length(figure: Figure, vertices: Array, heads: Array) -> float:
    """From the wrist along the bones of the middle finger to its tip [m]."""
    chain = [heads[figure.bone(f"{name}.L")] for name in ("wrist", "finger3-1", "finger3-2", "finger3-3")]
    chain.append(vertices[tip_vertex(figure, vertices, heads, "finger3-3.L")])
    return float(sum(np.linalg.norm(b - a) for a, b in pairwise(chain)))


def tip_vertex(figure: Figure, vertices: Array, heads: Array, bone: str) -> int:
    """The vertex farthest out on the last bone of a finger."""
    before = bone.replace("-3.", "-2.")
    along = unit(heads[figure.bone(bone)] - heads[figure.bone(before)])
    own = np.array([name == bone for name in figure.vertex_bones])
    return int(np.argmax(np.where(own, vertices @ along, -np.inf)))


def scene_axes(points: Array) -> Array:
    """MakeHuman's people look along -y with their left at +x; here along +x with their left at +y."""
    return np.stack([-points[:, 1], points[:, 0], points[:, 2]], axis=1)


def unit(vector: Array | Sequence[float]) -> Array:
    v = np.asarray(vector, dtype=float)
    return v / np.linalg.norm(v)


def rotation(matrix: Array) -> Array:
    u, _, vt = np.linalg.svd(matrix)
    return u @ vt


def axes(along: Array, lateral: Array) -> Array:
    first = unit(along)
    second = unit(lateral - first * (lateral @ first))
    return np.stack([first, second, np.cross(first, second)], axis=1)


def shortest(start: Array, end: Array, nearby: Array | None = None) -> Array:
    """The smallest rotation from one direction to another; ``nearby`` is the axis for half a turn."""
    a, b = unit(start), unit(end)
    axis, cosine = np.cross(a, b), float(a @ b)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:
        return (
            np.eye(3)
            if cosine > 0
            else Rotation.from_rotvec(np.pi * (nearby if nearby is not None else UPWARD)).as_matrix()
        )
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, cosine)).as_matrix()
