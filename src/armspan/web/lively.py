"""The one component of our own: draws the frames of the live line, in three dimensions, from above, as curves."""

from typing import Literal, TypeAlias

from nicegui.element import Element
from nicegui.elements.scene import Scene

Kind: TypeAlias = Literal["space", "plan", "strips", "scores", "say", "aim", "keys"]
"""What is drawn: the scene, the sheet from above, the bands' signals, confidence bars, the words, what is pointed at;
``keys`` stops the robots at Esc and the space bar, and says so."""

THREE_FROM = Scene
"""NiceGUI's scene brings three.js as the module that the component imports."""


class Lively(Element, component="lively.js", esm={"armspan-drawn": "drawn"}):
    """One view of the live line; all of a page's views share one connection.

    Options: ``strips`` takes ``bands`` (their names; all of the room's without it), ``scores`` takes ``threshold``
    (a share), ``space`` and ``plan`` take ``stops=True`` (show the set-up's residuals after it, too), ``plan`` takes
    ``draw=True``. A plan tells ``on("picked", ...)`` with ``args`` ``{x, y, robot, zone}`` in metres of the sheet, and
    while it draws ``on("drawn", ...)`` with ``{polygon: [[x, y], ...]}``; a polygon told does not cross itself.
    """

    def __init__(self, kind: Kind, label: str, **options: object) -> None:
        super().__init__()
        self._props["kind"] = kind
        self._props["label"] = label
        self._props["options"] = options

    def show(self, **options: object) -> None:
        """Change some of the options."""
        self._props["options"] = {**self._props["options"], **options}
        self.update()
