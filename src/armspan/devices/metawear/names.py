"""The published names of a MetaWear board's commands, by rule, for whoever asks for bytes by name.

A name is a path, as ``acc.bmi160.config.100Hz.8g``, ``fusion.config.mms.ndof.16g.2000dps`` or
``led.pattern.blink.green.rev0``; the board, the chip and a module's revision may stand in it or be given beside it.
Numbers may be left out of the name and given as arguments: ``acc.config`` with ``rate_hz`` 100 and ``range_g`` 8.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

from armspan.devices.metawear import boards
from armspan.devices.metawear.boards import Board, board_named
from armspan.devices.metawear.commands import PLAIN, RULES, VECTOR_LED
from armspan.devices.metawear.name_forms import Writes, checked
from armspan.devices.metawear.sessions import Steps
from armspan.errors import DeviceError, known_names

_BOARDS_OF_CHIPS: Final[Mapping[str, str]] = {"bmi160": "mmrl_current", "bmi270": "mms"}
_MODULE_OF_PREFIX: Final[Mapping[str, int]] = {
    "led": boards.LED,
    "disconnect_event": boards.LED,
    "mag": boards.MAG,
    "settings": boards.SETTINGS,
    "fusion": boards.FUSION,
    "acc": boards.ACC,
    "gyro": boards.GYRO,
}


def encode(name: str, board: Board | str | None = None, args: Mapping[str, Any] = MappingProxyType({})) -> Steps:
    """What to write, as steps with their titles (one without a title, but for whole sessions).

    Raises:
        DeviceError: for a name, an argument or a board that does not exist, or a number that must not reach the wire.

    """
    path, named_board = _placed(name, board_named(board) if isinstance(board, str) else board)
    writes = _written(path, named_board, args, of_vectors=".rev" in name)
    if isinstance(writes, bytes):
        return (("", (writes,)),)
    flat = tuple(write for write in writes if isinstance(write, bytes))
    return (("", flat),) if len(flat) == len(writes) else tuple(s for s in writes if not isinstance(s, bytes))


def forms() -> list[str]:
    """Every form of name, its arguments in braces."""
    return sorted([*PLAIN, *(rule.form for rule in RULES)])


def _placed(name: str, board: Board | None) -> tuple[str, Board]:
    """The name without board, chip and revision; and the board that they tell."""
    path, chip = _without(name, r"bmi160|bmi270|bmm150")
    path, told = _without(path, "|".join(boards.NAMED))
    if board and told and board != board_named(told):
        raise DeviceError(f"{name} is of the board {told}, but another is asked for; leave one of them out")
    board = board or board_named(told or _BOARDS_OF_CHIPS.get(chip, "mmrl_current"))
    has = {"acc": board.acc_chip, "gyro": board.gyro_chip}.get(path.split(".")[0], chip)
    if chip in _BOARDS_OF_CHIPS and chip != has:
        raise DeviceError(f"{name} is of a {chip}, the {board.name} has a {has}; choose another board")
    match = re.fullmatch(r"(.+)\.rev([<>]?=?)(\d+)(?:_led)?(.*)", path)
    if match is None:
        return path, board
    revision = int(match[3]) + {"<": -1, ">": 1}.get(match[2], 0)
    return match[1] + match[4], _revised(board, path, max(revision, 0))


def _without(path: str, words: str) -> tuple[str, str]:
    match = re.search(rf"(?:^|\.)({words})(?=\.|$)", path)
    return (path[: match.start()] + path[match.end() :], match[1]) if match else (path, "")


def _revised(board: Board, path: str, revision: int) -> Board:
    module = _MODULE_OF_PREFIX.get(path.split(".")[0])
    if module is None:
        raise DeviceError(known_names("a revision for", path.split(".")[0], _MODULE_OF_PREFIX))
    implementation, _, extra = board.modules.get(module, (0, 0, b""))
    return replace(board, modules={**board.modules, module: (implementation, revision, extra)})


def _written(path: str, board: Board, args: Mapping[str, Any], *, of_vectors: bool) -> Writes:
    if path in PLAIN:
        if args:
            raise DeviceError(f"{path} takes no {', '.join(args)}")
        return PLAIN[path](board)
    for rule in RULES:
        match = re.fullmatch(rule.pattern, path)
        if match is not None or path == rule.short:
            beside = {key: value for key, value in VECTOR_LED.items() if of_vectors and key in rule.optional}
            told = {**rule.optional, **beside, **(match.groupdict() if match else {}), **args}
            return rule.encode(board, **checked(rule, told))
    raise DeviceError(_unknown(path))


def _unknown(path: str) -> str:
    """The sentence for a name that does not exist: its module's, or the modules."""
    module = path.split(".")[0]
    near = [form for form in forms() if form.split(".")[0] == module]
    if near:
        return known_names("the MetaWear command", path, near)
    return known_names("the MetaWear command's first word", module, {form.split(".")[0] for form in forms()})
