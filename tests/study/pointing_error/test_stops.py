import numpy as np
import pytest

from armspan.study.pointing_error.bands import DESK_PLACES
from armspan.study.pointing_error.monte_carlo import TABLE
from armspan.study.pointing_error.stops import COUNTS, chosen, of_people, simulated
from armspan.study.pointing_error.virtual import virtual_gestures


@pytest.fixture(scope="module")
def rows():
    return simulated((TABLE,), 400, 0)


def median(rows, words, stops, gestures=1):
    (found,) = [row for row in rows if row.who.endswith(words) and (row.stops, row.gestures) == (stops, gestures)]
    return found.median


@pytest.mark.parametrize("test", range(9))
def test_the_tested_place_is_never_among_eight_stops(test):
    assert sorted({*chosen(8)(test), test}) == list(range(9))
    assert len(chosen(8)(test)) == 8


@pytest.mark.parametrize("test", [1, 3, 5, 7])
def test_four_and_five_stops_are_corners_with_and_without_the_middle(test):
    assert sorted(chosen(4)(test)) == [0, 2, 6, 8]
    assert sorted(chosen(5)(test)) == [0, 2, 4, 6, 8]


def test_every_case_is_there(rows):
    assert len(rows) == 3 * len(COUNTS)
    assert all(row.simulated and 0.0 < row.median < row.p90 for row in rows)


def test_without_drift_more_stops_and_more_gestures_help(rows):
    assert median(rows, "no drift", 25) < median(rows, "no drift", 4) < median(rows, "no drift", 3)
    assert median(rows, "no drift", 4, 5) < median(rows, "no drift", 4)


def test_a_drift_makes_many_stops_worse_than_few(rows):
    assert median(rows, ", drift", 25) > median(rows, ", drift", 5)


def test_the_result_does_not_depend_on_who_computes_it(rows):
    def backwards(function, tasks):
        return [function(task) for task in list(tasks)[::-1]][::-1]

    assert simulated((TABLE,), 400, 0, backwards) == rows


def test_people_get_a_row_for_each_number_of_stops():
    rng = np.random.default_rng(0)
    people = [virtual_gestures(rng, "straight", DESK_PLACES, repeats=2) for _ in range(2)]
    found = of_people("two", people, rng, simulated=True, draws=1)
    assert [(row.stops, row.gestures) for row in found] == [(4, 1), (5, 1), (8, 1), (4, 5), (5, 5), (8, 5)] * 2
    assert {row.who for row in found} == {"two, one band", "two, two bands"}
    assert all(row.median < 0.3 for row in found)
    assert found[0].document()["median_mm"] == pytest.approx(1000.0 * found[0].median)
