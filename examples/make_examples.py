"""Writes pairs.csv, rays.csv and body.toml beside itself: made-up numbers from plain geometry, not recordings.

A person with a straight right arm stands at (0.45, 0.80) m before a sheet of 0.9 x 0.6 m on a table of 0.75 m, turned
by 10 degrees, and puts the fingertip on the line from the eye to the light of a robot. Each hold misses by a degree
or so, each of its samples by a little more. Run: python examples/make_examples.py
"""

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).parent
EYE_HEIGHT, SHOULDER_TO_EYE, ARM = 1.60, np.array([0.06, 0.15, 0.22]), 0.72
FEET, YAW = np.array([0.45, 0.80, 0.75]), np.radians(100.0)  # sheet_from_user: what `armspan calibrate` should find
LIGHT = -0.045
STOPS = ((0.08, 0.08), (0.82, 0.08), (0.82, 0.52), (0.08, 0.52))
TARGETS = ((0.45, 0.30, 0.0), (0.20, 0.15, 0.0), (0.70, 0.40, LIGHT))
QUATERNION = [f"forearm_q{axis}" for axis in "wxyz"]


def forearm_angles(target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Yaw and elevation [rad] in ``user`` of a straight arm whose fingertip hides a target [m] of the sheet."""
    x, y, z = (target - FEET) * [1.0, -1.0, -1.0]
    c, s = np.cos(YAW), np.sin(YAW)
    eye = np.array([0.0, 0.0, EYE_HEIGHT])
    gaze = np.array([c * x + s * y, -s * x + c * y, z]) - eye
    gaze /= np.linalg.norm(gaze)
    along = -SHOULDER_TO_EYE @ gaze
    reach = along + np.sqrt(along**2 - SHOULDER_TO_EYE @ SHOULDER_TO_EYE + ARM**2)
    forearm = (SHOULDER_TO_EYE + reach * gaze) / ARM
    return np.array([np.arctan2(forearm[1], forearm[0]), np.arcsin(forearm[2])])


def quaternion(angles: NDArray[np.float64]) -> list[str]:
    """user_from_wrist (w, x, y, z) of a forearm turned left by the yaw, then raised by the elevation."""
    cy, cp = np.cos(angles / 2)
    sy, sp = np.sin(angles / 2)
    return [f"{value:.5f}" for value in (cy * cp, sy * sp, -cy * sp, sy * cp)]


def main() -> None:
    """Write the three files."""
    rng = np.random.default_rng(1)
    with (HERE / "pairs.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["t_s", "stop", *QUATERNION, "x_m", "y_m", "z_m"])
        for stop, (x, y) in enumerate(STOPS, 1):
            meant = forearm_angles(np.array([x, y, LIGHT])) + rng.normal(0.0, np.radians(1.0), 2)
            for sample in range(5):
                shown = quaternion(meant + rng.normal(0.0, np.radians(0.2), 2))
                table.writerow([f"{6 * stop + 0.1 * sample:.1f}", stop, *shown, x, y, LIGHT])
    with (HERE / "rays.csv").open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["t_s", *QUATERNION, "z_m"])
        for number, target in enumerate(TARGETS):
            angles = forearm_angles(np.array(target)) + rng.normal(0.0, np.radians(1.0), 2)
            table.writerow([40 + 3 * number, *quaternion(angles), target[2]])
        table.writerow([49, *quaternion(np.array([0.0, np.radians(25.0)])), 0.0])  # the arm held up: no spot
    (HERE / "body.toml").write_text(
        "# Made up, like pairs.csv and rays.csv: see make_examples.py. Lengths in metres, from a tape.\n"
        "# shoulder_to_eye_m: from the pointing shoulder's pivot to the dominant eye, [forward, left, up].\n"
        f"[body]\neye_height_m = {EYE_HEIGHT:.2f}\n"
        f"shoulder_to_eye_m = [{', '.join(f'{value:.2f}' for value in SHOULDER_TO_EYE)}]\n"
        f'shoulder_to_fingertip_m = {ARM:.2f}\narm = "right"\n',
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
