"""``armspan emulate metawear``: MetaWear boards on an emulated radio, or each on a pseudo-terminal."""

import argparse
import asyncio
import functools
from collections.abc import Callable, Sequence
from contextlib import AsyncExitStack, ExitStack
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from armspan.cli.emulate_ble import Truth, add_door, add_link_faults, link_faults, on_air, seconds, until_told, world
from armspan.cli.ranges import integer, port
from armspan.config.emulated import WornBoard
from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.board_models import DEBUG, MODELS, Traits
from armspan.devices.metawear.board_usb import serve_usb
from armspan.devices.metawear.peripheral import MetaWearPeripheral
from armspan.errors import ConfigError
from armspan.links.ble_emulated import Air
from armspan.links.waves import LinkFaults
from armspan.simulation.bands import VirtualBand, draw_band
from armspan.simulation.person import VirtualPerson, draw_person

PORT = 6402
OLDER = {"mmr_fw150": "mmr_fw113", "mmrl_current": "mmrl_fw113", "mms_current": "mms"}
RESET = bytes([DEBUG, 0x01])
CLICKS_S = ((0.0, True), (0.08, False), (0.24, True), (0.32, False))
"""A double click."""
AHEAD_S = 0.06
"""So far is a movement computed in advance [s]."""
TURN_S = 1.6
"""A waving person points elsewhere every so often [s]."""


