"""A small simulated room, quick to play, and sessions played in it once for all tests of a process."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from armspan.cli.play import play
from armspan.config.house import House, open_house
from armspan.config.room_file import parse_room
from armspan.log import LogFile, read

ROOM = {
    "sheet": {"width_m": 0.6, "height_m": 0.45},
    "zones": [{"name": "pond", "polygon_m": [[0.08, 0.2], [0.18, 0.2], [0.18, 0.3], [0.08, 0.3]]}],
    "stops_m": [[0.12, 0.1], [0.5, 0.1], [0.48, 0.36]],
    "bands": [{"kind": "simulated", "name": "wrist"}],
    "robots": [
        {"kind": "simulated", "name": "ash", "start_m": [0.2, 0.1]},
        {"kind": "simulated", "name": "elm", "start_m": [0.4, 0.24], "heading_deg": 90.0},
    ],
    "simulation": {"seed": 5, "person": {"at_m": [0.3, 0.65], "trials": 1}},
}
"""Two robots, one zone, three stops near each other; one trial without the cursor and one with it."""

KINDS = [("straight", 1, "onboard"), ("straight", 2, "raw"), ("natural", 1, "raw"), ("natural", 2, "onboard")]
"""Posture, number of bands and fusion: each value of each with each of the others but once."""


def small_room(posture="straight", bands=1, fusion="onboard", seed=5, **more):
    worn = [("wrist", "forearm"), ("elbow", "upperarm")][:bands]
    entries = [{"kind": "simulated", "name": n, "segment": s, "fusion": fusion} for n, s in worn]
    simulation = ROOM["simulation"] | {"seed": seed}
    return parse_room(ROOM | {"bands": entries, "simulation": simulation, "posture": posture} | more)


class Played(NamedTuple):
    """A session that was played, and its log as bytes and as read back."""

    house: House
    data: bytes
    log: LogFile


@cache
def played(posture="straight", bands=1, fusion="onboard", seed=5) -> Played:
    return play_anew(posture, bands, fusion, seed)


def play_anew(posture="straight", bands=1, fusion="onboard", seed=5) -> Played:
    house = open_house(small_room(posture, bands, fusion, seed), seconds=90)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "small.mcap"
        play(house, path, live=False)
        return Played(house, path.read_bytes(), read(path))
