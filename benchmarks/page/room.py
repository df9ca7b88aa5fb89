"""The room of the page's benchmarks: two bands, twenty virtual robots, four zones, a person who points."""

from pathlib import Path

from armspan.conductor import Conductor
from armspan.config.house import open_house
from armspan.config.room_file import RoomFile, ZoneEntry
from armspan.config.virtual_entries import SimulatedBand, SimulatedPerson, SimulatedRobot, Simulation
from armspan.ports import Sink
from armspan.records import Calibrated, Record, Sheet
from armspan.simulation.script import Phase

SHEET = Sheet(2.0, 1.5)
STOPS = ((0.12, 0.12), (1.88, 0.12), (1.88, 1.38), (0.12, 1.38))
ZONES = {"garden": (0.475, 0.415), "harbour": (1.0, 0.415), "market": (0.475, 1.075), "mill": (1.0, 1.075)}


def twenty_robots(seed: int = 1) -> RoomFile:
    """Robots in rows on a big sheet, zones between them; the person is asked to point again and again."""
    places = [(0.3 + 0.35 * (k % 5), 0.25 + 0.33 * (k // 5)) for k in range(20)]
    return RoomFile(
        sheet=SHEET,
        bands=(SimulatedBand("wrist"), SimulatedBand("upper arm", "upperarm")),
        robots=tuple(SimulatedRobot(f"robot{k:02}", place, 37.0 * k % 360) for k, place in enumerate(places)),
        zones=tuple(ZoneEntry(name, _square(*xy)) for name, xy in ZONES.items()),
        stops_m=STOPS,
        simulation=Simulation(seed, 0.75, SimulatedPerson((1.0, 1.75), trials=200, feedback="on")),
    )


def _square(x: float, y: float, half: float = 0.07) -> tuple[tuple[float, float], ...]:
    return ((x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half))


async def calibrated(more: float, sinks: list[Sink]) -> Conductor:
    """The room's conductor as it is ``more`` seconds after its calibration, as fast as it goes."""
    house, until = open_house(twenty_robots(), Path(), seconds=600.0), [float("inf")]

    def end_in_time(record: Record) -> None:
        if isinstance(record, Calibrated):
            until[0] = min(until[0], record.t + more)
        if record.t >= until[0] and house.world:
            house.world.script.phase = Phase.DONE

    session = house.session([*sinks, end_in_time])
    await house.run(session, live=False)
    return session.conductor  # type: ignore[return-value]
