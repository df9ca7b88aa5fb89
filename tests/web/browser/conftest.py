"""A real page in a real browser: ``armspan run`` in a process of its own, headless Chromium before it."""

import shutil

import pytest

from served_page import Served

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
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


@pytest.fixture(scope="module")
def served(tmp_path_factory, request):
    """The simulated room's page; a module's ``SPEED`` lets time go faster."""
    page = Served(tmp_path_factory.mktemp("served"), "--speed", getattr(request.module, "SPEED", "1"))
    yield page
    page.close()


@pytest.fixture(scope="module")
def chromium():
    """A headless Chromium (skips where there is none)."""
    playwright = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pip install playwright"
    )
    if CHROMIUM is None:
        pytest.skip("no Chromium: apt install chromium")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture
def tab(chromium, served):
    """A tab on the page; what the page's scripts complain of fails the test."""
    page = chromium.new_page(viewport={"width": 1280, "height": 800})
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(served.address)
    yield page
    page.close()
    assert wrong == []
