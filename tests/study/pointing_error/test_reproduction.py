import json
from dataclasses import asdict

import numpy as np
import pytest

from armspan.study.pointing_error import readings
from armspan.study.pointing_error import reproduction as whole
from armspan.study.pointing_error.readings import angle_curves
from armspan.study.pointing_error.scene import ideal_circle
from armspan.study.pointing_error.tables import tables


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(whole, "FIGURE_SIZES", (-9, 9))
        patch.setattr(whole, "TABLE_SIZES", (5,))
        patch.setattr(readings, "DRAWS", 3)
        return whole.reproduction()


def test_every_scene_is_told_of(found):
    assert {curve.scene for curve in found.figures} == {"published circle"}
    scenes = ["ideal user, circle", "ideal user, front sector"]
    assert list(dict.fromkeys(curve.scene for curve in found.curves)) == scenes
    assert list(dict.fromkeys(row.scene for row in found.optimised)) == scenes
    assert list(dict.fromkeys(row.workplace for row in found.unabsorbed)) == ["table at 1 m", "floor at 1.5 m"]
    assert [each.figure for each in found.maps] == ["1.3.2a", "1.3.2b"]


def test_the_three_readings_of_nine(found):
    """0; the chord 2 r sin(4.5°), 9 % of the median distance from the origin; and published, 355.2 and 109.4 mm."""
    curves = {curve.error: curve for curve in found.figures}
    assert max(curves["IMU yaw"].worst_mm) < 1e-9
    assert np.allclose(curves["IMU yaw"].unfitted_mm, 2 * 1087.5 * np.sin(np.radians(4.5)))
    assert max(curves["all measures"].worst_mm) < 1e-9
    assert np.allclose(curves["all measures"].unfitted_mm, 0.09 * np.hypot(1087.5, 540.0), rtol=1e-4)
    told = {(point.figure, point.size): point.published_mm for point in found.published}
    assert told["1.3.3b", 9.0] == 355.2
    assert told["1.3.3a", -9.0] == pytest.approx(109.35)


def test_it_is_plain_and_fits_its_tables(found):
    assert json.loads(json.dumps(asdict(found), allow_nan=False))["unabsorbed"][0]["kind"] == "heading drifts"
    assert all(len(row) == len(table.columns) for table in tables(found) for row in table.rows)


def test_one_seed_one_answer(monkeypatch):
    monkeypatch.setattr(readings, "DRAWS", 3)
    one, two = (angle_curves(ideal_circle(), (5,), np.random.default_rng(whole.SEED)) for _ in range(2))
    other = angle_curves(ideal_circle(), (5,), np.random.default_rng(whole.SEED + 1))
    assert one == two != other
