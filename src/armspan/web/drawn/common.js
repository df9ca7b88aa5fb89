// What several views share: words, colours, and the numbers of a frame.

export const INK = "#1d2733";
export const QUIET = "#5b6876";
export const RAY = "#b0450a";
export const SPOT = "#b0450a";
export const ZONE = "#1f5fa8";
export const WRONG = "#8b0000";
export const LEDS = 6;

const HELD = 1;
const WAITING = 2;
const LOST = 4;
const UNHEARD = 8;

// One robot of a frame, with its state in words ("" where all is well).
export function robotOf(frame, room, index) {
  const row = frame.robots[index];
  const name = room.robots[index];
  return {
    name,
    x: row[0],
    y: row[1],
    heading: row[2],
    words: stateWords(row[3], frame.waiting?.[name]),
    heard: !(row[3] & UNHEARD),
    lifted: Boolean(row[3] & HELD),
    lights: row.slice(5),
  };
}

// The robots that cannot be drawn, in words; "" where there are none.
export function unheard(frame, room) {
  const names = room.robots.filter((_, index) => frame.robots[index][3] & UNHEARD);
  return names.length ? `Not heard: ${names.join(", ")}` : "";
}

function stateWords(state, why) {
  const words = [];
  if (state & LOST) words.push("out of reach");
  if (state & HELD) words.push("lifted");
  if (state & WAITING) words.push(why || "waits");
  return words.join(", ");
}

export function lightColour(light) {
  return `#${light.toString(16).padStart(6, "0")}`;
}

// The stops of the set-up: place, number, residual in words, and where the person is led to now.
export function stopsOf(frame, room, always) {
  const setup = frame.setup;
  if (!setup) return [];
  const going = setup.step !== "idle";
  if (!going && !always) return [];
  const seen = new Map(setup.seen.map(([number, residual, used]) => [number, { residual, used }]));
  return room.stops.map(([x, y], index) => {
    const number = index + 1;
    const one = seen.get(number);
    const residual = one ? `: ${degrees(one.residual)}°${one.used ? "" : " left out"}` : "";
    return { x, y, text: `${number}${residual}`, now: going && setup.step === "point" && setup.stop === number };
  });
}

export function degrees(radians) {
  return ((radians * 180) / Math.PI).toFixed(1);
}

export function percent(share) {
  return `${Math.round(share * 100)} %`;
}

export function middle(polygon) {
  const sum = polygon.reduce(([x, y], [a, b]) => [x + a, y + b], [0, 0]);
  return [sum[0] / polygon.length, sum[1] / polygon.length];
}

function inside([x, y], polygon) {
  let odd = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i, i += 1) {
    const [ax, ay] = polygon[i];
    const [bx, by] = polygon[j];
    if (ay > y !== by > y && x < ((bx - ax) * (y - ay)) / (by - ay) + ax) odd = !odd;
  }
  return odd;
}

// The robot (a little beside it counts, for fingers) or the zone at a place, null where there is none.
export function robotAt(place, frame, room) {
  const far = room.robots.map((_, index) => {
    const robot = robotOf(frame, room, index);
    return robot.heard ? Math.hypot(robot.x - place[0], robot.y - place[1]) : Infinity;
  });
  const nearest = Math.min(...far);
  return nearest < Math.max(1.3 * room.radius, 0.025) ? room.robots[far.indexOf(nearest)] : null;
}

export function zoneAt(place, room) {
  return room.zones.find((zone) => inside(place, zone.polygon))?.name ?? null;
}

// Do two of a closed polygon's edges cross, or lie on each other? Neighbours share a corner and are left out.
export function crosses(polygon) {
  const count = polygon.length;
  for (let i = 0; i < count; i += 1) {
    for (let j = i + 2; j < count; j += 1) {
      if (i === 0 && j === count - 1) continue;
      if (meet(polygon[i], polygon[i + 1], polygon[j], polygon[(j + 1) % count])) return true;
    }
  }
  return false;
}

function meet(a, b, c, d) {
  const side = (p, q, r) => (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
  return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
}

// A canvas that fills its box at the display's own resolution; `changed` is called when its size changes.
export function fitted(box, label, changed) {
  const canvas = document.createElement("canvas");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", label);
  box.append(canvas);
  const fit = { canvas, width: 0, height: 0, ratio: 1 };
  const measure = () => {
    fit.ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    fit.width = box.clientWidth;
    fit.height = box.clientHeight;
    canvas.width = Math.round(fit.width * fit.ratio);
    canvas.height = Math.round(fit.height * fit.ratio);
    changed();
  };
  const watcher = new ResizeObserver(measure);
  watcher.observe(box);
  fit.close = () => watcher.disconnect();
  return fit;
}
