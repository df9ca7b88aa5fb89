"""The game master's view in a real browser."""

import re

import pytest


@pytest.fixture
def master(tab, served):
    """A tab on the game master's view, which has control."""
    tab.goto(served.address + "master")
    tab.get_by_role("button", name="Start", exact=True).wait_for()
    tab.locator("button", has_text="Take control").dispatch_event("click")
    tab.get_by_text("You have control").wait_for()
    return tab


def press(page, name):
    """Press a button as somebody without a mouse does."""
    page.get_by_role("button", name=name, exact=True).focus()
    page.keyboard.press("Enter")


def drag(page, sheet):
    """Draw a rectangle left above the sheet's middle."""
    sheet.scroll_into_view_if_needed()
    box = sheet.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x - 180, y - 60)
    page.mouse.down()
    page.mouse.move(x - 120, y - 30, steps=5)
    page.mouse.up()


def test_the_list_is_led_by_the_keyboard_and_told_in_words(master):
    press(master, "Start")
    master.get_by_text("1. Wander about: goes on.").wait_for()
    master.locator("tr", has_text="amber").get_by_text("wander about").wait_for()
    press(master, "Pause")
    master.get_by_text("1. Wander about: paused.").wait_for()
    master.locator("tr", has_text="told to rest").nth(3).wait_for()
    press(master, "Next")
    master.get_by_text("2. Cover the sheet in lanes: goes on.").wait_for()
    master.keyboard.press("Escape")
    master.get_by_text(re.compile("all robots are stopped")).wait_for()
    press(master, "Start")
    master.get_by_text(re.compile("press Resume all, then begin again")).wait_for()
    press(master, "Resume all")
    master.get_by_text(re.compile("goes on no more")).wait_for()


def test_a_zone_drawn_with_the_mouse_is_named_and_a_name_twice_refused_in_place(master):
    sheet = master.get_by_label(re.compile("draw a new zone here"))
    name = master.get_by_label("Name of the zone").last
    for _ in range(10):  # the sheet moves while the page grows
        drag(master, sheet)
        master.wait_for_timeout(1000)
        if name.is_visible():
            break
    name.fill("garden")
    name.press("Enter")
    master.get_by_text("zone 'garden' is named twice").wait_for()
    name.fill("meadow")
    name.press("Enter")
    master.get_by_text(re.compile(r"^meadow \(\d+ × \d+ cm\)$")).wait_for()
    master.get_by_role("button", name="Cover meadow in lanes").wait_for()


def test_who_has_no_control_is_told_and_refused(master, chromium, served):
    other = chromium.new_context(viewport={"width": 1024, "height": 768}).new_page()
    other.goto(served.address + "master")
    other.get_by_text(re.compile("Here you can look, and stop")).wait_for()
    press(other, "Start")
    other.get_by_text("press Take control first").wait_for()
    assert other.get_by_text(re.compile(": goes on\\.")).count() == 0
    assert other.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    other.context.close()
