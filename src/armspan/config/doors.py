"""From a room's entries to the drivers of its devices: made here, opened by the session."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from armspan.config.room_file import RoomFile
from armspan.devices.cellulo.driver import CelluloRelay
from armspan.devices.cellulo.entry import CelluloEntry, open_cellulos
from armspan.devices.cellulo.sockets import CelluloSockets
from armspan.devices.metawear.counters import Report
from armspan.devices.metawear.driver import MetaWearBand
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.phone.driver import PhoneBands
from armspan.devices.phone.entry import PhoneEntry
from armspan.devices.receptor.driver import Receptors
from armspan.devices.toio.driver import ToioCubes
from armspan.devices.toio.entry import ToioEntry
from armspan.links.ble import OWN
from armspan.links.hci import radio_named
from armspan.ports import Source, Swarm

LAST_GAPS = 20
"""Gaps that a report spells out."""

KEPT = ".armspan"
"""The folder beside a room file in which devices keep what they must know next time: calibrations, certificates."""


class Driver(Protocol):
    """A device, or several behind one door."""

    def source(self) -> Source:
        """Its events; closing it closes the device."""


@dataclass(slots=True)
class Doors:
    """The drivers of a room, and who takes commands for whom, by the names of robots and bands."""

    drivers: list[Driver] = field(default_factory=list)
    commanded: dict[str, Swarm] = field(default_factory=dict)

    def __bool__(self) -> bool:
        return bool(self.drivers)

    def invitation(self) -> str:
        """What a person must do on other devices before anything comes from them; nothing where there is none."""
        return "\n".join(driver.invitation() for driver in self.drivers if isinstance(driver, PhoneBands))

    def reports(self) -> dict[str, object]:
        """What each device went through: samples, losses, gaps, links; by name."""
        found: dict[str, object] = {}
        for driver in self.drivers:
            if isinstance(driver, MetaWearBand):
                found[driver.entry.name] = _of_band(driver.report())
            elif isinstance(driver, PhoneBands | Receptors):
                found |= driver.report()
            elif isinstance(driver, CelluloRelay | CelluloSockets):
                found[", ".join(driver.names)] = {"poses_refused": driver.refused}
        return found

    def advice(self) -> list[str]:
        """What a person should mend, in sentences."""
        found = [
            f"{driver.entry.name}: {driver.report().trouble}"
            for driver in self.drivers
            if isinstance(driver, MetaWearBand) and driver.report().trouble and not driver.report().connections
        ]
        for driver in self.drivers:
            if isinstance(driver, PhoneBands):
                found += driver.advice()
            elif isinstance(driver, Receptors):
                found += driver.told()
        return found


def _of_band(report: Report) -> dict[str, object]:
    """A band's report as a program wants it: the gaps are counted, and the last ones told."""
    told = dataclasses.asdict(report)
    for stream in told["streams"].values():
        stream["latest_gaps"] = [dataclasses.asdict(gap) for gap in list(stream["latest_gaps"])[-LAST_GAPS:]]
    return told


def make_doors(room: RoomFile, now: Callable[[], float], folder: Path) -> Doors:
    """The drivers of a room's real devices, none of them open yet; ``now`` is the session's clock [s].

    Raises:
        ConfigError: where two devices get in each other's way, or for a radio that cannot be.
        MissingExtra: for a radio that needs a package.

    """
    kept, doors = folder / KEPT, Doors()
    for entry in room.bands:
        if isinstance(entry, MetaWearEntry):
            radio = OWN if entry.port else radio_named(entry.radio or room.radio)
            band = MetaWearBand(entry, now=now, radio=radio, calibration=kept)
            doors.drivers.append(band)
            doors.commanded[entry.name] = band
    phones = [entry for entry in room.bands if isinstance(entry, PhoneEntry)]
    if phones:
        doors.drivers.append(PhoneBands(phones, now, kept))
    cellulos = [entry for entry in room.robots if isinstance(entry, CelluloEntry)]
    for driver in open_cellulos(cellulos, room.sheet.origin_m, now):
        doors.drivers.append(driver)
        doors.commanded |= {name: driver for name in driver.names}
    cubes = [entry for entry in room.robots if isinstance(entry, ToioEntry)]
    for name in dict.fromkeys(entry.radio or room.radio for entry in cubes):
        behind = [entry for entry in cubes if (entry.radio or room.radio) == name]
        toio = ToioCubes(behind, origin_m=room.sheet.origin_m, now=now, radio=radio_named(name))
        doors.drivers.append(toio)
        doors.commanded |= {entry.name: toio for entry in behind}
    if room.receptors:
        doors.drivers.append(Receptors(room.receptors, [robot.name for robot in room.robots], now))
    return doors
