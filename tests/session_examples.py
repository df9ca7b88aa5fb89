"""A short session with what is awkward in files, and how tests write sessions down."""

import math

from armspan import log
from armspan.records import (
    Drive,
    ImuSample,
    Light,
    Link,
    Pointed,
    RobotState,
    Say,
    Scores,
    Stop,
    Tick,
)

ROOM = {"sheet": {"width_m": 0.7}, "robots": ["é", "b"]}
HEADER = {"armspan": "0.1.0", "epoch": 0, "room": ROOM, "seed": None}
WRIST, ROBOT = "right_wrist", "cellulo_1"

SESSION = [
    Link(t=0.0, source=WRIST, up=True),
    ImuSample(t=0.0101, source=WRIST, acc=(0.1, -0.2, 9.81), gyr=(0.0, 1e-9, -0.0), quat=(1.0, 0.0, 0.0, 0.0)),
    RobotState(t=0.02, robot=ROBOT, xy=(0.1, 0.2), heading=math.pi, battery=0.5),
    Tick(t=0.05),
    ImuSample(t=0.0201, source=WRIST, acc=(1 / 3, 2 / 3, 1e22), gyr=(5e-324, 0.0, 0.0)),
    Pointed(t=0.05, source=WRIST, xy=(0.1, 0.25), covariance=((1e-4, 2e-5), (3e-5, 4e-4)), robot=ROBOT),
    Pointed(t=0.1, source=WRIST, xy=None, covariance=None, refused="the arm points up"),
    Scores(t=0.1, source=WRIST, labels=("wave", "push"), probabilities=(0.9, 0.1)),
    Light(t=0.1, robot=ROBOT, colour=(255, 0, 7)),
    Drive(t=0.15, robot=ROBOT, velocity=(0.05, 0.0), turn=0.0, until=0.65),
    Say(t=0.2, text="Point at the red robot, \u201cyes\u201d, and\nwait"),
    Stop(t=0.2, why="the arm is down"),
]


def written(path, session, header=HEADER):
    with log.LogWriter(path, header) as writer:
        for record in session:
            writer(record)
    return path
