"""The log view: every session of the folder, and one of them shown again."""

import mimetypes
from collections.abc import Awaitable, Callable

from nicegui import ui

from armspan.web.ask import confirmed
from armspan.web.desk import Desk
from armspan.web.sessions import SessionLog
from armspan.web.views.logs_player import Player
from armspan.web.views.logs_words import happened_words, length_words, size_words

MCAP = "application/vnd.mcap"  # https://www.iana.org/assignments/media-types/application/vnd.mcap
mimetypes.add_type(MCAP, ".mcap")

_COLUMNS = ("Began", "Room", "Length", "What happened", "")


def build(desk: Desk) -> None:
    """Build the view."""
    player = Player(desk)
    with ui.element("section").classes("panel"):
        logs = LogPanel(desk)
    ui.timer(0.25, player.look)
    ui.timer(5.0, logs.look)
    ui.timer(0.0, logs.look, once=True)


class LogPanel:
    """The list of logs; it is made anew when the folder has changed."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        ui.label("Sessions").classes("title").props('role="heading" aria-level="2"')
        ui.label("Every session is logged. Nothing is deleted here: logs are files in the folder of sessions.").classes(
            "hint"
        )
        self.state = ui.label("The folder is being read …").props('role="status"')
        self.table = ui.element("div").classes("scrolled")
        self.box = ui.element("div")
        self._known: list[SessionLog] | None = None

    async def look(self) -> None:
        """Show the logs that there are now."""
        logs = await self.desk.host.logs.listed()
        told = [log if not log.open else _without_size(log) for log in logs]
        if told == self._known or self.table.is_deleted:
            return
        self._known = told
        self.state.set_text(f"{len(logs)} sessions" if logs else "There is no session yet.")
        self.table.clear()
        with self.table, ui.element("table").classes("table"):
            with ui.element("thead"), ui.element("tr"):
                for column in _COLUMNS:
                    with ui.element("th").props('scope="col"'):
                        ui.label(column)
            with ui.element("tbody"):
                for log in logs:
                    self._row(log)

    def _row(self, log: SessionLog) -> None:
        with ui.element("tr"):
            with ui.element("td"):
                ui.label(log.began)
            with ui.element("td"):
                ui.label(log.room).tooltip(log.name)
            with ui.element("td").classes("together"):
                ui.label("being written" if log.open else length_words(log.seconds))
                ui.label(size_words(log.size) if not log.open else "").classes("hint")
            with ui.element("td"):
                if log.readable:
                    ui.label("goes on now" if log.open else happened_words(log.counts))
                if log.trouble:
                    with ui.element("span").classes("sign bad"):
                        ui.icon("warning")
                        ui.label(log.trouble)
            with ui.element("td").classes("together"):
                if not log.open:
                    self._buttons(log)

    def _buttons(self, log: SessionLog) -> None:
        def button(text: str, do: Callable[[], Awaitable[None]]) -> None:
            told = f"{text}: {log.room}, {log.began}".replace('"', "'")
            ui.button(text, on_click=do).props(f'outline no-caps padding="xs sm" aria-label="{told}"')

        if log.readable:
            button("Show again", lambda: self._replay(log))
            button("CSV", lambda: self._tables(log))
        else:
            button("Save what is whole", lambda: self._save(log))
        button("MCAP", lambda: self._download(log))

    async def _replay(self, log: SessionLog) -> None:
        with self.box:
            if not self.desk.may():
                return
            running = self.desk.host.status.activity not in ("idle", "replaying")
            words = "This ends what runs now: the robots are stopped, and its log is closed. Show the session again?"
            if running and not await confirmed(words, "End it and show the session"):
                return
            reading = ui.notification("The log is being read …", type="info", timeout=None, spinner=True)
            shown = await self.desk.do(self.desk.host.logs.replay(log.name))
            reading.dismiss()
            if shown:
                ui.run_javascript("window.scrollTo(0, 0)")
            else:
                await self.look()

    async def _tables(self, log: SessionLog) -> None:
        with self.box:
            ui.notify("The tables are being made …", type="info")
            await self.desk.do(self._made(log))

    async def _made(self, log: SessionLog) -> None:
        made = await self.desk.host.logs.tables(log.name)
        ui.download.file(made, f"{log.name.removesuffix('.mcap')}_tables.zip", "application/zip")

    async def _download(self, log: SessionLog) -> None:
        with self.box:
            await self.desk.do(self._given(log))

    async def _given(self, log: SessionLog) -> None:
        ui.download.file(self.desk.host.logs.path(log.name), log.name, MCAP)

    async def _save(self, log: SessionLog) -> None:
        with self.box:
            if await self.desk.do(self._saved(log)):
                await self.look()

    async def _saved(self, log: SessionLog) -> None:
        ui.notify(f"Saved as {await self.desk.host.logs.save(log.name)}", type="positive")


def _without_size(log: SessionLog) -> SessionLog:
    """A log that is being written, as it is compared: it grows all the time."""
    return SessionLog(log.name, log.began, log.room, 0, open=True)
