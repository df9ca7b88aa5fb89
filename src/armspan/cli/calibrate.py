"""``armspan calibrate``: the user's place from recorded pairs, and spots predicted from it."""

import argparse
import dataclasses
import sys
import time
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from armspan.cli.results import Results
from armspan.config.body_file import read_body
from armspan.config.recordings import Recording, read_pairs, read_rays
from armspan.errors import CalibrationError, ConfigError, DataError
from armspan.frames import Array, rotation_from_quaternion
from armspan.pointing.calibration import METHODS, Fit, calibrate, quality
from armspan.pointing.pairs import Pairs, moving_pairs, still_pairs
from armspan.pointing.parameters import Parameter
from armspan.pointing.priors import PITCH_SD, TABLE_SD, Priors
from armspan.pointing.rays import default_model
from armspan.pointing.spots import Spot, spot
from armspan.records import MODELS, Body, Model

SUSPECT = float(np.radians(8.0))
"""Residual [rad] above which the frame of the points may be the other way up."""


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb and its options."""
    parser = subparsers.add_parser(
        "calibrate",
        help="find the user's place from recorded pairs of arm and point",
        description=(
            "Find where the user stands relative to the sheet from recorded pairs of arm attitude and point. "
            "Columns of PAIRS.csv: t_s; stop (leave it out for moving data); forearm_qw..qz (user_from_wrist, w first, "
            "x along the forearm to the hand); upperarm_qw..qz for a second band; x_m, y_m, z_m of the very point "
            "pointed at, z into the table unless --z-up. Spots of --predict are drawn a little towards the area."
        ),
    )
    add = parser.add_argument
    add("pairs", type=Path, metavar="PAIRS.csv", help="arm attitudes and the points pointed at")
    add("--body", type=Path, required=True, metavar="BODY.toml", help="the person's measures")
    add(
        "--model",
        choices=MODELS,
        help="the line the arm points along (default: two-band if it can be, else head-finger)",
    )
    add("--method", choices=METHODS, default="least-squares", help="how to fit (default: %(default)s)")
    add("--z-up", action="store_true", help="the points' frame has z up (default: z into the table)")
    add("--predict", type=Path, metavar="RAYS.csv", help="further arms, whose spots are predicted")
    add("--anywhere", action="store_true", help="predict without assuming that people point near the area calibrated")
    add(
        "--table-height-m",
        type=float,
        metavar="H",
        help="height of z = 0 above the user's floor, if it is known (best with --free-body)",
    )
    add("--free-pitch", action="store_true", help="let the band sit turned on the wrist (prior: 3 degrees)")
    add(
        "--free-body",
        action="store_true",
        help="let the body's measures move within the covariance_m2 of BODY.toml (`armspan body` writes it)",
    )
    add("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Calibrate, print the result on stdout, and return the exit code."""
    body = read_body(args.body)
    _check_covariance(args, body)
    recording = read_pairs(args.pairs)
    rays = read_rays(args.predict) if args.predict else None
    model = args.model or default_model(body, recording.upperarm is not None)
    _check_bands(args.predict, model, rays)
    fit, solve_ms = _fit(args, body, recording, model)
    spots = [] if rays is None else _spots(fit, rays, args.anywhere)
    if args.json:
        document = _document(fit, solve_ms)
        if rays is not None:
            document["predictions"] = [_prediction(float(t), s) for t, s in zip(rays.times, spots, strict=True)]
        sys.stdout.buffer.write(msgspec.json.encode(document) + b"\n")
    else:
        _show(Results(), fit, recording, rays, spots)
    return 0


def _check_covariance(args: argparse.Namespace, body: Body) -> None:
    if args.free_body and body.covariance is None:
        raise ConfigError(
            f"{args.body} has no covariance_m2, within which --free-body lets the measures move: write a body file "
            "that has it with `armspan body --height-m 1.75 --out BODY.toml`, or leave --free-body out"
        )


