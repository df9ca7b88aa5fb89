"""The whole job through emulated devices: a person's MetaWear band and the table's Cellulo robots, byte by byte."""

import math
from itertools import pairwise

import numpy as np
import pytest

import fast_time
from armspan.config.demo_room import demo_room
from armspan.config.house import open_emulated
from armspan.errors import ConfigError
from armspan.links.waves import LinkFaults
from armspan.records import Calibrated, ImuSample, Link, RobotState, Selected, Stop

BREAK = 15.0


@pytest.fixture(scope="module")
def played():
    """A session in which the band's link breaks during the set-up's third stop."""
    with pytest.MonkeyPatch.context() as patch:
        fast_time.hasten(patch)
        house = open_emulated(demo_room(3, trials=2, feedback="off"), "metawear", "cellulo")
        house.emulation.faults = LinkFaults(loss=0.01, burst_s=0.045, breaks_at=(BREAK,), away_s=0.5)
        records = []

        async def scene():
            session = house.session([records.append])
            await house.run(session, live=True)
            return np.hypot(*house.emulation.firmware.truth()[2].T)

        return house, records, fast_time.run(scene, 400.0)


def of(kind, records):
    return [record for record in records if isinstance(record, kind)]


def test_the_person_is_placed_and_points(played):
    house, records, _ = played
    (found, *_) = of(Calibrated, records)
    truth = house.world.truth
    assert math.dist(found.xyz[:2], truth.xyz[:2]) < 0.4
    right = [choice for choice in of(Selected, records) if choice.how == "dwell"]
    assert len(right) >= 2


def test_a_link_that_breaks_costs_no_heading(played):
    _, records, _ = played
    links = [(record.up, record.fresh) for record in of(Link, records) if record.source == "wrist"]
    assert links[:3] == [(True, True), (False, False), (True, False)]


def test_samples_and_states_come_as_they_were_measured(played):
    _, records, _ = played
    times = [sample.t for sample in of(ImuSample, records)]
    assert all(b > a for a, b in pairwise(times))
    assert 0.97 < np.median(np.diff(times)) / 0.01 < 1.03
    assert {state.robot for state in of(RobotState, records)} == {"amber", "birch", "cobalt", "dune"}


def test_the_robots_stand_at_the_end(played):
    _, records, speeds = played
    assert isinstance(records[-1], Stop) or any(isinstance(record, Stop) for record in records[-10:])
    assert speeds.max() < 0.03


def test_devices_live_by_the_clock(played):
    house, _, _ = played

    async def scene():
        await house.run(house.session([]), live=False)

    with pytest.raises(ConfigError, match="leave --pace fast out"):
        fast_time.run(scene)
