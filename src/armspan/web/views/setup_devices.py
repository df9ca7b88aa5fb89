"""The wizard's first step: are all bands and robots there?"""

from collections.abc import Callable

from nicegui import ui

from armspan.web.desk import Desk
from armspan.web.views.setup_kept import Kept
from armspan.web.views.setup_words import device_row, devices_verdict

_COLUMNS = (
    ("name", "Device"),
    ("kind", "Kind"),
    ("where", "Where"),
    ("link", "Link"),
    ("battery", "Battery"),
    ("rate", "Samples"),
    ("lost", "Lost"),
    ("note", "Note"),
)


def build(desk: Desk, kept: Kept, go: Callable[[int], None]) -> Callable[[], None]:
    """The table of devices."""
    ui.label("Put the bands on, firmly, with the sensor on top of the wrist, and the robots on the sheet.")
    columns = [{"name": name, "label": label, "field": name, "align": "left"} for name, label in _COLUMNS]
    table = ui.table(columns=columns, rows=[], row_key="name").classes("wizard-table").props("flat separator=cell")
    verdict = ui.label().classes("wizard-verdict").props('role="status"')
    advice = ui.label().classes("wizard-lines")
    joining = ui.label().classes("wizard-joining")
    with ui.element("div").classes("wizard-buttons"):
        ui.button("Next: measures", on_click=lambda: go(1)).props("no-caps")

    def look() -> None:
        devices = desk.host.devices()
        rows = [device_row(device) for device in devices]
        if rows != table.rows:
            table.rows = rows
        verdict.set_text(devices_verdict(devices))
        advice.set_text("\n".join(desk.host.advice()))
        if not joining.text:
            joining.set_text(desk.host.invitation())
        for told in (advice, joining):
            told.set_visibility(bool(told.text))

    return look
