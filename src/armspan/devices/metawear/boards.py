"""What a MetaWear board is made of, as its modules tell it: implementations and revisions.

A module that answers ``[m, 80]`` with two bytes, or not at all, is absent (MbientLab MetaWear-API, docs/
api-specification.md; MetaWear-SDK-Cpp 0.30.0, test/common.py and test_metawearboard.py).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from armspan.errors import DeviceError, known_names

SWITCH: Final = 0x01
LED: Final = 0x02
ACC: Final = 0x03
TEMPERATURE: Final = 0x04
HAPTIC: Final = 0x08
PROCESSOR: Final = 0x09
EVENT: Final = 0x0A
LOGGING: Final = 0x0B
TIMER: Final = 0x0C
MACRO: Final = 0x0F
SETTINGS: Final = 0x11
GYRO: Final = 0x13
LIGHT: Final = 0x14
MAG: Final = 0x15
FUSION: Final = 0x19
DEBUG: Final = 0xFE

MODULES: Final[Mapping[int, str]] = {
    SWITCH: "switch",
    LED: "LED",
    ACC: "accelerometer",
    TEMPERATURE: "temperature",
    0x05: "GPIO",
    0x06: "neopixel",
    0x07: "iBeacon",
    HAPTIC: "haptic",
    PROCESSOR: "data processor",
    EVENT: "event",
    LOGGING: "logging",
    TIMER: "timer",
    0x0D: "I2C",
    MACRO: "macro",
    0x10: "GSR",
    SETTINGS: "settings",
    0x12: "barometer",
    GYRO: "gyro",
    LIGHT: "ambient light",
    MAG: "magnetometer",
    0x16: "humidity",
    0x17: "colour",
    0x18: "proximity",
    FUSION: "sensor fusion",
    DEBUG: "debug",
}
MODELS: Final[Mapping[str, str]] = {
    "0": "MetaWear R",
    "1": "MetaWear RG",
    "2": "MetaWear C",
    "3": "MetaHealth",
    "4": "MetaTracker",
    "5": "MetaMotion R",
    "6": "MetaMotion C",
    "8": "MetaMotion S",
}
"""By the model number of the Device Information service (2a24)."""
ACC_CHIPS: Final[Mapping[int, str]] = {1: "bmi160", 3: "bma255", 4: "bmi270"}
GYRO_CHIPS: Final[Mapping[int, str]] = {0: "bmi160", 1: "bmi270"}

Module: TypeAlias = tuple[int, int, bytes]
"""Implementation, revision, and the bytes after them."""


@dataclass(frozen=True, slots=True)
class Board:
    """A board's modules by their number, those only that are there, and its model's number."""

    modules: Mapping[int, Module] = field(default_factory=dict)
    model: str = ""

    @property
    def name(self) -> str:
        """The board's name in the shop; a MetaMotion R without a light sensor is an RL."""
        name = MODELS.get(self.model, f"MetaWear of unknown model {self.model!r}")
        return f"{name}L" if self.model == "5" and LIGHT not in self.modules else name

    def has(self, module: int, revision: int = 0) -> bool:
        """Whether the module is there, at that revision or a later one."""
        return module in self.modules and self.modules[module][1] >= revision

    def implementation(self, module: int) -> int:
        """The module's implementation.

        Raises:
            DeviceError: where the board lacks it.

        """
        return self._of(module)[0]

    def revision(self, module: int) -> int:
        """The module's revision.

        Raises:
            DeviceError: where the board lacks it.

        """
        return self._of(module)[1]

    @property
    def acc_chip(self) -> str:
        """``bmi160`` or ``bmi270``.

        Raises:
            DeviceError: where there is none, or one that Armspan does not know.

        """
        return _chip("accelerometer", self.implementation(ACC), {1: "bmi160", 4: "bmi270"})

    @property
    def gyro_chip(self) -> str:
        """``bmi160`` or ``bmi270``.

        Raises:
            DeviceError: where there is none, or one that Armspan does not know.

        """
        return _chip("gyro", self.implementation(GYRO), GYRO_CHIPS)

    def _of(self, module: int) -> Module:
        if module not in self.modules:
            raise DeviceError(f"the {self.name} has no {MODULES.get(module, f'module {module:02x}')} module")
        return self.modules[module]


def board_from_replies(replies: Iterable[bytes], model: str = "") -> Board:
    """The board that gave these replies to ``[m, 80]``; a missing or a two-byte reply is an absent module.

    Raises:
        DeviceError: where a reply is none to that question.

    """
    modules = {}
    for reply in replies:
        if len(reply) < 2 or reply[1] != 0x80 or len(reply) == 3:
            raise DeviceError(f"{reply.hex() or 'nothing'} is no module's reply: [module, 80, ...] expected")
        if len(reply) > 2:
            modules[reply[0]] = (reply[2], reply[3], bytes(reply[4:]))
    return Board(modules, model)


def module_reply(board: Board, module: int) -> bytes:
    """What the board answers when asked for a module; two bytes for an absent one."""
    implementation, revision, extra = board.modules.get(module, (None, None, b""))
    head = bytes((module, 0x80))
    return head if implementation is None or revision is None else head + bytes((implementation, revision)) + extra


def board_named(name: str) -> Board:
    """One of the boards whose tables are published.

    Raises:
        DeviceError: for any other name.

    """
    if name not in NAMED:
        raise DeviceError(known_names("the MetaWear board", name, NAMED))
    return NAMED[name]


def _chip(what: str, implementation: int, chips: Mapping[int, str]) -> str:
    if implementation not in chips:
        known = ", ".join(f"{number} ({chip})" for number, chip in chips.items())
        raise DeviceError(f"the {what} is of implementation {implementation}; Armspan knows {known}")
    return chips[implementation]


def _table(model: str, replies: str) -> Board:
    return board_from_replies((bytes.fromhex(reply[:2] + "80" + reply[2:]) for reply in replies.split()), model)


_MMR_FW113 = (
    "010000 020000 030101 04010000030102 0500010303030301 070000 080000 0900001c 0a00001c 0b000208802b0000 "
    "0c000008 0d0001 0f000108 110003 120000 130001 140000 150001 16 1900000300060002000100 fe0002"
)
_MMRL_FW113 = _MMR_FW113.replace("030101", "030102").replace("120000", "12").replace("140000", "14")
_MMS = (
    "010000 0200010300 030400 04010000030102 05000203030303030301 070000 080000 0900001c 0a00001c "
    "0b0003080000fb030002 0c000008 0d0001 0f00020800 11000a0700 120000 130100 140000 150002 16 "
    "1900030300060002000100 fe000503"
)
_MMRL_CURRENT = (
    "010000 0200010300 030102 04010000030102 05000203030303030301 070000 080000 0900031c 0a00001c "
    "0b0003080000fb030002 0c000008 0d0001 0f00020800 11000a0000 12 130001 14 150002 16 "
    "1900030300060002000100 fe000603"
)
NAMED: Final[Mapping[str, Board]] = {
    "mmr_fw113": _table("5", _MMR_FW113),
    "mmrl_fw113": _table("5", _MMRL_FW113),
    "mms": _table("8", _MMS),
    "mmrl_current": _table("5", _MMRL_CURRENT),
}
"""MetaMotion R and RL of firmware 1.1.3, MetaMotion S (test/common.py), and today's RL (api-specification.md)."""
