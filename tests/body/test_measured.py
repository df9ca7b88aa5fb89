from math import sqrt

import numpy as np
import pytest

from armspan.body.anthropometry import prior
from armspan.body.fusion import fuse
from armspan.body.measured import ALIKE, measure
from armspan.body.observation import Observation
from armspan.body.told import Told
from armspan.body.views import Seen
from armspan.errors import ConfigError, DataError

MAN = Told(height_m=1.75, sex="man")
UNTOLD = Told(sex="man")


def look(*observations, notes=(), asked=None):
    """A view that always tells the same; ``asked`` collects what it was told to expect."""

    def seen(known):
        if asked is not None:
            asked.append(known)
        return Seen(tuple(Observation(*each) for each in observations), tuple(notes))

    return seen


def test_without_views_it_is_what_is_expected():
    found = measure(MAN)
    assert found.fused.body == fuse(prior(MAN), []).body
    assert np.array_equal(found.prior.mean, prior(MAN).mean)
    assert found.notes == ()


def test_one_view_is_fused_as_it_is():
    seen = ("arm length", 0.75, 0.01, "front.jpg")
    found = measure(MAN, [look(seen)])
    assert found.fused == fuse(prior(MAN), [Observation(*seen)])


@pytest.mark.parametrize("count", [2, 3])
def test_alike_pictures_are_worth_what_correlated_ones_are(count):
    """The mean of n values whose errors are correlated by r has the variance sd² (1 + (n - 1) r) / n."""
    looks = [look(("up", 0.22, 0.02, f"{number}.jpg"), ("forward", 0.12, 0.03, "")) for number in range(count - 1)]
    found = measure(MAN, [*looks, look(("up", 0.22, 0.02, "last.jpg"))])
    one = Observation("up", 0.22, 0.02 * sqrt((1.0 + ALIKE * (count - 1)) / count), "")
    other = Observation("forward", 0.12, 0.03 * sqrt((1.0 + ALIKE * (count - 2)) / (count - 1)), "")
    expected = fuse(prior(MAN), [one, other]).body
    assert found.fused.body.covariance == pytest.approx(expected.covariance)
    assert found.fused.body.shoulder_to_eye_m == pytest.approx(expected.shoulder_to_eye_m)


def test_notes_are_told_once_in_their_order():
    found = measure(MAN, [look(notes=("by height", "no eye")), look(notes=("by height", "tilted"))])
    assert found.notes == ("by height", "no eye", "tilted")


def test_what_each_view_told_is_kept():
    found = measure(MAN, [look(("up", 0.2, 0.01, "front.jpg"), notes=("a",)), look(notes=("b",))])
    assert [seen.notes for seen in found.seen] == [("a",), ("b",)]
    assert found.seen[0].observations == (Observation("up", 0.2, 0.01, "front.jpg"),)  # before it is doubted more


def test_every_view_is_asked_with_what_is_expected():
    asked = []
    found = measure(MAN, [look(asked=asked), look(asked=asked)])
    assert asked == [found.prior] * 2


def test_the_eyes_seen_stand_in_for_a_height_not_typed():
    asked = []
    found = measure(UNTOLD, [look(("eye height", 1.60, 0.01, "front.jpg"), asked=asked)])
    assert found.prior.mean[0] == pytest.approx(1.60, abs=0.003)
    assert found.prior.told.height_m is None
    assert found.fused.taken == ()  # told once, in the prior
    first, again = asked  # the view is measured anew, with the better prior
    assert again is found.prior
    assert first.covariance[0, 0] > again.covariance[0, 0]


def test_soles_are_taken_off_before_a_height_is_made_of_the_eyes():
    seen = look(("eye height", 1.60, 0.01, "front.jpg"))
    bare, shod = (measure(Told(sex="man", sole_m=sole), [seen]).prior for sole in (0.0, 0.03))
    assert shod.mean[0] == pytest.approx(bare.mean[0], abs=0.003)
    assert shod.stature == pytest.approx(bare.stature - 0.03 / 0.93, abs=0.01)


def test_two_eyes_heights_are_weighed_and_no_surer_than_the_better():
    better, worse = ("eye height", 1.60, 0.01, "front.jpg"), ("eye height", 1.66, 0.02, "side.jpg")
    both = measure(UNTOLD, [look(better), look(worse)]).prior
    assert np.allclose(both.mean, measure(UNTOLD, [look(("eye height", 1.612, 0.01, ""))]).prior.mean)  # weights 4 : 1
    assert np.allclose(both.covariance, measure(UNTOLD, [look(better)]).prior.covariance)


def test_the_other_measures_of_such_views_are_fused():
    seen = ("arm length", 0.72, 0.01, "front.jpg")
    found = measure(UNTOLD, [look(("eye height", 1.60, 0.01, "front.jpg"), seen)])
    assert found.fused.taken == (Observation(*seen),)


@pytest.mark.parametrize("looks", [(), (look(("up", 0.2, 0.01, "side.jpg")),)])
def test_neither_height_nor_eyes(looks):
    with pytest.raises(ConfigError, match=r"The height is missing: give the standing height .+ 1\.72, or a picture"):
        measure(UNTOLD, looks)


def test_a_view_that_cannot_be_measured_is_told():
    def bent(known):
        raise DataError("The right elbow is bent")

    with pytest.raises(DataError, match="elbow is bent"):
        measure(MAN, [bent])
