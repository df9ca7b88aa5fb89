"""Takes recorded, one deleted, a model trained and used, in a real browser."""

import re

import pytest

pytestmark = pytest.mark.timeout(100)


def test_from_no_takes_to_live_bars(tab, served):
    tab.goto(served.address + "gestures")
    tab.get_by_text("There are no takes yet").wait_for()
    tab.get_by_role("button", name="Train on all takes").click()
    tab.get_by_text("there is no take of a gesture to learn from").wait_for()
    tab.get_by_role("button", name="OK", exact=True).first.click()

    tab.get_by_label("Person code").fill("Anna B.")
    tab.get_by_label("Takes of each").fill("2")
    tab.get_by_label("Everyday motion, seconds").fill("12")
    for label in ("stop", "mixing"):
        tab.get_by_role("checkbox", name=label, exact=True).press("Enter")
    start = tab.get_by_role("button", name="Start recording")
    start.press("Enter")
    tab.get_by_text("cannot begin a file's name").wait_for()
    tab.get_by_role("button", name="OK", exact=True).first.click()
    tab.get_by_label("Person code").fill("p07")
    start.press("Enter")

    tab.get_by_text(re.compile("Recording: 1 of 7")).wait_for(timeout=20000)
    tab.get_by_role("button", name="Train on all takes").click()
    tab.get_by_text("a recording goes on").wait_for()
    tab.get_by_role("button", name="everyday motion: 0.2 min").wait_for(timeout=30000)

    tab.get_by_role("button", name="mixing: 2 takes, 1 for practice").click()
    tab.get_by_role("button", name="Look at mixing, p07, number 2").click()
    tab.get_by_text("right band: acceleration").wait_for()
    assert tab.locator("svg.take polyline").count() == 12
    tab.get_by_role("button", name="Delete mixing, p07, number 1").click()
    tab.get_by_role("button", name="Delete it").click()
    tab.get_by_role("button", name="mixing: 2 takes", exact=True).wait_for()
    assert (served.folder / "takes" / ".deleted" / "mixing" / "p07_01.csv").is_file()

    tab.get_by_role("button", name="Train on all takes").click()
    tab.get_by_role("button", name="Use this model").click(timeout=30000)
    assert re.findall(r"\d", tab.locator("table.confusion").inner_text())
    assert len(list((served.folder / "models").glob("*.model"))) == 1
    tab.get_by_role("button", name="Begin the set-up").click(timeout=20000)
    tab.locator(".gest-bars").get_by_text("mixing").wait_for(timeout=30000)

    slider = tab.get_by_role("slider")
    before = slider.get_attribute("aria-valuenow")
    slider.locator("[tabindex]").first.press("ArrowLeft")
    tab.get_by_text(f"A gesture counts from {100 * float(before) - 5:.0f} % on").wait_for()
    tab.get_by_text(re.compile("False triggers: .* an hour")).last.wait_for()

    choice = tab.get_by_label("mixing").last
    choice.click()
    tab.get_by_role("option", name="come together").click()
    tab.get_by_role("button", name="Save for this room").click()
    tab.get_by_text("Saved: the next sessions").wait_for()
    assert len(list((served.folder / "models").glob("*.model"))) == 2  # with the threshold as it is now