def _check_bands(path: Path, model: Model, rays: Recording | None) -> None:
    if model == "two-band" and rays is not None and rays.upperarm is None:
        raise DataError(
            f"{path}, line 1: the columns upperarm_qw..qz are missing, but the two-band model needs them: record them, "
            "or calibrate with --model head-finger"
        )


def _fit(args: argparse.Namespace, body: Body, recording: Recording, model: Model) -> tuple[Fit, float]:
    """The fit and the milliseconds it took, in a second run: the first one also pays for numpy's awakening."""
    if args.table_height_m is not None and not 0.0 <= args.table_height_m <= 3.0:
        raise ConfigError(
            f"--table-height-m is {args.table_height_m:g}; expected metres between 0 and 3 above the user's floor"
        )
    height = None if args.table_height_m is None else (args.table_height_m, TABLE_SD)
    priors = Priors(height, PITCH_SD if args.free_pitch else None, args.free_body)
    try:
        pairs = _pairs(recording)
        for _ in range(2):
            started = time.perf_counter()
            fit = calibrate(body, pairs, model, z_up=args.z_up, method=args.method, priors=priors)
            took = time.perf_counter() - started
        if fit.rms > SUSPECT and _other_way_up_fits(fit, body, pairs):
            told = "without --z-up" if args.z_up else "with --z-up"
            print(f"armspan calibrate: the rays fit twice as well {told}: which way does z point?", file=sys.stderr)
    except CalibrationError as error:
        raise CalibrationError(f"{args.pairs}: {error}") from None
    return fit, 1000.0 * took


def _other_way_up_fits(fit: Fit, body: Body, pairs: Pairs) -> bool:
    try:
        return calibrate(body, pairs, fit.model, z_up=not fit.z_up).rms < fit.rms / 2.0
    except CalibrationError:
        return False


def _pairs(recording: Recording) -> Pairs:
    forearm, upperarm = _attitudes(recording)
    if recording.stops is not None:
        return still_pairs(forearm, upperarm, recording.points, recording.stops)
    return moving_pairs(forearm, upperarm, recording.points, recording.times)


def _attitudes(recording: Recording) -> tuple[Array, Array | None]:
    upperarm = None if recording.upperarm is None else rotation_from_quaternion(recording.upperarm)
    return rotation_from_quaternion(recording.forearm), upperarm


def _spots(fit: Fit, rays: Recording, anywhere: bool) -> list[Spot]:
    origins, directions = fit.rays(*_attitudes(rays))
    area = None if anywhere else fit.area
    return [
        spot(fit, origin, direction, float(point[2]), area=area)
        for origin, direction, point in zip(origins, directions, rays.points, strict=True)
    ]


def _document(fit: Fit, solve_ms: float) -> dict[str, Any]:
    residuals = [float(np.degrees(stop.residual)) for stop in fit.stops]
    document = {
        "model": fit.model,
        "method": fit.method,
        "sheet_from_user": {"xyz_m": fit.xyz.tolist(), "yaw_rad": fit.yaw},
        "covariance": fit.covariance.tolist(),
        "rms_deg": float(np.degrees(fit.rms)),
        "stops": [
            {"stop": _label(stop.stop), "residual_deg": angle, "pairs": stop.pairs, "used": stop.used}
            for stop, angle in zip(fit.stops, residuals, strict=True)
        ],
        "residual_deg": residuals,
        "condition": fit.condition,
        "solve_ms": solve_ms,
    }
    if fit.parameters:
        document |= {"parameters": [dataclasses.asdict(p) for p in fit.parameters], "body": _measures(fit.body)}
    return document


def _measures(body: Body) -> dict[str, Any]:
    """The body in use, in the keys of a body file; its doubt is told by the parameters."""
    known = {"arm": body.arm, "eye_height_m": body.eye_height_m, "shoulder_to_eye_m": body.shoulder_to_eye_m}
    known["shoulder_to_fingertip_m"] = body.shoulder_to_fingertip_m
    limbs = {"upper_arm_m": body.upper_arm_m, "elbow_to_fingertip_m": body.elbow_to_fingertip_m}
    return known | {key: value for key, value in limbs.items() if value is not None}


