import numpy as np
import pytest

from armspan.study.pointing_error.recordings import limb, numbered_places


def test_a_limb_points_from_joint_to_joint_with_its_side_level():
    (axes,) = limb(np.array([[0.0, 0.0, 1.0]]), np.array([[3.0, 0.0, 5.0]]))
    assert axes[:, 0] == pytest.approx([0.6, 0.0, 0.8])
    assert axes[:, 1] == pytest.approx([0.0, 1.0, 0.0])
    assert axes[:, 2] == pytest.approx([-0.8, 0.0, 0.6])


def test_places_are_numbered_row_by_row():
    targets = np.array([[x, y, 0.5] for x in (3, 1, 2) for y in (1, -1, 0)], dtype=float)
    assert numbered_places(targets).tolist() == [8, 6, 7, 2, 0, 1, 5, 3, 4]
