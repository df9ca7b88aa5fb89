"""Setting a board up for a profile, finding it set up already, and leaving it as it was found.

What is on a board survives a disconnection, so nothing is taken for granted: it is cleaned first, and what it was told
is read back, since no write is acknowledged.
"""

from dataclasses import dataclass

from armspan.devices.metawear import programs, signals, wire
from armspan.devices.metawear.boards import EVENT, FUSION, HAPTIC, LED, MAG, PROCESSOR, Board
from armspan.devices.metawear.decoding import decode
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.metawear.notifications import ChipConfig, Created, FusionConfig, Ranges
from armspan.devices.metawear.quantities import OUTPUTS
from armspan.devices.metawear.talk import Talk
from armspan.errors import DeviceError, DeviceLost

TRIES = 3
SETTLE_S = 0.2
"""For a magnetometer that was stopped: one that was just powered sends zeros otherwise (MetaWear-API-Swift)."""
NOTICE_MS = 1000
"""How long a band that loses its host buzzes, so that the wearer notices."""
_QUIET_FUSION = (b"\x19\x01\x00", b"\x19\x03\x00\x7f")


class NotSetUp(DeviceLost):
    """A board that answers did not take what it was told."""


@dataclass(frozen=True, slots=True)
class SetUp:
    """How a board was set up: what decodes its notifications, and the processor that sends fused samples."""

    ranges: Ranges
    processor: int | None = None


def outputs(entry: MetaWearEntry) -> tuple[str, ...]:
    """The fusion's outputs that an entry wants; the orientation completes a sample and comes last."""
    if entry.outputs == "quaternion":
        return ("quaternion",)
    field = ("corrected_mag",) if entry.mode == "ndof" else ()
    return ("corrected_acc", "corrected_gyro", *field, "quaternion")


def clean(board: Board) -> tuple[bytes, ...]:
    """Remove and stop whatever a host before us left: processors, events, loggers, streams, chips, light."""
    chips = ("acc", "gyro", "mag") if board.has(MAG) else ("acc", "gyro")
    streams = ["acc", "gyro", "switch", *(("mag",) if board.has(MAG) else ())]
    return (
        *programs.TEAR_DOWN,
        *(_QUIET_FUSION if board.has(FUSION) else ()),
        *map(wire.stop, chips),
        *map(wire.disable_sampling, chips),
        *(wire.unsubscribe(board, stream) for stream in streams),
        *(wire.unsubscribe(board, output) for output in (OUTPUTS if board.has(FUSION) else ())),
        *((signals.play("stop_and_clear"),) if board.has(LED) else ()),
    )


async def set_up(talk: Talk, entry: MetaWearEntry, board: Board, calibration: tuple[bytes, ...] = ()) -> SetUp:
    """Clean a board, configure it and start its streams; ``calibration`` are the writes that give its data back.

    Raises:
        DeviceLost: where it does not answer.
        NotSetUp: where it did not take its settings.

    """
    await talk.tell(clean(board))
    await talk.learn(wire.read("log_time"))  # it has read all of that
    await _configure(talk, entry, board)
    await talk.tell(calibration)
    await _install_notice(talk, board)
    await talk.tell(wire.subscribe(board, "switch"))
    if entry.profile == "raw":
        processor = await _create_fused(talk, board)
        done = SetUp(ranges(entry, processor), processor)
    else:
        done = SetUp(ranges(entry))
    await talk.tell(listening(entry, board, done), running(entry))
    return done


def ranges(entry: MetaWearEntry, processor: int | None = None) -> Ranges:
    """What decodes the notifications of a board that is set up so."""
    if processor is None:
        return Ranges(entry.acc_range_g, entry.gyro_range_dps)
    return Ranges(entry.acc_range_g, entry.gyro_range_dps, {processor: "fused"})


def listening(entry: MetaWearEntry, board: Board, done: SetUp) -> tuple[bytes, ...]:
    """Subscribe to the streams, again or for the first time; nothing of what runs is touched."""
    if done.processor is not None:
        return programs.subscribe_processor(done.processor)
    return tuple(wire.subscribe(board, output) for output in outputs(entry))


