"""Training: begin, how far it is, what came out."""

import re
import time

from nicegui import ui

from armspan.gesture.model import Facts
from armspan.gesture.training import advice
from armspan.web.desk import Desk
from armspan.web.views.gestures_words import account, confusion_table, name_of


def build(desk: Desk) -> None:
    """The button, the bar, the account."""
    with ui.element("section").classes("panel gest"):
        ui.label("Train").classes("gest-title").props('role="heading" aria-level="2"')
        panel = _Train(desk)
    panel.look()
    ui.timer(0.5, panel.look)


class _Train:
    """Training and what it told."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self._shown: Facts | None = None
        self._since: float | None = None
        with ui.element("div").classes("gest-row"):
            self.train = ui.button("Train on all takes", on_click=self._begin).classes("gest-button")
            self.cancel = ui.button("Cancel training", on_click=self._cancel).classes("gest-button").props("outline")
        self.bar = ui.linear_progress(show_value=False).props('aria-label="Progress of the training"')
        self.told = ui.label().classes("gest-told").props('role="status"')
        self.result = ui.element("div").classes("gest-result")
        with ui.element("div").classes("gest-row") as self.use:
            ui.button("Use this model", on_click=self._use).classes("gest-button")
            ui.label("The room opens anew and wants its set-up again.")

    async def _begin(self) -> None:
        if self.desk.may():
            await self.desk.do(self.desk.host.gestures.train())
            self.look()

    def _cancel(self) -> None:
        if self.desk.may():
            self.desk.host.gestures.cancel()
            self.look()

    async def _use(self) -> None:
        if self.desk.may():
            await self.desk.do(self.desk.host.gestures.use())

    def look(self) -> None:
        """Show how it stands."""
        gestures = self.desk.host.gestures
        job, trained = gestures.job, gestures.trained
        self.train.set_visibility(not job.runs)
        self.cancel.set_visibility(job.runs)
        self.bar.set_visibility(job.runs)
        self.bar.set_value(job.share)
        self._since = (self._since or time.monotonic()) if job.runs else None
        going = f"{job.what[:1].upper()}{job.what[1:]} (since {time.monotonic() - (self._since or 0.0):.0f} s)"
        self.told.set_text(going if job.runs else job.trouble)
        self.use.set_visibility(trained is not None and not gestures.used and not job.runs)
        model = gestures.model
        facts = trained.facts if trained is not None else model.facts if model is not None else None
        if facts is not None and facts is not self._shown:
            self._shown = facts
            self._draw(facts)

    def _draw(self, facts: Facts) -> None:
        self.result.clear()
        with self.result:
            for line in account(facts):
                ui.label(line)
            table = (facts.scores.get("by_take") or {}).get("confusion")
            if table:
                ui.label("Rows: the gesture made. Columns: what it was taken for. Bold: right.")
                ui.html(confusion_table(facts.labels, table), sanitize=False).classes("gest-wide")
            ui.label("What would help").classes("gest-sub")
            with ui.element("ul").classes("gest-advice"):
                for line in advice(facts):
                    with ui.element("li"):
                        ui.label(_named(line, facts))


def _named(line: str, facts: Facts) -> str:
    """A line with the gestures' names in the place of their labels."""
    labels = sorted(facts.labels, key=len, reverse=True)
    return re.sub("|".join(rf"\b{re.escape(label)}\b" for label in labels), lambda found: name_of(found[0]), line)