def _label(stop: str) -> int | str:
    return int(stop) if stop.isdecimal() else stop


def _prediction(t: float, found: Spot) -> dict[str, Any]:
    return {
        "t_s": t,
        "xy_m": None if found.xy is None else found.xy.tolist(),
        "covariance": None if found.covariance is None else found.covariance.tolist(),
        "refused": found.refused,
    }


def _show(console: Console, fit: Fit, recording: Recording, rays: Recording | None, spots: list[Spot]) -> None:
    sd = np.sqrt(np.diagonal(fit.covariance))
    place = Table("", r"x \[m]", r"y \[m]", r"z \[m]", r"yaw \[deg]", title="sheet_from_user")
    place.add_row("place", *(f"{v:.3f}" for v in fit.xyz), f"{np.degrees(fit.yaw):.1f}")
    place.add_row("± 1 sd", *(f"{v:.3f}" for v in sd[:3]), f"{np.degrees(sd[3]):.1f}")
    console.print(f"{fit.model} rays, {fit.method}")
    console.print(place)
    if fit.stops:
        stops = Table("stop", r"residual \[deg]", "samples", "", title="stops")
        for stop in fit.stops:
            left_out = "" if stop.used else "left out"
            stops.add_row(escape(stop.stop), f"{np.degrees(stop.residual):.2f}", str(stop.pairs), left_out)
        console.print(stops)
    if fit.parameters:
        console.print(_parameters_table(fit.parameters))
    if rays is not None:
        console.print(_spots_table(rays, spots))
    console.print(verdict(fit, len(recording.times)), soft_wrap=True)


def _parameters_table(parameters: tuple[Parameter, ...]) -> Table:
    table = Table("parameter", "found", "± 1 sd", "prior", "± 1 sd", "verdict", title="parameters")
    for parameter in parameters:
        numbers = (parameter.value, parameter.sd, parameter.prior, parameter.prior_sd)
        table.add_row(
            f"{parameter.name} \\[{'deg' if parameter.unit == 'rad' else 'm'}]",
            *(_cell(number, parameter.unit) for number in numbers),
            parameter.verdict,
        )
    return table


def _cell(number: float | None, unit: str) -> str:
    if number is None:
        return "-"
    return f"{np.degrees(number):.1f}" if unit == "rad" else f"{number:.3f}"


def _spots_table(rays: Recording, spots: list[Spot]) -> Table:
    table = Table(r"t \[s]", r"x \[m]", r"y \[m]", r"± 1 sd, longest \[m]", title="spots")
    for t, found in zip(rays.times, spots, strict=True):
        if found.xy is None or found.covariance is None:
            table.add_row(f"{t:.2f}", "-", "-", escape(found.refused or ""))
            continue
        longest = float(np.sqrt(np.linalg.eigvalsh(found.covariance)[-1]))
        table.add_row(f"{t:.2f}", *(f"{v:.3f}" for v in found.xy), f"{longest:.3f}")
    return table


def verdict(fit: Fit, samples: int) -> str:
    """How good the calibration is, in plain words."""
    degrees = np.degrees(fit.rms)
    advice = "point again" if fit.model == "two-band" else "keep the arm straight, or add a second band"
    word = f"poor: {advice}" if quality(fit) == "poor" else quality(fit)
    out = [stop.stop for stop in fit.stops if not stop.used]
    from_what = f"{len(fit.stops) - len(out)} stops" if fit.stops else f"{samples} samples of a moving point"
    text = f"The rays of {from_what} pass their points by {degrees:.1f} degrees (rms), which is {word}."
    if out:
        text += f" Left out, as it fits none of the others: stop {', '.join(out)}; point there again."
    return text
