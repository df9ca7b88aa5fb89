"""Who steers: one browser at a time; who has control is visible, and taking it over is one click."""

import itertools
from dataclasses import dataclass, field


@dataclass(slots=True)
class Control:
    """The browsers that are open, by their ids, and the one that steers; everybody may stop the robots."""

    names: dict[str, str] = field(default_factory=dict)
    holder: str | None = None
    _away: set[str] = field(default_factory=set)

    def enter(self, browser: str, what: str) -> str:
        """A browser's line to the page is up; a new one is named, and steers if nobody does or who does is away."""
        self._away.discard(browser)
        if browser not in self.names:
            names = (f"{what} {number}" for number in itertools.count(1))
            self.names[browser] = next(name for name in names if name not in self.names.values())
        if self.holder is None or self.holder in self._away:
            self.holder = browser
        return self.names[browser]

    def away(self, browser: str) -> None:
        """A browser's line is down: it may be closed, or loading the page anew."""
        self._away.add(browser)

    def leave(self, browser: str) -> bool:
        """A browser is gone; was it the one that steered?"""
        self.names.pop(browser, None)
        self._away.discard(browser)
        if self.holder != browser:
            return False
        self.holder = None
        return True

    def take(self, browser: str) -> None:
        """Give control to a browser that is open."""
        if browser in self.names:
            self.holder = browser

    def has(self, browser: str) -> bool:
        """Whether a browser steers."""
        return self.holder == browser

    def words(self, browser: str) -> str:
        """Who has control, as that browser is told."""
        if self.has(browser):
            return "You have control"
        return f"{self.names[self.holder]} has control" if self.holder in self.names else "Nobody has control"
