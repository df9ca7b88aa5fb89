"""``armspan init``: a commented room file to start from."""

import argparse
from pathlib import Path

from armspan.errors import ConfigError

ROOM = """\
# A room for Armspan. Lengths are metres, angles degrees; every number says its unit in its name.
# `armspan run THIS_FILE` opens it. Everything here is simulated until you name real devices.

# How users are asked to hold the arm: "straight", or "natural", in which the elbow bends and one band sees less.
posture = "straight"

# How high the sheet lies above the floor the user stands on, by tape. Leave it out where it is not known.
table_height_m = 0.75

# The printed sheet the robots drive on: x to the right, y down as printed, from its upper left corner.
# The user stands at the lower edge. origin_m is where that corner lies in the robots' own coordinates.
[sheet]
width_m = 0.9
height_m = 0.6
origin_m = [0.0, 0.0]

# Named areas that can be pointed at: corners in order round each.
[[zones]]
name = "garden"
polygon_m = [[0.18, 0.16], [0.30, 0.16], [0.30, 0.28], [0.18, 0.28]]

[[zones]]
name = "harbour"
polygon_m = [[0.60, 0.34], [0.72, 0.34], [0.72, 0.46], [0.60, 0.46]]

# The bands. One sits on the forearm of the pointing arm; a second one on the upper arm sees the elbow's bend.
# kind = "simulated" (fusion = "onboard": the band's own quaternion, or "raw"), or
# kind = "replay" with log = "FILE.mcap" for the samples of an earlier session.
[[bands]]
kind = "simulated"
name = "wrist"
segment = "forearm"
fusion = "onboard"

# [[bands]]
# kind = "simulated"
# name = "upperarm"
# segment = "upperarm"

# A band on the other wrist, for gestures with both arms ("right" and "left"; not told, it is the pointing arm's).
# [[bands]]
# kind = "simulated"
# name = "other"
# arm = "left"

# The robots. The first one drives to the stops of the set-up.
[[robots]]
kind = "simulated"
name = "amber"
start_m = [0.45, 0.20]

[[robots]]
kind = "simulated"
name = "birch"
start_m = [0.30, 0.40]

[[robots]]
kind = "simulated"
name = "cobalt"
start_m = [0.62, 0.20]

# The user's measures, from a tape. A simulated person is measured by itself; a real one needs this table.
# shoulder_to_eye_m runs from the pivot of the pointing shoulder to the dominant eye: [forward, left, up].
# [body]
# eye_height_m = 1.60
# shoulder_to_eye_m = [0.06, 0.15, 0.22]
# shoulder_to_fingertip_m = 0.72
# arm = "right"
# upper_arm_m = 0.31
# elbow_to_fingertip_m = 0.43

# What robots may do at most. These are the defaults.
[limits]
speed_m_s = 0.15
lease_s = 0.3
lead_m = 0.045
body_radius_m = 0.045
gap_m = 0.01
accel_m_s2 = 1.0
latency_s = 0.05  # the longest that a command takes to a robot, or its state back
battery = 0.05  # below this share a robot is stopped

# How a choice is made: the probability a candidate needs, the one that keeps it, how long it is held (0.3 to 2 s),
# and how likely it is that nothing known is meant.
[selection]
gate = 0.8
hold = 0.65
dwell_s = 1.0
elsewhere = 0.05

# Arm gestures: a model written by `armspan train`, and what each gesture begins. `armspan swarm --list` tells all
# behaviours. One gesture must stop the robots. Robots that were chosen by pointing in the choice_s before a gesture
# are the only ones that it is for.
# [gestures]
# model = "gestures.model"
# choice_s = 8.0
# [gestures.behaviours]
# stop = "stop"
# mixing = "random-walk"
# breaststroke = "sweep"  # or sweep@garden: only that zone
# raise_both = "gather"
# arms_to_ground = "disperse"
# x_left_high = "rotate-left"
# x_right_high = "rotate-right"

# The virtual part: one seed is one session. at_m is where the person stands, in sheet coordinates.
[simulation]
seed = 1
table_height_m = 0.75  # where the virtual table truly is; the one at the top is what was measured

[simulation.person]
at_m = [0.45, 0.80]
facing_deg = 0.0
trials = 8
feedback = "both"  # "off", "on", or first off and then on
# gestures = ["mixing", "everyday:10", "stop"]  # made after the trials; needs a band on either wrist
"""


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "init",
        help="write a commented room file to start from",
        description="Write a commented room file; an existing file is never replaced.",
    )
    parser.add_argument("room", type=Path, nargs="?", default=Path("room.toml"), metavar="ROOM.toml")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Write the file."""
    try:
        with args.room.open("x", encoding="utf-8") as file:
            file.write(ROOM)
    except FileExistsError:
        raise ConfigError(f"{args.room} exists and is kept; name another file: armspan init OTHER.toml") from None
    except OSError as error:
        raise ConfigError(f"{args.room} cannot be written: {error.strerror}") from None
    print(f"{args.room} is written; open it with: armspan run {args.room}")
    return 0
