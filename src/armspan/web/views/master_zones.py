"""Zones of the sheet: drawn, typed, renamed, deleted."""

import json
from collections.abc import Awaitable, Callable, Sequence
from functools import partial

import msgspec
from nicegui import ui
from nicegui.events import GenericEventArguments

from armspan.errors import ConfigError
from armspan.records import Vec2, Zone
from armspan.web.ask import confirmed, named
from armspan.web.desk import Desk
from armspan.web.lively import Lively


class ZonePanel:
    """The sheet from above, on which zones are drawn, and the list of zones beside it."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        ui.label("Zones").classes("title").props('role="heading" aria-level="2"')
        ui.label(
            "Draw a new zone: drag a rectangle on the sheet, or click its corners one by one and the last one twice. "
            "Below it can be typed."
        ).classes("hint")
        plan = Lively("plan", "The sheet from above: draw a new zone here", draw=True).classes("tall")
        plan.on("drawn", self._drawn)
        self.list = ui.element("div").classes("rows")
        self._typed()
        self.box = ui.element("div")
        self._seen: tuple[Zone, ...] | None = None
        self.look()

    def look(self) -> None:
        """Show the zones that there are now."""
        zones = self._zones
        if zones == self._seen:
            return
        self._seen = zones
        self.list.clear()
        with self.list:
            for zone in zones:
                with ui.element("div").classes("row"):
                    ui.label(f"{zone.name} ({size_words(zone)})").classes("grow")
                    _small("edit", f"Rename {zone.name}", partial(self._rename, zone))
                    _small("delete", f"Delete {zone.name}", partial(self._delete, zone))
            if not zones:
                ui.label("There is no zone that can be changed.")
            else:
                ui.button("Keep for next time …", on_click=self._show_toml).props("flat dense")

    @property
    def _zones(self) -> tuple[Zone, ...]:
        settings = self.desk.host.settings
        return settings.zones if settings is not None else ()

    def _typed(self) -> None:
        """A rectangle by its numbers, for those who do not draw."""
        with ui.expansion("Add a zone by numbers").classes("wide"):
            self.name = ui.input("Name of the zone").classes("wide")
            with ui.row():
                kinds = (("left", 10.0), ("top", 10.0), ("width", 20.0), ("height", 15.0))
                self.sizes = [
                    ui.number(f"{what} [cm]", value=value, format="%.1f").classes("short") for what, value in kinds
                ]
            ui.button("Add zone", on_click=self._add_typed)

    async def _add_typed(self) -> None:
        if not self.desk.may():
            return
        values = [size.value for size in self.sizes]
        if any(value is None for value in values):
            ui.notify("Type all four sizes", type="warning")
            return
        left, top, width, height = (float(value) / 100 for value in values)
        if await self._add(self.name.value or "", rectangle(left, top, width, height)):
            self.name.set_value("")

    async def _drawn(self, event: GenericEventArguments) -> None:
        """A polygon was drawn: it gets a name, and is asked for; a name that is refused can be typed again."""
        if not self.desk.may():
            return
        polygon = corners(event.args)
        name = ""
        with self.box:
            while name := await named("What is the new zone called?", "Name of the zone", name):
                if await self._add(name, polygon):
                    return

    async def _add(self, name: str, polygon: tuple[Vec2, ...]) -> bool:
        return await self._rezone((*self._zones, Zone(name.strip(), polygon)))

    async def _rename(self, zone: Zone) -> None:
        if not self.desk.may():
            return
        with self.box:
            name = await named(f"What is {zone.name} called from now on?", "Name of the zone", zone.name)
            if name and name != zone.name:
                zones = [Zone(name, old.polygon) if old.name == zone.name else old for old in self._zones]
                await self._rezone(zones, (zone.name, name))

    async def _delete(self, zone: Zone) -> None:
        with self.box:
            if self.desk.may() and await confirmed(f"Delete the zone {zone.name}?", f"Delete {zone.name}"):
                await self._rezone([old for old in self._zones if old.name != zone.name])

    async def _rezone(self, zones: Sequence[Zone], renamed: tuple[str, str] | None = None) -> bool:
        return await self.desk.do(self.desk.host.activities.rezone(zones, renamed))

    async def _show_toml(self) -> None:
        with ui.dialog() as dialog, ui.card().classes("ask"):
            ui.label("Zones hold until Armspan ends. To have them again, put these lines into the room's file:")
            ui.textarea("Zones", value=as_toml(self._zones)).props("readonly autogrow").classes("wide")
            ui.button("Close", on_click=dialog.close)
        await dialog
        dialog.delete()


def _small(icon: str, label: str, do: Callable[[], Awaitable[None]]) -> None:
    told = label.replace('"', "'")
    ui.button(icon=icon, on_click=do).props(f'flat dense aria-label="{told}"').tooltip(label)


def corners(args: object) -> tuple[Vec2, ...]:
    """A polygon that was drawn, to a millimetre (ConfigError for what is none)."""
    try:
        told = msgspec.convert(args, dict[str, object])
        polygon = msgspec.convert(told.get("polygon"), tuple[Vec2, ...], strict=False)
    except msgspec.ValidationError as error:
        raise ConfigError(f"That was no polygon: {error}") from None
    return tuple((round(x, 3), round(y, 3)) for x, y in polygon)


def rectangle(left: float, top: float, width: float, height: float) -> tuple[Vec2, ...]:
    """A rectangle's corners [m], in order round it, to a millimetre."""
    x0, y0, x1, y1 = (round(v, 3) for v in (left, top, left + width, top + height))
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def size_words(zone: Zone) -> str:
    """How wide and high a zone is, in centimetres."""
    xs, ys = [x for x, _ in zone.polygon], [y for _, y in zone.polygon]
    return f"{100 * (max(xs) - min(xs)):.0f} × {100 * (max(ys) - min(ys)):.0f} cm"


def as_toml(zones: Sequence[Zone]) -> str:
    """Zones as lines for the room's file."""
    texts = []
    for zone in zones:
        places = ", ".join(f"[{x:.3f}, {y:.3f}]" for x, y in zone.polygon)
        texts.append(f"[[zones]]\nname = {json.dumps(zone.name, ensure_ascii=False)}\npolygon_m = [{places}]\n")
    return "\n".join(texts)
