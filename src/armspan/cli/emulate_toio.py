"""``armspan emulate toio``: toio cubes on one mat and an emulated radio."""

import argparse
import math
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np

from armspan.cli.emulate_ble import Truth, add_door, add_link_faults, on_air, seconds, until_told, world
from armspan.cli.ranges import integer, port
from armspan.devices.toio.mat import Mat
from armspan.devices.toio.peripheral import addresses, peripherals
from armspan.devices.toio.quantities import MATS, UNIT_M
from armspan.errors import ConfigError
from armspan.links.ble_emulated import Air
from armspan.records import Vec2

PORT = 6412
ASIDE_S, ASIDE_M = 2.0, 0.1
"""For so long is a cube lifted, and so far away is it put down."""
LEAST_SPACING_M = 0.05


def add_parser(devices: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the device and its options."""
    parser = devices.add_parser(
        "toio",
        help="toio cubes on one mat and an emulated radio",
        description="Emulate toio cubes. The first line on stdout is for a room file; Ctrl-C ends them.",
    )
    parser.add_argument("--cubes", type=_count, default=2, metavar="N", help="default: %(default)s")
    parser.add_argument("--port", type=port, default=PORT, metavar="P", help="of HCI; 0 for any; default: %(default)s")
    parser.add_argument("--mat", choices=sorted(MATS), default="ring", help="default: %(default)s")
    add_door(parser)
    faults = add_link_faults(parser)
    faults.add_argument("--kidnap-at", type=seconds, metavar="S", help="lift the first cube for 2 s")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Be the cubes until told to end."""
    return until_told(lambda: emulate(args))


async def emulate(args: argparse.Namespace) -> None:
    """Be the cubes until cancelled."""
    scene = _Scene(args)
    with ExitStack() as stack:
        truth = Truth.to(args.truth, scene.true, stack)
        await on_air(peripherals(scene.mat), args, lambda air: scene.live(air, truth))


def _count(text: str) -> int:
    return integer(text, "a number of cubes", 1, 50)


def places(n: int, mat: str) -> list[Vec2]:
    """Places [m] for n cubes in even rows, from the mat's top left corner.

    Raises:
        ConfigError: where they do not fit.

    """
    (left, top), (right, bottom) = MATS[mat]
    width, height = (right - left) * UNIT_M, (bottom - top) * UNIT_M
    columns = max(1, round(math.sqrt(n * width / height)))
    dx, dy = width / columns, height / -(-n // columns)
    if min(dx, dy) < LEAST_SPACING_M:
        raise ConfigError(f"{n} cubes do not fit on the mat {mat} of {width:.2g} x {height:.2g} m; expected fewer")
    return [((k % columns + 0.5) * dx, (k // columns + 0.5) * dy) for k in range(n)]


class _Scene:
    """The mat, and what happens on it."""

    def __init__(self, args: argparse.Namespace) -> None:
        rng = np.random.default_rng([args.seed, 4])
        self.mat = Mat(places(args.cubes, args.mat), rng.uniform(0.0, 2.0 * math.pi, args.cubes), rng, mat=args.mat)
        self._addresses = addresses(args.cubes)
        self._middle = UNIT_M * np.ptp(np.array(MATS[args.mat]), axis=0) / 2
        self._kidnap: float | None = args.kidnap_at

    async def live(self, air: Air, truth: Truth | None) -> None:
        """Let the cubes live, and be lifted."""
        await world(self._go_on, air, truth)

    def _go_on(self, t: float) -> None:
        if self._kidnap is None or t < self._kidnap:
            return
        if not self.mat.lifted[0]:
            self.mat.lift(0)
        elif t >= self._kidnap + ASIDE_S:
            x, y, heading = self.mat.pose[:, 0]
            self.mat.put_down(0, self._aside((float(x), float(y))), float(heading) + math.pi / 2)
            self._kidnap = None

    def _aside(self, xy: Vec2) -> Vec2:
        """A place nearer to the mat's middle, or beyond it."""
        way = self._middle - xy
        x, y = np.asarray(xy) + ASIDE_M * way / max(float(np.hypot(*way)), 1e-6)
        return float(x), float(y)

    def true(self, t: float) -> Sequence[dict[str, object]]:
        """What is so: places [m] from the mat's corner, headings [rad] clockwise, lights, what the motors are told."""
        return [
            {
                "address": address,
                "xy_m": self.mat.pose[:2, k].round(5).tolist(),
                "heading": round(float(self.mat.pose[2, k]) % (2.0 * math.pi), 4),
                "lifted": bool(self.mat.lifted[k]),
                "wheels": cube.wheels,
                "light": cube.light,
            }
            for k, (address, cube) in enumerate(zip(self._addresses, self.mat.cubes, strict=True))
        ]
