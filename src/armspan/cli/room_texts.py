"""Room files to start from, as `armspan init` writes them."""

TOP = """\
# A room for Armspan. Lengths are metres, angles degrees; every number says its unit in its name.
# `armspan run THIS_FILE` opens it.

# How users are asked to hold the arm: "straight", or "natural", in which the elbow bends and one band sees less.
posture = "straight"

# How high the sheet lies above the floor the user stands on, by tape. Leave it out where it is not known.
table_height_m = 0.75

# The Bluetooth LE radio for real devices: left out, the system's own; "hci1", another adapter; "bumble:usb:0", a dongle
# without BlueZ; and what `armspan emulate metawear` prints.
# radio = "hci1"

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

"""

VIRTUAL = """\
# Everything here is simulated. `armspan init --devices lab` writes a room with real bands and robots, `--devices phone`
# one with a phone on the wrist.

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

"""

LAB = """\
# The bands: MetaMotion boards of MbientLab over Bluetooth LE. `armspan check --scan` lists the addresses that are heard
# (pip install 'armspan[ble]'). One sits on the forearm of the pointing arm; a second one on the upper arm sees the
# elbow's bend.
[[bands]]
kind = "metawear"
name = "wrist"
address = "E8:C9:8F:52:7B:07"  # or "usb:/dev/ttyACM0" for a MetaMotion S on its cable
segment = "forearm"
profile = "fusion"  # the board's own orientation; "raw": samples with the board's clock, the orientation found here
mode = "imu_plus"  # no compass; "ndof": with one, away from iron
# strap = "hand-at-minus-y"  # which axis of the board points to the hand; left out, the set-up finds it

# [[bands]]
# kind = "metawear"
# name = "upperarm"
# address = "F1:4A:45:90:AC:9D"
# segment = "upperarm"

# A band on the other wrist, for gestures with both arms ("right" and "left"; not told, it is the pointing arm's).
# [[bands]]
# kind = "metawear"
# name = "other"
# address = "D5:66:1B:20:3C:4E"
# arm = "left"

# The robots. The first one drives to the stops of the set-up. Cellulo by Bluetooth Classic: door = "rfcomm" (at most
# seven robots for each adapter), "relay" for EPFL's robot pool, or a serial port that the system bound to a robot.
[[robots]]
kind = "cellulo"
name = "amber"
address = "00:06:66:E7:8A:D8"
door = "rfcomm"
# adapter = "00:1A:7D:DA:71:13"  # the address of the adapter to reach it by, where there are several
led_zero_deg = 0.0  # where its light 0 sits, clockwise from straight ahead; EPFL's own programs disagree: look
led_turn = "clockwise"

[[robots]]
kind = "cellulo"
name = "birch"
address = "00:06:66:E7:8E:65"
door = "relay"
relay = "127.0.0.1:2556"

# [[robots]]
# kind = "cellulo"
# name = "cobalt"
# door = "/dev/rfcomm0"

# Sony's toio cubes (pip install 'armspan[ble]'); the sheet is then a mat: "ring", "tile" or "simple", 0.56 m wide.
# [[robots]]
# kind = "toio"
# name = "dune"
# address = "C0:22:33:44:55:66"
# mat = "ring"

# A laser on the wrist, and receptors on the robots that notice its spot: a choice that needs no set-up. In the wrist's
# frame (x to the hand, y left, z out of the back of the hand); direction_deg is how far it is turned left and up.
# [laser]
# position_m = [0.0, 0.0, -0.03]  # below the wrist
# direction_deg = [0.0, -12.0]  # a little down, so that it meets the table

# What the receptors' microcontroller sends: lines "hit NAME" and "lost NAME", over a cable, UDP or HTTP. Doors that
# listen beyond this machine need a token or a list of addresses (allow).
# [[receptors]]
# kind = "serial"
# name = "cable"
# path = "/dev/ttyUSB0"

# [[receptors]]
# kind = "udp"
# name = "tops"
# listen = "127.0.0.1:47701"

# [[receptors]]
# kind = "http"
# name = "web"
# listen = "127.0.0.1:47702"

"""

PHONE = """\
# A phone strapped to the wrist, screen up, its top edge to the hand (pip install 'armspan[phone]'). app = "browser":
# the page that `armspan run` shows as a QR code. "sensor-logger": the app of that name pushes to listen, from a phone
# or (stream = "watch") a watch. "sensor-server": the Android app of that name is asked at url = "ws://192.168.1.23:8080".
[[bands]]
kind = "phone"
name = "wrist"
app = "browser"
listen = "0.0.0.0:8443"  # all of this machine's networks: only with a token, which the QR code carries
token = "change-me-to-something-long"
rate_hz = 60.0

# The robots are simulated. `armspan init --devices lab` writes a room with real ones.
[[robots]]
kind = "simulated"
name = "amber"
start_m = [0.45, 0.20]

[[robots]]
kind = "simulated"
name = "birch"
start_m = [0.30, 0.40]

"""

BODY = """\
# The user's measures, from a tape.
# shoulder_to_eye_m runs from the pivot of the pointing shoulder to the dominant eye: [forward, left, up].
[body]
eye_height_m = 1.60
shoulder_to_eye_m = [0.06, 0.15, 0.22]
shoulder_to_fingertip_m = 0.72
arm = "right"
# upper_arm_m = 0.31  # with a band on the upper arm
# elbow_to_fingertip_m = 0.43

"""

LIMITS = """\
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

"""

SIMULATION = """\
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

TOKEN = "change-me-to-something-long"
"""Stands for a token; each file that is written gets one of its own."""

ROOMS = {
    "simulated": TOP + VIRTUAL + LIMITS + SIMULATION,
    "lab": TOP + LAB + BODY + LIMITS,
    "phone": TOP + PHONE + BODY + LIMITS,
}
