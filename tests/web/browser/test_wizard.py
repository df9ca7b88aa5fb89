"""The set-up wizard in a real browser: from start to steering, bad input said in place, nothing lost on the way."""

import re

import pytest

SPEED = "5"
READY = re.compile(r"Ready after (\d+) min (\d+) s")


@pytest.fixture
def wizard(tab, served):
    """A tab on the wizard's first step."""
    tab.goto(served.address + "set-up")
    tab.get_by_text("You have control").wait_for()
    button(tab, "1 Devices").click()
    arrived(tab, "Devices")
    tab.get_by_text("All 6 devices are connected").wait_for()
    return tab


def arrived(page, step):
    """Wait for a step, whose title takes the keyboard's focus: what had it before does not hear the next key."""
    page.locator(".wizard-here:focus").filter(has_text=step).wait_for()


def button(page, name):
    return page.get_by_role("button", name=name, exact=True)


def height(page):
    return page.get_by_label("Height [m]", exact=True)


def test_bad_input_is_said_in_place_and_nothing_typed_is_lost(wizard, served):
    button(wizard, "2 Measures").click()
    for typed, says in (
        ("17.5", "Height = 17.5, but it is in metres"),
        ("tall", "'tall' is not a number"),
        ("", "The height is missing"),
    ):
        height(wizard).fill(typed)
        button(wizard, "Find my measures").click()
        wizard.get_by_role("alert").filter(has_text=says).wait_for()
    height(wizard).fill("1,82")
    wizard.get_by_text("A picture or a skeleton file").click()
    wrong = {"name": "holiday.jpg", "mimeType": "image/jpeg", "buffer": b"hello"}
    wizard.locator("input[type=file]").first.set_input_files(wrong)
    wizard.get_by_text("holiday.jpg, 0.0 MB").wait_for()
    button(wizard, "Find my measures").click()
    wizard.get_by_role("alert").filter(has_text="holiday.jpg is a text file, not a picture").wait_for()
    wizard.get_by_role("link", name="Table", exact=True).click()
    wizard.get_by_role("link", name="Set-up", exact=True).click()
    assert height(wizard).input_value() == "1,82"
    wizard.goto(served.address + "set-up")  # as after a closed lid
    assert height(wizard).input_value() == "1,82"


def test_who_has_no_control_changes_nothing(wizard, chromium, served):
    other = chromium.new_context().new_page()
    other.goto(served.address + "set-up")
    other.get_by_text(re.compile(r"Computer \d+ has control")).wait_for()
    button(other, "3 Heading and calibration").click()
    button(other, "Begin").click()
    other.get_by_text("press Take control first").wait_for()
    assert other.get_by_text("Nothing is asked now").is_visible()
    other.context.close()


def test_from_the_start_to_steering_by_keyboard_alone_in_under_two_minutes(wizard):
    def enter(name):
        button(wizard, name).press("Enter")

    enter("Start the time now")
    enter("Next: measures")
    arrived(wizard, "Measures")
    height(wizard).fill("1.68")
    wizard.keyboard.press("Enter")
    wizard.get_by_text("Your measures").wait_for()
    assert wizard.get_by_text(re.compile(r"^± \d+ mm$")).count() == 5
    enter("Use these measures")
    arrived(wizard, "Heading and calibration")
    button(wizard, "Begin").wait_for()
    if button(wizard, "Let the robots move again").is_visible():  # a browser was closed before
        enter("Let the robots move again")
    button(wizard, "Begin").and_(wizard.locator(":enabled")).wait_for()
    enter("Begin")
    wizard.get_by_text("Stop 2 of 4").first.wait_for(timeout=60_000)
    wizard.get_by_text("Stop 1: taken").wait_for()
    wizard.get_by_text("The set-up is done").wait_for(timeout=90_000)
    assert wizard.get_by_text(re.compile(r"degrees off")).count() == 4
    minutes, seconds = READY.search(wizard.get_by_role("timer").inner_text()).groups()
    assert 60 * int(minutes) + int(seconds) < 120
    enter("Next: steer")
    enter("Point at the robot birch (simulated)")
    wizard.get_by_role("link", name="Steer now").focus()
    wizard.keyboard.press("Enter")
    aim = wizard.get_by_role("group", name="What is pointed at")
    aim.get_by_text(re.compile(r"^birch, \d+ %")).wait_for(timeout=10_000)
