import asyncio

import pytest

from armspan.web.desk import Office
from armspan.web.layout import _device, _leave
from armspan.web.shown import Shown


class Host:
    """Notes what is pressed."""

    def __init__(self):
        self.pressed = []

    async def press(self, name, value=""):
        self.pressed.append((name, value))


@pytest.mark.parametrize(
    ("agent", "word"),
    [
        ("Mozilla/5.0 (Windows NT 10.0; Win64; x64)", "Computer"),
        ("Mozilla/5.0 (iPad; CPU OS 16_0 like Mac OS X) Mobile/15E148", "Tablet"),
        ("Mozilla/5.0 (Linux; Android 13; SM-X200)", "Tablet"),
        ("Mozilla/5.0 (Linux; Android 13; Pixel 7) Mobile Safari", "Phone"),
        ("", "Computer"),
    ],
)
def test_browsers_are_named_by_their_device(agent, word):
    assert _device(agent) == word


def test_when_the_browser_that_steers_is_gone_the_robots_stop():
    office = Office(Host(), Shown())
    office.control.enter("a", "Computer")
    office.control.enter("b", "Tablet")
    asyncio.run(_leave(office, "b"))
    assert office.host.pressed == []
    asyncio.run(_leave(office, "a"))
    assert office.host.pressed == [("stop", "the page that had control was closed")]
