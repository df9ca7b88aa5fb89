import numpy as np
import pytest

from armspan.study.pointing_error.feedback import QUOTED, SECONDS, simulated


@pytest.fixture(scope="module")
def rows():
    return simulated(np.random.default_rng(0), people=4)


def test_every_case_has_a_row_over_time(rows):
    assert [row.who for row in rows] == [
        "straight arm, table at 1 m",
        "natural arm, table at 1 m",
        "straight arm, floor at 2 m",
    ]
    for row in rows:
        assert row.metres.shape == row.angles.shape == (2, len(SECONDS))
        assert row.gestures % 3 == 0


def test_who_sees_the_spot_puts_it_right(rows):
    for row in rows:
        without, shown = row.metres
        assert shown[-1] < 0.6 * without[-1]
        assert shown[-1] < 0.05
        assert row.angles[1, -1] < np.radians(1.5)


def test_without_a_cursor_time_changes_little(rows):
    for row in rows:
        assert row.metres[0, 2:].max() < 2.5 * row.metres[0, 2:].min()


def test_the_same_dice_give_the_same_people(rows):
    again = simulated(np.random.default_rng(0), people=4)
    assert all(np.array_equal(one.metres, other.metres) for one, other in zip(rows, again, strict=True))


def test_documents_tell_the_end_and_the_way_there(rows):
    document = rows[0].document()
    assert document["without_mm"] == pytest.approx(1000.0 * rows[0].metres[0, -1])
    assert document["with_over_time_mm"][-1] == pytest.approx(document["with_mm"])
    assert document["with_deg"] == pytest.approx(np.degrees(rows[0].angles[1, -1]))
    assert document["simulated"] is True


def test_quoted_numbers_are_as_published():
    (laser,) = [quoted.document() for quoted in QUOTED if not quoted.simulated]
    assert laser["without_mm"] == pytest.approx(530.0)
    assert laser["with_mm"] == pytest.approx(55.0)
    assert laser["without_deg"] == pytest.approx(10.9)
    assert laser["with_deg"] == pytest.approx(0.9)
