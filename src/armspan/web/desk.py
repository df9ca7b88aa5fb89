"""One browser's desk: what its views may ask for, and who has control."""

from collections.abc import Awaitable
from dataclasses import dataclass, field

from nicegui import ui

from armspan.errors import ArmspanError
from armspan.web.control import Control
from armspan.web.host import Host
from armspan.web.shown import Shown


@dataclass(slots=True)
class Office:
    """What all browsers share."""

    host: Host
    shown: Shown
    control: Control = field(default_factory=Control)


@dataclass(slots=True)
class Desk:
    """What one browser has: the office, and its own id."""

    office: Office
    browser: str

    @property
    def host(self) -> Host:
        """What runs the activities."""
        return self.office.host

    @property
    def shown(self) -> Shown:
        """What the session showed last."""
        return self.office.shown

    def may(self) -> bool:
        """Whether this browser steers; if not, it is told who does."""
        control = self.office.control
        if control.holder is None:
            control.take(self.browser)
        if not control.has(self.browser):
            ui.notify(f"{control.words(self.browser)}: press Take control first", type="warning")
            return False
        return True

    async def press(self, name: str, value: str = "") -> None:
        """Press a button of the session, if this browser steers."""
        if self.may():
            await self.host.press(name, value)

    async def do(self, work: Awaitable[object]) -> bool:
        """Wait for work; what is wrong is said in place, and False."""
        try:
            await work
        except ArmspanError as error:
            ui.notify(
                str(error), type="negative", timeout=10000, multi_line=True, actions=[{"label": "OK", "color": "white"}]
            )
            return False
        return True
