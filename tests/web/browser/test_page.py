"""The page as a whole: nothing from elsewhere, one steers and all may stop, a token for those who come from afar."""

import re

import pytest

from served_page import Served


def test_nothing_is_asked_of_anybody_else(chromium, served):
    context = chromium.new_context()
    asked = []
    context.on("request", lambda request: asked.append(request.url))
    context.route(re.compile(rf"^(?!{re.escape(served.address)}).*"), lambda route: route.abort())
    page = context.new_page()
    for path in ("", "set-up", "gestures", "master", "log"):
        page.goto(served.address + path)
        page.get_by_role("button", name="Stop all robots").wait_for()
    strange = [url for url in asked if not url.startswith((served.address, "data:", "blob:"))]
    context.close()
    assert strange == []
    assert len(asked) > 10


def test_one_steers_and_another_takes_over_by_a_click(chromium, served):
    first, second = (chromium.new_context().new_page() for _ in range(2))
    first.goto(served.address)
    first.get_by_text("You have control").wait_for()
    second.goto(served.address)
    second.get_by_text(re.compile(r"Computer \d+ has control")).wait_for()
    second.get_by_role("button", name="Take control").click()
    second.get_by_text("You have control").wait_for()
    first.get_by_text(re.compile(r"Computer \d+ has control")).wait_for()
    first.context.close()
    second.context.close()


@pytest.fixture(scope="module")
def afar(tmp_path_factory):
    """A page for others too."""
    page = Served(tmp_path_factory.mktemp("afar"), "--host", "0.0.0.0")
    yield page
    page.close()


def test_from_afar_the_token_is_asked_for_and_a_wrong_one_said_in_place(chromium, afar):
    address, token = afar.address.split("?token=")
    assert "0.0.0.0" not in address
    page = chromium.new_context().new_page()
    page.goto(address)
    page.get_by_label("Token").fill("guessed")
    page.get_by_role("button", name="Enter").click()
    page.get_by_text("That token is wrong").wait_for()
    page.get_by_label("Token").fill(token)
    page.get_by_role("button", name="Enter").click()
    page.get_by_role("button", name="Stop all robots").wait_for()
    page.get_by_text("You have control").wait_for()
    assert "token" not in page.url
    page.context.close()
