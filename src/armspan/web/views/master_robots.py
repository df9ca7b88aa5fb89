"""The robots' table: what each does, and what it needs, in words with an icon."""

from dataclasses import dataclass

from nicegui import ui

from armspan.web.desk import Desk
from armspan.web.views.master_state import RobotRow, Sign, robot_rows

_COLUMNS = ("Takes part", "Robot", "Does", "Battery", "Lifted", "Link", "Waits because", "")


class _Cell:
    """A state as icon and words."""

    def __init__(self) -> None:
        with ui.element("td"), ui.element("span").classes("sign") as self.box:
            self.icon, self.words = ui.icon(""), ui.label()
        self._sign: Sign | None = None

    def show(self, sign: Sign) -> None:
        """Show a state, if it is another one."""
        if sign != self._sign:
            self._sign = sign
            self.icon.set_name(sign.icon)
            self.words.set_text(sign.words)
            self.box.classes(add="bad" if sign.bad else None, remove=None if sign.bad else "bad")


@dataclass(slots=True)
class _Line:
    """The changing parts of one robot's row."""

    takes_part: ui.checkbox
    signs: tuple[_Cell, _Cell, _Cell, _Cell]
    waits: ui.label
    resume: ui.button


class RobotPanel:
    """Every robot of the room, also of one that is shown again."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        ui.label("Robots").classes("title").props('role="heading" aria-level="2"')
        self.table = ui.element("div").classes("scrolled")
        self._names: list[str] | None = None
        self._lines: dict[str, _Line] = {}
        self.look()

    def look(self) -> None:
        """Show how the robots are now."""
        shown, agenda = self.desk.shown, self.desk.host.activities.agenda
        rows = robot_rows(shown.room(), shown.frame())
        if [row.robot for row in rows] != self._names:
            self._rebuild([row.robot for row in rows])
        for row in rows:
            line = self._lines[row.robot]
            for cell, sign in zip(line.signs, (row.doing, row.battery, row.held, row.link), strict=True):
                cell.show(sign)
            line.waits.set_text(row.waits)
            line.resume.set_enabled(_can_resume(row))
            line.takes_part.set_value(row.robot not in agenda.out)

    def _rebuild(self, names: list[str]) -> None:
        self._names, self._lines = names, {}
        self.table.clear()
        with self.table:
            if not names:
                ui.label("No room with robots is open.")
                return
            with ui.element("table").classes("table"):
                with ui.element("thead"), ui.element("tr"):
                    for column in _COLUMNS:
                        with ui.element("th").props('scope="col"'):
                            ui.label(column)
                with ui.element("tbody"):
                    for name in names:
                        self._lines[name] = self._row(name)

    def _row(self, name: str) -> _Line:
        with ui.element("tr"):
            with ui.element("td"):
                takes_part = ui.checkbox(value=True).props(f'aria-label="{name} takes part"')
                takes_part.on("update:model-value", lambda event: self._leave_out(name, not takes_part.value))
            with ui.element("th").props('scope="row"'):
                ui.label(name)
            signs = (_Cell(), _Cell(), _Cell(), _Cell())
            with ui.element("td"):
                waits = ui.label()
            with ui.element("td"):
                resume = ui.button("Resume", on_click=lambda: self.desk.press("resume", name))
                resume.props(f'outline dense aria-label="Resume {name}"')
        return _Line(takes_part, signs, waits, resume)

    async def _leave_out(self, robot: str, out: bool) -> None:
        if self.desk.may():
            await self.desk.do(self.desk.host.activities.leave_out(robot, out))
        self.look()


def _can_resume(row: RobotRow) -> bool:
    """Whether a word to this robot alone lets it go; a stop of all robots is for Resume all."""
    return bool(row.waits) and row.doing.words != "stopped"
