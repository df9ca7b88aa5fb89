import pytest

from armspan.study.pointing_error.published import Published
from armspan.study.pointing_error.readings import Curve
from armspan.study.pointing_error.reproduction import Optimised, Reproduction
from armspan.study.pointing_error.tables import tables
from armspan.study.pointing_error.unabsorbed import Unabsorbed


@pytest.fixture
def found():
    curve = Curve("circle", "IMU yaw", "deg", (1.0, 10.0), (0.0, 0.04), (0.0, 0.1), (19.1, 191.14))
    share = Curve("circle", "arm length", "%", (1.0,), (0.0,), (0.0,), (4.68,))
    points = (Published("1.3.3a", -9.0, "%", 109.35, 109.28), Published("1.3.3b", 2.0, "deg", 75.6, 78.53))
    optimised = (Optimised("circle", "IMU yaw", "deg", (1.0,), (3.81,), (0.62,)),)
    rows = tuple(
        Unabsorbed(place, "other eye aims", "eyes", 41.63, 54.63, 1.0, 1.0, 41.63, 6.51, "62 mm")
        for place in ("table", "floor")
    )
    return Reproduction((), (curve, share), optimised, points, (), rows)


def test_every_part_has_its_table_in_order(found):
    titles = [table.title for table in tables(found)]
    assert titles == [
        "Figure 1.3.3a, published and supposed [mm]",
        "Figure 1.3.3b, published and supposed [mm]",
        "circle: median error over its rays [mm]",
        "circle: median error over its rays [mm]",
        "circle: calibrated by Nelder-Mead on the mean angle [mm]",
        "Not absorbed, table [mm]",
        "Not absorbed, floor [mm]",
    ]


def test_rows_are_as_wide_as_their_columns(found):
    for table in tables(found):
        assert {len(row) for row in table.rows} == {len(table.columns)}


def test_numbers_are_told_in_tenths(found):
    told = tables(found)
    assert told[0].rows == (("-9", "109.3", "109.3", "-0.1"),)
    assert told[1].rows == (("+2", "75.6", "78.5", "+2.9"),)
    assert told[2].columns == ("error", "calibrated, 1 deg", "calibrated, 10 deg", "not, 1 deg", "not, 10 deg")
    assert told[2].rows == (("IMU yaw", "0.0", "0.0", "19.1", "191.1"),)
    assert told[4].rows == (("IMU yaw", "3.8", "0.6"),)
    assert told[5].rows[0][:4] == ("other eye aims", "eye", "41.6", "54.6")
