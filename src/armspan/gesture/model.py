"""A trained gesture model: what it needs, what it found in training, and its two classifiers.

One classifier takes whole takes, one windows that end now; the second spots gestures in a stream. As bytes a model is
a zip of plain arrays and one JSON text: nothing in it is executed when it is loaded.
"""

import io
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from scipy import special

from armspan.errors import ModelError
from armspan.frames import Array
from armspan.gesture.channels import Channels
from armspan.gesture.decision import Rule
from armspan.gesture.pipeline import Pipeline
from armspan.gesture.takes import NULL

FORMAT = "armspan gesture model 1"


class Facts(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a model says of itself.

    ``labels`` are its gestures; ``rate_hz`` that of the takes it learnt from; ``take_length`` how many points a take
    is brought to; windows have ``window_s`` seconds on a grid of ``grid_hz``; ``lead_s`` tells how long after its onset
    each gesture is noticed. ``scores`` are what cross-validation gave.
    """

    format: str = FORMAT
    kind: str
    recipe: str
    columns: tuple[str, ...]
    labels: tuple[str, ...]
    rate_hz: float
    take_length: int
    window_s: float
    grid_hz: float
    hop: int
    temperature: float = 1.0
    rule: Rule = Rule()
    lead_s: dict[str, float] = {}
    persons: tuple[str, ...] = ()
    takes: dict[str, int] = {}
    null_s: float = 0.0
    simulated: bool = False
    seed: int = 0
    scores: dict[str, Any] = {}


@dataclass(frozen=True, slots=True, eq=False)
class GestureModel:
    """A trained model; ``windows`` spots, ``takes`` classifies whole takes."""

    facts: Facts
    takes: Pipeline
    windows: Pipeline

    @property
    def channels(self) -> Channels:
        """From the columns it needs to its channels."""
        return Channels(self.facts.columns)

    @property
    def window(self) -> int:
        """Grid points of a window."""
        return round(self.facts.window_s * self.facts.grid_hz)

    def probabilities(self, windows: Array) -> Array:
        """Probabilities (n, labels + 1) of windows (n, d, w): the gestures in order, null last."""
        return softmax(self.scores(windows), self.facts.temperature)

    def scores(self, windows: Array) -> Array:
        """The windows' decision values (n, labels + 1) in the same order; minus infinity for a label not learnt."""
        return ordered(self.windows, windows, self.facts.labels)


def ordered(pipeline: Pipeline, windows: Array, labels: tuple[str, ...]) -> Array:
    """Decision values (n, labels + 1) of a pipeline: the gestures in order, null last, -inf where never seen."""
    values = pipeline.decision_function(windows)
    table = np.full((len(windows), len(labels) + 1), -np.inf)
    places = {label: k for k, label in enumerate((*labels, NULL))}
    for column, label in enumerate(pipeline.classes):
        table[:, places[label]] = values[:, column]
    return table


def softmax(scores: Array, temperature: float) -> Array:
    """Probabilities (n, m) of scores (n, m)."""
    return np.asarray(special.softmax(scores / temperature, axis=1))


def dump(model: GestureModel) -> bytes:
    """A model as bytes."""
    arrays: dict[str, Array] = {}
    plain = {"facts": msgspec.to_builtins(model.facts)}
    for name, pipeline in (("takes", model.takes), ("windows", model.windows)):
        plain[name] = _split(pipeline.state(), name, arrays)
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        _add(archive, "model.json", msgspec.json.encode(plain))
        for name, array in arrays.items():
            content = io.BytesIO()
            np.save(content, array, allow_pickle=False)
            _add(archive, f"{name}.npy", content.getvalue())
    return file.getvalue()


def load(data: bytes) -> GestureModel:
    """A model from bytes.

    Raises:
        ModelError: the bytes are no model, damaged, or of another version.

    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            plain = msgspec.json.decode(archive.read("model.json"))
            arrays = {
                name.removesuffix(".npy"): np.load(io.BytesIO(archive.read(name)), allow_pickle=False)
                for name in archive.namelist()
                if name.endswith(".npy")
            }
        facts = msgspec.convert(plain["facts"], Facts)
        if facts.format != FORMAT:
            raise ModelError(f"it is of the format {facts.format!r}, this Armspan reads {FORMAT!r}: train it again")
        model = GestureModel(
            facts,
            Pipeline.from_state(_join(plain["takes"], "takes", arrays)),
            Pipeline.from_state(_join(plain["windows"], "windows", arrays)),
        )
        # Parts that do not fit together show when they are used: better here than in the middle of a session.
        model.probabilities(np.zeros((1, model.channels.count, model.window)))
        model.takes.predict(np.zeros((1, model.channels.count, facts.take_length)))
        return model
    except ModelError:
        raise
    except (
        zipfile.BadZipFile,
        zlib.error,
        msgspec.MsgspecError,
        KeyError,
        ValueError,
        TypeError,
        EOFError,
        NotImplementedError,
        RuntimeError,
        IndexError,
        AttributeError,
        OSError,
    ) as error:
        raise ModelError(f"it is damaged or not a gesture model ({error}): train it again, or take a copy") from None


def _add(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    # A fixed date, so that one training gives the same bytes every time.
    archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)


def _split(state: Mapping[str, Any], prefix: str, arrays: dict[str, Array]) -> dict[str, Any]:
    """The plain part of a state; arrays go to ``arrays`` under their path."""
    plain: dict[str, Any] = {}
    for key, value in state.items():
        if isinstance(value, np.ndarray):
            arrays[f"{prefix}/{key}"] = value
        elif isinstance(value, Mapping):
            plain[key] = _split(value, f"{prefix}/{key}", arrays)
        else:
            plain[key] = value.item() if isinstance(value, np.generic) else value
    return plain


def _join(plain: Mapping[str, Any], prefix: str, arrays: Mapping[str, Array]) -> dict[str, Any]:
    state = {
        key: _join(value, f"{prefix}/{key}", arrays) if isinstance(value, dict) else value
        for key, value in plain.items()
    }
    for path, array in arrays.items():
        folder, _, key = path.rpartition("/")
        if folder == prefix:
            state[key] = array
    return state
