"""The set-up wizard: devices, measures, heading and calibration, ready."""

from collections.abc import Callable
from typing import TypeAlias

from nicegui import ui

from armspan.web.desk import Desk
from armspan.web.views import setup_calibration, setup_devices, setup_measures, setup_ready
from armspan.web.views.setup_kept import Kept, kept_for
from armspan.web.views.setup_words import clock_words

Look: TypeAlias = Callable[[], None]
"""Shows what has changed; called twice a second."""
Go: TypeAlias = Callable[[int], None]
"""Goes to a step, by its number from 0."""

STEPS: tuple[tuple[str, Callable[[Desk, Kept, Go], Look]], ...] = (
    ("Devices", setup_devices.build),
    ("Measures", setup_measures.build),
    ("Heading and calibration", setup_calibration.build),
    ("Ready", setup_ready.build),
)


def build(desk: Desk) -> None:
    """The steps' buttons with the clock, and the step that is open."""
    _Wizard(desk)


class _Wizard:
    """One browser's wizard; a step is built when it is gone to, from what is kept."""

    def __init__(self, desk: Desk) -> None:
        self.desk, self.kept = desk, kept_for(desk)
        self.buttons: list[ui.button] = []
        with ui.element("nav").classes("wizard-steps").props('aria-label="Steps of the set-up"'):
            for number, (name, _) in enumerate(STEPS):
                button = ui.button(f"{number + 1} {name}", on_click=lambda _, n=number: self.visit(n))
                self.buttons.append(button.props("no-caps unelevated"))
            self.clock = ui.label().classes("wizard-clock").props('role="timer"')
            again = ui.button("Start the time now", on_click=lambda: self.kept.clock.start(self.desk.shown.t))
            again.props("no-caps outline")
        self.closed = ui.element("div").classes("panel wizard-step")
        with self.closed:
            ui.label("The room is not open for steering, so nothing can be set up.")
            ui.button("Open the room", on_click=self._open).props("no-caps")
        self.panel = ui.element("section").classes("panel wizard-step")
        self.look_at_step: Look = lambda: None
        self.go(self.kept.step)
        ui.timer(0.5, self.look)

    def go(self, number: int) -> None:
        """Open a step."""
        self.kept.step = number
        for n, button in enumerate(self.buttons):
            here = n == number
            button.props(f"color={'primary' if here else 'white'} text-color={'white' if here else 'dark'}")
            button.props('aria-current="step"' if here else "", remove="" if here else "aria-current")
        self.panel.clear()
        name, make = STEPS[number]
        with self.panel:
            title = ui.label(f"Step {number + 1} of {len(STEPS)}: {name}").classes("wizard-title wizard-here")
            title.props('role="heading" tabindex="-1"')
            self.look_at_step = make(self.desk, self.kept, self.visit)
        self.look()

    def visit(self, number: int) -> None:
        """Open a step, and let the keyboard and a screen reader go on there."""
        self.go(number)
        self.panel.client.run_javascript("document.querySelector('.wizard-here')?.focus()")

    def look(self) -> None:
        """Show the time, and what the step shows."""
        shown, kept = self.desk.shown, self.kept
        activity = self.desk.host.status.activity
        self.closed.set_visibility(activity not in ("opening", "steering"))
        self.panel.set_visibility(activity == "steering")
        if shown.mind is None or activity != "steering":
            return
        kept.clock.look(shown.t, shown.mind.sight(), shown.said)
        self.clock.set_text(clock_words(kept.clock.seconds(shown.t), ready=kept.clock.ready is not None))
        self.look_at_step()

    async def _open(self) -> None:
        if self.desk.may():
            await self.desk.do(self.desk.host.steer())
