"""Gestures live: how sure the model is, from when a gesture counts, what each gesture does."""

import msgspec
from nicegui import ui

from armspan.conductor.changes import changed
from armspan.errors import ConfigError
from armspan.web.desk import Desk
from armspan.web.lively import Lively
from armspan.web.views.gestures_words import NAMES, missing_stop, name_of, noticed, orders_of, predicted


def build(desk: Desk) -> None:
    """The bars, the slider, the dictionary."""
    with ui.element("section").classes("panel gest"):
        ui.label("Live").classes("gest-title").props('role="heading" aria-level="2"')
        threshold = _Threshold(desk)
    with ui.element("section").classes("panel gest"):
        ui.label("What each gesture does").classes("gest-title").props('role="heading" aria-level="2"')
        orders = _Orders(desk)

    def look() -> None:
        threshold.look()
        orders.look()

    look()
    ui.timer(0.5, look)


class _Threshold:
    """The confidence bars, and the slider of the threshold with what it costs."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self._known: float | None = None
        self.told = ui.label().classes("gest-told").props('role="status"')
        self.begin = ui.button("Begin the set-up", on_click=lambda: desk.press("setup")).classes("gest-button")
        self.bars = Lively("scores", "How sure the model is of each gesture", names=NAMES).classes("gest-bars")
        self.block = ui.element("div").classes("gest-result")
        with self.block:
            self.words = ui.label().classes("gest-sub")
            self.slider = ui.slider(min=0.2, max=0.95, step=0.05, value=0.6, on_change=self._say)
            self.slider.props('aria-label="Threshold: how sure the model must be"').on("change", self._set)
            self.noticed, self.false = ui.label(), ui.label()
        self.wishes = ui.element("div").classes("gest-row")
        self._wishes: tuple[str, ...] = ()

    def look(self) -> None:
        """Follow the session."""
        model = self.desk.host.gestures.model
        self.block.set_visibility(model is not None)
        self.bars.set_visibility(model is not None)
        waits = model is not None and self.desk.shown.scores is None
        leading = model is not None and self._leading()
        self.begin.set_visibility(waits and not leading)
        if model is None:
            recording = self.desk.host.gestures.progress is not None
            text = (
                "After the recording: train, and use the model." if recording else "There is no model in this room yet."
            )
            self.told.set_text(text)
        elif waits:
            self.told.set_text("Nothing to see yet: gestures are recognised after the set-up.")
        elif leading:
            self.told.set_text("The set-up goes on: until it is through, only a stop counts.")
        else:
            made = self.desk.shown.gesture
            self.told.set_text(f"Recognised last: {name_of(made.label)}" if made else "No gesture was recognised yet.")
        if model is not None and model.facts.rule.threshold != self._known:
            self._known = model.facts.rule.threshold
            self.slider.set_value(self._known)
            self._say()
        asks = self.desk.host.gestures.simulated and not waits and not leading
        labels = model.facts.labels if model is not None and asks else ()
        if labels != self._wishes:
            self._draw_wishes(labels)

    def _leading(self) -> bool:
        sight = self.desk.shown.mind.sight() if self.desk.shown.mind is not None else None
        return sight is None or sight.step != "idle"

    def _say(self) -> None:
        model = self.desk.host.gestures.model
        if model is None:
            return
        value = float(self.slider.value)
        self.words.set_text(f"A gesture counts from {100 * value:.0f} % on")
        self.noticed.set_text(noticed(model.facts, value))
        self.false.set_text(predicted(model.facts, value))
        self.bars.show(threshold=value)

    async def _set(self) -> None:
        if self.desk.may():
            await self.desk.press("threshold", f"{self.slider.value:g}")
        elif self._known is not None:
            self.slider.set_value(self._known)

    def _draw_wishes(self, labels: tuple[str, ...]) -> None:
        self._wishes = labels
        self.wishes.clear()
        with self.wishes:
            if labels:
                ui.label("Ask the virtual person for:")
            for label in labels:
                button = ui.button(name_of(label), on_click=lambda label=label: self._wish(label))
                button.props("outline no-caps")

    async def _wish(self, label: str) -> None:
        await self.desk.press("wish", f"gesture:{label}")


class _Orders:
    """The dictionary: which gesture begins what."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self._drawn: tuple[object, ...] = ()
        self.choices: dict[str, ui.select] = {}
        self.told = ui.label().classes("gest-told").props('role="status"')
        self.table = ui.element("div").classes("gest-orders")
        with ui.element("div").classes("gest-row"):
            self.apply = ui.button("Apply", on_click=self._apply).classes("gest-button")
            self.keep = ui.button("Save for this room", on_click=self._keep).classes("gest-button").props("outline")

    def look(self) -> None:
        """Follow the session; what is being edited stays until something else holds."""
        gestures, settings = self.desk.host.gestures, self.desk.host.settings
        usable = settings is not None and gestures.progress is None
        self.apply.set_visibility(usable)
        self.keep.set_visibility(usable)
        self.table.set_visibility(usable)
        if settings is None or not usable:
            self.told.set_text("Open the room to change what gestures do.")
            return
        labels = gestures.model.facts.labels if gestures.model is not None else tuple(settings.gestures)
        if missing_stop(settings.gestures, labels):
            self.told.set_text("No gesture of this model stops the robots yet: choose one.")
        else:
            self.told.set_text("")
        zones = tuple(zone.name for zone in settings.zones)
        now = (labels, zones, tuple(sorted(settings.gestures.items())))
        if now != self._drawn:
            self._drawn = now
            self._draw(labels, zones, settings.gestures)

    def _draw(self, labels: tuple[str, ...], zones: tuple[str, ...], orders: dict[str, str]) -> None:
        self.table.clear()
        self.choices = {}
        options = orders_of(zones)
        with self.table:
            for label in labels:
                order = orders.get(label, "")
                choice = ui.select(options, label=name_of(label), value=order if order in options else "")
                self.choices[label] = choice.classes("gest-order")

    async def _apply(self) -> bool:
        if not self.desk.may():
            return False
        orders = {label: choice.value for label, choice in self.choices.items() if choice.value}
        if not await self.desk.do(self._press(msgspec.json.encode(orders).decode())):
            return False
        ui.notify("This holds now", type="positive")
        return True

    async def _press(self, orders: str) -> None:
        if self.desk.host.settings is None:
            raise ConfigError("no room is open: open it first")
        changed(self.desk.host.settings, "gestures", orders)
        await self.desk.press("gestures", orders)

    async def _keep(self) -> None:
        if await self._apply() and await self.desk.do(self.desk.host.gestures.keep()):
            ui.notify("Saved: the next sessions of this room begin with it", type="positive")
