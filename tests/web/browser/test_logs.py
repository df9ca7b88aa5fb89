"""The log view in a real browser."""

import re
import shutil
from pathlib import Path

import pytest

GOLDEN = Path(__file__).parents[2] / "sessions" / "small.mcap"


@pytest.fixture
def logs(tab, served):
    """A tab on the log view of a folder with a session in it."""
    shutil.copy(GOLDEN, served.folder / "sessions" / "2026-11-01_101500_golden.mcap")
    tab.goto(served.address + "log")
    tab.get_by_role("button", name=re.compile("^Show again: golden")).wait_for()
    return tab


def test_a_session_is_shown_again_after_a_question_and_one_click_leads_back(logs):
    logs.get_by_role("button", name=re.compile("^Show again: golden")).click()
    logs.get_by_role("button", name="End it and show the session").click()
    logs.get_by_role("button", name="Pause").click(timeout=60_000)
    logs.get_by_text(re.compile("of 0:23 min$")).wait_for()
    place = logs.locator(".player .q-slider").bounding_box()
    logs.mouse.click(place["x"] + 0.9 * place["width"], place["y"] + place["height"] / 2)
    logs.get_by_text(re.compile("0:2[012] min of 0:23 min")).wait_for()
    logs.get_by_role("button", name="Back to the room").click()
    logs.get_by_text("Shown again").wait_for(state="hidden")


@pytest.mark.parametrize(
    ("button", "name", "kind"),
    [
        ("MCAP", "2026-11-01_101500_golden.mcap", "application/vnd.mcap"),
        ("CSV", "2026-11-01_101500_golden_tables.zip", "application/zip"),
    ],
)
def test_downloads_come_with_their_content_type(logs, button, name, kind):
    logs.evaluate(
        "() => { HTMLAnchorElement.prototype.click = function () { window.asked = [this.href, this.download] } }"
    )
    logs.get_by_role("button", name=re.compile(f"^{button}: golden")).click()
    address, told = logs.wait_for_function("window.asked", timeout=60_000).json_value()
    answer = logs.request.get(address)
    assert (told, answer.status, answer.headers["content-type"]) == (name, 200, kind)
    if button == "MCAP":
        assert answer.body() == GOLDEN.read_bytes()
