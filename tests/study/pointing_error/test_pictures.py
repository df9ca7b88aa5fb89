import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from matplotlib.image import imread
from numpy.testing import assert_allclose

from armspan.study.pointing_error import readings
from armspan.study.pointing_error.pictures import draw_all, draw_map
from armspan.study.pointing_error.published import compare, maps
from armspan.study.pointing_error.readings import angle_curves, body_curves
from armspan.study.pointing_error.reproduction import Reproduction, optimised
from armspan.study.pointing_error.scene import front_sector, ideal_circle, published_circle, table_workplace
from armspan.study.pointing_error.unabsorbed import unabsorbed


@pytest.fixture(scope="module")
def found():
    """As `reproduction` makes it, with fewer sizes and draws."""
    circle, sizes = published_circle(), (-10, 0, 10)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(readings, "DRAWS", 2)
        angles = angle_curves(circle, sizes, np.random.default_rng(1))
    return Reproduction(
        (*angles, *body_curves(circle, sizes)), (), (), compare(circle), maps(circle), unabsorbed(table_workplace())
    )


def test_every_picture_is_written_a_thousand_pixels_wide(found, tmp_path):
    names = draw_all(found, tmp_path)
    assert names == [*(f"figure-1.3.{n}.png" for n in ("2a", "2b", "3a", "3b")), "unabsorbed.png"]
    for name in names:
        image = imread(tmp_path / name)
        assert 980 <= image.shape[1] <= 1040
        assert image[..., :3].std() > 0.02
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


def test_maps_of_equal_numbers_are_equal_pictures_and_others_are_not(found, tmp_path):
    one, two, three = (tmp_path / f"{n}.png" for n in range(3))
    draw_map(one, found.maps[0])
    draw_map(two, found.maps[0])
    moved = tuple((x + 100.0, y) for x, y in found.maps[0].unfitted)
    draw_map(three, replace(found.maps[0], unfitted=moved))
    assert one.read_bytes() == two.read_bytes() != three.read_bytes()


def test_a_reproduction_is_plain_numbers(found):
    assert json.loads(json.dumps(asdict(found), allow_nan=False))["maps"][0]["figure"] == "1.3.2a"


def test_the_reports_optimiser_beside_a_careful_one():
    """On the circle both find the place; in the front sector the report's stops short, even of rays that are right."""
    circle = {row.error: row for row in optimised(ideal_circle(), (2,))}
    assert max(circle["IMU yaw"].report_mm) < 1e-3
    front = {row.error: row for row in optimised(front_sector(), (2,))}
    assert front["whole ray about x"].report_mm[0] > 2 * front["whole ray about x"].careful_mm[0]
    assert_allclose(front["all measures"].careful_mm, 0.0, atol=1e-3)
    assert front["all measures"].report_mm[0] > 5.0
