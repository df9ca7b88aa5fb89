from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from armspan.errors import DataError
from armspan.gesture.takes import Take, check_takes, longest_gap

COLUMNS = ("right_ax", "right_ay", "right_az")


def a_take(label: str = "wave", number: int = 1, rate: float = 50.0, n: int = 100, person: str = "p") -> Take:
    rng = np.random.default_rng([number, len(label)])
    return Take(label, person, number, COLUMNS, np.arange(n) / rate, rng.standard_normal((n, 3)))


def some_takes() -> list[Take]:
    return [a_take(label, number) for label in ("wave", "clap") for number in (1, 2, 3)]


def test_sound_takes_pass_and_practice_is_left_out() -> None:
    takes = some_takes()
    takes[0] = replace(takes[0], practice=True)
    assert [take.name for take in check_takes(takes)] == [take.name for take in takes[1:]]


def with_times(change: Callable[[np.ndarray], None]) -> Callable[[Take], Take]:
    def changed(take: Take) -> Take:
        times = take.times.copy()
        change(times)
        return replace(take, times=times)

    return changed


def _set_back(times: np.ndarray) -> None:
    times[40:] -= 0.5


def _leap(times: np.ndarray) -> None:
    times[40:] += 3.0


def with_values(change: Callable[[np.ndarray], None]) -> Callable[[Take], Take]:
    def changed(take: Take) -> Take:
        values = take.values.copy()
        change(values)
        return replace(take, values=values)

    return changed


def _all_missing(values: np.ndarray) -> None:
    values[:] = np.nan


def _one_band_missing(values: np.ndarray) -> None:
    values[:, 1] = np.nan


def _gap(values: np.ndarray) -> None:
    values[20:60] = np.nan


def _flat(values: np.ndarray) -> None:
    values[:] = 1.0


def _nearly_flat(values: np.ndarray) -> None:
    values *= 0.001


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (with_times(_set_back), "jumps back"),
        (with_times(_leap), r"jumps from 0.78 to 3.8 s"),
        (with_values(_all_missing), "no number"),
        (with_values(_one_band_missing), "no number in right_ay"),
        (with_values(_gap), "missing for 0.8"),
        (with_values(_flat), "no motion"),
        (with_values(_nearly_flat), "no motion"),
        (lambda take: take.picked(COLUMNS[:2]), "lacks right_az"),
        (lambda take: replace(take, times=take.times * 2), "recorded at 25 Hz, the others at 50 Hz"),
        (lambda take: replace(take, times=take.times[:5], values=take.values[:5]), "5 samples"),
        (lambda take: replace(take, label="Wave"), "differ by case"),
    ],
)
def test_a_spoilt_take_is_named_with_what_is_wrong(spoil: Callable[[Take], Take], words: str) -> None:
    takes = some_takes()
    takes[1] = spoil(takes[1])
    with pytest.raises(DataError, match=words) as caught:
        check_takes(takes)
    assert "/p_02" in str(caught.value) or "case" in words
    assert "\n" not in str(caught.value)


def test_nothing_to_learn_from_is_said() -> None:
    with pytest.raises(DataError, match="no take to learn from: record"):
        check_takes([])
    with pytest.raises(DataError, match="practice takes are not used"):
        check_takes([replace(a_take(), practice=True)])


def test_standing_still_is_no_error_where_all_takes_of_the_label_do() -> None:
    still = [with_values(_nearly_flat)(a_take("stand", number)) for number in (1, 2, 3)]
    assert len(check_takes([*some_takes(), *still])) == 9


def test_the_longest_gap_counts_from_sample_to_sample() -> None:
    times, missing = np.arange(10) / 10, np.zeros(10, dtype=bool)
    missing[3:5] = True
    assert longest_gap(times, missing) == pytest.approx(0.3)
    assert longest_gap(times, np.zeros(10, dtype=bool)) == 0.0
