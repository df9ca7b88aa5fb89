"""People with two arms, for the tests of what they do with both."""

import numpy as np

from armspan.simulation.person import Person, draw_person
from armspan.simulation.second_arm import TwoArmedPerson

# The right pivot at (0, -0.2, 1.35), the right eye at (0, 0, 1.6), the left one 6 cm beside it: the middle of
# the body is 3 cm to the left of the eye, and the other pivot at (0, 0.26, 1.35).
FLAWLESS = Person(
    eye_height=1.6,
    shoulder_to_eye=(0.0, 0.2, 0.25),
    upper_arm=0.3,
    forearm=0.25,
    hand=0.2,
    eyes_apart=0.06,
)


def flawless(seed=0, **more):
    return TwoArmedPerson(
        FLAWLESS, (0.0, 0.0), 0.0, np.random.default_rng(seed), np.random.default_rng([seed, 2]), **more
    )


def drawn(seed, **more):
    """Somebody at the room's origin who faces its x."""
    rng = np.random.default_rng(seed)
    return TwoArmedPerson(draw_person(rng), (0.0, 0.0), 0.0, rng, np.random.default_rng([seed, 2]), **more)


def both(person, times):
    """The poses of the left and of the right arm."""
    one, other = person.pose(times), person.other_pose(times)
    return (one, other) if person.person.arm == "left" else (other, one)


def climbs(pose):
    """How far the forearm points up, in degrees, (m,)."""
    return np.degrees(np.arcsin(np.clip(pose.room_from_forearm[:, 2, 0], -1.0, 1.0)))
