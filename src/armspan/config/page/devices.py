"""The devices of a room as the page lists them: link, battery, rate, loss."""

import re
from dataclasses import dataclass

from armspan.conductor.settings import BandSettings
from armspan.config.doors import Doors
from armspan.config.house import House
from armspan.devices.metawear.counters import Report
from armspan.devices.metawear.driver import MetaWearBand
from armspan.devices.phone.driver import PhoneBands
from armspan.devices.receptor.driver import Receptors
from armspan.web.host import Device
from armspan.web.shown import Shown

_COLOURS = re.compile("\x1b\\[[0-9;]*m")

SILENT = 1.0
"""Seconds without a word after which a band is told to be silent."""


@dataclass(frozen=True, slots=True)
class Told:
    """What a band's driver tells of it: battery and loss as shares, where it knows them; what is wrong."""

    battery: float | None = None
    lost: float | None = None
    trouble: str = ""


def devices_of(house: House | None, shown: Shown) -> list[Device]:
    """Every band, then every robot."""
    if house is None:
        return []
    told = told_by(house.doors)
    bands = [_band(band, house, shown, told.get(band.name)) for band in house.settings.bands]
    return [*bands, *(_robot(name, house, shown) for name in house.settings.robots)]


def told_by(doors: Doors) -> dict[str, Told]:
    """What the drivers of bands tell, by the bands' names; asked twice a second, so no list of gaps is copied."""
    found: dict[str, Told] = {}
    for driver in doors.drivers:
        if isinstance(driver, MetaWearBand):
            found[driver.entry.name] = _of_metawear(driver.report())
        elif isinstance(driver, PhoneBands):
            for name, counters in driver.report().items():
                found[name] = Told(None, share(counters["lost"], counters["samples"]))
    return found


def advice_of(doors: Doors) -> list[str]:
    """What a person should mend, in sentences, beside what the table of devices says."""
    found: list[str] = []
    for driver in doors.drivers:
        if isinstance(driver, PhoneBands):
            found += driver.advice()
        elif isinstance(driver, Receptors):
            found += driver.told()
    return found


def invitation_of(doors: Doors) -> str:
    """What to do on phones, with QR codes of blocks; the colours are those of a terminal and are left out."""
    return _COLOURS.sub("", doors.invitation())


def share(lost: float, came: float) -> float | None:
    """How many of the samples were lost, of 1; None before any."""
    return lost / (lost + came) if lost + came > 0 else None


def _of_metawear(report: Report) -> Told:
    streams = report.streams.values()
    lost = share(sum(stream.lost for stream in streams), sum(stream.samples for stream in streams))
    return Told(report.battery, lost, report.trouble)


def _band(band: BandSettings, house: House, shown: Shown, told: Told | None) -> Device:
    strip = shown.strips.get(band.name)
    heard = strip is not None and shown.t - strip.heard < SILENT and band.name not in shown.down
    arm = band.arm or shown_arm(house, shown)
    where = f"{arm} {'wrist' if band.segment == 'forearm' else 'upper arm'}"
    origin = _origin(house, band.name)
    note = "" if heard else "nothing heard: is it on, charged and near?"
    if told is not None and told.trouble and not heard:
        note = told.trouble
    return Device(
        band.name,
        "band",
        where,
        heard,
        told.battery if told else None,
        strip.rate if strip is not None and heard else None,
        told.lost if told else None,
        note or origin,
    )


def shown_arm(house: House, shown: Shown) -> str:
    """The arm that points now, which the page may have changed."""
    settings = shown.mind.settings if shown.mind is not None else house.settings
    return settings.body.arm


def _robot(name: str, house: House, shown: Shown) -> Device:
    state = shown.robots.get(name)
    note = _origin(house, name)
    if state is None:
        note = "nothing heard: is it on and on the sheet?"
    elif state.held:
        note = "lifted: put it on the sheet"
    up = state is not None and name not in shown.down
    return Device(name, "robot", "sheet", up, state.battery if state else None, None, None, note)


def _origin(house: House, name: str) -> str:
    """Whether a device is no real one."""
    if any(name in names for names in house.replayed.values()):
        return "replayed from a log"
    world = house.world
    if world is not None and (name in world.robots.names or any(band.name == name for band in world.bands)):
        return "simulated"
    return ""
