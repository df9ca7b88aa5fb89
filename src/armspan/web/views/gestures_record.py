"""Recording takes: what is to be recorded, begin, end."""

from nicegui import ui

from armspan.conductor.recorder_words import HOW
from armspan.gesture.takes import SEVEN
from armspan.web.desk import Desk
from armspan.web.views.gestures_host import Asked
from armspan.web.views.gestures_words import name_of, own_labels


def build(desk: Desk) -> None:
    """The form, and how far a recording is."""
    gestures = desk.host.gestures
    with ui.element("section").classes("panel gest"):
        ui.label("Record takes").classes("gest-title").props('role="heading" aria-level="2"')
        form = ui.element("div").classes("gest-form")
        with form:
            asked = _Form(simulated=gestures.simulated)
        with ui.element("div").classes("gest-row"):
            start = ui.button("Start recording", on_click=lambda: _start(desk, asked)).classes("gest-button")
            end = ui.button("End recording", on_click=lambda: desk.press("stop")).classes("gest-button")
            opened = ui.button("Open the room", on_click=lambda: _open(desk)).classes("gest-button").props("outline")
        told = ui.label().classes("gest-told").props('role="status"')

    def look() -> None:
        progress, status = gestures.progress, desk.host.status
        start.set_visibility(progress is None)
        form.set_visibility(progress is None)
        end.set_visibility(progress is not None)
        opened.set_visibility(status.activity == "idle")
        told.set_text(_told(progress, status.activity, simulated=gestures.simulated))

    look()
    ui.timer(0.5, look)


class _Form:
    """The fields of the form."""

    def __init__(self, *, simulated: bool) -> None:
        self.chosen: dict[str, ui.checkbox] = {}
        with ui.element("fieldset").classes("gest-choices"):
            with ui.element("legend"):
                ui.label("Gestures")
            for label in SEVEN:
                self.chosen[label] = ui.checkbox(name_of(label)).tooltip(HOW[label])
        self.own = ui.input("Other gestures, separated by commas").props('hint="Letters, digits, _ and -"')
        self.own.set_visibility(not simulated)
        with ui.element("div").classes("gest-row"):
            self.takes = ui.number("Takes of each", value=5, min=1, precision=0).props('hint="and one for practice"')
            self.person = ui.input("Person code", value="p01").props('hint="no real name"')
            self.null = ui.number("Everyday motion, seconds", value=0, min=0, precision=0).props('hint="best 600"')
        self.taps = ui.checkbox("A double click on a band begins and ends a take")
        self.taps.set_visibility(not simulated)
        self.hurried = ui.checkbox("The virtual person hurries (ten times as fast)", value=simulated)
        self.hurried.set_visibility(simulated)

    def asked(self) -> Asked:
        """What the fields ask for."""
        labels = [label for label, box in self.chosen.items() if box.value]
        return Asked(
            (*labels, *own_labels(self.own.value or "")),
            int(self.takes.value or 0),
            self.person.value or "",
            float(self.null.value or 0.0),
            bool(self.taps.value),
            bool(self.hurried.value),
        )


async def _start(desk: Desk, form: _Form) -> None:
    if desk.may():
        await desk.do(desk.host.gestures.record(form.asked()))


async def _open(desk: Desk) -> None:
    if desk.may():
        await desk.do(desk.host.steer())


def _told(progress: tuple[int, int] | None, activity: str, *, simulated: bool) -> str:
    if progress is not None:
        finished, asked = progress
        by = " A virtual person makes them: the takes are marked as simulated." if simulated else ""
        return f"Recording: {finished} of {asked} takes are finished and kept.{by}"
    if activity == "recording":
        return "The recording begins"
    if activity == "idle":
        return "No room is open."
    return "While takes are recorded the robots stand still; afterwards the room opens anew and wants its set-up."
