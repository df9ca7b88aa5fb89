"""The wizard's second step: the person's measures, typed or from a picture."""

from collections.abc import Callable
from typing import Literal

import msgspec
from nicegui import events, ui

from armspan.errors import ArmspanError
from armspan.records import Body
from armspan.web.desk import Desk
from armspan.web.host import Portrait, Portraits
from armspan.web.views.setup_kept import Kept
from armspan.web.views.setup_pictures import found_pictures, picture_fields
from armspan.web.views.setup_words import FIELDS, FieldError, arms_with_band, body_rows, told_of, whole_number

_EYE = (
    "Which eye? Point with a straight arm at a small thing far off, both eyes open, and close the left eye. Still on "
    "it: the right eye. It jumps: the left. Do it three times; if the answers differ, choose “not sure”."
)
_CHOICES: dict[str, tuple[str, dict[str, str], str]] = {
    "sex": ("Sex (narrows the measures somewhat)", {"woman": "woman", "man": "man", "": "not told"}, ""),
    "arm": ("The arm that points", {"right": "right", "left": "left"}, "right"),
    "eye": ("The eye that sights", {"right": "right", "left": "left", "both": "not sure"}, "right"),
}


def build(desk: Desk, kept: Kept, go: Callable[[int], None]) -> Callable[[], None]:
    """The fields, the pictures, and what comes of them."""
    return _Measuring(desk, kept, go).look


class _Measuring:
    def __init__(self, desk: Desk, kept: Kept, go: Callable[[int], None]) -> None:
        self.desk, self.kept, self.go = desk, kept, go
        self.inputs: dict[str, ui.input] = {}
        with ui.element("div").classes("wizard-halves"):
            with ui.element("div"):
                self._fields()
            with ui.element("div"):
                self.result = ui.element("div").classes("wizard-result").props('aria-live="polite"')
        self.shows: object = None
        self._show_result()

    # --- fields ----------------------------------------------------------------------------------------

    def _fields(self) -> None:
        ui.label("Height and sex are enough; every further measure makes pointing surer. All in metres.")
        self._input("height_m")
        self._choice("sex")
        self._choice("arm")
        self._choice("eye")
        ui.label(_EYE).classes("wizard-hint")
        with ui.expansion("More measures with a tape").classes("wizard-more"):
            for field in FIELDS:
                if field != "height_m":
                    self._input(field)
            told = self.kept.typed.get("self_reported") == "yes"
            box = ui.checkbox("The height is what the person says, not measured", value=told)
            box.on_value_change(lambda event: self._type("self_reported", "yes" if event.value else ""))
        with ui.expansion("A picture or a skeleton file").classes("wizard-more"):
            picture_fields(self.desk, self.kept, self._field_input, self._uploaded)
        self.wrong = ui.label().classes("trouble").props('role="alert"')
        self.wrong.set_visibility(False)
        with ui.element("div").classes("wizard-buttons"):
            self.measure = ui.button("Find my measures", on_click=self._measure).props("no-caps")
            ui.button("Keep the room's measures", on_click=lambda: self.go(2)).props("no-caps outline")

    def _input(self, field: str) -> None:
        label, hint = FIELDS[field]
        self._field_input(field, f"{label} [m]", hint)

    def _field_input(self, field: str, label: str, hint: str) -> None:
        ui.label(label)
        made = ui.input(value=self.kept.typed.get(field, "")).classes("wizard-input")
        made.props(f'aria-label="{label}" hint="{hint}" outlined dense hide-bottom-space autocomplete=off')
        made.on_value_change(lambda event: self._type(field, str(event.value or "")))
        made.on("keydown.enter", self._measure)
        self.inputs[field] = made

    def _choice(self, field: str) -> None:
        label, options, usual = _CHOICES[field]
        with ui.element("fieldset").classes("wizard-choice"):
            with ui.element("legend"):
                ui.label(label)
            chosen = ui.radio(options, value=self.kept.typed.get(field, usual)).props("inline")
        chosen.on_value_change(lambda event: self._type(field, str(event.value or "")))

    def _type(self, field: str, text: str) -> None:
        self.kept.typed[field] = text
        for made in self.inputs.values():
            made.error = None

    async def _uploaded(self, side: Literal["front", "side"], event: events.UploadEventArguments) -> None:
        if self.desk.may():
            self.kept.portraits[side] = Portrait(side, event.file.name, await event.file.read())

    # --- measuring -------------------------------------------------------------------------------------

    async def _measure(self) -> None:
        if not self.desk.may():
            return
        self._complain("")
        try:
            told = told_of(self.kept.typed)
            self._check_arm(told.arm)
            portraits = self._portraits()
            if told.height_m is None and not portraits.marker:
                raise FieldError("height_m", "The height is missing: type it in metres, such as 1.72")
        except FieldError as error:
            self._complain(str(error), error.field)
            return
        self.measure.props("loading")
        try:
            self.kept.found = await self.desk.host.measure(told, portraits)
            self.kept.portraits.clear()
        except ArmspanError as error:
            self._complain(str(error))
        finally:
            self.measure.props(remove="loading")
        self._show_result()

    def _portraits(self) -> Portraits:
        typed, files = self.kept.typed, tuple(self.kept.portraits.values())
        return Portraits(files, whole_number(typed.get("person", "")), bool(files) and typed.get("marker") == "yes")

    def _check_arm(self, arm: str) -> None:
        settings = self.desk.host.settings
        if settings is not None and arm not in arms_with_band(settings):
            worn = " or ".join(arms_with_band(settings))
            raise FieldError(
                "arm", f"No band is worn on the {arm} forearm: choose the {worn} arm, or wear a band there"
            )

    def _complain(self, text: str, field: str = "") -> None:
        """Say what is wrong: at its field, where it has one."""
        made = self.inputs.get(field)
        if made is not None:
            made.error = text
            made.run_method("focus")
        self.wrong.set_text(text if made is None else "")
        self.wrong.set_visibility(bool(self.wrong.text))

    # --- what came of it -------------------------------------------------------------------------------

    def look(self) -> None:
        """Notice that the measures which were asked for are in use."""
        settings = self.desk.host.settings
        if settings is not None and self.kept.asked == settings.body:
            self.kept.asked = self.kept.found = None
            self.desk.host.keep_body(settings.body)
            ui.notify("These measures are in use now", type="positive")
            self.go(2)
        elif settings is not None and self.shows is not settings.body:
            self._show_result()

    def _show_result(self) -> None:
        settings, found = self.desk.host.settings, self.kept.found
        self.shows = settings.body if settings is not None else None
        self.result.clear()
        with self.result:
            if found is not None:
                _table("Your measures", found.body)
                if found.notes:
                    with ui.expansion("How they were found").classes("wizard-more"):
                        for note in found.notes:
                            ui.label(note).classes("wizard-hint")
                found_pictures(found)
                ui.button("Use these measures", on_click=self._use).props("no-caps").classes("wizard-big")
            if settings is not None:
                _table("The measures in use now", settings.body)

    async def _use(self) -> None:
        if self.kept.found is not None and self.desk.may():
            self.kept.asked = self.kept.found.body
            await self.desk.host.press("body", msgspec.json.encode(self.kept.found.body).decode())


def _table(title: str, body: Body) -> None:
    columns = [("measure", f"{body.arm} arm"), ("value", "Size"), ("sd", "Unsure by")]
    ui.label(title).classes("wizard-title").props('role="heading"')
    ui.table(
        columns=[{"name": name, "label": label, "field": name, "align": "left"} for name, label in columns],
        rows=body_rows(body),
        row_key="measure",
    ).classes("wizard-table").props("flat separator=cell")
