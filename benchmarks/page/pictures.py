"""Pictures of the page for its documentation: a simulated room, led through its views in headless Chromium.

``armspan run`` is started in a temporary folder, time four times as fast as real. A virtual person is set up, points
at a robot, records three gestures in a hurry and trains; the game master draws a zone and begins a behaviour; a session
is shown again. What the pictures show is looked at by hand. Run: python benchmarks/page/pictures.py
"""

import argparse
import contextlib
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Generator
from pathlib import Path

from PIL import Image
from playwright.sync_api import Locator, Page, sync_playwright

FOLDER = Path(__file__).parents[2] / "docs" / "images"
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
GESTURES = ("stop", "mixing", "raise both arms")
SIZE = (1280, 800)
WIDE = (1600, 1000)
"""What is too long for a picture is shown as with a browser's zoom of 80 %."""

LONG = 120_000
"""Milliseconds for what the virtual person does at its own pace."""


@contextlib.contextmanager
def served(folder: Path, speed: float) -> Generator[str, None, None]:
    """The simulated room's page, as a process of its own; its address."""
    words = ("--port", "0", "--no-browser", "--speed", str(speed))
    process = subprocess.Popen(
        [sys.executable, "-m", "armspan", "run", *words],
        cwd=folder,
        env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=30)


def keep(page: Page, name: str) -> None:
    """The page as it is now, in few colours."""
    file = FOLDER / f"{name}.png"
    with Image.open(io.BytesIO(page.screenshot())) as picture:
        small = picture.convert("RGB").resize(SIZE, Image.Resampling.LANCZOS)
        few = small.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    few.save(file, optimize=True)
    print(f"{file.name}: {file.stat().st_size / 1000:.0f} kB", flush=True)


def zoom(page: Page, size: tuple[int, int]) -> None:
    """A window of this size, kept in a picture of `SIZE`."""
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.wait_for_timeout(500)


def top(page: Page, what: Locator, at: float = 80) -> None:
    """Scroll so that something stands right below the header, or so far below the window's edge."""
    what.evaluate("(it, at) => window.scrollTo(0, it.getBoundingClientRect().top + window.scrollY - at)", at)
    page.wait_for_timeout(500)


def button(page: Page, name: str) -> Locator:
    """The button of exactly this name."""
    return page.get_by_role("button", name=name, exact=True)


def set_up(page: Page) -> None:
    """The wizard, from the first step to its verdict."""
    button(page, "Start the time now").click()
    button(page, "Next: measures").click()
    page.get_by_label("Height [m]", exact=True).fill("1.68")
    button(page, "Find my measures").click()
    button(page, "Use these measures").click()
    button(page, "Begin").and_(page.locator(":enabled")).click()
    page.get_by_text("The set-up is done").wait_for(timeout=LONG)
    page.mouse.move(0, 0)
    page.wait_for_timeout(1000)
    keep(page, "set-up")
    button(page, "Next: steer").click()


def point(page: Page) -> None:
    """The table, while a robot is pointed at and decided."""
    button(page, "Point at the robot amber (simulated)").click()
    page.get_by_role("link", name="Steer now").click()
    page.locator(".lively-name", has_text="amber").first.wait_for()
    page.wait_for_timeout(1500)
    page.get_by_role("group", name="What is pointed at").get_by_text(re.compile(r"^amber, \d+ %")).wait_for()
    keep(page, "table")


def lead(page: Page) -> None:
    """The game master: a zone drawn by hand, and robots that cover it."""
    page.get_by_role("link", name="Game master").click()
    sheet = page.get_by_label(re.compile("draw a new zone here"))
    sheet.scroll_into_view_if_needed()
    page.wait_for_timeout(1500)
    box = sheet.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for dx, dy in ((-80, 70), (40, 55), (105, 100), (70, 150), (-60, 140)):
        page.mouse.click(x + dx, y + dy)
        page.wait_for_timeout(600)
    sheet.press("Enter")
    name = page.get_by_role("dialog").get_by_label("Name of the zone")
    name.fill("meadow")
    name.press("Enter")
    button(page, "Cover meadow in lanes").click()
    top(page, page.get_by_role("heading", name="Zones", exact=True), at=230)
    page.wait_for_timeout(700)
    keep(page, "master")


def learn(page: Page) -> None:
    """Takes of three gestures in a hurry, a model of them, and what it sees."""
    page.get_by_role("link", name="Gestures").click()
    page.get_by_label("Takes of each").fill("3")
    page.get_by_label("Everyday motion, seconds").fill("30")
    for label in GESTURES:
        page.get_by_role("checkbox", name=label, exact=True).click()
    button(page, "Start recording").click()
    page.get_by_role("button", name=re.compile("^everyday motion: ")).wait_for(timeout=LONG)
    button(page, "Train on all takes").click()
    button(page, "Use this model").click(timeout=LONG)
    button(page, "Begin the set-up").click(timeout=LONG)
    button(page, "mixing").wait_for(timeout=LONG)
    zoom(page, WIDE)
    top(page, page.get_by_role("heading", name="Takes", exact=True))
    button(page, "mixing").dispatch_event("click")
    page.get_by_text("Recognised last: mixing").wait_for(timeout=LONG)
    keep(page, "gestures")


def show_again(page: Page) -> None:
    """A session of before, some seconds of it."""
    zoom(page, SIZE)
    page.get_by_role("link", name="Log").click()
    page.get_by_role("button", name=re.compile("^Show again: ")).last.click()
    button(page, "End it and show the session").click()
    button(page, "Pause").click(timeout=LONG)
    page.get_by_text(re.compile(r"^\d+:\d\d min of \d+:\d\d min$")).wait_for(timeout=LONG)
    place = page.locator(".player .q-slider").bounding_box()
    assert place is not None
    page.mouse.click(place["x"] + 0.75 * place["width"], place["y"] + place["height"] / 2)
    button(page, "Play").click()
    page.wait_for_timeout(7000)
    button(page, "Pause").click()
    page.wait_for_timeout(500)
    keep(page, "log")


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, served(Path(folder), 4) as address, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        page.set_default_timeout(20_000)
        page.goto(address + "set-up")
        for show in (set_up, point, lead, learn, show_again):
            show(page)
        browser.close()


if __name__ == "__main__":
    main()
