"""A log shown again: its place in time, its pace, and the way back."""

from nicegui import ui
from nicegui.events import GenericEventArguments

from armspan.web.desk import Desk
from armspan.web.film import SPEEDS, Film
from armspan.web.lively import Lively
from armspan.web.views.gestures_words import NAMES
from armspan.web.views.logs_words import length_words


class Player:
    """Seen while a log is shown; all browsers see the same place of it."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        with ui.element("section").classes("panel player") as self.box:
            ui.label("Shown again").classes("title").props('role="heading" aria-level="2"')
            self.words = ui.label().props('role="status"')
            with ui.row().classes("buttons"):
                self.play = ui.button("Play", on_click=self._play)
                self.speed = ui.toggle({speed: f"{speed}×" for speed in SPEEDS}, value=1, on_change=self._pace)
                self.speed.props('aria-label="Speed"')
                ui.button("Back to the room", icon="home", on_click=self._back).props("outline")
            self.slider = ui.slider(min=0, max=1, step=0.1, value=0).props('label aria-label="Seconds of the session"')
            self.slider.on("update:model-value", self._seek, throttle=0.1)
        with ui.element("div").classes("side") as self.views:
            Lively("space", "The table and the arms, in three dimensions").classes("panel tall")
            Lively("plan", "The sheet from above").classes("panel tall")
            Lively("strips", "The bands' signals").classes("panel")
            Lively("scores", "How sure each gesture is", names=NAMES).classes("panel")
        self.look()

    @property
    def film(self) -> Film | None:
        """What is shown, None where no log is."""
        return self.desk.shown.film

    def look(self) -> None:
        """Show where the log is."""
        film, replaying = self.film, self.desk.host.status.activity == "replaying"
        self.box.set_visibility(replaying)
        self.views.set_visibility(replaying and film is not None)
        if film is None:
            self.words.set_text("The log is being read …")
            return
        self.words.set_text(place_words(film))
        self.play.set_text("Pause" if film.playing else "Play")
        self.play.props(f"icon={'pause' if film.playing else 'play_arrow'}")
        self.slider.props(f"max={film.opening.seconds:.1f}")
        self.slider.set_value(round(film.position, 1))
        self.speed.set_value(film.speed)

    def _play(self) -> None:
        if self.film is not None and self.desk.may():
            self.film.play(not self.film.playing)
            self.look()

    def _pace(self) -> None:
        film = self.film
        if film is not None and self.speed.value != film.speed and self.desk.may():
            film.speed = int(self.speed.value)

    def _seek(self, event: GenericEventArguments) -> None:
        if self.film is not None and self.desk.may():
            self.film.seek(float(event.args))
            self.desk.shown.version += 1

    async def _back(self) -> None:
        if self.desk.may():
            await self.desk.do(self.desk.host.steer())


def place_words(film: Film) -> str:
    """Where a log is, and what is to be known of it."""
    words = f"{length_words(film.position)} of {length_words(film.opening.seconds)}"
    if not film.whole:
        words += f"; ready up to {length_words(film.ready)}"
    return f"{words}. {film.opening.note}" if film.opening.note else words
