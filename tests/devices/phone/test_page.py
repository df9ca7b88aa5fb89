"""The page: one file that needs nobody else, and whose script says what the decoder understands."""

import json
import math
import re
import shutil
import subprocess
from importlib.resources import files

import pytest

from armspan.devices.phone.band import Band
from armspan.devices.phone.browser import Browser
from armspan.records import ImuSample, Press, Tap

PAGE = files("armspan.devices.phone").joinpath("page.html").read_text(encoding="utf-8")
SCRIPT = re.search(r"<script>(.*?)</script>", PAGE, re.DOTALL).group(1)

# A browser just large enough: elements that hold a text, a line that always opens, sensors that are told what to say.
BROWSER = r"""
const texts = [], listeners = {}, elements = {};
const element = () => ({ textContent: "", className: "", hidden: false, handlers: {},
  classList: { add() {}, remove() {} },
  addEventListener(kind, f) { this.handlers[kind] = f; } });
const define = (name, value) => Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
define("document", { visibilityState: "visible", title: "", addEventListener() {},
  getElementById: id => elements[id] || (elements[id] = element()) });
define("location", { protocol: "https:", host: "lab:8443", search: "?token=t&band=wrist" });
define("navigator", { userAgent: USER_AGENT, wakeLock: { request: async () => { awake++; return element(); } } });
let awake = 0, asked = 0, posted = [];
define("window", globalThis);
define("isSecureContext", true);
define("addEventListener", (kind, f) => { (listeners[kind] = listeners[kind] || new Set()).add(f); });
define("removeEventListener", (kind, f) => { if (listeners[kind]) listeners[kind].delete(f); });
define("fetch", async (url, how) => { posted.push([how.method, url]); return { ok: true }; });
class Line {
  static OPEN = 1;
  static all = [];
  constructor(url) { this.url = url; this.readyState = 0; this.bufferedAmount = 0; Line.all.push(this); }
  open() { this.readyState = 1; this.onopen(); }
  close() { this.readyState = 3; this.onclose({ code: 1006 }); }
  send(text) { texts.push(text); }
}
define("WebSocket", Line);
const permission = { async requestPermission() { asked++; return "granted"; } };
define("DeviceMotionEvent", APPLE ? permission : class {});
define("DeviceOrientationEvent", APPLE ? permission : class {});
const fire = (kind, event) => { for (const f of listeners[kind] || []) f(event); };
const sleep = ms => new Promise(done => setTimeout(done, ms));
"""

SCENE = r"""
(async () => {
  Line.all[0].open();
  elements.begin.handlers.click();
  await sleep(5);
  const move = (timeStamp, x, y, z, alpha, beta, gamma) => fire("devicemotion",
    { timeStamp, accelerationIncludingGravity: { x, y, z }, rotationRate: { alpha, beta, gamma } });
  move(900, null, null, null, null, null, null);
  move(984, 0, 0, 9.8, 0, 0, 0);
  for (let k = 0; k < 30; k++) {
    fire("deviceorientation", { timeStamp: 990 + 16 * k, alpha: 30, beta: 20, gamma: 10 });
    move(1000 + 16 * k, SIGN * -1.6, SIGN * 3.4, SIGN * 9.1, 1, -2, 3);
  }
  const press = { preventDefault() {} };
  elements.tap.handlers.pointerdown(press);
  elements.tap.handlers.pointerdown(press);
  await sleep(400);
  elements.stop.handlers.pointerdown(press);
  Line.all[0].onmessage({ data: '{"stopped":true}' });
  const heard = elements.stopped.textContent;
  Line.all[0].close();
  move(2000, 0, 0, 9.8, 0, 0, 0);
  elements.stop.handlers.pointerdown(press);
  await sleep(5);
  const alone = elements.stopped.textContent;
  await sleep(300);
  Line.all[1].open();
  console.log(JSON.stringify({ sent: texts, asked, awake, posted, heard, alone, lines: Line.all.map(line => line.url),
                               state: elements.line.textContent, trouble: elements.trouble.textContent,
                               begin: elements.begin.hidden, tap: elements.tap.hidden }));
  process.exit(0);
})();
"""


