"""A recipe and a model in a row, chosen by name."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np

from armspan.errors import ModelError, known_names
from armspan.frames import Array

KINDS = ("kernels", "cnn", "dtw")
RECIPES = ("standard", "report")
WINDOW_FEATURES = 2000


class Estimator(Protocol):
    """A scikit-learn classifier on (n, channels, times); Armspan's own can also be written down."""

    classes_: Array

    def fit(self, X: Array, y: Array, groups: Array | None = None) -> Self:
        """Learn."""

    def decision_function(self, X: Array) -> Array:
        """One value per class (n, n_classes)."""


def estimator(kind: str) -> Any:
    """The class of a kind of model (ModelError for a name that is none).

    Imported here and not above: scikit-learn takes a second, which verbs that need no model shall not wait for.
    """
    if kind == "kernels":
        from armspan.gesture.kernels import Kernels

        return Kernels
    if kind == "dtw":
        from armspan.gesture.dtw import Dtw

        return Dtw
    if kind == "cnn":
        from armspan.gesture.cnn import Cnn

        return Cnn
    raise ModelError(known_names("Model", kind, KINDS))


def preparation(name: str) -> Any:
    """The class of a recipe (ModelError for a name that is none)."""
    from armspan.gesture.recipes import Report, Standard

    recipes = {"standard": Standard, "report": Report}
    if name not in recipes:
        raise ModelError(known_names("Recipe", name, RECIPES))
    return recipes[name]


def _sized(model: Any, kind: str, seed: int, windows: bool) -> Any:
    if kind == "dtw":
        return model()
    return model(seed=seed, n_features=WINDOW_FEATURES) if kind == "kernels" and windows else model(seed=seed)


@dataclass(slots=True, eq=False)
class Pipeline:
    """A recipe and an estimator, fitted together."""

    kind: str
    recipe_name: str
    recipe: Any
    model: Any

    @classmethod
    def fresh(
        cls, kind: str, recipe: str, groups: Sequence[int], seed: int = 0, *, windows: bool = False
    ) -> "Pipeline":
        """An unfitted one; ``groups`` are the channels' sensors.

        For ``windows``, of which there are thousands, kernels are half as many.
        """
        model = _sized(estimator(kind), kind, seed, windows)
        return cls(kind, recipe, preparation(recipe)(groups=tuple(groups)), model)

    def fit(self, X: Array, y: Sequence[str], together: Sequence[str] | None = None) -> Self:
        """Learn from (n, c, t), their labels, and what is to be left out ``together`` where a penalty is chosen."""
        groups = np.asarray(together) if together is not None and len(set(together)) > 1 else None
        self.recipe.fit(X)
        self.model.fit(self.recipe.transform(X), np.asarray(y), groups)
        return self

    @property
    def classes(self) -> list[str]:
        """The labels, in the order of the decision values."""
        return [str(label) for label in self.model.classes_]

    def decision_function(self, X: Array) -> Array:
        """Values (n, n_classes); the largest is the answer."""
        return np.asarray(self.model.decision_function(self.recipe.transform(X)))

    def predict(self, X: Array) -> list[str]:
        """The labels of takes or windows."""
        classes = self.classes
        return [classes[k] for k in np.argmax(self.decision_function(X), axis=1)]

    def state(self) -> dict[str, Any]:
        """Everything that a copy needs."""
        return {
            "kind": self.kind,
            "recipe_name": self.recipe_name,
            "recipe": self.recipe.state(),
            "model": self.model.state(),
        }

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> "Pipeline":
        """The pipeline of a state."""
        kind, name = state["kind"], state["recipe_name"]
        recipe = preparation(name).from_state(state["recipe"])
        return cls(kind, name, recipe, estimator(kind).from_state(state["model"]))
