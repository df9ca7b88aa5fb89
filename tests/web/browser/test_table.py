"""The table's view: what is drawn, what is said, and the keys that stop the robots."""

import signal
import time

import pytest

KEYS = ".lively-keys .lively-body"


@pytest.fixture
def table(tab):
    """The table's view, once it draws."""
    tab.wait_for_function("globalThis.armspanLine?.drawn > 3")
    tab.locator(".lively-labels").wait_for(state="attached")
    return tab


def test_the_scene_and_the_plan_are_drawn_and_told_in_words(table):
    table.get_by_text("Pointing works after the set-up").wait_for()
    labels = table.locator(".lively-name")
    for words in ("amber", "tower", "Sheet 90 × 60 cm", "place not known yet"):
        labels.filter(has_text=words).wait_for()
    assert table.get_by_role("img", name="three dimensions").count() == 1
    plan = table.get_by_role("img", name="The sheet from above")
    colours = plan.evaluate(
        """canvas => new Set(new Uint32Array(canvas.getContext("2d")
             .getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size"""
    )
    assert colours > 20
    where = labels.filter(has_text="amber").bounding_box()
    table.get_by_role("img", name="three dimensions").press("ArrowLeft")
    table.wait_for_timeout(300)
    assert labels.filter(has_text="amber").bounding_box() != where


def test_the_stops_of_the_set_up_are_shown_on_demand(table):
    stops = table.locator(".lively-name.stop")
    assert stops.first.is_hidden()
    table.get_by_role("switch", name="Show the set-up's stops").press("Enter")
    for number in range(1, 5):
        stops.get_by_text(str(number), exact=True).wait_for()


def test_escape_and_the_space_bar_stop_the_robots_and_press_no_button(table):
    for key, focused in (("Escape", "body"), (" ", "body"), (" ", ".top .stop")):
        table.evaluate("() => { clicked = 0; document.querySelector('.top .stop').onclick = () => { clicked += 1; }; }")
        table.locator(focused).focus()
        table.keyboard.press(key)
        table.get_by_role("alert").filter(has_text="All robots stopped").wait_for()
        table.evaluate(f"document.querySelector('{KEYS}').textContent = ''")
        assert (key, focused, table.evaluate("clicked")) == (key, focused, 0)


def test_a_space_in_a_text_stops_nothing_and_escape_does(table):
    table.evaluate("document.body.append(Object.assign(document.createElement('input'), {id: 'text'}))")
    table.locator("#text").press_sequentially("a b")
    assert table.locator("#text").input_value() == "a b"
    assert table.locator(KEYS).text_content() == ""
    table.locator("#text").press("Escape")
    table.get_by_role("alert").filter(has_text="All robots stopped").wait_for()


def test_a_lost_connection_is_said_in_every_view_and_goes_on_when_it_is_back(table, served):
    served.process.send_signal(signal.SIGSTOP)
    try:
        lost = table.locator(".view .lively-lost", has_text="Connection to Armspan lost since")
        lost.nth(2).wait_for()
        assert "the robots are stopped if this page had control" in lost.nth(0).text_content()
    finally:
        served.process.send_signal(signal.SIGCONT)
    lost.nth(0).wait_for(state="detached")
    before = table.evaluate("armspanLine.drawn")
    time.sleep(0.5)
    assert table.evaluate("armspanLine.drawn") > before


def test_robots_states_are_words_and_places_are_found(table):
    found = table.evaluate(
        """async () => {
          const { robotOf, unheard, robotAt, zoneAt, stopsOf } = await import("armspan-drawn/common.js");
          const room = { robots: ["ash", "elm", "fir"], radius: 0.02, stops: [[0.1, 0.2], [0.3, 0.2]],
            zones: [{ name: "mill", polygon: [[0.2, 0.2], [0.4, 0.2], [0.3, 0.4]] }] };
          const lights = [0, 0, 0, 0, 0, 0];
          const frame = { robots: [[0.1, 0.1, 0, 7, 1, ...lights], [0.3, 0.3, 0, 0, 1, ...lights],
            [0, 0, 0, 8, -1, ...lights]], waiting: { ash: "elm is too close" },
            setup: { step: "point", stop: 2, seen: [[1, 0.02, false]] } };
          return { words: room.robots.map((_, k) => robotOf(frame, room, k).words), unheard: unheard(frame, room),
            robots: [[0.11, 0.1], [0.2, 0.1], [0, 0]].map((place) => robotAt(place, frame, room)),
            zones: [[0.3, 0.25], [0.2, 0.35]].map((place) => zoneAt(place, room)),
            stops: stopsOf(frame, room, false).map(({ text, now }) => [text, now]) };
        }"""
    )
    assert found["words"] == ["out of reach, lifted, elm is too close", "", ""]
    assert found["unheard"] == "Not heard: fir"
    assert found["robots"] == ["ash", None, None]
    assert found["zones"] == ["mill", None]
    assert found["stops"] == [["1: 1.1° left out", False], ["2", True]]


def test_a_zone_is_drawn_by_corners_or_by_dragging_and_never_over_itself(table):
    told, crossed = table.evaluate(
        """async () => {
          const { Pencil } = await import("armspan-drawn/pencil.js");
          const { crosses } = await import("armspan-drawn/common.js");
          const told = [];
          const pencil = new Pencil((polygon) => told.push(polygon), () => {});
          const click = (place) => { pencil.down(place); pencil.up(place, 0.01); };
          pencil.down([0.1, 0.1]); pencil.move([0.3, 0.2], 0.01); pencil.up([0.3, 0.2], 0.01);
          [[0.1, 0.1], [0.3, 0.3], [0.3, 0.1], [0.1, 0.3]].forEach(click);
          const crossed = crosses(pencil.corners);
          pencil.close();
          pencil.back();
          click([0.3, 0.1]);
          pencil.close();
          return [told, crossed];
        }"""
    )
    rectangle = [[0.1, 0.1], [0.3, 0.1], [0.3, 0.2], [0.1, 0.2]]
    assert crossed
    assert told == [rectangle, [[0.1, 0.1], [0.3, 0.3], [0.3, 0.1]]]
