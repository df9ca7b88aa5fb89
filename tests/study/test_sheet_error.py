import numpy as np
import pytest

from armspan.records import Sheet
from armspan.study.sheet_error import sheet_errors, sheet_rms

SHEET = Sheet(0.9, 0.6)
PLACE = ((0.45, 0.9, 0.75), 1.6)


def test_the_truth_has_no_error():
    assert sheet_errors(PLACE, PLACE, (1.6, 1.6), SHEET) == pytest.approx(np.zeros(81), abs=1e-12)


def test_a_shift_is_the_same_everywhere():
    moved = ((0.48, 0.94, 0.75), 1.6)
    assert sheet_errors(moved, PLACE, (1.6, 1.6), SHEET) == pytest.approx(np.full(81, 0.05))


def test_eye_height_and_table_height_cancel():
    """An eye believed 8 cm too high, found over a sheet 8 cm too low: not to be told apart by pointing."""
    lifted = ((0.45, 0.9, 0.83), 1.6)
    assert sheet_errors(lifted, PLACE, (1.68, 1.6), SHEET) == pytest.approx(np.zeros(81), abs=1e-12)


def test_a_turn_grows_with_the_distance_from_the_user():
    errors = sheet_errors((PLACE[0], 1.6 + 0.01), PLACE, (1.6, 1.6), SHEET).reshape(9, 9)
    away = np.hypot(np.linspace(0, 0.9, 9)[None, :] - 0.45, np.linspace(0, 0.6, 9)[:, None] - 0.9)
    assert errors == pytest.approx(2 * np.sin(0.005) * away)


def test_rms_and_no_answer():
    assert sheet_rms(np.array([0.03, 0.04])) == pytest.approx(np.sqrt(0.00125))
    assert sheet_rms(np.array([0.03, np.nan])) == np.inf
