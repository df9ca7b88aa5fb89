"""The wizard's third step: heading and calibration, with what each stop left over, and a verdict."""

from collections.abc import Callable

from nicegui import ui

from armspan.conductor.sight import Sight
from armspan.web.desk import Desk
from armspan.web.views.setup_kept import Kept
from armspan.web.views.setup_words import is_ready, progress_share, progress_words, stop_words, verdict


def build(desk: Desk, kept: Kept, go: Callable[[int], None]) -> Callable[[], None]:
    """The buttons, the progress, the stops."""
    view = _Calibration(desk, kept, go)
    return view.look


class _Calibration:
    def __init__(self, desk: Desk, kept: Kept, go: Callable[[int], None]) -> None:
        self.desk, self.kept = desk, kept
        ui.label(
            "Stand (or sit) where you will steer, and stay there. Press Begin and do what the large words at the top "
            "say: first a pose or two for the heading, then a robot drives to a few stops and you point at its light."
        )
        with ui.element("div").classes("wizard-buttons"):
            self.begin = ui.button("Begin", on_click=self._begin).props("no-caps").classes("wizard-big")
            self.next = ui.button("Next: steer", on_click=lambda: go(3)).props("no-caps").classes("wizard-big")
        self.bar = ui.linear_progress(0.0, show_value=False).props('aria-label="How much of the set-up is done"')
        self.progress = ui.label().classes("wizard-verdict").props('role="status"')
        self.verdict = ui.label().classes("wizard-verdict").props('role="status"')
        self.stops = ui.element("div").classes("wizard-stops")
        self.words: list[ui.label] = []
        self.again: list[ui.button] = []

    def look(self) -> None:
        """Show what the set-up is at."""
        mind = self.desk.shown.mind
        sight = mind.sight() if mind is not None else None
        if sight is None:
            return
        self._count(len(mind.settings.stops) if mind is not None else 0)
        ready = is_ready(sight)
        self.begin.set_text("Begin again" if ready or sight.step != "idle" else "Begin")
        self.begin.set_enabled(not sight.stopped)
        self.begin.props(f"color={'white' if ready else 'primary'} text-color={'dark' if ready else 'white'}")
        if ready and not self.next.visible:  # who goes on by keyboard goes on there
            self.next.client.run_javascript(f"setTimeout(() => getHtmlElement({self.next.id})?.focus(), 100)")
        self.next.set_visibility(ready)
        self.bar.set_value(progress_share(sight))
        self.progress.set_text(progress_words(sight))
        told = verdict(sight)
        self.verdict.set_text(told)
        self.verdict.set_visibility(bool(told))
        self._stops(sight, ready)

    def _stops(self, sight: Sight, ready: bool) -> None:
        for number, (words, again) in enumerate(zip(self.words, self.again, strict=True), start=1):
            words.set_text(f"Stop {number}: {stop_words(sight, number)}")
            again.set_enabled(ready and not sight.stopped)

    def _count(self, count: int) -> None:
        """As many lines as there are stops."""
        if len(self.words) == count:
            return
        self.stops.clear()
        self.words.clear()
        self.again.clear()
        with self.stops:
            for number in range(1, count + 1):
                with ui.element("div").classes("wizard-stop"):
                    self.words.append(ui.label())
                    again = ui.button(f"Take stop {number} again", on_click=lambda _, n=number: self._again(n))
                    self.again.append(again.props("no-caps outline"))

    async def _begin(self) -> None:
        if not self.desk.may():
            return
        if self.kept.clock.ready is not None:
            self.kept.clock.start(self.desk.shown.t)
        await self.desk.host.press("setup")

    async def _again(self, number: int) -> None:
        await self.desk.press("stop_again", str(number))
