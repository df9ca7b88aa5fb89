"""The fusion's calibration, kept for each board in a folder and given back at its next connection.

The firmware tells for each chip how well it is calibrated, 0 to 3, and gives ten bytes that say how; they are kept
where all the chips of the mode are at 3. Magnetometer data of less crashes the firmware when given back.
"""

import os
from dataclasses import dataclass
from pathlib import Path

import msgspec

from armspan.devices.metawear.boards import FUSION, Board
from armspan.devices.metawear.decoding import decode
from armspan.devices.metawear.notifications import CalibrationData, CalibrationState
from armspan.devices.metawear.talk import Talk
from armspan.devices.metawear.wire import MODE_SENSORS, read, write_calibration
from armspan.errors import DeviceError

GOOD = 3
BYTES = 10


class Kept(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A chip's data, as hexadecimal digits, and its accuracy when it was read."""

    data: str
    accuracy: int

    @property
    def bytes(self) -> bytes | None:
        """The data where they may be given back."""
        try:
            data = bytes.fromhex(self.data)
        except ValueError:
            return None
        return data if self.accuracy == GOOD and len(data) == BYTES else None


class Calibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is kept of one board."""

    mac: str
    firmware: str = ""
    chips: dict[str, Kept] = {}


@dataclass(frozen=True, slots=True)
class Shelf:
    """A folder with a file for each board; None keeps nothing."""

    folder: Path | None = None

    def writes(self, mac: str, mode: str) -> tuple[bytes, ...]:
        """The writes that give a board its data back; nothing where not all of them are good."""
        kept = self.load(mac)
        data = {chip: one.bytes for chip, one in kept.chips.items()} if kept is not None else {}
        acc, gyro, mag = (data.get(chip) for chip in ("acc", "gyro", "mag"))
        if acc is None or gyro is None:
            return ()
        if mode == "ndof" and mag is not None:
            return write_calibration("ndof", acc, gyro, mag)
        return write_calibration("imu_plus", acc, gyro)

    def load(self, mac: str) -> Calibration | None:
        """What is kept of a board; a file that cannot be read is as good as none, and will be written anew."""
        path = self.path(mac)
        try:
            return msgspec.json.decode(path.read_bytes(), type=Calibration) if path is not None else None
        except (OSError, msgspec.MsgspecError):
            return None

    def save(self, calibration: Calibration) -> None:
        """Keep a board's data; chips that were not asked now keep what they had.

        Raises:
            DeviceError: where the folder cannot be written to.

        """
        path, before = self.path(calibration.mac), self.load(calibration.mac)
        if path is None:
            return
        chips = {**(before.chips if before is not None else {}), **calibration.chips}
        text = msgspec.json.format(msgspec.json.encode(msgspec.structs.replace(calibration, chips=chips)), indent=2)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            aside = path.with_suffix(".part")
            aside.write_bytes(text)
            os.replace(aside, path)
        except OSError as error:
            raise DeviceError(f"the calibration of {calibration.mac} cannot be kept in {path}: {error}") from None

    def path(self, mac: str) -> Path | None:
        """The file of a board."""
        return None if self.folder is None else self.folder / f"metawear-{mac.replace(':', '').lower()}.json"


async def accuracy(talk: Talk, board: Board) -> CalibrationState | None:
    """How well a board's chips are calibrated; None where it does not tell."""
    if not board.has(FUSION, 2):
        return None
    state = _meaning(await talk.ask(read("calibration_state"), tries=1), board)
    return state if isinstance(state, CalibrationState) else None


def is_good(state: CalibrationState, mode: str) -> bool:
    """Whether all the chips of a mode are calibrated."""
    accuracies = {"acc": state.acc, "gyro": state.gyro, "mag": state.mag}
    return all(accuracies[chip] == GOOD for chip in MODE_SENSORS[mode])


async def take(talk: Talk, board: Board, mode: str) -> dict[str, Kept] | None:
    """The data of a mode's chips; None where one of them does not come."""
    chips: dict[str, Kept] = {}
    for chip in MODE_SENSORS[mode]:
        data = _meaning(await talk.ask(read(f"calibration_{chip}"), tries=2), board)
        if not isinstance(data, CalibrationData) or data.sensor != chip:
            return None
        chips[chip] = Kept(data.data.hex(), GOOD)
    return chips


def _meaning(answer: bytes | None, board: Board) -> object:
    if answer is None:
        return None
    try:
        return decode(answer, board)
    except DeviceError:
        return None
