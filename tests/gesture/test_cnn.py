"""Training in torch, and everything after it without."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from armspan.errors import MissingExtra, ModelError
from armspan.gesture import cnn
from armspan.gesture.cnn import Cnn, batches, folded, layers, mixed, quiet_torch, refitted_head, warped_times
from armspan.gesture.network import Network

DATA = Path(__file__).parents[2] / ".." / "shared" / "data" / "gestures"


def swings(
    rng: np.random.Generator, n: int, labels: tuple[str, ...] = ("a", "b", "c"), t: int = 40
) -> tuple[np.ndarray, np.ndarray]:
    """Takes (n, 2, t) of sines; a label is its number of swings, the start is anywhere."""
    rows = np.arange(n) % len(labels)
    phase = rng.uniform(0, 2 * np.pi, (n, 1)) + 2 * np.pi * (rows[:, None] + 1) * np.linspace(0, 1, t)
    X = np.stack([np.sin(phase), np.cos(phase)], axis=1) + 0.1 * rng.normal(size=(n, 2, t))
    return X * np.array([1.0, 50.0])[:, None] + np.array([0.0, 9.8])[:, None], np.array(labels)[rows]


@pytest.fixture(scope="module")
def trained() -> Cnn:
    pytest.importorskip("torch", reason="torch is not installed (extra cnn)")
    X, y = swings(np.random.default_rng(0), 36)
    return Cnn(filters=12, members=2, steps=60, seed=3).fit(X, y)


def test_learns_and_tells_probabilities(trained: Cnn) -> None:
    X, y = swings(np.random.default_rng(1), 60)
    assert trained.score(X, y) > 0.95
    assert trained.classes_.tolist() == ["a", "b", "c"]
    chances = trained.predict_proba(X)
    np.testing.assert_allclose(chances.sum(axis=1), 1.0)
    np.testing.assert_array_equal(chances.argmax(axis=1), trained.decision_function(X).argmax(axis=1))


def test_numpy_says_what_torch_says() -> None:
    """Batch norm with statistics, gains and offsets that are not those of the start, and members averaged."""
    torch = pytest.importorskip("torch", reason="torch is not installed (extra cnn)")
    rng = np.random.default_rng(2)
    X = rng.normal(size=(5, 3, 29)) * 4 + 7
    centre, spread = np.array([7.0, 6, 8]), np.array([4.0, 3, 5])
    with quiet_torch(1):
        nets = [layers(torch, 3, 8, 4).eval() for _ in range(3)]
        for part in (part for net in nets for part in net if hasattr(part, "running_var")):
            torch.nn.init.normal_(part.weight)
            torch.nn.init.normal_(part.bias)
            part.running_mean.normal_()
            part.running_var.uniform_(0.2, 3.0)
        Z = torch.from_numpy(((X - centre[:, None]) / spread[:, None]).astype(np.float32))
        with torch.no_grad():
            expected = np.mean([net(Z).numpy() for net in nets], axis=0)
    assert np.abs(expected).max() > 0.1
    np.testing.assert_allclose(folded(nets, centre, spread).scores(X), expected, atol=1e-4)


def test_same_seed_same_model_and_torch_is_left_as_it_was(trained: Cnn) -> None:
    import torch

    X, y = swings(np.random.default_rng(0), 36)
    torch.manual_seed(11)
    threads, expected = torch.get_num_threads(), torch.rand(3, generator=torch.Generator().manual_seed(11))
    again = Cnn(filters=12, members=2, steps=60, seed=3).fit(X, y)
    np.testing.assert_array_equal(torch.rand(3).numpy(), expected.numpy())
    assert (torch.get_num_threads(), torch.are_deterministic_algorithms_enabled()) == (threads, False)
    np.testing.assert_array_equal(again.decision_function(X), trained.decision_function(X))
    other = Cnn(filters=12, members=2, steps=60, seed=4).fit(X, y)
    assert not np.allclose(other.decision_function(X), trained.decision_function(X))


def test_written_down_it_runs_where_torch_is_not(trained: Cnn, tmp_path: Path) -> None:
    X, _ = swings(np.random.default_rng(4), 9)
    expected = trained.decision_function(X)
    np.savez(tmp_path / "state.npz", takes=X, **trained.state())  # nothing in it is an object
    program = (
        "import sys\n"
        "class Absent:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name.partition('.')[0] == 'torch': raise ImportError(name)\n"
        "sys.meta_path.insert(0, Absent())\n"
        "import numpy as np\n"
        "from armspan.gesture.cnn import Cnn\n"
        "state = dict(np.load(sys.argv[1]))\n"
        "model, X = Cnn.from_state(state), state['takes']\n"
        "labels = model.refine(X[:2], ['b', 'new']).classes_\n"
        "np.savez(sys.argv[2], scores=model.decision_function(X), answers=model.predict(X), labels=labels)\n"
    )
    subprocess.run([sys.executable, "-c", program, tmp_path / "state.npz", tmp_path / "out.npz"], check=True)
    with np.load(tmp_path / "out.npz") as out:
        assert np.abs(out["scores"] - expected).max() < 1e-4
        assert out["answers"].tolist() == trained.predict(X).tolist()
        assert out["labels"].tolist() == ["a", "b", "c", "new"]


def test_state_round_trip(trained: Cnn) -> None:
    X, y = swings(np.random.default_rng(5), 12)
    state = trained.state()
    assert all(isinstance(value, int | np.ndarray) for value in state.values())
    copy = Cnn.from_state(state)
    np.testing.assert_array_equal(copy.decision_function(X), trained.decision_function(X))
    np.testing.assert_array_equal(copy.refine(X, y).decision_function(X), trained.refine(X, y).decision_function(X))
    assert copy.get_params() == trained.get_params()


def test_own_takes_turn_the_answer(trained: Cnn) -> None:
    """A person who swaps two gestures: three takes of each, heavy as they are, outvote the twelve of the others."""
    X, y = swings(np.random.default_rng(6), 60)
    theirs = np.array([{"a": "c", "b": "b", "c": "a"}[label] for label in y], dtype=object)
    own, rest = np.arange(9), np.arange(9, 60)
    generic, refined = trained.score(X[rest], theirs[rest].astype(str)), trained.refine(X[own], theirs[own])
    assert generic < 0.4  # only ``b`` is right
    assert refined.score(X[rest], theirs[rest].astype(str)) > 0.9
    light = trained.refine(X[own], theirs[own], weight=1e-3)
    assert light.predict(X[rest]).tolist() == trained.predict(X[rest]).tolist()


def test_refitted_head_of_two_classes() -> None:
    """One feature, classes at 0 and 1: the border is in the middle, its side tells the class."""
    E = np.repeat([[0.0], [1.0]], 20, axis=0)
    classes, weights, bias = refitted_head(E, np.repeat(["n", "y"], 20), np.ones(40))
    scores = np.array([[0.4], [0.5], [0.6]]) @ weights + bias
    assert (classes.tolist(), scores.shape) == (["n", "y"], (3, 2))
    np.testing.assert_allclose(scores[:, 1] - scores[:, 0] > 0, [False, scores[1, 1] > scores[1, 0], True])
    assert abs(scores[1, 1] - scores[1, 0]) < 1e-2


def test_warped_times_stay_inside_and_never_turn_back() -> None:
    times = warped_times(200, 50, np.random.default_rng(7))
    assert times.shape == (200, 50)
    assert times.min() >= 0
    assert times.max() <= 49
    assert np.diff(times, axis=1).min() >= 0
    np.testing.assert_allclose(times.mean(axis=0), np.arange(50), atol=1.5)
    assert times[:, 25].std() > 1


def test_batches_take_every_row_in_turn() -> None:
    drawn, rng = [], np.random.default_rng(8)
    for rows, _ in zip(batches(10, 4, rng), range(5), strict=False):
        drawn += rows.tolist()
    assert sorted(drawn[:10]) == sorted(drawn[10:]) == list(range(10))


def test_mixed_takes_and_targets_share_alike() -> None:
    eye = np.eye(6, dtype=np.float32)
    x, targets = mixed(eye[:, :, None], eye, np.random.default_rng(9))
    np.testing.assert_array_equal(x[:, :, 0], targets)
    np.testing.assert_allclose(targets.sum(axis=1), 1.0, rtol=1e-6)
    assert ((targets > 0).sum(axis=1) <= 2).all()


@pytest.mark.parametrize(
    ("X", "y", "words"),
    [
        (np.zeros((4, 2, 3)), ["a", "b"] * 2, "3 times"),
        (np.zeros((4, 2, 30)), ["a"] * 4, "at least one other"),
        (np.full((4, 2, 30), np.nan), ["a", "b"] * 2, "NaN"),
    ],
)
def test_takes_that_cannot_teach(X: np.ndarray, y: list[str], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        Cnn().fit(X, np.array(y))


def test_windows_that_do_not_fit(trained: Cnn) -> None:
    with pytest.raises(ModelError, match="2 channels"):
        trained.predict(np.zeros((1, 3, 40)))
    with pytest.raises(ModelError, match="2 takes with 1 labels"):
        trained.refine(np.zeros((2, 2, 40)), np.array(["a"]))
    with pytest.raises(ModelError, match="no gaps"):
        trained.refine(np.full((1, 2, 40), np.nan), np.array(["a"]))


def test_without_torch(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    X, y = swings(np.random.default_rng(10), 6)
    with pytest.raises(MissingExtra, match=r"torch is not installed: pip install 'armspan\[cnn\]'"):
        Cnn().fit(X, y)


def test_a_still_channel_and_whole_number_labels(trained: Cnn, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cnn, "EPOCHS", 1)
    X, _ = swings(np.random.default_rng(11), 8)
    X[:, 1] = 9.81
    model = Cnn(filters=4, members=1, steps=3).fit(X, np.arange(8) % 2)
    scores = model.decision_function(X)
    assert scores.shape == (8, 2)
    assert np.isfinite(scores).all()
    assert set(model.predict(X).tolist()) <= {0, 1}


def test_generic_model_and_one_own_take_on_real_people() -> None:
    """UTD-MHAD, seven arm gestures, one person left out: fewer steps than usual, so that the test is quick."""
    pytest.importorskip("torch", reason="torch is not installed (extra cnn)")
    path = DATA / "UTDMHAD21arm.npz"
    if not path.exists():
        pytest.skip("the recordings in ../shared/data/gestures are not here")
    with np.load(path) as file:
        kept = np.isin(file["y"], np.arange(7))
        X, y, subject = file["X"][kept].astype(float), file["y"][kept], file["subject"][kept]
    own = np.flatnonzero(subject == subject[0])
    first = np.array([next(k for k in own if y[k] == label) for label in range(7)])
    rest = np.setdiff1d(own, first)
    model = Cnn(filters=32, members=1, steps=80).fit(X[subject != subject[0]], y[subject != subject[0]])
    generic, refined = model.score(X[rest], y[rest]), model.refine(X[first], y[first]).score(X[rest], y[rest])
    assert generic > 0.6
    assert refined >= max(generic, 0.9)


def test_state_is_the_network(trained: Cnn) -> None:
    X: Any = swings(np.random.default_rng(12), 6)[0]
    np.testing.assert_array_equal(Network.from_state(trained.state()).scores(X), trained.decision_function(X))
