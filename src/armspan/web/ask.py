"""Questions before something is done."""

from nicegui import ui


async def confirmed(words: str, yes: str) -> bool:
    """Ask whether to do something; Esc says no, and stops the robots as ever."""
    with ui.dialog() as dialog, ui.card().classes("ask"):
        ui.label(words)
        with ui.row():
            ui.button(yes, on_click=lambda: dialog.submit(True)).props("autofocus")
            ui.button("Cancel", on_click=lambda: dialog.submit(False)).props("flat")
    return bool(await _answer(dialog))


async def named(words: str, label: str, value: str = "") -> str:
    """Ask for a name; nothing where it was not given."""
    with ui.dialog() as dialog, ui.card().classes("ask"):
        ui.label(words)
        typed = ui.input(label, value=value).props("autofocus")
        typed.on("keydown.enter", lambda: dialog.submit(typed.value))
        with ui.row():
            ui.button("OK", on_click=lambda: dialog.submit(typed.value))
            ui.button("Cancel", on_click=lambda: dialog.submit(""))
    return str(await _answer(dialog) or "").strip()


async def _answer(dialog: ui.dialog) -> object:
    """What was answered; the dialog is gone then, also where its browser went before it was."""
    answer = await dialog
    if not dialog.is_deleted:
        dialog.delete()
    return answer
