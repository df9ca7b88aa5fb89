"""Zones drawn on the page: checked before they are pressed."""

from collections.abc import Sequence

import msgspec

from armspan.conductor import Settings
from armspan.conductor.changes import changed
from armspan.config.room_file import ZoneEntry
from armspan.errors import ConfigError
from armspan.records import Zone
from armspan.web.activities import Act


def rezoned(settings: Settings, zones: Sequence[Zone], acts: Sequence[Act]) -> str:
    """What the press ``zones`` carries.

    Raises:
        ConfigError: a zone that cannot be, a name twice, or a zone gone that an activity or a gesture is for.

    """
    value = msgspec.json.encode(zones).decode()
    named = {zone.name for zone in zones}
    for zone in zones:
        if set(zone.name) & set(":@"):
            raise ConfigError(f"zone {zone.name!r}: a name holds neither : nor @, which part it from other words")
    for act in acts:
        zone_name = act.order.partition("@")[2]
        if zone_name and zone_name not in named:
            raise ConfigError(f"zone {zone_name!r} is needed by the activity {act.name!r}: change or remove that first")
    changed(settings, "zones", value)
    return value


def entries(zones: Sequence[Zone]) -> tuple[ZoneEntry, ...]:
    """Zones as a room's file has them."""
    return tuple(ZoneEntry(zone.name, zone.polygon) for zone in zones)
