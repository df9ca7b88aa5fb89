"""Loose clothes, hair and shoes upon a body: what a picture of a real person shows in place of the skin."""

from dataclasses import replace

import numpy as np
from bodies import UPWARD, Array
from poses import Posed

SOLE = 0.025
"""Height of the shoes' soles [m]."""
LOOSE = {"shirt": (0.006, 0.020), "trousers": (0.005, 0.015), "hair": (0.012, 0.035), "shoe": (0.004, 0.008)}
"""How far cloth and hair stand off the skin [m], drawn for each person."""


def dressed(body: Posed, rng: np.random.Generator) -> Posed:
    """The body in clothes that stand off by a few millimetres, with folds, hair and shoes; landmarks stay in the body.

    The floor stays where it is: body and landmarks rise by `SOLE`.
    """
    off = {part: rng.uniform(*limits) for part, limits in LOOSE.items()}
    thickness = np.array([off.get(part, 0.0) for part in body.parts])
    thickness = _blended(thickness, body) * (1 + 0.5 * _folds(body.vertices, rng))
    outside = body.vertices + thickness[:, None] * _normals(body)
    lifted = np.clip(body.vertices[:, 2] / 0.06, 0, 1) ** 2 * (3 - 2 * np.clip(body.vertices[:, 2] / 0.06, 0, 1))
    outside[:, 2] = np.maximum(outside[:, 2] + SOLE * lifted, 0.0)
    landmarks = {name: point + SOLE * UPWARD for name, point in body.landmarks.items()}
    return replace(body, vertices=outside, landmarks=landmarks)


def _folds(vertices: Array, rng: np.random.Generator) -> Array:
    """Smooth random waves over the body, from -1 to 1."""
    waves = rng.normal(0, 40, (6, 3))
    return np.asarray(np.sin(vertices @ waves.T + rng.uniform(0, 2 * np.pi, 6)).mean(axis=1))


def _normals(body: Posed) -> Array:
    corners = body.vertices[body.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    at_vertices = np.zeros_like(body.vertices)
    for k in range(3):
        np.add.at(at_vertices, body.faces[:, k], normals)
    return at_vertices / np.maximum(np.linalg.norm(at_vertices, axis=1, keepdims=True), 1e-12)


def _blended(values: Array, body: Posed) -> Array:
    """Values at vertices after three steps of averaging with the neighbours: hems slope instead of breaking."""
    count = np.bincount(body.faces.ravel(), minlength=len(values))
    for _ in range(3):
        mean = values[body.faces].mean(axis=1)
        total = np.bincount(body.faces.ravel(), np.repeat(mean, 3), minlength=len(values))
        values = np.where(count > 0, total / np.maximum(count, 1), values)
    return values