def test_the_page_needs_nobody_else():
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:)""", PAGE)
    assert not re.findall(r"https?://\w", PAGE)
    assert "import" not in SCRIPT
    assert "@import" not in PAGE
    assert len(PAGE) < 40_000


def test_the_script_knows_its_elements():
    ids = set(re.findall(r'id="(\w+)"', PAGE))
    assert set(re.findall(r'\$\("(\w+)"\)', SCRIPT)) <= ids


def test_it_says_how_to_wear_the_phone_and_what_the_warning_means():
    words = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", PAGE))
    for part in (
        "back of your forearm",
        "top edge of the phone toward your hand",
        "screen away",
        "certificate",
        "STOP",
    ):
        assert part in words


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed: the page's script cannot be run")
@pytest.mark.parametrize("apple", [True, False])
def test_the_script_says_what_the_decoder_understands(apple):
    agent = "Mozilla/5.0 (iPhone; CPU iPhone OS 18_0)" if apple else "Mozilla/5.0 (Linux; Android 15)"
    before = BROWSER.replace("USER_AGENT", json.dumps(agent)).replace("APPLE", json.dumps(apple))
    program = before + SCRIPT + SCENE.replace("SIGN", "-1" if apple else "1")
    done = subprocess.run(["node", "-"], input=program, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["lines"] == ["wss://lab:8443/line?token=t&band=wrist"] * 2
    assert told["asked"] == (2 if apple else 0)
    assert (told["awake"], told["begin"], told["tap"]) == (1, True, False)
    assert told["heard"] == "stopped: the computer heard it"
    assert told["posted"] == [["POST", "/stop?token=t&band=wrist"]]
    assert (told["state"], told["trouble"]) == ("connected", "")
    check_decoded(told["sent"], apple)


@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed: the page's script cannot be run")
def test_where_no_line_opens_the_script_posts():
    before = BROWSER.replace("USER_AGENT", '"iPhone"').replace("APPLE", "true")
    program = before + SCRIPT + POSTING
    done = subprocess.run(["node", "-"], input=program, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["lines"] == 2
    assert {(how, url) for how, url, _ in told["posts"]} == {("POST", "/say?token=t&band=wrist")}
    bodies = [body.splitlines() for _, _, body in told["posts"]]
    assert all("hello" in body[0] for body in bodies)
    check_decoded([bodies[0][0], bodies[0][0], *(text for body in bodies for text in body[1:])], True, taps=[1])
    assert (told["state"], told["after"], told["taken"]) == ("connected", "connecting again", "not connected")


POSTING = r"""
(async () => {
  const posts = [];
  let answer = () => ({ band: "wrist", rate: 60, lost: 0, stopped: posts.at(-1)[2].includes("stop") });
  define("fetch", async (url, how) => {
    await sleep(3);
    posts.push([how.method, url, how.body]);
    const told = answer();
    if (!told) throw new Error("refused");
    return { ok: true, json: async () => told };
  });
  for (let k = 0; k < 2; k++) { Line.all[k].readyState = 3; Line.all[k].onclose({ code: 1006 }); await sleep(600); }
  elements.begin.handlers.click();
  await sleep(5);
  for (let k = 0; k < 30; k++) {
    fire("deviceorientation", { timeStamp: 990 + 16 * k, alpha: 30, beta: 20, gamma: 10 });
    fire("devicemotion", { timeStamp: 1000 + 16 * k, accelerationIncludingGravity: { x: 1.6, y: -3.4, z: -9.1 },
                           rotationRate: { alpha: 1, beta: -2, gamma: 3 } });
    await sleep(5);
  }
  const press = { preventDefault() {} };
  elements.tap.handlers.pointerdown(press);
  await sleep(400);
  elements.stop.handlers.pointerdown(press);
  await sleep(60);
  const state = elements.line.textContent, lines = Line.all.length, said = posts.slice();
  answer = () => null;
  await sleep(100);
  const after = elements.line.textContent;
  answer = () => ({ taken: true });
  await sleep(800);
  console.log(JSON.stringify({ lines, posts: said, state, after, taken: elements.line.textContent }));
  process.exit(0);
})();
"""


def check_decoded(sent, apple, taps=(2,)):
    device, events = Browser(Band("wrist")), []
    for k, text in enumerate(sent):
        events += device.feed(text.encode(), 5.0 + 0.016 * k)
    assert device.band.counters.malformed == 0
    hellos = [json.loads(text)["hello"] for text in sent if "hello" in text]
    assert [hello["apple"] for hello in hellos] == [apple] * 2
    assert hellos[0]["page"] == hellos[1]["page"]
    told = [event for event in events if isinstance(event, ImuSample)]
    assert len(told) == 30  # what came before the first attitude waits, what came without a line is lost
    assert told[-1].acc == pytest.approx((-1.6, 3.4, 9.1))
    assert told[-1].gyr == pytest.approx([math.radians(value) for value in (1, -2, 3)])
    assert told[-1].quat == pytest.approx((0.9437, 0.1449, 0.1277, 0.2685), abs=0.003)  # 30, 20 and 10 degrees
    assert [event.count for event in events if isinstance(event, Tap)] == list(taps)
    assert len([event for event in events if isinstance(event, Press)]) == 1  # the second went by its own way
