"""An emulated MetaWear board on the emulated air: its GATT table as a trace of a real one shows it."""

import math

from armspan.devices.metawear.board import MetaWearBoard
from armspan.links.ble_emulated import Characteristic, Handle, Service

SERVICE = "326a9000-85cb-9195-d9dd-464cfbbae75a"
COMMAND = "326a9001-85cb-9195-d9dd-464cfbbae75a"
NOTIFY = "326a9006-85cb-9195-d9dd-464cfbbae75a"
DFU = "00001530-1212-efde-1523-785feabcd123"
DFU_CONTROL = "00001531-1212-efde-1523-785feabcd123"
DFU_PACKET = "00001532-1212-efde-1523-785feabcd123"
BATTERY = "00002a19-0000-1000-8000-00805f9b34fb"
MAKER = "MbientLab Inc"


class MetaWearPeripheral:
    """A board as `armspan.links.ble_emulated` wants a peripheral to be."""

    def __init__(self, board: MetaWearBoard) -> None:
        self.board = board
        self.address = board.address
        self._handle: Handle | None = None
        self._was_bootloader = board.bootloader
        self._asked: tuple[float, float] | None = None

    @property
    def name(self) -> str:
        """As advertised."""
        return "MetaBoot" if self.board.bootloader else self.board.name

    @property
    def services(self) -> tuple[str, ...]:
        """As advertised."""
        return (DFU,) if self.board.bootloader else (SERVICE,)

    def table(self) -> tuple[Service, ...]:
        """Generic services first; then the bootloader's, or battery, device information and the main one."""
        if self.board.bootloader:
            control = Characteristic(DFU_CONTROL, ("write", "notify"))
            return (
                *_generic(self.name),
                Service(DFU, (Characteristic(DFU_PACKET, ("write-without-response",)), control)),
            )
        return (*_generic(self.name), *self._services())

    def _services(self) -> tuple[Service, ...]:
        model = self.board.model
        told = (
            ("2a29", MAKER), ("2a24", model.number), ("2a25", self.board.traits.serial), ("2a27", model.hardware),
            ("2a26", model.firmware),
        )  # fmt: skip
        information = tuple(Characteristic(_long(uuid), ("read",), text.encode()) for uuid, text in told)
        command = Characteristic(COMMAND, ("read", "write-without-response", "write"))
        return (
            Service(_long("180f"), (Characteristic(BATTERY, ("read", "notify")),)),
            Service(_long("180a"), information),
            Service(SERVICE, (command, Characteristic(NOTIFY, ("read", "notify")))),
        )

    def attach(self, handle: Handle) -> None:
        """The air gives its handle."""
        self._handle = handle

    def read(self, uuid: str) -> bytes:
        """The battery's level; the others are empty until they are written."""
        return bytes([self.board.traits.battery]) if uuid == BATTERY else b""

    def written(self, uuid: str, data: bytes) -> None:
        """Commands go to the board."""
        if uuid == COMMAND:
            self.board.write(data)

    def connected(self) -> None:
        """The board hears of it."""
        self._asked = None
        self.board.linked(True)

    def disconnected(self) -> None:
        """The board hears of it."""
        self.board.linked(False)

    def advance(self, t: float) -> float | None:
        """Let the board's time go on, and pass on what it says."""
        board, handle = self.board, self._handle
        for packet in board.advance(t):
            if handle is not None:
                handle.notify(NOTIFY, packet)
        if handle is not None:
            self._pass_on(handle)
        due = board.due()
        return None if due is None else math.nextafter(due, math.inf)

    def _pass_on(self, handle: Handle) -> None:
        board = self.board
        if board.wish is not None and board.wish != self._asked:
            self._asked = board.wish
            handle.ask(*board.wish)
        if board.leaving is not None:
            handle.drop(board.leaving)
        if board.bootloader != self._was_bootloader:
            self._was_bootloader = board.bootloader
            handle.renew()


def _generic(name: str) -> tuple[Service, ...]:
    access = (
        ("2a00", name.encode()), ("2a01", b"\x00\x00"), ("2a04", bytes.fromhex("0600280000005802")), ("2aa6", b"\x01"),
    )  # fmt: skip
    return (
        Service(_long("1800"), tuple(Characteristic(_long(uuid), ("read",), value) for uuid, value in access)),
        Service(_long("1801"), (Characteristic(_long("2a05"), ("indicate",), b""),)),
    )


def _long(short: str) -> str:
    return f"0000{short}-0000-1000-8000-00805f9b34fb"
