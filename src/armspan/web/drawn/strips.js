// The signals of each band, the last seconds of them: acceleration above, turn rate below.
import { INK, QUIET, fitted } from "./common.js";

const SPAN = 6; // s
const GAP = 0.12; // s without a sample that is drawn as a gap
const AXES = [
  { name: "x", colour: "#1f5fa8", dash: [], words: "x solid" },
  { name: "y", colour: "#b0450a", dash: [7, 4], words: "y dashed" },
  { name: "z", colour: "#2e7d32", dash: [2, 3], words: "z dotted" },
];
const CHARTS = [
  { words: "acceleration", unit: "m/s²", first: 1, scale: 1, least: 15 },
  { words: "turn rate", unit: "deg/s", first: 4, scale: 180 / Math.PI, least: 150 },
];
const LEFT = 58;
const TOP = 26;
const HEAD = 24; // the legend's line
const FOOT = 20; // the times' line

export class Strips {
  constructor(box, { label, options }) {
    this.fit = fitted(box, label, () => this.redraw?.());
    this.context = this.fit.canvas.getContext("2d");
    this.options = options;
    this.kept = new Map(); // band -> rows [t, acc, gyr]
    this.redraw = () => this.last && this.draw(...this.last);
  }

  set(options) {
    this.options = options;
    this.redraw();
  }

  close() {
    this.fit.close();
  }

  draw(frame, room) {
    this.last = [frame, room];
    const strips = frame.strips ?? {};
    for (const [band, rows] of Object.entries(strips)) this.keep(band, rows, frame.t);
    const known = room ? room.bands.map((band) => band.name) : [];
    const bands = (this.options.bands ?? known).filter((band) => known.includes(band));
    const { width, height, ratio } = this.fit;
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.clearRect(0, 0, width, height);
    this.context.font = "17px sans-serif";
    if (bands.length === 0) {
      this.text("No band is worn in this room", 8, 24, INK);
      return;
    }
    const each = (height - HEAD - FOOT) / (bands.length * CHARTS.length);
    this.legend(width);
    this.times(width, height);
    bands.forEach((band, k) => {
      const of = room.bands.find((one) => one.name === band);
      CHARTS.forEach((chart, m) => this.chart(chart, of, frame.t, HEAD + (k * CHARTS.length + m) * each, each));
    });
  }

  keep(band, rows, now) {
    const kept = this.kept.get(band) ?? [];
    if (kept.length && now < kept[kept.length - 1][0]) kept.length = 0; // a log is shown from an earlier place
    const last = kept.length ? kept[kept.length - 1][0] : -Infinity;
    for (const row of rows) if (row[0] > last) kept.push(row);
    while (kept.length && kept[0][0] < now - SPAN - 1) kept.shift();
    this.kept.set(band, kept);
  }

  chart({ words, unit, first, scale, least }, band, now, top, height) {
    const rows = this.kept.get(band.name) ?? [];
    const { width } = this.fit;
    const low = top + TOP;
    const high = top + height - 6;
    let most = least;
    for (const row of rows) for (let k = first; k < first + 3; k += 1) most = Math.max(most, Math.abs(row[k]) * scale);
    if (most > least) most = least * 2 ** Math.ceil(Math.log2(most / least));
    const x = (t) => LEFT + ((t - now + SPAN) / SPAN) * (width - LEFT - 8);
    const y = (value) => (low + high) / 2 - ((value * scale) / most) * ((high - low) / 2);
    this.frameOf(x, now, low, high, most);
    const where = `${band.arm} ${band.segment === "forearm" ? "wrist" : "upper arm"}`;
    const name = where === band.name ? where : `${band.name} (${where})`;
    const silent = rows.length === 0 || now - rows[rows.length - 1][0] > 1;
    const told = `${name}, ${words} in ${unit}${silent ? ": nothing heard" : ""}`;
    this.text(told, 4, top + 18, silent ? "#8b0000" : INK);
    AXES.forEach((axis, k) => this.curve(rows, axis, (row) => [x(row[0]), y(row[first + k])], now));
  }

  frameOf(x, now, low, high, most) {
    const draw = this.context;
    draw.strokeStyle = "#d5dbe3";
    draw.lineWidth = 1;
    draw.setLineDash([]);
    draw.beginPath();
    for (const level of [low, (low + high) / 2, high]) {
      draw.moveTo(x(now - SPAN), level);
      draw.lineTo(x(now), level);
    }
    for (let s = 0; s <= SPAN; s += 1) {
      draw.moveTo(x(now - s), low);
      draw.lineTo(x(now - s), high);
    }
    draw.stroke();
    draw.textAlign = "right";
    this.text(`${most}`, LEFT - 4, low + 12, QUIET);
    this.text("0", LEFT - 4, (low + high) / 2 + 6, QUIET);
    this.text(`−${most}`, LEFT - 4, high, QUIET);
    draw.textAlign = "left";
  }

  times(width, height) {
    this.text(`${SPAN} s ago`, LEFT, height - 4, QUIET);
    this.context.textAlign = "right";
    this.text("now", width - 8, height - 4, QUIET);
    this.context.textAlign = "left";
  }

  curve(rows, axis, at, now) {
    const draw = this.context;
    draw.strokeStyle = axis.colour;
    draw.lineWidth = 1.8;
    draw.setLineDash(axis.dash);
    draw.beginPath();
    let before = -Infinity;
    for (const row of rows) {
      if (row[0] < now - SPAN) continue;
      const [x, y] = at(row);
      if (row[0] - before > GAP) draw.moveTo(x, y);
      else draw.lineTo(x, y);
      before = row[0];
    }
    draw.stroke();
  }

  legend(width) {
    const draw = this.context;
    let right = width - 8;
    for (const axis of [...AXES].reverse()) {
      right -= draw.measureText(axis.words).width;
      this.text(axis.words, right, 18, axis.colour);
      draw.strokeStyle = axis.colour;
      draw.lineWidth = 2.5;
      draw.setLineDash(axis.dash);
      draw.beginPath();
      draw.moveTo(right - 32, 13);
      draw.lineTo(right - 5, 13);
      draw.stroke();
      right -= 48;
    }
  }

  text(words, x, y, colour) {
    this.context.fillStyle = colour;
    this.context.fillText(words, x, y);
  }
}
