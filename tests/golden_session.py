"""The session kept in ``tests/sessions``: what a conductor once decided, so that a change of it is seen.

``python tests/golden_session.py`` writes it anew, after a change of decisions that is meant. It is a simulated
session of the small room, up to its first choice, with every fourth sample and every fifth state, rounded: small,
and still a session, since a conductor decides from whatever events it is given.
"""

import sys
from pathlib import Path

import msgspec

from armspan.conductor import Conductor
from armspan.log import LogWriter
from armspan.records import EVENTS, ImuSample, RobotState, Selected
from small_rooms import played

PATH = Path(__file__).parent / "sessions" / "small.mcap"
KEPT = {"wrist": 4, "ash": 5, "elm": 5}
"""Of the events of each source one in so many is kept."""


def thinned(records):
    """The events of a session up to its first choice, fewer and rounded."""
    seen = dict.fromkeys(KEPT, 0)
    for record in records:
        if isinstance(record, Selected):
            return
        if not isinstance(record, EVENTS):
            continue
        if isinstance(record, ImuSample | RobotState):
            source = record.source if isinstance(record, ImuSample) else record.robot
            seen[source] += 1
            if seen[source] % KEPT[source]:
                continue
        yield msgspec.convert(rounded(msgspec.to_builtins(record)), type(record))


def rounded(value):
    """The same with five decimals."""
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return tuple(rounded(item) for item in value)
    return round(value, 5) if isinstance(value, float) else value


def write(path: Path) -> None:
    """Decide anew and write it all down."""
    conductor = Conductor(played().house.settings)
    chosen = False
    with LogWriter(path, played().log.header, overwrite=True) as log:
        for event in thinned(played().log.records):
            if chosen:
                break
            log(event)
            for output in conductor.step(event):
                log(output)
                chosen = chosen or isinstance(output, Selected)


if __name__ == "__main__":
    write(PATH)
    print(f"{PATH} is written: {PATH.stat().st_size} bytes", file=sys.stderr)
