"""Virtual bands on real skeletons: what two wristbands would have told while a depth camera watched the arms."""

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import make_interp_spline
from scipy.linalg import solveh_banded
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation

from armspan.errors import DataError
from armspan.frames import Array

SKELETON_JOINTS = (
    *("left shoulder", "left elbow", "left wrist", "left hand"),
    *("right shoulder", "right elbow", "right wrist", "right hand"),
)
"""The order of the joints."""

BAND_COLUMNS = ("qx", "qy", "qz", "qw", "ax", "ay", "az", "gx", "gy", "gz")
"""A band's channels, as a take names them after ``left_`` or ``right_``."""

CUTOFF = 3.0
"""Low-pass [Hz]: white jitter of 1 cm in 19 frames a second still makes about 0.9 m/s² of noise; at 6 Hz, 5."""

FEWEST_FRAMES = 16

_ROLL_TIME = 0.15
_HABIT = 0.02
_NOTHING = 1e-9

_Complex: TypeAlias = NDArray[np.complex128]


def virtual_bands(
    joints: ArrayLike, rate_hz: float, *, cutoff_hz: float = CUTOFF, up: ArrayLike = (0.0, 1.0, 0.0)
) -> dict[str, Array]:
    """What bands on both wrists would tell: ``left`` and ``right``, each (n, 10) in `BAND_COLUMNS`, one row a frame.

    ``joints`` (n, 8, 3) [m] are `SKELETON_JOINTS` in right-handed axes in which ``up`` (3,) points up, by default a
    level camera's with y up. ``rate_hz`` must be the true rate: accelerations grow with its square.

    The columns are the attitude ``user_from_wrist`` (x, y, z, w), the wrist's linear acceleration without gravity
    [m/s²] and the forearm's angular rate [rad/s], both in ``user``: z up, y left along the usual line of the shoulders.
    Joints are smoothed by a Butterworth filter of second order, run forth and back (so of fourth order and without
    delay, Winter, "Biomechanics and Motor Control of Human Movement", 2009, section 3.4.4), and differentiated as
    quintic splines (a cubic one overstates accelerations of 3 Hz at 19 Hz by 8 %). The wrist's x runs from the elbow
    to the wrist. The joints do not show how the forearm is turned about it: the back of the hand is taken to look
    away from the upper arm, as with the palm down at a bent elbow; while the arm is straight, the turn is held, with
    a slight pull towards y to the left. So rates about x are the least to be trusted.

    Raises:
        DataError: on joints of another shape, NaN, fewer than `FEWEST_FRAMES` frames, a rate that is not above twice
            ``cutoff_hz``, an arm or a line of shoulders without length, or no direction ``up``.

    """
    places = _checked(joints, rate_hz, cutoff_hz)
    user_from_camera = _user_from_camera(places, np.asarray(up, dtype=float))
    smooth = sosfiltfilt(butter(2, cutoff_hz, fs=rate_hz, output="sos"), places @ user_from_camera.T, axis=0)
    sides = {"left": smooth[:, :3], "right": smooth[:, 4:7]}
    return {name: _band(arm, rate_hz, name) for name, arm in sides.items()}


def wrist_felt(band: Array, gravity: float = 9.80665) -> Array:
    """Specific force [m/s²] and angular rate [rad/s] in ``wrist`` (n, 6), as the chip feels them, of a band (n, 10)."""
    wrist_from_user = Rotation.from_quat(band[:, :4]).inv()
    force_user = band[:, 4:7] + np.array([0.0, 0.0, gravity])
    return np.hstack([wrist_from_user.apply(force_user), wrist_from_user.apply(band[:, 7:])])


def _checked(joints: ArrayLike, rate_hz: float, cutoff_hz: float) -> Array:
    places = np.asarray(joints, dtype=float)
    if places.ndim != 3 or places.shape[1:] != (8, 3):
        raise DataError(f"joints of shape {places.shape}: expected (frames, 8, 3), {', '.join(SKELETON_JOINTS)}")
    if len(places) < FEWEST_FRAMES:
        raise DataError(f"{len(places)} frames of a skeleton: at least {FEWEST_FRAMES} are needed to tell its motion")
    if not np.isfinite(places).all():
        frame = int(np.flatnonzero(~np.isfinite(places).all(axis=(1, 2)))[0])
        raise DataError(f"frame {frame} of the skeleton holds NaN or infinity: fill or cut lost frames first")
    if not 0.0 < 2.0 * cutoff_hz < rate_hz < np.inf:
        raise DataError(f"{rate_hz:g} frames a second smoothed at {cutoff_hz:g} Hz: give a cut-off below half the rate")
    return places


