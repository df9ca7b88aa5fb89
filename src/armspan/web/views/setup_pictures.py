"""Pictures and skeleton files in the wizard: uploaded, measured, looked at, gone."""

import base64
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Literal, TypeAlias

from nicegui import events, ui

from armspan.web.desk import Desk
from armspan.web.host import Measures
from armspan.web.views.setup_kept import Kept

Side: TypeAlias = Literal["front", "side"]
LARGEST = 40_000_000
"""Bytes of a file at most."""

_HOW: tuple[tuple[Side, str, str], ...] = (
    ("front", "From the front", "facing the camera, arms stretched out to the sides, level"),
    ("side", "From the side", "the pointing arm stretched forward, level, the camera at that side"),
)


def picture_fields(
    desk: Desk,
    kept: Kept,
    field: Callable[[str, str, str], None],
    uploaded: Callable[[Side, events.UploadEventArguments], Awaitable[None]],
) -> None:
    """Where files are given, and what is asked about them; ``field`` makes a text field (name, label, hint)."""
    lacks = ui.label().classes("wizard-hint")
    lacks.set_visibility(False)
    ui.label(
        "Camera at chest height, level, 4 m away; JPEG, PNG or WebP, or the JSON of OpenPose, openpifpaf, COCO or "
        "MediaPipe. It stays on this machine and is deleted once measured."
    ).classes("wizard-hint")
    for side, label, how in _HOW:
        _upload(kept, side, label, how, uploaded)
    field("person", "Which person", "only where several are in the picture: counted from 1 on the left")
    box = ui.checkbox("The marker sheet lies on the floor and gives the scale", value=kept.typed.get("marker") == "yes")
    box.on_value_change(lambda event: kept.typed.__setitem__("marker", "yes" if event.value else ""))

    async def ask() -> None:
        text = await desk.host.lacks_for_pictures()
        lacks.set_text(text)
        lacks.set_visibility(bool(text))

    ui.timer(0.1, ask, once=True)


def _upload(
    kept: Kept,
    side: Side,
    label: str,
    how: str,
    uploaded: Callable[[Side, events.UploadEventArguments], Awaitable[None]],
) -> None:
    upload = ui.upload(label=f"{label}: {how}", auto_upload=True, max_file_size=LARGEST, max_files=1)
    upload.props('accept=".jpg,.jpeg,.png,.webp,.json" flat bordered').classes("wizard-upload")
    with ui.element("div").classes("wizard-stop"):
        words = ui.label()
        drop = ui.button(f"Leave out the {side} file").props("no-caps outline dense")

    def show() -> None:
        file = kept.portraits.get(side)
        words.set_text("" if file is None else f"{file.name}, {len(file.data) / 1e6:.1f} MB")
        drop.set_visibility(file is not None)

    def left_out() -> None:
        kept.portraits.pop(side, None)
        show()

    async def took(event: events.UploadEventArguments) -> None:
        await uploaded(side, event)
        upload.reset()
        show()

    upload.on_upload(took)
    upload.on_rejected(
        partial(
            ui.notify, f"A JPEG, PNG, WebP or JSON file is wanted, of at most {LARGEST / 1e6:.0f} MB", type="warning"
        )
    )
    drop.on_click(left_out)
    show()
    ui.timer(0.5, show)


def found_pictures(found: Measures) -> None:
    """The pictures with the points drawn in: are they where they belong?"""
    for side, png in found.drawn:
        ui.label(f"The {side} picture: do the points sit on the joints? If not, take another picture.")
        image = ui.image(f"data:image/png;base64,{base64.b64encode(png).decode()}").classes("wizard-picture")
        image.props(f'alt="The {side} picture with the points that were found" fit=contain')
