"""Places on the sheet that a person names: they must lie on it, and a zone must be a plain polygon."""

from collections.abc import Sequence

import numpy as np
import shapely

from armspan.errors import ConfigError
from armspan.records import Sheet, Vec2, Zone


def check_place(what: str, xy: Vec2, sheet: Sheet) -> None:
    """Refuse a place off the sheet (ConfigError)."""
    x, y = xy
    if not (0 <= x <= sheet.width_m and 0 <= y <= sheet.height_m):
        raise ConfigError(f"{what} ({x}, {y}) lies off the sheet of {sheet.width_m} x {sheet.height_m} m")


def check_zone(zone: Zone, sheet: Sheet) -> None:
    """Refuse a zone that crosses itself, has no area or reaches off the sheet (ConfigError)."""
    if len(zone.polygon) < 3:
        raise ConfigError(f"zone {zone.name!r} has {len(zone.polygon)} corners; a polygon has three at least")
    corners = np.array(zone.polygon, dtype=float)
    if not np.isfinite(corners).all():
        raise ConfigError(f"zone {zone.name!r} has a corner that is no number; expected metres")
    shape = shapely.Polygon(corners)
    if not shape.is_valid or shape.area == 0:
        raise ConfigError(f"zone {zone.name!r} crosses itself or has no area; list its corners in order round it")
    if corners.min() < 0 or corners[:, 0].max() > sheet.width_m or corners[:, 1].max() > sheet.height_m:
        raise ConfigError(
            f"zone {zone.name!r} reaches outside the sheet of {sheet.width_m} x {sheet.height_m} m; coordinates are "
            "metres from the sheet's corner"
        )


def check_zones(zones: Sequence[Zone], sheet: Sheet) -> None:
    """Refuse zones of one name, without a name, or that cannot be (ConfigError)."""
    names = [zone.name for zone in zones]
    for zone in zones:
        if not zone.name.strip() or "@" in zone.name:
            raise ConfigError(f"zone {zone.name!r} needs a name to be pointed at by, without @")
        if names.count(zone.name) > 1:
            raise ConfigError(f"zone {zone.name!r} is named twice; names tell zones apart")
        check_zone(zone, sheet)