def _user_from_camera(places: Array, up: Array) -> Array:
    """The rotation (3, 3) from the camera's axes to z up, y from the right shoulder to the left one."""
    if up.shape != (3,) or not 0.0 < np.linalg.norm(up) < np.inf:
        raise DataError(f"up is {up.tolist()}: expected three numbers that point up in the axes of the joints")
    z = up / np.linalg.norm(up)
    line = np.median(places[:, 0] - places[:, 4], axis=0)
    left = line - (line @ z) * z
    length = float(np.linalg.norm(left))
    if length < 0.05:
        raise DataError(f"the shoulders are {length:.3f} m apart seen from above: too little to tell the front")
    y = left / length
    return np.stack([np.cross(y, z), y, z])


def _band(arm: Array, rate: float, name: str) -> Array:
    """One band's rows (n, 10) from smoothed shoulder, elbow and wrist (n, 3, 3) in ``user``."""
    shoulder, elbow, wrist = arm.transpose(1, 0, 2)
    times = np.arange(len(wrist)) / rate
    user_from_wrist = _forearm(elbow - shoulder, wrist - elbow, rate, name)
    acceleration = make_interp_spline(times, wrist, k=5)(times, 2)
    turning = make_interp_spline(times, user_from_wrist, k=5)(times, 1) @ user_from_wrist.transpose(0, 2, 1)
    # rounding aside this is skew, [rate]x
    rates = np.stack([turning[:, i, j] - turning[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=1) / 2.0
    quaternions = Rotation.from_matrix(user_from_wrist).as_quat()
    flips = np.cumprod(np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
    quaternions[1:] *= flips[:, None]
    return np.hstack([quaternions, acceleration, rates])


def _forearm(upperarm: Array, forearm: Array, rate: float, name: str) -> Array:
    """Attitudes ``user_from_wrist`` (n, 3, 3) of a forearm (n, 3), turned about itself by the elbow's plane."""
    lengths = np.linalg.norm(np.stack([upperarm, forearm]), axis=2)
    if lengths.min() < 0.01:
        frame = int(np.argmin(lengths.min(axis=0)))
        raise DataError(f"the {name} arm has no length in frame {frame}: two of its joints coincide")
    x = forearm / lengths[1][:, None]
    carried = _carried(x)
    # the length of the cross product is the sine of the elbow's angle: how far its plane can be trusted
    plane = _turn(np.cross(x, upperarm / lengths[0][:, None]), x, carried)
    habit = _turn(np.broadcast_to([0.0, 1.0, 0.0], x.shape), x, carried)
    roll = _held(plane * np.abs(plane) + _HABIT * habit, np.abs(plane) ** 2 + _HABIT * np.abs(habit), rate)
    y = roll.real[:, None] * carried + roll.imag[:, None] * np.cross(x, carried)
    return np.stack([x, y, np.cross(x, y)], axis=2)


def _carried(x: Array) -> Array:
    """Unit vectors (n, 3) across the directions x (n, 3) that do not turn about them from frame to frame."""
    least = np.eye(3)[np.argmin(np.abs(x[0]))]
    across = np.empty_like(x)
    across[0] = np.cross(x[0], least)
    for frame in range(1, len(x)):
        across[frame] = across[frame - 1] - (across[frame - 1] @ x[frame]) * x[frame]
        across[frame] /= np.linalg.norm(across[frame])
    across[0] /= np.linalg.norm(across[0])
    return across


def _turn(vectors: Array, x: Array, carried: Array) -> _Complex:
    """Vectors (n, 3) as complex numbers (n,) in the plane across x: real along ``carried``."""
    return np.asarray((vectors * carried).sum(axis=1) + 1j * (vectors * np.cross(x, carried)).sum(axis=1))


def _held(pull: _Complex, weight: Array, rate: float) -> _Complex:
    """Unit numbers (n,) near pull / weight where the weight is large, and steady where it is small.

    They minimise the sum of weight |z - pull / weight|² + (`_ROLL_TIME` rate)² |z' - z|², z' the next. Where nothing
    pulls at all, they are 1: the carried vector.
    """
    stiff = (_ROLL_TIME * rate) ** 2
    diagonal = weight + stiff * np.r_[1.0, np.full(len(weight) - 2, 2.0), 1.0] + _NOTHING
    found = solveh_banded(
        np.stack([np.r_[0.0, np.full(len(weight) - 1, -stiff)], diagonal]).astype(complex), pull + _NOTHING
    )
    return np.asarray(found / np.maximum(np.abs(found), 1e-12))
