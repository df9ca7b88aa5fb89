"""Emulated cubes on an emulated radio: what `armspan.links.ble_emulated` asks of a peripheral.

All cubes stand on one mat, so that they can touch; whoever is called first lets the time of all go on. Bytes that are
written count from the last hundredth of a second, as the cube's own clock does.
"""

from collections.abc import Sequence

from armspan.devices.toio.cube import Note
from armspan.devices.toio.mat import FRAME_S, Mat
from armspan.devices.toio.wire import SERVICE, UUIDS
from armspan.links.ble_emulated import Characteristic, Handle, Service

PROPERTIES = {
    "id": ("read", "notify"),
    "motor": ("write-without-response", "read", "notify"),
    "light": ("write",),
    "sound": ("write",),
    "sensor": ("write", "read", "notify"),
    "button": ("read", "notify"),
    "battery": ("read", "notify"),
    "configuration": ("write", "read", "notify"),
}
NAMES = {uuid: name for name, uuid in UUIDS.items()}


def addresses(n: int) -> list[str]:
    """Made-up addresses for n cubes."""
    return [f"D0:8B:7F:00:00:{number:02X}" for number in range(1, n + 1)]


def peripherals(mat: Mat, where: Sequence[str] | None = None) -> "list[CubePeripheral]":
    """A peripheral for each cube of a mat, at the addresses told."""
    scene = _Scene(mat)
    return [CubePeripheral(scene, k, address) for k, address in enumerate(where or addresses(len(mat.cubes)))]


class _Scene:
    """A mat whose time began when it was first asked for, and what its cubes have still to notify."""

    def __init__(self, mat: Mat) -> None:
        self.mat = mat
        self.waiting: list[list[Note]] = [[] for _ in mat.cubes]
        self.now, self._began = 0.0, 0.0
        self._going = False

    def advance(self, t: float) -> None:
        """Let the mat's time go on to the air's ``t`` [s]."""
        if not self._going:
            self._began, self._going = t, True
        self.now = max(self.now, t - self._began)
        for _, cube, note in self.mat.advance(self.now):
            self.waiting[cube].append(note)


class CubePeripheral:
    """One cube of a mat on the air."""

    services: tuple[str, ...] = (SERVICE,)

    def __init__(self, scene: _Scene, number: int, address: str) -> None:
        self.address = address
        self.name = f"toio-{'ABCDEFGHJK'[number // 10 % 10]}{number % 10}p"
        self.cube = scene.mat.cubes[number]
        self._scene, self._number = scene, number
        self._handle: Handle | None = None

    def table(self) -> tuple[Service, ...]:
        """The GATT table."""
        return (Service(SERVICE, tuple(Characteristic(UUIDS[name], words) for name, words in PROPERTIES.items())),)

    def attach(self, handle: Handle) -> None:
        """The handle to notify through."""
        self._handle = handle

    def read(self, uuid: str) -> bytes:
        """Somebody reads a value."""
        return self.cube.read(NAMES[uuid])

    def written(self, uuid: str, data: bytes) -> None:
        """Somebody wrote a value."""
        self.cube.write(self._scene.now, NAMES[uuid], data)

    def connected(self) -> None:
        """A host is there."""

    def disconnected(self) -> None:
        """The host is gone: settings are forgotten, motors go on as they were told."""
        self.cube.unlinked()

    def advance(self, t: float) -> float:
        """It is time ``t`` [s]: notify what is due; called again in a hundredth of a second."""
        self._scene.advance(t)
        notes, self._scene.waiting[self._number] = self._scene.waiting[self._number], []
        for characteristic, data in notes:
            if self._handle is not None:
                self._handle.notify(UUIDS[characteristic], data)
        return t + FRAME_S
