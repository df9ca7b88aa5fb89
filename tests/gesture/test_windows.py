import numpy as np

from armspan.gesture.channels import Channels
from armspan.gesture.takes import NULL, Take
from armspan.gesture.windows import clip, gesture_windows, null_windows, windows

COLUMNS = ("dev_a", "dev_b")


def a_ramp(seconds: float, gesture: tuple[float, float] | None = None, rate: float = 32.0) -> Take:
    times = np.arange(round(seconds * rate) + 1) / rate
    return Take("wave", "p", 1, COLUMNS, times, np.stack([times, -times], axis=1), False, gesture)


def test_a_clip_knows_where_its_gesture_lies_on_the_grid() -> None:
    part = clip(a_ramp(6.0, (1.5, 4.0)), Channels(COLUMNS), 32.0)
    assert part.values.shape == (192, 2)
    assert (part.start, part.end) == (47.0, 127.0)  # grid point 1 is the first
    whole = clip(a_ramp(3.0), Channels(COLUMNS), 32.0)
    assert (whole.start, whole.end) == (0.0, 95.0)


def test_windows_end_where_they_are_asked_to() -> None:
    values = np.arange(20.0).reshape(10, 2)
    cut = windows(values, 4, [3, 9])
    assert cut.shape == (2, 2, 4)
    np.testing.assert_array_equal(cut[1, 0], [12, 14, 16, 18])


def test_labels_tell_how_much_of_a_gesture_a_window_has_seen() -> None:
    part = clip(a_ramp(8.0, (2.0, 4.0)), Channels(COLUMNS), 32.0)
    X, labels = gesture_windows(part, 64, 4, [], np.random.default_rng(0))
    ends = X[:, 0, -1] + 1 / 64  # the ramp tells the time
    seen = ends[np.array(labels) == "wave"]
    null = ends[np.array(labels) == NULL]
    assert seen.min() >= 2.0 + 0.4 * 2 - 0.05
    assert seen.max() <= 4.0 + 0.1
    assert null[null < 3].max() <= 2.0 + 0.25 * 2 + 0.05
    assert null[null > 3].min() >= 4.0 + 0.6 * 2 - 0.05
    assert len(labels) == len(X)


def test_what_came_before_is_taken_from_everyday_motion() -> None:
    part = clip(a_ramp(1.0), Channels(COLUMNS), 32.0)
    X, _ = gesture_windows(part, 64, 4, [np.full((100, 2), 7.0)], np.random.default_rng(0))
    assert (X[:, :, 0] == 7.0).all()
    held, _ = gesture_windows(part, 64, 4, [], np.random.default_rng(0))
    np.testing.assert_array_equal(held[:, 0, 0], np.full(len(held), part.values[0, 0]))


def test_windows_with_a_gap_are_left_out() -> None:
    values = np.zeros((100, 2))
    values[50] = np.nan
    assert len(null_windows(values, 10, 1)) == 91 - 10
    assert len(null_windows(values[:5], 10, 1)) == 0
