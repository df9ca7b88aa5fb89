"""What distinguishes one wristband from another, and how it is worn.

The figures are those of a MetaMotion with a BMI160 or BMI270: noise 0.16 to 0.18 mg and 7 mdeg/s per root
Hz, offsets of 20 to 40 mg and of half a deg/s and more (data sheets); heading that drifts by 1 to 3.5 deg a
minute; bursts at connection intervals of 30 to 50 ms.
"""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from armspan.frames import Array
from armspan.records import Quaternion, Vec3
from armspan.simulation.inertial import GRAVITY

Fusion: TypeAlias = Literal["onboard", "raw"]


@dataclass(frozen=True, slots=True)
class BandTraits:
    """One band and how it is worn; those traits that are left out are flawless.

    Errors of the chip: noise per root Hz, offset and its slow wander, error of scale, for acceleration
    [m/s²] and rate [rad/s]. ``segment_from_sensor`` (w, x, y, z) and ``lever`` [m], from the wrist or elbow
    in the segment's frame, tell how it is worn. Of its own fusion: ``heading`` [rad] of the room in its
    earth, ``yaw_drift`` [rad/s] and ``yaw_wander`` [rad] about it, ``tilt`` [rad] slowly varying, and the
    time over which it takes the felt force for the vertical, ``settling`` [s]. Of its clock:
    ``clock_rate`` error [s/s], ``jitter`` of the samples [s], and by how much the driver takes them for
    ``late`` and ``late_wander`` [s]. Of its radio: ``burst`` interval [s], ``delay`` [s] on top, the share
    of bursts that come an interval late and the share of samples that is lost, in runs.
    """

    fusion: Fusion = "onboard"
    rate_hz: float = 100.0
    acc_noise: float = 0.0
    gyr_noise: float = 0.0
    acc_bias: Vec3 = (0.0, 0.0, 0.0)
    gyr_bias: Vec3 = (0.0, 0.0, 0.0)
    acc_wander: float = 0.0
    gyr_wander: float = 0.0
    acc_scale: Vec3 = (0.0, 0.0, 0.0)
    gyr_scale: Vec3 = (0.0, 0.0, 0.0)
    segment_from_sensor: Quaternion = (1.0, 0.0, 0.0, 0.0)
    lever: Vec3 = (-0.05, 0.0, 0.03)
    heading: float = 0.0
    yaw_drift: float = 0.0
    yaw_wander: float = 0.0
    tilt: float = 0.0
    settling: float = 0.0
    clock_rate: float = 0.0
    jitter: float = 0.0
    late: float = 0.0
    late_wander: float = 0.0
    burst: float = 0.04
    delay: float = 0.002
    missed: float = 0.0
    loss: float = 0.0
    loss_run: float = 1.5


def draw_band(rng: np.random.Generator, *, fusion: Fusion = "onboard", upside_down: bool = False) -> BandTraits:
    """Draw one band, worn with any roll about the segment and, ``upside_down``, with x to the elbow.

    A band with its own fusion calibrates its gyroscope's offset; one that sends what it felt leaves it in.
    """
    roll = float(rng.uniform(-np.pi, np.pi))
    chip = 1.0 if fusion == "raw" else 0.15
    acc_bias, gyr_bias = rng.normal(0.0, 0.2, 3) * chip, np.radians(rng.normal(0.0, 0.5, 3)) * chip
    scales = rng.normal(0.0, 0.005, 6)
    drift = float(np.radians(rng.uniform(1.0, 3.5)) / 60.0 * rng.choice((-1.0, 1.0)))
    return BandTraits(
        fusion=fusion,
        acc_noise=170e-6 * GRAVITY,
        gyr_noise=float(np.radians(0.007)),
        acc_bias=_triple(acc_bias),
        gyr_bias=_triple(gyr_bias),
        acc_wander=0.02,
        gyr_wander=float(np.radians(0.03)),
        acc_scale=_triple(scales[:3]),
        gyr_scale=_triple(scales[3:]),
        segment_from_sensor=_worn(roll, upside_down, rng),
        lever=_lever(roll, rng),
        heading=float(rng.uniform(-np.pi, np.pi)),
        yaw_drift=drift,
        yaw_wander=float(np.radians(0.7)),
        tilt=float(np.radians(rng.uniform(0.35, 0.7))),
        settling=float(rng.uniform(3.0, 6.0)),
        clock_rate=float(rng.normal(0.0, 20e-6)),
        jitter=0.0002,
        late=float(rng.uniform(0.001, 0.004)),
        late_wander=0.0007,
        burst=float(rng.uniform(0.03, 0.05)),
        delay=float(rng.uniform(0.001, 0.003)),
        missed=0.03,
        loss=float(rng.uniform(0.005, 0.01)),
    )


def _triple(values: Array) -> Vec3:
    x, y, z = values.tolist()
    return x, y, z


def _worn(roll: float, upside_down: bool, rng: np.random.Generator) -> Quaternion:
    tilt = Rotation.from_rotvec([0.0, *np.radians(rng.normal(0.0, 3.0, 2))])
    turned = Rotation.from_rotvec([0.0, 0.0, np.pi if upside_down else 0.0])
    x, y, z, w = (Rotation.from_rotvec([roll, 0.0, 0.0]) * tilt * turned).as_quat().tolist()
    return w, x, y, z


def _lever(roll: float, rng: np.random.Generator) -> Vec3:
    # The chip lies on the skin, 3 cm from the bone's axis on the side to which its z points.
    radius = float(rng.normal(0.03, 0.004))
    along = -float(rng.uniform(0.03, 0.07))
    return along, -radius * float(np.sin(roll)), radius * float(np.cos(roll))