def running(entry: MetaWearEntry) -> tuple[bytes, ...]:
    """Let the chips and the fusion run."""
    if entry.profile == "fusion":
        return wire.start_fusion(entry.mode, outputs(entry))
    return (*map(wire.enable_sampling, ("gyro", "acc")), *map(wire.start, ("gyro", "acc")))


def nudge(entry: MetaWearEntry) -> tuple[bytes, ...]:
    """Let outputs come again without touching the filter, which writing its switch would reset."""
    return running(entry)[:-1] if entry.profile == "fusion" else running(entry)


def leave(entry: MetaWearEntry, board: Board) -> tuple[bytes, ...]:
    """Stop everything, remove what was installed, and let the board disconnect."""
    return (*programs.TEAR_DOWN[:2], *clean(board), wire.DISCONNECT)


async def is_as_set_up(talk: Talk, entry: MetaWearEntry, board: Board) -> bool:
    """Whether a board still has the settings it was given.

    Raises:
        DeviceLost: where it does not answer.

    """
    return all([await _has(talk, board, question, wanted) for question, wanted in _settings(entry)])


def _settings(entry: MetaWearEntry) -> list[tuple[str, object]]:
    rate = entry.rate_hz
    acc, gyro = ChipConfig("acc", rate, entry.acc_range_g), ChipConfig("gyro", rate, entry.gyro_range_dps)
    if entry.profile == "raw":
        return [("acc_config", acc), ("gyro_config", gyro)]
    return [("fusion_config", FusionConfig(entry.mode, entry.acc_range_g, entry.gyro_range_dps)), ("acc_config", acc)]


async def _has(talk: Talk, board: Board, question: str, wanted: object) -> bool:
    answer = await talk.learn(wire.read(question))
    try:
        return decode(answer, board) == wanted
    except DeviceError:
        return False


async def _configure(talk: Talk, entry: MetaWearEntry, board: Board) -> None:
    acc, gyro = entry.acc_range_g, entry.gyro_range_dps
    for _ in range(TRIES):
        if entry.profile == "raw":
            rate = entry.rate_hz
            await talk.tell(wire.configure_acc(board, rate, acc), wire.configure_gyro(board, rate, gyro))
        else:
            await talk.tell(wire.configure_fusion(board, entry.mode, acc, gyro))
            await talk.wait(SETTLE_S if entry.mode == "ndof" else 0.0)
        if await is_as_set_up(talk, entry, board):
            return
    raise NotSetUp(f"{entry.name} does not keep its settings")


async def _create_fused(talk: Talk, board: Board) -> int:
    """Create the three processors of samples with a clock; each needs the number of the one before."""
    keep, _, _ = programs.fused_raw(board)
    buffer = await _create(talk, keep)
    _, fuse, _ = programs.fused_raw(board, buffer)
    fuser = await _create(talk, fuse)
    _, _, account = programs.fused_raw(board, buffer, fuser)
    return await _create(talk, account)


async def _create(talk: Talk, write: bytes) -> int:
    """The number of a new processor; an answer that is lost must not create a second one."""
    answer = await talk.ask(write, (PROCESSOR, 2), tries=1)
    created = decode(answer, Board()) if answer is not None else None
    if not isinstance(created, Created):
        raise NotSetUp(f"{talk.name} did not create a data processor")
    return created.number


async def _install_notice(talk: Talk, board: Board) -> None:
    """Let the board blink and buzz when it loses its host; a board that will not do so is still a band."""
    writes: list[bytes] = []
    if board.has(LED):
        writes = [signals.led_preset(board, "blink", "red", repeat=10), signals.play("play")]
    if board.has(HAPTIC):
        writes.append(signals.motor(100, NOTICE_MS))
    for write in writes:
        head, parameters = programs.on_disconnect([write])
        await talk.ask(head, (EVENT, 2), tries=1, rest=(parameters,))
