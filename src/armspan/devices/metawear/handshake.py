"""Getting to know a board: what it is called, which modules it has, and since when it runs."""

from dataclasses import dataclass

from armspan.devices.metawear.boards import (
    ACC,
    DEBUG,
    FUSION,
    GYRO,
    HAPTIC,
    LED,
    MAG,
    PROCESSOR,
    SETTINGS,
    SWITCH,
    Board,
    board_from_replies,
)
from armspan.devices.metawear.decoding import decode
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.metawear.notifications import LogTime, Mac
from armspan.devices.metawear.talk import Carrier, Talk
from armspan.devices.metawear.wire import BOOTLOADER_SERVICE, SERVICE, ask_module, read
from armspan.errors import DeviceError, DeviceLost

INFORMATION = {"firmware": "2a26", "model": "2a24", "hardware": "2a27", "maker": "2a29", "serial": "2a25"}
"""Of the Device Information service, in the vendor's order of reading."""
NEEDED = (SWITCH, LED, ACC, HAPTIC, PROCESSOR, SETTINGS, GYRO, MAG, FUSION, DEBUG)


@dataclass(frozen=True, slots=True)
class Identity:
    """What a board says of itself, and its address where it tells it."""

    firmware: str = ""
    model: str = ""
    hardware: str = ""
    maker: str = ""
    serial: str = ""
    mac: str | None = None


@dataclass(frozen=True, slots=True)
class Met:
    """A board that has been asked: ``board`` are its modules."""

    identity: Identity
    board: Board


async def meet(talk: Talk, entry: MetaWearEntry, identity: Identity | None = None) -> Met:
    """Ask a board what it is; its name is known already where it is on a cable.

    Raises:
        DeviceError: for a board that cannot do what the entry wants, with what to try.
        DeviceLost: where it does not answer.

    """
    identity = identity or await _read_identity(talk)
    replies = [await _asked(talk, module) for module in NEEDED]
    if not any(len(reply) > 2 for reply in replies):
        raise DeviceLost(f"{entry.name} is linked but answers no question")
    board = board_from_replies(replies, identity.model)
    check(entry, board, identity)
    return Met(Identity(*_texts(identity), await _mac(talk, board)), board)


async def reference(talk: Talk) -> LogTime:
    """The board's clock now, and the number of its last reset.

    Raises:
        DeviceLost: where it does not answer.

    """
    time = decode(await talk.learn(read("log_time")), Board())
    if not isinstance(time, LogTime):
        raise DeviceLost(f"{talk.name} answered something else when asked for its clock")
    return time


def check(entry: MetaWearEntry, board: Board, identity: Identity) -> None:
    """Whether this board can do what the entry wants.

    Raises:
        DeviceError: where it cannot, with what to try.

    """
    what = f"{entry.name} ({entry.address}) is a {board.name} with firmware {identity.firmware or 'of unknown version'}"
    if not (board.has(ACC) and board.has(GYRO)):
        raise DeviceError(f"{what}, which lacks an accelerometer or a gyro; expected a MetaMotion R, RL, C or S")
    for chip in (board.acc_chip, board.gyro_chip):
        if chip not in ("bmi160", "bmi270"):
            raise DeviceError(f"{what}, whose motion chip is a {chip}; expected a BMI160 or a BMI270")
    if entry.profile == "raw" and not board.has(PROCESSOR, 3):
        revision = board.revision(PROCESSOR) if board.has(PROCESSOR) else "none"
        raise DeviceError(
            f"{what}: too old for samples with a clock (its data processor is of revision {revision}, 3 is needed); "
            "update it with MbientLab's app, or set profile = 'fusion'"
        )
    if entry.profile == "fusion" and not board.has(FUSION):
        raise DeviceError(f"{what}, which has no sensor fusion; set profile = 'raw', or use a MetaMotion")
    if entry.mode == "ndof" and not board.has(MAG):
        raise DeviceError(f"{what}, which has no magnetometer; set mode = 'imu_plus'")


def check_services(carrier: Carrier, entry: MetaWearEntry) -> None:
    """Whether this is a MetaWear board that runs its firmware.

    Raises:
        DeviceError: where it is not, with what to try.

    """
    services = carrier.services
    if services is None or SERVICE in services:
        return
    if BOOTLOADER_SERVICE in services:
        raise DeviceError(
            f"{entry.name} ({entry.address}) is in its bootloader (MetaBoot), where it only takes new firmware; finish "
            "the update with MbientLab's app, or let its battery run down and charge it"
        )
    raise DeviceError(f"{entry.name} ({entry.address}) is no MetaWear board: it does not offer the service {SERVICE}")


async def _read_identity(talk: Talk) -> Identity:
    texts = {}
    for name, short in INFORMATION.items():
        value = await talk.carrier.read(f"0000{short}-0000-1000-8000-00805f9b34fb")
        texts[name] = value.decode("ascii", "replace").strip("\0 ")
    return Identity(**texts)


async def _asked(talk: Talk, module: int) -> bytes:
    """What a module answers; some firmware answers two bytes for an absent one, some nothing at all.

    That is believed where the board answers other questions meanwhile.
    """
    question = ask_module(module)
    for _ in range(2):
        answer = await talk.ask(question, tries=2)
        if answer is not None:
            return answer
        await reference(talk)
    return question


async def _mac(talk: Talk, board: Board) -> str | None:
    if not board.has(SETTINGS):
        return None
    answer = await talk.ask(read("mac"), tries=2)
    try:
        mac = decode(answer or b"", board)
    except DeviceError:
        return None
    return mac.address if isinstance(mac, Mac) else None


def _texts(identity: Identity) -> tuple[str, str, str, str, str]:
    return identity.firmware, identity.model, identity.hardware, identity.maker, identity.serial
