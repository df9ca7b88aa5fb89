"""The networks of BlazePose and of the hand landmarks, run by LiteRT on the CPU.

They are published with MediaPipe (Apache-2.0): Bazarevsky et al. 2020, "BlazePose: On-device Real-time Body Pose
tracking", and Zhang et al. 2020, "MediaPipe Hands: On-device Real-time Hand Tracking".
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from armspan.body.picture.native import stderr_kept
from armspan.errors import DeviceError, MissingExtra
from armspan.frames import Array

Network: TypeAlias = Callable[[NDArray[np.float32]], list[Array]]
"""A picture (height, width, 3) in, the outputs in the file's order out, each without its first axis, of length one."""

DETECTOR = "pose_detection.tflite"
BODY = "pose_landmark_full.tflite"
HAND = "hand_landmark_full.tflite"

_FORMS = {DETECTOR: (224, 2), BODY: (256, 5), HAND: (224, 4)}
"""Side of the picture that goes in [px], and how many outputs come out: what tells the networks apart."""
_THREADS = 2


@dataclass(frozen=True, slots=True)
class Networks:
    """What finds people, what finds a body's points, what finds a hand's."""

    detector: Network
    body: Network
    hand: Network


def open_networks(weights: Path) -> Networks:
    """The networks in a folder.

    Raises:
        DeviceError: a file is missing, or is no network or another one.
        MissingExtra: LiteRT is not installed.

    """
    return Networks(_open(weights / DETECTOR), _open(weights / BODY), _open(weights / HAND))


def _open(path: Path) -> Network:
    try:
        from ai_edge_litert.interpreter import Interpreter
    except ImportError:
        raise MissingExtra("ai-edge-litert", "picture") from None
    if not path.is_file():
        raise DeviceError(
            f"{path} is not there, and without it no picture can be measured: run `armspan body --set-up`"
        )
    try:
        with stderr_kept():  # LiteRT tells of its delegate there
            interpreter = Interpreter(str(path), num_threads=_THREADS)
            interpreter.allocate_tensors()
    except (ValueError, RuntimeError):
        raise DeviceError(f"{path} is no network that LiteRT can read: run `armspan body --set-up` again") from None
    entries, exits = interpreter.get_input_details(), interpreter.get_output_details()
    if (entries[0]["shape"][1], len(exits)) != _FORMS[path.name]:
        raise DeviceError(f"{path} is another network than its name says: run `armspan body --set-up` again")

    def run(picture: NDArray[np.float32]) -> list[Array]:
        interpreter.set_tensor(entries[0]["index"], picture[None])
        interpreter.invoke()
        return [np.asarray(interpreter.get_tensor(each["index"])[0], float) for each in exits]

    return run
