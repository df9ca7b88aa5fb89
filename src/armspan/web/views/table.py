"""The table: robots, arms and ray as the system believes them, and what is pointed at."""

from nicegui import ui

from armspan.web.desk import Desk
from armspan.web.lively import Lively


def build(desk: Desk) -> None:
    """The live scene beside the sheet from above."""
    with ui.element("div").classes("panel aim"):
        Lively("aim", "What is pointed at")
        stops = ui.switch("Show the set-up's stops")
    with ui.element("div").classes("side"):
        views = [
            Lively("space", "The table and the arms, in three dimensions").classes("panel tall"),
            Lively("plan", "The sheet from above").classes("panel tall"),
        ]

    def show() -> None:
        for view in views:
            view.show(stops=stops.value)

    stops.on_value_change(show)
