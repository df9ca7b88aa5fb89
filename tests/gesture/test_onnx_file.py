"""The ONNX file against the NumPy network, through ONNX's own reference implementation."""

import json
import sys
from typing import Any

import numpy as np
import pytest

from armspan.errors import MissingExtra
from armspan.gesture.network import Block, Network
from armspan.gesture.onnx_file import to_onnx
from armspan.gesture.recipes import Report, Standard

CLASSES = ["mixing", "null", "stop"]


def made_state(members: int, rng: np.random.Generator) -> dict[str, Any]:
    blocks = tuple(
        Block(
            rng.normal(size=(members, 6, channels, taps)).astype(np.float32) / 3,
            rng.normal(size=(members, 6)).astype(np.float32),
            halves,
        )
        for channels, taps, halves in ((4, 7, True), (6, 5, True), (6, 3, False))
    )
    weights, bias = rng.normal(size=(members * 6, 3)), rng.normal(size=3)
    network = Network(
        rng.normal(size=4),
        rng.uniform(0.5, 2.0, 4),
        blocks,
        weights.astype(np.float32),
        bias.astype(np.float32),
    )
    return {**network.state(), "classes": np.array(CLASSES)}


def run(data: bytes, windows: np.ndarray) -> np.ndarray:
    onnx = pytest.importorskip("onnx", reason="onnx is not installed (extra cnn)")
    reference = pytest.importorskip("onnx.reference", reason="onnx is not installed (extra cnn)")
    model = onnx.load_from_string(data)
    onnx.checker.check_model(model, full_check=True)
    return np.asarray(reference.ReferenceEvaluator(model).run(["scores"], {"windows": windows.astype(np.float32)})[0])


@pytest.mark.parametrize("members", [1, 3])
def test_same_scores_for_any_number_and_length_of_windows(members: int) -> None:
    pytest.importorskip("onnx", reason="onnx is not installed (extra cnn)")
    rng = np.random.default_rng(members)
    state = made_state(members, rng)
    data, network = to_onnx(state), Network.from_state(state)
    for n, t in ((1, 31), (5, 31), (2, 64)):
        windows = rng.normal(size=(n, 4, t)) * 3 + 1
        np.testing.assert_allclose(run(data, windows), network.scores(windows), rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("name", ["standard", "report"])
def test_the_recipe_before_it_can_be_inside(name: str) -> None:
    pytest.importorskip("onnx", reason="onnx is not installed (extra cnn)")
    rng = np.random.default_rng(5)
    takes = rng.normal(size=(6, 4, 33)) * np.array([1.0, 9.8, 200, 3])[:, None] + np.array([0, 9.8, -50, 1])[:, None]
    takes[2, 1] = 4.0  # a channel that does not move
    recipe = (Standard((0, 0, 1, 1)) if name == "standard" else Report((0, 0, 1, 1))).fit(takes)
    state = made_state(2, rng)
    expected = Network.from_state(state).scores(recipe.transform(takes))
    np.testing.assert_allclose(run(to_onnx(state, recipe.state()), takes), expected, rtol=1e-3, atol=1e-3)


def test_the_file_says_its_ends_and_its_classes() -> None:
    onnx = pytest.importorskip("onnx", reason="onnx is not installed (extra cnn)")
    model = onnx.load_from_string(to_onnx(made_state(2, np.random.default_rng(6))))
    (windows,), (scores,) = model.graph.input, model.graph.output
    assert (windows.name, scores.name) == ("windows", "scores")
    dims = windows.type.tensor_type.shape.dim
    assert [d.dim_param or d.dim_value for d in dims] == ["batch", 4, "times"]
    assert [d.dim_param or d.dim_value for d in scores.type.tensor_type.shape.dim] == ["batch", 3]
    assert {p.key: json.loads(p.value) for p in model.metadata_props} == {"classes": CLASSES}


def test_without_onnx(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "onnx", None)
    with pytest.raises(MissingExtra, match=r"pip install 'armspan\[cnn\]'"):
        to_onnx(made_state(1, np.random.default_rng(7)))
