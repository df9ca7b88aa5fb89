"""The virtual part of a room: person, bands, robots and laser, drawn from its seed."""

import numpy as np

from armspan.conductor import Settings
from armspan.config.body_file import body_from_table
from armspan.config.room_file import RoomFile
from armspan.config.virtual_entries import SimulatedBand, SimulatedPerson, SimulatedRobot
from armspan.errors import ConfigError
from armspan.records import Body
from armspan.simulation.bands import VirtualBand, draw_band
from armspan.simulation.beam import Beam
from armspan.simulation.gesture_script import Agenda, Programme
from armspan.simulation.guided import Guided
from armspan.simulation.laser import VirtualLaser, draw_laser
from armspan.simulation.person import Person, VirtualPerson, draw_person, measured_body
from armspan.simulation.receptors import ReceptorTraits, VirtualReceptors
from armspan.simulation.robots import Plant, VirtualRobots
from armspan.simulation.script import Script, Target, Trial
from armspan.simulation.second_arm import TwoArmedPerson
from armspan.simulation.world import World, zone_middles


def draw_wearer(wanted: SimulatedPerson, room: RoomFile, rng: np.random.Generator) -> Person:
    """The person who wears the virtual bands."""
    arm = (room.body or {}).get("arm", "right")
    return draw_person(rng, arm=arm, posture=room.posture, stature=wanted.stature_m, seated=wanted.seated)


def body_of(room: RoomFile, person: Person | None, rng: np.random.Generator) -> Body:
    """The measures that the room tells, or those that a virtual tape finds (ConfigError)."""
    measured = measured_body(person, rng) if person is not None else None
    if room.body is not None:
        return body_from_table(room.body, "the room")
    if measured is None:
        raise ConfigError("[body] is missing: a real person's measures are needed")
    return _to_the_millimetre(measured)


def _to_the_millimetre(body: Body) -> Body:
    """A body as it is written down from a tape."""
    forward, left, up = (round(float(value), 3) for value in body.shoulder_to_eye_m)
    return Body(
        round(float(body.eye_height_m), 3),
        (forward, left, up),
        round(float(body.shoulder_to_fingertip_m), 3),
        body.arm,
        None if body.upper_arm_m is None else round(float(body.upper_arm_m), 3),
        None if body.elbow_to_fingertip_m is None else round(float(body.elbow_to_fingertip_m), 3),
        body.covariance,
    )


def virtual_world(
    room: RoomFile,
    settings: Settings,
    person: Person | None,
    bands: list[SimulatedBand],
    robots: list[SimulatedRobot],
    rng: np.random.Generator,
    *,
    guided: bool = False,
) -> World:
    """The world of a room: its virtual robots, and the person with the bands where there is one.

    A ``guided`` person does what is wished from outside, instead of going through trials.
    """
    wanted = room.simulation.person
    someone = None
    if person is not None:
        x, y = wanted.at_m
        facing = np.pi / 2 + np.radians(wanted.facing_deg)
        both = any(_on_other_arm(band, settings) for band in bands)
        arms = np.random.default_rng([room.simulation.seed, 2])
        someone = (
            TwoArmedPerson(person, (x, -y), float(facing), rng, arms)
            if both
            else VirtualPerson(person, (x, -y), float(facing), rng)
        )
    worn = [_worn(band, settings, rng, room.simulation.seed) for band in bands]
    driven = VirtualRobots(
        tuple(robot.name for robot in robots),
        np.array([robot.start_m for robot in robots], dtype=float).reshape(-1, 2),
        np.radians([robot.heading_deg for robot in robots]),
        room.sheet,
        rng,
        Plant(),
    )
    trials = draw_trials(wanted, settings, rng) if someone else ()
    return World(
        someone,
        worn,
        driven,
        zone_middles(settings.zones),
        Guided() if guided else _agenda(trials, wanted.gestures),
        rng,
        table_height=room.simulation.table_height_m,
        light_height=room.light_height_m,
        beam=_beam(settings, robots, room.simulation.seed) if someone else None,
    )


def _agenda(trials: tuple[Trial, ...], gestures: tuple[str, ...]) -> Agenda:
    """The trials, and after them the gestures where there are any."""
    script = Script(trials)
    return Programme(script, gestures) if gestures else script


def _beam(settings: Settings, robots: list[SimulatedRobot], seed: int) -> Beam | None:
    """The virtual laser, off by what careful strapping leaves, and receptors; dice of their own change nothing else."""
    if settings.laser is None:
        return None
    own = np.random.default_rng([seed, 4])
    left, up = np.radians(settings.laser.direction_deg).tolist()
    laser = VirtualLaser(draw_laser(own, settings.laser.position_m, (left, up)))
    fitted = [robot.name for robot in robots if robot.receptor]
    return Beam(laser, VirtualReceptors(fitted, ReceptorTraits(), own) if fitted else None)


def _on_other_arm(band: SimulatedBand, settings: Settings) -> bool:
    return (band.arm or settings.body.arm) != settings.body.arm


def _worn(band: SimulatedBand, settings: Settings, rng: np.random.Generator, seed: int) -> VirtualBand:
    """A virtual band; the other arm's has dice of its own, so that what the pointing arm feels is the same without."""
    if not _on_other_arm(band, settings):
        return VirtualBand(band.name, band.segment, draw_band(rng, fusion=band.fusion), rng)
    own = np.random.default_rng([seed, 3])
    return VirtualBand(band.name, "other_forearm", draw_band(own, fusion=band.fusion), own)


def draw_trials(wanted: SimulatedPerson, settings: Settings, rng: np.random.Generator) -> tuple[Trial, ...]:
    """The targets the person is asked for, robots and zones in turn, first without and then with the cursor."""
    names = [f"robot:{name}" for name in settings.robots] + [f"zone:{zone.name}" for zone in settings.zones]
    targets: list[str] = []
    while len(targets) < wanted.trials:
        round_ = [names[k] for k in rng.permutation(len(names))]
        if targets and round_[0] == targets[-1]:
            round_ = [*round_[1:], round_[0]]
        targets.extend(round_)
    modes = {"off": (False,), "on": (True,), "both": (False, True)}[wanted.feedback]
    return tuple(Trial(Target(name), shown) for shown in modes for name in targets[: wanted.trials])
