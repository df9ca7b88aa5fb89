"""The takes that there are: counts per gesture, each take, its signals, away with a bad one."""

from nicegui import ui

from armspan.web.desk import Desk
from armspan.web.views.gestures_host import TakeRow
from armspan.web.views.gestures_words import counted, drawing, name_of, state_of


def build(desk: Desk) -> None:
    """The list, kept up to date."""
    with ui.element("section").classes("panel gest"):
        ui.label("Takes").classes("gest-title").props('role="heading" aria-level="2"')
        panel = _Takes(desk)
    ui.timer(0.5, panel.look)


class _Takes:
    """The list of takes: of one gesture at a time each take is shown."""

    def __init__(self, desk: Desk) -> None:
        self.desk, self.rows, self.label = desk, list[TakeRow](), ""
        self._stamp: int | None = None
        self.counts = ui.element("div").classes("gest-counts")
        self.list = ui.element("div").classes("gest-list")
        self.picture = ui.element("div").classes("gest-picture")

    async def look(self) -> None:
        """Read the folder again where it has changed."""
        stamp = self.desk.host.gestures.stamp
        if stamp == self._stamp:
            return
        self._stamp = stamp
        self.rows = await self.desk.host.gestures.takes()
        self._draw_counts()
        self._draw_list()

    def _draw_counts(self) -> None:
        self.counts.clear()
        with self.counts:
            if not self.rows:
                ui.label("There are no takes yet. Choose gestures above and start recording.")
            for label, words in counted(self.rows):
                text = f"{name_of(label)}: {words}"
                shown = label == self.label
                button = ui.button(text, on_click=lambda label=label: self._choose(label)).classes("gest-count")
                button.props(f'no-caps {"" if shown else "outline"} aria-expanded="{"true" if shown else "false"}"')

    def _choose(self, label: str) -> None:
        self.label = "" if self.label == label else label
        self.picture.clear()
        self._draw_counts()
        self._draw_list()

    def _draw_list(self) -> None:
        self.list.clear()
        rows = [row for row in self.rows if row.label == self.label]
        if not rows:
            return
        with self.list, ui.element("table").classes("gest-table"):
            with ui.element("tr"):
                for head in ("Take", "Recorded", "Length", "State", ""):
                    with ui.element("th").props('scope="col"'):
                        ui.label(head)
            for row in rows:
                self._draw_row(row)

    def _draw_row(self, row: TakeRow) -> None:
        name = f"{row.person}, number {row.number}"
        length = "-" if row.seconds is None else f"{row.seconds:.1f} s"
        with ui.element("tr"):
            for text in (name, row.recorded, length, state_of(row)):
                with ui.element("td"):
                    ui.label(text)
            with ui.element("td").classes("gest-row"):
                look = ui.button("Look at it", on_click=lambda: self._show(row)).props("outline no-caps")
                look.props(f'aria-label="Look at {name_of(row.label)}, {name}"')
                away = ui.button("Delete", on_click=lambda: self._delete(row)).props("outline no-caps color=negative")
                away.props(f'aria-label="Delete {name_of(row.label)}, {name}"')

    async def _show(self, row: TakeRow) -> None:
        """Draw a take's signals."""
        await self.desk.do(self._drawn(row))

    async def _drawn(self, row: TakeRow) -> None:
        curves = await self.desk.host.gestures.curves(row.key)
        self.picture.clear()
        with self.picture:
            ui.label(f"{name_of(row.label)}, {row.person}, number {row.number}").classes("gest-sub")
            ui.html(drawing(curves), sanitize=False)
            ui.label("Solid: x, forward. Dashed: y, to the left. Dotted: z, up. Shaded: the gesture.")

    async def _delete(self, row: TakeRow) -> None:
        """Ask, then put a take aside."""
        if not self.desk.may():
            return
        with ui.dialog() as dialog, ui.card():
            ui.label(f"Delete {name_of(row.label)}, {row.person}, number {row.number}?").classes("gest-sub")
            ui.label("It is moved to the folder .deleted beside the takes, and can be put back from there.")
            with ui.element("div").classes("gest-row"):
                ui.button("Delete it", on_click=lambda: dialog.submit(True)).props("no-caps color=negative")
                ui.button("Keep it", on_click=lambda: dialog.submit(False)).props("no-caps outline autofocus")
        wanted = await dialog
        dialog.delete()
        if wanted and await self.desk.do(self.desk.host.gestures.delete(row.key)):
            self.picture.clear()
            await self.look()
