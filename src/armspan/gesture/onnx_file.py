"""A trained network as an ONNX file, for those who run it elsewhere."""

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from armspan.errors import MissingExtra
from armspan.gesture.network import Network

OPSET = 17
IR_VERSION = 8
"""Old enough for runtimes of 2022."""


def to_onnx(state: dict[str, Any], recipe: Mapping[str, Any] | None = None) -> bytes:
    """The ONNX bytes of a `Cnn` that was written down.

    Input ``windows`` (batch, channels, times) float32, output ``scores`` (batch, classes); batch and times may be any.
    The windows are those of the sensors if the ``recipe`` before the network is given (the state of a `Standard` or a
    `Report`), else what the recipe made of them. The classes are in the metadata as a JSON list.

    Raises:
        MissingExtra: onnx is not installed.

    """
    try:
        import onnx
    except ImportError:
        raise MissingExtra("onnx", "cnn") from None
    network, graph = Network.from_state(state), _Graph(onnx)
    signal, centre, spread = "windows", network.centre, network.spread
    if recipe is not None and "mean" in recipe:
        centre, spread = recipe["mean"] + recipe["scale"] * centre, recipe["scale"] * spread
    elif recipe is not None:
        signal = _stretched_differences(graph, signal)
    signal = graph.node(
        "Div", graph.node("Sub", signal, graph.constant(centre[:, None])), graph.constant(spread[:, None])
    )
    return graph.model(_scores(graph, signal, network), len(centre), np.asarray(state["classes"]).tolist())


def _stretched_differences(graph: "_Graph", signal: str) -> str:
    """What the recipe `Report` does: each channel of each window stretched to a span of 2, then first differences."""
    least = graph.node("ReduceMin", signal, axes=[2], keepdims=1)
    span = graph.node("Sub", graph.node("ReduceMax", signal, axes=[2], keepdims=1), least)
    one = graph.constant(1.0)
    moves = graph.node("Greater", span, graph.constant(0.0))
    unit = graph.node("Div", graph.node("Sub", signal, least), graph.node("Where", moves, span, one))
    later = graph.node("Slice", unit, graph.whole(1), graph.whole(np.iinfo(np.int64).max), graph.whole(2))
    sooner = graph.node("Slice", unit, graph.whole(0), graph.whole(-1), graph.whole(2))
    return graph.node("Mul", graph.node("Sub", later, sooner), graph.constant(2.0))


def _scores(graph: "_Graph", signal: str, network: Network) -> str:
    """The ensemble as grouped convolutions: the first block sees the same channels in every member."""
    for k, block in enumerate(network.blocks):
        members, out, channels, taps = block.weights.shape
        weights = graph.constant(block.weights.reshape(members * out, channels, taps))
        offset = graph.constant(block.offset.reshape(-1))
        pads = [taps // 2, taps // 2]
        signal = graph.node("Conv", signal, weights, offset, group=members if k else 1, kernel_shape=[taps], pads=pads)
        signal = graph.node("Relu", signal)
        if block.halves:
            signal = graph.node("MaxPool", signal, kernel_shape=[2], strides=[2])
    embedding = graph.node("Flatten", graph.node("GlobalAveragePool", signal))
    return graph.node("Gemm", embedding, graph.constant(network.weights), graph.constant(network.bias), output="scores")


class _Graph:
    """Nodes and constants under numbered names."""

    def __init__(self, onnx: Any) -> None:
        self.onnx = onnx
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def node(self, kind: str, *inputs: str, output: str = "", **attributes: Any) -> str:
        name = output or f"{kind.lower()}_{len(self.nodes)}"
        self.nodes.append(self.onnx.helper.make_node(kind, list(inputs), [name], **attributes))
        return name

    def constant(self, value: NDArray[Any] | float) -> str:
        return self._kept(np.asarray(value, dtype=np.float32))

    def whole(self, value: int) -> str:
        return self._kept(np.array([value], dtype=np.int64))

    def _kept(self, value: NDArray[Any]) -> str:
        name = f"constant_{len(self.constants)}"
        self.constants.append(self.onnx.numpy_helper.from_array(value, name))
        return name

    def model(self, output: str, channels: int, classes: list[Any]) -> bytes:
        helper, real = self.onnx.helper, self.onnx.TensorProto.FLOAT
        windows = helper.make_tensor_value_info("windows", real, ["batch", channels, "times"])
        scores = helper.make_tensor_value_info(output, real, ["batch", len(classes)])
        graph = helper.make_graph(self.nodes, "armspan_gestures", [windows], [scores], self.constants)
        opset = helper.make_opsetid("", OPSET)
        model = helper.make_model(graph, producer_name="armspan", opset_imports=[opset], ir_version=IR_VERSION)
        helper.set_model_props(model, {"classes": msgspec.json.encode(classes).decode()})
        return bytes(model.SerializeToString())
