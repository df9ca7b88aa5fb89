"""Questions before something is done."""

from nicegui import ui


async def confirmed(words: str, yes: str) -> bool:
    """Ask whether to do something; Esc says no, and stops the robots as ever."""
    with ui.dialog() as dialog, ui.card().classes("ask"):
        ui.label(words)
        with ui.row():
            ui.button(yes, on_click=lambda: dialog.submit(True)).props("autofocus")
            ui.button("Cancel", on_click=lambda: dialog.submit(False)).props("flat")
    answer = await dialog
    dialog.delete()
    return bool(answer)


async def named(words: str, label: str, value: str = "") -> str:
    """Ask for a name; nothing where it was not given."""
    with ui.dialog() as dialog, ui.card().classes("ask"):
        ui.label(words)
        typed = ui.input(label, value=value).props("autofocus")
        typed.on("keydown.enter", lambda: dialog.submit(typed.value))
        with ui.row():
            ui.button("OK", on_click=lambda: dialog.submit(typed.value))
            ui.button("Cancel", on_click=lambda: dialog.submit(""))
    answer = await dialog
    dialog.delete()
    return str(answer or "").strip()
