"""The game master's view: activities, behaviours, robots and zones."""

from collections.abc import Sequence

from nicegui import ui

from armspan.gesture.takes import INITIAL
from armspan.simulation.gesture_styles import LABELS
from armspan.swarm.director import IN_ZONES, MAKERS
from armspan.web.activities import in_words
from armspan.web.desk import Desk
from armspan.web.views.gestures_words import name_of
from armspan.web.views.master_list import ActivityPanel, TurnPanel
from armspan.web.views.master_robots import RobotPanel
from armspan.web.views.master_zones import ZonePanel

_EVERYDAY = 20
"""Seconds of everyday motion that a virtual person is asked for."""


def build(desk: Desk) -> None:
    """Build the view."""
    banner = ui.label().classes("banner").props('role="status"')
    with ui.element("section").classes("panel"):
        turn = TurnPanel(desk)
    with ui.element("section").classes("panel"):
        robots = RobotPanel(desk)
    with ui.element("div").classes("side"):
        with ui.element("section").classes("panel"):
            activities = ActivityPanel(desk)
        with ui.element("section").classes("panel"):
            zones = ZonePanel(desk)
    with ui.element("section").classes("panel"):
        behaviours = BehaviourPanel(desk)
    with ui.element("section").classes("panel") as simulated:
        person = PersonPanel(desk)

    def look() -> None:
        words = banner_words(desk)
        banner.set_text(words)
        banner.set_visibility(bool(words))
        simulated.set_visibility(desk.host.status.simulated and desk.host.status.activity == "steering")
        for panel in (turn, activities, zones, robots, behaviours, person):
            panel.look()

    look()
    ui.timer(0.5, look)


def banner_words(desk: Desk) -> str:
    """Why buttons of this view do nothing, or nothing where they do."""
    control, activity = desk.office.control, desk.host.status.activity
    if activity == "replaying":
        return "A log is shown again: what is seen here is of that time, and the buttons reach no robot."
    if activity != "steering":
        return "No room is open for steering, so these buttons reach no robot."
    if control.holder is not None and not control.has(desk.browser):
        return f"{control.words(desk.browser)}. Here you can look, and stop; press Take control to lead."
    return ""


class BehaviourPanel:
    """One button for everything that robots can do by themselves."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        ui.label("Let the robots …").classes("title").props('role="heading" aria-level="2"')
        ui.label("At once, with the robots that take part; the list of activities keeps its place.").classes("hint")
        self.buttons = ui.row().classes("buttons")
        self._zones: tuple[str, ...] | None = None
        self.look()

    def look(self) -> None:
        """Offer the zones that there are now."""
        settings = self.desk.host.settings
        zones = tuple(zone.name for zone in settings.zones) if settings is not None else ()
        if zones == self._zones:
            return
        self._zones = zones
        self.buttons.clear()
        with self.buttons:
            for order in orders(zones):
                ui.button(in_words(order), on_click=lambda order=order: self._behave(order)).props("outline no-caps")

    async def _behave(self, order: str) -> None:
        if self.desk.may():
            await self.desk.do(self.desk.host.activities.behave(order))


def orders(zones: Sequence[str]) -> list[str]:
    """Every behaviour, and those for a zone for each zone."""
    return [*MAKERS, *(f"{name}@{zone}" for name in IN_ZONES for zone in zones)]


class PersonPanel:
    """What the virtual person can be asked to do."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        ui.label("Virtual person (simulated)").classes("title").props('role="heading" aria-level="2"')
        ui.label("No real arm moves here. Pointing needs the set-up, which is on the page Set-up.").classes("hint")
        self.buttons = ui.element("div")
        self._known: tuple[tuple[str, ...], ...] | None = None
        self.look()

    def look(self) -> None:
        """Offer what there is to point at now."""
        settings = self.desk.host.settings
        robots = settings.robots if settings is not None else ()
        zones = tuple(zone.name for zone in settings.zones) if settings is not None else ()
        if (robots, zones) == self._known:
            return
        self._known = (tuple(robots), zones)
        self.buttons.clear()
        with self.buttons:
            self._row("Point at", [(name, f"robot:{name}") for name in robots])
            self._row("Point at the zone", [(name, f"zone:{name}") for name in zones])
            self._row(
                "Make the gesture", [(name_of(label), f"gesture:{label}") for label in LABELS if label != INITIAL]
            )
            self._row("Or", [("everyday motion", f"everyday:{_EVERYDAY}"), ("rest", "rest")])

    def _row(self, words: str, wishes: list[tuple[str, str]]) -> None:
        if wishes:
            with ui.row().classes("buttons").props(f'role="group" aria-label="{words}"'):
                ui.label(words)
                for name, wish in wishes:
                    ui.button(name, on_click=lambda wish=wish: self.desk.press("wish", wish)).props(
                        "outline no-caps dense"
                    )
