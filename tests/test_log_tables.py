import csv
from itertools import count

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan import log
from armspan.errors import LogError
from armspan.records import Calibrated
from record_strategies import records
from session_examples import SESSION, written

EXACT = settings(derandomize=True, database=None, deadline=None, max_examples=60)


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    """Paths that do not exist yet."""
    folder, number = tmp_path_factory.mktemp("logs"), count()
    return lambda: folder / f"{next(number)}.mcap"


def test_tables_by_hand(fresh, tmp_path):
    calibrated = Calibrated(
        t=0.3, source="a", xyz=(1.0, 2.0, 3.0), yaw=0.5, covariance=(1.0, 2.0), rms=0.1, sigma=0.2, pairs=9
    )
    folder = tmp_path / "new" / "tables"
    tables = log.export_csv(written(fresh(), [*SESSION, calibrated]), folder)
    assert sorted(tables) == sorted(folder.iterdir())
    text = {table.stem: table.read_text("utf-8") for table in tables}
    assert text["ImuSample"] == (
        "order,arrived,t,source,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,mag_z,quat_w,quat_x,quat_y,quat_z\n"
        "1,0.0101,0.0101,right_wrist,0.1,-0.2,9.81,0.0,1e-09,-0.0,,,,1.0,0.0,0.0,0.0\n"
        "4,0.05,0.0201,right_wrist,0.3333333333333333,0.6666666666666666,1e+22,5e-324,0.0,0.0,,,,,,,\n"
    )
    assert text["Pointed"] == (
        "order,arrived,t,source,xy_x,xy_y,covariance_xx,covariance_xy,covariance_yx,covariance_yy,"
        "robot,zone,probability,decided,refused\n"
        "5,0.05,0.05,right_wrist,0.1,0.25,0.0001,2e-05,3e-05,0.0004,cellulo_1,,0.0,False,\n"
        "6,0.1,0.1,right_wrist,,,,,,,,,0.0,False,the arm points up\n"
    )
    assert text["Scores"].startswith("order,arrived,t,source,labels_0,labels_1,probabilities_0,probabilities_1\n")
    assert text["Light"] == "order,arrived,t,robot,colour_r,colour_g,colour_b,led\n8,0.1,0.1,cellulo_1,255,0,7,\n"
    assert text["Say"].endswith('0.2,0.2,"Point at the red robot, \u201cyes\u201d, and\nwait",\n')
    assert text["Calibrated"].splitlines()[0] == (
        "order,arrived,t,source,xyz_x,xyz_y,xyz_z,yaw,covariance_0,covariance_1,rms,sigma,pairs"
    )


def test_tables_are_not_overwritten_unasked(fresh, tmp_path):
    path = written(fresh(), SESSION)
    log.export_csv(path, tmp_path)
    with pytest.raises(LogError, match=r"Link\.csv exists already"):
        log.export_csv(path, tmp_path)
    assert len(log.export_csv(path, tmp_path, overwrite=True)) == 10
    with pytest.raises(LogError, match=r"Link\.csv cannot be a folder"):
        log.export_csv(path, tmp_path / "Link.csv")


@EXACT
@given(st.lists(records(), min_size=1, max_size=6))
def test_tables_hold_every_record_of_any_session(fresh, session):
    path = written(fresh(), session)
    rows = {}
    for table in log.export_csv(path, path.with_suffix(".tables")):
        with table.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                assert None not in {*row, *row.values()}  # as many cells as columns
                rows[int(row["order"])] = (table.stem, float(row["t"]))
    assert [rows[order] for order in sorted(rows)] == [(type(r).__name__, r.t) for r in session]
