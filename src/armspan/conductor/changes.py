"""Presses that change the room while it is open: zones, the dictionary of gestures, the person's measures.

They are events like any other, so a log with them replays by itself.
"""

import msgspec

from armspan.conductor.places import check_zones
from armspan.conductor.settings import Settings
from armspan.errors import ConfigError, known_names
from armspan.records import Body, Zone
from armspan.swarm.director import STOP, order_name

CHANGES = ("zones", "gestures", "body")
"""The presses that `changed` knows; each carries JSON."""


def changed(settings: Settings, name: str, value: str) -> Settings:
    """The settings after a press of one of `CHANGES`.

    Raises:
        ConfigError: what cannot be, in a sentence; the old settings hold.

    """
    try:
        match name:
            case "zones":
                return msgspec.structs.replace(settings, zones=_zones(settings, value))
            case "gestures":
                return msgspec.structs.replace(settings, gestures=_gestures(settings, value))
            case "body":
                return msgspec.structs.replace(settings, body=_body(value))
    except msgspec.DecodeError as error:
        raise ConfigError(f"{name}: {error}") from None
    raise ConfigError(known_names("change", name, CHANGES))


def _zones(settings: Settings, value: str) -> tuple[Zone, ...]:
    zones = msgspec.json.decode(value, type=tuple[Zone, ...])
    check_zones(zones, settings.sheet)
    named = {zone.name for zone in zones}
    for label, order in settings.gestures.items():
        zone = order.partition("@")[2]
        if zone and zone not in named:
            raise ConfigError(f"zone {zone!r} is needed by the gesture {label!r} ({order}): change that first")
    return zones


def _gestures(settings: Settings, value: str) -> dict[str, str]:
    wanted = msgspec.json.decode(value, type=dict[str, str])
    orders = {label: order_name(order) for label, order in wanted.items()}
    for label, order in orders.items():
        zone = order.partition("@")[2]
        names = [known.name for known in settings.zones]
        if zone and zone not in names:
            raise ConfigError(f"{label}: {known_names('zone', zone, names)}")
    if STOP not in orders.values():
        raise ConfigError(f"no gesture is mapped to {STOP!r}: one must always stop the robots")
    return orders


def _body(value: str) -> Body:
    body = msgspec.json.decode(value, type=Body)
    for what, length, low, high in (
        ("the eye height", body.eye_height_m, 0.5, 2.3),
        ("shoulder to fingertip", body.shoulder_to_fingertip_m, 0.3, 1.2),
    ):
        if not low <= length <= high:
            raise ConfigError(f"{what} of {length:g} m: expected {low:g} to {high:g} m")
    return body
