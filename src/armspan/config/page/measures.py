"""A person's measures for the page: typed sizes, pictures and skeleton files, read as by ``armspan body``."""

import tempfile
import tomllib
from importlib.util import find_spec
from pathlib import Path

from armspan.body.measured import Measured, measure
from armspan.body.picture.overlay import overlay
from armspan.body.told import Told
from armspan.config.body_file import body_text
from armspan.config.body_views import Wanted, read_view
from armspan.config.weights import missing_weights, weights_folder
from armspan.errors import ArmspanError
from armspan.records import Body
from armspan.web.host import Measures, Portraits

_OPTIONS = {
    "--person": '"Which person"',
    "leave --marker out": "leave the marker sheet unticked",
    "--keep DIR": "below",
}
"""What ``armspan body`` calls its options, and what the page does."""


def lacks() -> str:
    """What must be installed to measure pictures, in a sentence; nothing where all is there."""
    if find_spec("cv2") is None or find_spec("ai_edge_litert") is None:
        return (
            "To measure pictures, install the extra: pip install 'armspan[picture]' and then armspan body --set-up, in "
            "a terminal. Skeleton files (JSON) are read without."
        )
    if missing_weights(weights_folder()):
        return (
            "To measure pictures, the networks must be fetched once: armspan body --set-up, in a terminal. Skeleton "
            "files (JSON) are read without."
        )
    return ""


def entry(body: Body) -> dict[str, object]:
    """Measures as a room file's ``[body]`` holds them, to the tenth of a millimetre."""
    table: dict[str, object] = tomllib.loads(body_text(body, ""))["body"]
    return table


def measured(typed: Told, portraits: Portraits) -> Measures:
    """Measure a person; the uploaded files lie in a temporary folder while they are read, and are gone afterwards.

    Raises:
        ConfigError: for sizes that cannot be.
        DataError: for a file in which the person cannot be measured.
        MissingExtra: where pictures need what is not installed.

    """
    with tempfile.TemporaryDirectory(prefix="armspan-") as folder:
        try:
            return _measured(typed, portraits, Path(folder))
        except ArmspanError as error:
            raise _said(error, Path(folder), portraits) from None


def _measured(typed: Told, portraits: Portraits, folder: Path) -> Measures:
    wanted = Wanted(weights_folder(), None, portraits.person, portraits.marker)
    views = []
    for portrait in portraits.files:
        path = folder / portrait.side
        path.write_bytes(portrait.data)
        views.append(read_view(path, portrait.side, wanted))
        path.unlink()
    found = measure(typed, [view.measured for view in views])
    drawn = [
        (view.side, overlay(view.picture.pixels, view.skeleton, marker=view.marker, notes=seen.notes, arm=typed.arm))
        for view, seen in zip(views, found.seen, strict=True)
        if view.picture is not None
    ]
    return Measures(found.fused.body, (*found.notes, *_left_out(found)), tuple(drawn))


def _left_out(found: Measured) -> list[str]:
    return [
        f"{odd.observation.measure} of {odd.observation.value:.3f} m from the {odd.observation.source} is "
        f"{abs(odd.z):.1f} standard deviations from what this height tells, and was left out"
        for odd in found.fused.rejected
    ]


def _said(error: ArmspanError, folder: Path, portraits: Portraits) -> ArmspanError:
    """The same complaint in the page's words: uploaded files by their own names, no options of a command."""
    text = str(error)
    for portrait in portraits.files:
        text = text.replace(str(folder / portrait.side), portrait.name)
    for option, words in _OPTIONS.items():
        text = text.replace(option, words)
    return error if text == str(error) else type(error)(text)
