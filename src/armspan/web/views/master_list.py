"""The list of activities: led, and edited."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from nicegui import ui

from armspan.swarm.director import IN_ZONES, MAKERS
from armspan.web.activities import Act, Agenda, Turn, in_words
from armspan.web.desk import Desk
from armspan.web.views.master_state import done_words, turn_words

_WHOLE = "the whole sheet"


@dataclass(slots=True)
class _Line:
    """One row of the list: what marks it as the one whose turn it is."""

    box: ui.element
    mark: ui.icon


class TurnPanel:
    """Start, Pause, Next: whose turn it is, and how it stands."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        with ui.element("div").classes("buttons"):
            self.turn = ui.label().classes("turn").props('role="status"')
            self.now = ui.label()
        with ui.element("div").classes("buttons"):
            self._led("Start", "play_arrow", "start")
            self._led("Pause", "pause", "pause").props("color=warning text-color=dark")
            self._led("Next", "skip_next", "next")
            self._led("Previous", "skip_previous", "previous").props("outline")
            ui.button("Resume all", icon="lock_open", on_click=lambda: desk.press("resume")).props("outline")
        ui.label(
            "Pause lets the robots come to rest; Start begins the activity again. Stop all robots holds them until "
            "Resume all is pressed; nothing moves by that alone."
        ).classes("hint")
        self.look()

    def look(self) -> None:
        """Show how things stand."""
        desk, frame = self.desk, self.desk.shown.frame()
        steering = desk.host.status.activity == "steering"
        self.turn.set_text(turn_words(desk.host.activities.agenda, frame, steering))
        self.now.set_text(done_words(frame))

    def _led(self, text: str, icon: str, turn: Turn) -> ui.button:
        async def lead() -> None:
            if self.desk.may():
                await self.desk.do(self.desk.host.activities.lead(turn))
                self.look()

        return ui.button(text, icon=icon, on_click=lead)


class ActivityPanel:
    """The list, with the one whose turn it is."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        ui.label("Activities").classes("title").props('role="heading" aria-level="2"')
        self.note = ui.label().classes("trouble").props('role="alert"')
        self.list = ui.element("div").classes("rows")
        ui.button("Add an activity", icon="add", on_click=lambda: self._edit(None)).props("outline")
        self.box = ui.element("div")
        self._acts: tuple[Act, ...] | None = None
        self._lines: list[_Line] = []
        self.look()

    def look(self) -> None:
        """Show the list."""
        agenda = self.desk.host.activities.agenda
        self.note.set_text(agenda.note)
        self.note.set_visibility(bool(agenda.note))
        if agenda.acts != self._acts:
            self._rebuild(agenda)
        for place, line in enumerate(self._lines):
            turn = place == agenda.place
            line.box.classes(add="current" if turn else None, remove=None if turn else "current")
            line.mark.set_name("play_arrow" if turn else "")

    def _rebuild(self, agenda: Agenda) -> None:
        self._acts, self._lines = agenda.acts, []
        self.list.clear()
        with self.list:
            for place, act in enumerate(agenda.acts):
                self._row(place, act)

    def _row(self, place: int, act: Act) -> None:
        with ui.element("div").classes("row") as box:
            self._lines.append(_Line(box, ui.icon("").classes("mark")))
            ui.label(f"{place + 1}. {act.name}").classes("grow")
            if act.name != in_words(act.order):
                ui.label(in_words(act.order)).classes("hint")
            ui.label(", ".join(act.robots) or "all robots").classes("hint")
            name = f"{place + 1}, {act.name}".replace('"', "'")
            for icon, words, do in (
                ("play_arrow", "Start", lambda: self._choose(place)),
                ("arrow_upward", "Move up", lambda: self._move(place, -1)),
                ("arrow_downward", "Move down", lambda: self._move(place, 1)),
                ("edit", "Change", lambda: self._edit(place)),
                ("close", "Remove", lambda: self._remove(place)),
            ):
                button = ui.button(icon=icon, on_click=do).props(f'flat dense aria-label="{words} {name}"')
                button.props(f'data-act="{words.replace(" ", "-").lower()}-{place}"').tooltip(words)

    async def _choose(self, place: int) -> None:
        if self.desk.may():
            await self.desk.do(self.desk.host.activities.choose(place))
            self.look()

    async def _move(self, place: int, by: int) -> None:
        acts = list(self.desk.host.activities.agenda.acts)
        if self.desk.may() and 0 <= place + by < len(acts):
            acts[place], acts[place + by] = acts[place + by], acts[place]
            await self._arrange(acts)
            button = f"[data-act='move-{'up' if by < 0 else 'down'}-{place + by}']"
            with self.box:  # the button that was pressed is gone
                ui.run_javascript(f'setTimeout(() => document.querySelector("{button}")?.focus(), 50)')

    async def _remove(self, place: int) -> None:
        if self.desk.may():
            acts = list(self.desk.host.activities.agenda.acts)
            await self._arrange([*acts[:place], *acts[place + 1 :]])

    async def _arrange(self, acts: list[Act]) -> bool:
        with self.box:
            done = await self.desk.do(self.desk.host.activities.arrange(acts))
        self.look()
        return done

    async def _edit(self, place: int | None) -> None:
        """Ask for an activity, a new one or what is at a place."""
        if not self.desk.may():
            return
        acts = list(self.desk.host.activities.agenda.acts)
        with self.box:
            form = ActForm(self.desk, acts[place] if place is not None else None)
            await form.asked(lambda act: self._arrange([*acts, act] if place is None else _with(acts, place, act)))


def _with(acts: list[Act], place: int, act: Act) -> list[Act]:
    return [*acts[:place], act, *acts[place + 1 :]]


class ActForm:
    """Asks for an activity in a dialog, until it can be."""

    def __init__(self, desk: Desk, act: Act | None) -> None:
        settings = desk.host.settings
        zones = [zone.name for zone in settings.zones] if settings is not None else []
        robots = list(settings.robots) if settings is not None else []
        order, _, zone = act.order.partition("@") if act is not None else (next(iter(MAKERS)), "", "")
        with ui.dialog() as self.dialog, ui.card().classes("ask"):
            ui.label("Change the activity" if act else "A new activity").classes("title")
            self.order = ui.select({name: in_words(name) for name in MAKERS}, label="What the robots do", value=order)
            self.order.classes("wide").props("autofocus")
            self.zone = ui.select([_WHOLE, *zones], label="Where", value=zone if zone in zones else _WHOLE)
            self.zone.classes("wide").bind_visibility_from(self.order, "value", lambda name: name in IN_ZONES)
            self.name = ui.input("Name (what it is called here; may stay empty)", value=act.name if act else "")
            self.name.classes("wide")
            chosen = [robot for robot in act.robots if robot in robots] if act is not None else []
            self.robots = ui.select(robots, label="Robots (none: all that take part)", value=chosen, multiple=True)
            self.robots.classes("wide").props("use-chips")
            with ui.row():
                ui.button("Save", on_click=lambda: self.dialog.submit(True))
                ui.button("Cancel", on_click=lambda: self.dialog.submit(False)).props("flat")

    @property
    def act(self) -> Act:
        """What is asked for."""
        order = str(self.order.value)
        if order in IN_ZONES and self.zone.value != _WHOLE:
            order = f"{order}@{self.zone.value}"
        return Act(self.name.value or "", order, tuple(self.robots.value or ()))

    async def asked(self, keep: Callable[[Act], Awaitable[bool]]) -> None:
        """Ask until ``keep`` takes it, or somebody cancels."""
        while await self.dialog:
            if await keep(self.act):
                break
        self.dialog.delete()
