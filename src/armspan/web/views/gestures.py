"""Gestures: record takes, look through them, train, and see what the model recognises."""

from nicegui import ui

from armspan.web.desk import Desk
from armspan.web.lively import Lively
from armspan.web.views import gestures_live, gestures_record, gestures_takes, gestures_train


def build(desk: Desk) -> None:
    """Build the view."""
    with ui.element("div").classes("side"):
        gestures_record.build(desk)
        with ui.element("section").classes("panel gest"):
            ui.label("Signals of the bands").classes("gest-title").props('role="heading" aria-level="2"')
            Lively("strips", "Signals of the bands").classes("gest-strips")
    gestures_takes.build(desk)
    gestures_train.build(desk)
    with ui.element("div").classes("side"):
        gestures_live.build(desk)
