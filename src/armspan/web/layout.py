"""The page's frame: where one is, who steers, what to do now, and the stop that is always there."""

from collections.abc import Callable
from pathlib import Path

from nicegui import ui

from armspan.web.desk import Desk, Office
from armspan.web.lively import Lively
from armspan.web.views import gestures, logs, master, setup, table

STYLE = Path(__file__).with_name("style.css")

VIEWS: dict[str, tuple[str, Callable[[Desk], None]]] = {
    "/": ("Table", table.build),
    "/set-up": ("Set-up", setup.build),
    "/gestures": ("Gestures", gestures.build),
    "/master": ("Game master", master.build),
    "/log": ("Log", logs.build),
}
"""The views by path: their names, and what builds them."""


def root(office: Office) -> None:
    """Build the page for one browser."""
    client = ui.context.client
    desk = Desk(office, client.id)
    what = _device(client.request.headers.get("user-agent", "") if client.request else "")
    client.on_connect(lambda: office.control.enter(client.id, what))
    client.on_disconnect(lambda: office.control.away(client.id))
    client.on_delete(lambda: _leave(office, client.id))
    ui.add_css(STYLE.read_text(encoding="utf-8"), shared=False)
    ui.colors(primary="#1f5fa8", negative="#c00016")
    with ui.header().classes("top"):
        ui.link("Armspan", "/").classes("brand")
        tabs = {path: ui.link(name, path).classes("tab") for path, (name, _) in VIEWS.items()}
        ui.space()
        control = ui.label().classes("control").props('role="status"')
        take = ui.button("Take control", on_click=lambda: office.control.take(client.id)).props("outline color=white")
        stop = ui.button("Stop all robots", on_click=lambda: office.host.press("stop")).classes("stop")
        stop.props('color=negative aria-keyshortcuts="Escape Space"')
        stop.tooltip("Esc, or the space bar outside of text")
    Lively("keys", "Stops the robots at Esc and the space bar")
    Lively("say", "What to do now").classes("say")
    state = _state(desk)
    ui.sub_pages({path: _built(build, desk) for path, (_, build) in VIEWS.items()}).classes("view")

    def mark(path: str) -> None:
        for of, tab in tabs.items():
            tab.props('aria-current="page"' if of == path.partition("?")[0] else "", remove="aria-current")

    def look() -> None:
        control.set_text(office.control.words(client.id))
        take.set_visibility(not office.control.has(client.id))
        state()

    client.sub_pages_router.on_path_changed(mark)
    mark(client.sub_pages_router.current_path)
    look()
    ui.timer(0.5, look)


def _state(desk: Desk) -> Callable[[], None]:
    """What keeps the robots from moving, and the way on; what is given back brings it up to date."""
    with ui.element("div").classes("trouble") as shut:
        why = ui.label().props('role="alert"')
        ui.button("Open the room again", on_click=lambda: _open(desk))
    with ui.element("div").classes("halted") as halted:
        stopped = ui.label().props('role="alert"')
        ui.button("Let the robots move again", on_click=lambda: desk.press("resume"))

    def look() -> None:
        status, mind = desk.host.status, desk.shown.mind
        sight = mind.sight() if mind is not None and status.activity == "steering" else None
        why.set_text(status.trouble or "The room is closed")
        shut.set_visibility(status.activity == "idle")
        halted.set_visibility(sight is not None and sight.stopped)
        told = desk.shown.stopped_why
        why_stopped = f" ({told})" if told not in ("", "stop") else ""
        stopped.set_text(f"All robots are stopped{why_stopped}, and stay so until somebody lets them go on")

    return look


async def _open(desk: Desk) -> None:
    if desk.may():
        await desk.do(desk.host.steer())


def _built(build: Callable[[Desk], None], desk: Desk) -> Callable[[], None]:
    return lambda: build(desk)


async def _leave(office: Office, browser: str) -> None:
    """A browser is gone; when the one that steered goes, nobody sees to the robots any more, and they stop."""
    if office.control.leave(browser):
        await office.host.press("stop", "the page that had control was closed")


def _device(agent: str) -> str:
    """A word for the device a browser runs on."""
    if "iPad" in agent or "Tablet" in agent or ("Android" in agent and "Mobile" not in agent):
        return "Tablet"
    return "Phone" if "Mobile" in agent or "iPhone" in agent else "Computer"
