"""The wizard's last step: steer; and what a simulated person can be asked."""

from collections.abc import Callable

from nicegui import ui

from armspan.web.desk import Desk
from armspan.web.views.setup_kept import Kept
from armspan.web.views.setup_words import is_ready, verdict


def build(desk: Desk, kept: Kept, go: Callable[[int], None]) -> Callable[[], None]:
    """The way to the table, and the simulated person's buttons."""
    words = ui.label().classes("wizard-verdict").props('role="status"')
    steer = ui.link("Steer now", "/").classes("wizard-steer")
    back = ui.button("Back to heading and calibration", on_click=lambda: go(2)).props("no-caps outline")
    person = ui.element("div").classes("wizard-person")
    built = False

    def look() -> None:
        nonlocal built
        mind = desk.shown.mind
        sight = mind.sight() if mind is not None else None
        ready = sight is not None and is_ready(sight)
        words.set_text(
            verdict(sight)
            if ready and sight is not None
            else "Not ready yet: the set-up is not through. Go back a step."
        )
        steer.set_visibility(ready)
        back.set_visibility(not ready)
        person.set_visibility(ready and desk.host.status.simulated)
        if mind is not None and not built and desk.host.status.simulated:
            built = True
            with person:
                _wishes(desk, mind.settings.robots, [zone.name for zone in mind.settings.zones])

    return look


def _wishes(desk: Desk, robots: tuple[str, ...], zones: list[str]) -> None:
    """What the simulated person can be asked to do."""
    ui.label("Simulated person").classes("wizard-title").props('role="heading"')
    ui.label("There is no real person in this room. Let the simulated one:")
    wishes = [(f"Point at the robot {name}", f"robot:{name}") for name in robots]
    wishes += [(f"Point at the zone {name}", f"zone:{name}") for name in zones]
    with ui.element("div").classes("wizard-buttons"):
        for label, wish in [*wishes, ("Lower the arm", "rest")]:
            ui.button(f"{label} (simulated)", on_click=lambda _, w=wish: desk.press("wish", w)).props("no-caps outline")
