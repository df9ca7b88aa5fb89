// The live line: one WebSocket and one render loop for all views of a page.
//
// A view has `draw(frame, room)` (room null where none is open) and may have `set(options)` and `close()`. The latest
// frame wins: what came before it and was not drawn is never drawn.

export const LOST_AFTER = 1000; // ms without a word after which the connection is said to be lost
const DEAD_AFTER = 4000; // ms after which it is opened anew
const PAUSES = [250, 500, 1000, 2000, 4000]; // ms before the next try

const views = new Map(); // view -> the element it is in
const counts = { frames: 0, drawn: 0, bytes: 0 }; // what benchmarks and tests read
globalThis.armspanLine = counts;

let socket = null;
let tries = 0;
let heard = performance.now();
let opened = heard;
let room = null;
let frame = null;
let fresh = false;
let waiting = 0; // frames that came and are not acknowledged yet
let asked = false;

export function join(view, element) {
  views.set(view, element);
  if (socket === null) open();
  fresh = true;
  ask();
  return () => views.delete(view);
}

// Send a text at once; false where the line is not open, or has been silent so long that it may not arrive.
export function send(text) {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(text);
  return performance.now() - heard < LOST_AFTER;
}

function open() {
  opened = performance.now();
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  const mine = new WebSocket(`${scheme}://${location.host}/live`);
  socket = mine;
  mine.binaryType = "arraybuffer";
  const reader = new TextDecoder();
  mine.onmessage = (event) => {
    if (socket === mine) take(JSON.parse(reader.decode(event.data)), event.data.byteLength);
  };
  mine.onclose = () => {
    if (socket === mine) again();
  };
}

function again() {
  waiting = 0;
  const pause = PAUSES[Math.min(tries, PAUSES.length - 1)];
  tries += 1;
  setTimeout(open, pause);
}

function take(message, bytes) {
  heard = performance.now();
  tries = 0;
  counts.bytes += bytes;
  if (!("t" in message)) {
    room = message.room;
    return;
  }
  frame = message;
  fresh = true;
  waiting += 1;
  counts.frames += 1;
  ask();
}

// A hidden tab has no display frames: it acknowledges by timer, and draws nothing.
function ask() {
  if (asked) return;
  asked = true;
  if (document.hidden) setTimeout(acknowledge, 200);
  else requestAnimationFrame(draw);
}

function draw() {
  if (fresh && frame !== null) {
    fresh = false;
    counts.drawn += 1;
    const shown = frame.room === room?.number ? room : null;
    for (const view of [...views.keys()]) view.draw(frame, shown);
  }
  acknowledge();
}

function acknowledge() {
  asked = false;
  for (; waiting > 0; waiting -= 1) send("k");
}

// Draw the latest frame again, for what changed by itself.
export function redraw() {
  fresh = true;
  ask();
}

document.addEventListener("visibilitychange", () => {
  asked = false;
  redraw();
});

setInterval(() => {
  if (socket === null) return;
  const quiet = performance.now() - heard;
  const lost = views.size > 0 && quiet > LOST_AFTER;
  for (const element of views.values()) {
    const words = element.firstElementChild;
    const text = lost
      ? `Connection to Armspan lost since ${Math.round(quiet / 1000)} s; the robots are stopped if this page had control.`
      : "";
    if (words.textContent !== text) words.textContent = text;
    words.hidden = !lost;
    element.classList.toggle("lost", lost);
  }
  if (performance.now() - Math.max(heard, opened) > DEAD_AFTER && socket.readyState < WebSocket.CLOSING) {
    socket.onclose = null; // a line that is cut somewhere on its way closes only after minutes
    socket.close();
    again();
  }
}, 250);
