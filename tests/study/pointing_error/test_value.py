import json

import numpy as np
import pytest

from armspan.study.pointing_error import moving, value
from armspan.study.pointing_error.bands import REAL_PLACES
from armspan.study.pointing_error.moving import CHOICES, REAL_SECONDS, Following
from armspan.study.pointing_error.recordings import Recordings
from armspan.study.pointing_error.stops import REAL_COUNTS
from armspan.study.pointing_error.virtual import virtual_gestures
from straight_arms import BODY, pointing_at


def following():
    """A flawless arm that follows a robot round the person for 30 s."""
    times = np.arange(0.0, 30.0, 0.2)
    points = np.column_stack([2.0 * np.cos(0.2 * times), 2.0 * np.sin(0.2 * times), 0.5 + 0.3 * np.sin(0.18 * times)])
    head = np.tile([0.0, 0.0, BODY.eye_height_m], (len(times), 1))
    return Following(BODY, times, pointing_at(points), points, head)


@pytest.fixture(scope="module")
def told():
    """The study in small with recordings, and what it told of its progress."""
    people = (virtual_gestures(np.random.default_rng(2), "natural", REAL_PLACES, repeats=2),)
    steps = []
    with pytest.MonkeyPatch.context() as patch:
        real = moving.real
        patch.setattr(moving, "real", lambda sessions, rng: real(sessions, rng, segments=2))
        patch.setattr(value, "DRAWS", 2)
        recordings = Recordings(people, (following(),))
        found = value.study(recordings, count=100, people=1, progress=lambda *what: steps.append(what))
    return found, steps


def test_real_people_stand_after_the_simulated_ones(told):
    document = told[0].document()
    for part, real in (
        ("stops", 4 * len(REAL_COUNTS)),  # one band and two, one gesture and five
        ("bands", 1),
        ("moving", len(REAL_SECONDS) * len(CHOICES)),
    ):
        simulated = [row["simulated"] for row in document[part]]
        assert simulated == [True] * (len(simulated) - real) + [False] * real, part
    assert document["bands"][-1]["who"] == "1 people, 1.5 to 3.5 m"
    assert document["bands"][-1]["one_band"]["gestures"] == 20 * 5 * 2  # draws, tested places, gestures at each


def test_it_is_plain_json_in_degrees(told):
    document = json.loads(json.dumps(told[0].document(), allow_nan=False))
    paces = [part["deg_per_s"] for part in document["miss_by_speed"]]
    assert len(paces) == 3
    assert paces == sorted(paces)
    assert max(part["miss_deg"] for part in document["miss_by_speed"]) < 1e-3


def test_progress_rises_to_its_end(told):
    steps = [(done, total) for what, done, total in told[1] if what not in ("table at 1 m", "floor at 1.5 m")]
    assert steps == [(k, 5) for k in range(6)]
    drawn = [done / total for what, done, total in told[1] if what == "table at 1 m"]
    assert drawn == sorted(drawn)
    assert drawn[-1] == 1.0