def add_parser(devices: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the device and its options."""
    parser = devices.add_parser(
        "metawear",
        help="MetaWear wristbands on an emulated radio, or on serial ports",
        description="Emulate MetaWear boards. The first line on stdout is for a room file; Ctrl-C ends them.",
    )
    parser.add_argument("--boards", type=_count, default=1, metavar="N", help="default: %(default)s")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--port", type=port, default=PORT, metavar="P", help="of HCI; 0 for any; default: %(default)s")
    where.add_argument("--usb", action="store_true", help="a serial port for each board instead: prints their paths")
    parser.add_argument("--model", choices=sorted(MODELS), help="default: mmrl_current; mms_current with --usb")
    parser.add_argument("--motion", choices=("still", "wave"), default="still", help="default: %(default)s")
    add_door(parser)
    faults = add_link_faults(parser)
    faults.add_argument("--absent", choices=("short", "silent"), default="short", help="how absent modules answer")
    faults.add_argument("--bootloader", action="store_true", help="the boards wait for new firmware")
    faults.add_argument("--old-firmware", action="store_true", help="the boards run one of years ago")
    faults.add_argument("--reset-at", type=seconds, metavar="S", help="the boards begin anew")
    faults.add_argument("--press-at", type=seconds, metavar="S", help="each button is pressed twice")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Be the boards until told to end."""
    return until_told(lambda: emulate(args))


async def emulate(args: argparse.Namespace) -> None:
    """Be the boards until cancelled.

    Raises:
        ConfigError: for words that do not go together.

    """
    if args.usb and link_faults(args) != LinkFaults(away_s=args.away_s):
        raise ConfigError("--usb is a cable: leave out what goes wrong on the radio (--drop to --silence-at)")
    scene = _Scene(args)
    with ExitStack() as stack:
        truth = Truth.to(args.truth, scene.true, stack)
        if args.usb:
            await _on_cables(scene, truth)
        else:
            peripherals = [MetaWearPeripheral(board) for board in scene.boards]
            await on_air(peripherals, args, lambda air: scene.live(air, truth))


def _count(text: str) -> int:
    return integer(text, "a number of boards", 1, 8)


def _model(args: argparse.Namespace) -> str:
    name: str = args.model or ("mms_current" if args.usb else "mmrl_current")
    if not args.old_firmware:
        return name
    if name not in OLDER:
        raise ConfigError(f"--old-firmware: the model {name} has none that is older; expected {', '.join(OLDER)}")
    return OLDER[name]


async def _on_cables(scene: "_Scene", truth: Truth | None) -> None:
    async with AsyncExitStack() as stack:
        paths = [await stack.enter_async_context(serve_usb(board)) for board in scene.boards]
        for path in paths:
            print(f'address = "usb:{path}"', flush=True)
        await scene.live(None, truth)


class _Scene:
    """The boards and who wears them."""

    def __init__(self, args: argparse.Namespace) -> None:
        traits, model = Traits(absent=args.absent, bootloader=args.bootloader), _model(args)
        self.boards = [
            MetaWearBoard(
                model,
                traits,
                address=f"E8:C9:8F:52:7B:{k:02X}",
                generator=np.random.default_rng([args.seed, 2, k]),
            )
            for k in range(1, args.boards + 1)
        ]
        self._wearers = (
            [_wearer(board, args.seed, k) for k, board in enumerate(self.boards, 1)] if args.motion == "wave" else []
        )
        self._acts = list(_acts(self.boards, args))
        self._air: Air | None = None
        self._shift = 0.0

    async def live(self, air: Air | None, truth: Truth | None) -> None:
        """Let the boards be worn, pressed and reset."""
        self._air, self._shift = air, asyncio.get_running_loop().time()
        await world(self._go_on, air, truth)

    def _go_on(self, t: float) -> None:
        for wearer in self._wearers:
            wearer.move(t + AHEAD_S, self._shift)
        due = [act for act in self._acts if act[0] <= t]
        self._acts = [act for act in self._acts if act[0] > t]
        for _, board, act in due:
            act()
            if self._air is not None:
                self._air.wake(board.address)

    def true(self, t: float) -> Sequence[dict[str, object]]:
        """What is so at ``t`` [s]: the link, the button, what the wearer sees and feels, where the forearm is."""
        lines: list[dict[str, object]] = [
            {
                "address": board.address,
                "connected": board.up,
                "pressed": board.pressed,
                "lamp": board.lamp.playing,
                "buzzes": len(board.haptics),
            }
            for board in self.boards
        ]
        for line, wearer in zip(lines, self._wearers, strict=False):
            line |= wearer.true(t)
        return lines


_Act = tuple[float, MetaWearBoard, Callable[[], None]]


def _acts(boards: Sequence[MetaWearBoard], args: argparse.Namespace) -> "list[_Act]":
    """What happens to the boards, and when [s]."""
    acts: list[_Act] = []
    for board in boards:
        if args.press_at is not None:
            acts += [(args.press_at + at, board, functools.partial(board.press, down)) for at, down in CLICKS_S]
        if args.reset_at is not None:
            acts.append((args.reset_at, board, functools.partial(board.write, RESET)))
    return sorted(acts, key=lambda act: act[0])


@dataclass
class _Wearer:
    """A virtual person who points here and there, with a board on the forearm."""

    person: VirtualPerson
    worn: WornBoard
    rng: np.random.Generator
    turns: int = 0

    def move(self, t: float, shift: float) -> None:
        """Let the board feel what the forearm does up to ``t`` [s], which the loop calls ``shift`` later."""
        while self.turns * TURN_S <= t:
            aside = 0.4 * (-1) ** self.turns * self.rng.uniform(0.5, 1.0)
            self.person.point(self.turns * TURN_S, (1.0, aside, self.rng.uniform(0.6, 1.2)))
            self.turns += 1
        self.worn.shift = shift
        self.worn.advance(t, self.person)

    def true(self, t: float) -> dict[str, object]:
        """Where the wrist is [m] and how the forearm is turned (w, x, y, z), in the room."""
        pose = self.person.pose([t])
        wxyz = Rotation.from_matrix(pose.room_from_forearm[0]).as_quat(scalar_first=True)
        return {"wrist_m": pose.wrist[0].round(4).tolist(), "room_from_forearm": wxyz.round(5).tolist()}


def _wearer(board: MetaWearBoard, seed: int, number: int) -> _Wearer:
    rng = np.random.default_rng([seed, 3, number])
    person = VirtualPerson(draw_person(rng), (0.0, 0.0), 0.0, rng)
    return _Wearer(person, WornBoard(VirtualBand(board.address, "forearm", draw_band(rng), rng), board), rng)
