// The sheet from above, x to the right and y down, as the user sees it from its lower edge. Places are picked on it and zones are drawn on it.
import { INK, LEDS, QUIET, RAY, SPOT, WRONG, ZONE, fitted, lightColour, middle } from "./common.js";
import { robotAt, robotOf, stopsOf, unheard, zoneAt } from "./common.js";
import { redraw } from "./line.js";
import { Pencil } from "./pencil.js";

const MARGIN = 34; // px around the sheet
const STEP = 0.01; // m that an arrow key moves the mark

export class Plan {
  constructor(box, { label, options, tell }) {
    this.label = label;
    this.fit = fitted(box, label, redraw);
    this.canvas = this.fit.canvas;
    this.context = this.canvas.getContext("2d");
    this.canvas.tabIndex = 0;
    this.tell = tell;
    this.mark = null; // where the keyboard points
    this.pencil = new Pencil((polygon) => tell("drawn", { polygon }), redraw);
    this.canvas.addEventListener("pointerdown", (event) => this.down(event));
    this.canvas.addEventListener("pointermove", (event) => this.move(event));
    this.canvas.addEventListener("pointerup", (event) => this.up(event));
    this.canvas.addEventListener("dblclick", () => this.options.draw && this.pencil.close());
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.canvas.addEventListener("blur", () => this.unmark());
    this.set(options);
  }

  set(options) {
    if (!options.draw) this.pencil.clear();
    this.options = options;
    const how = options.draw
      ? "click the corners or drag a rectangle; Enter closes, Backspace takes back; arrow keys and C set corners"
      : "click, or arrow keys and Enter, to choose a place";
    this.canvas.setAttribute("aria-label", `${this.label}: ${how}`);
    this.canvas.classList.toggle("drawing", Boolean(options.draw));
    redraw();
  }

  close() {
    this.fit.close();
  }

  // --- mouse, touch and keys ------------------------------------------------------------------------

  placeOf(event) {
    const edge = this.canvas.getBoundingClientRect();
    const [width, height] = this.sheet;
    const x = (event.clientX - edge.left - this.left) / this.scale;
    const y = (event.clientY - edge.top - this.top) / this.scale;
    return [Math.min(Math.max(x, 0), width), Math.min(Math.max(y, 0), height)];
  }

  down(event) {
    if (!this.room || event.button !== 0) return;
    this.unmark();
    if (!this.options.draw) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.pencil.down(this.placeOf(event));
  }

  move(event) {
    if (this.room && this.options.draw) this.pencil.move(this.placeOf(event), 8 / this.scale);
  }

  up(event) {
    if (!this.room || event.button !== 0) return;
    if (this.options.draw) this.pencil.up(this.placeOf(event), 8 / this.scale);
    else this.pick(this.placeOf(event));
  }

  key(event) {
    if (!this.room) return;
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const move = moves[event.key];
    if (move) this.step(move, event.shiftKey ? 5 * STEP : STEP);
    else if (event.key === "Enter" && this.options.draw) this.pencil.close();
    else if (event.key === "Enter" && this.mark) this.pick(this.mark);
    else if (event.key === "Backspace" && this.options.draw) this.pencil.back();
    else if (event.key.toLowerCase() === "c" && this.options.draw && this.mark) this.pencil.corner(this.mark, 0);
    else return;
    event.preventDefault();
  }

  step([dx, dy], by) {
    const [width, height] = this.sheet;
    const [x, y] = this.mark ?? [width / 2, height / 2];
    this.mark = [Math.min(Math.max(x + dx * by, 0), width), Math.min(Math.max(y + dy * by, 0), height)];
    if (this.options.draw) this.pencil.move(this.mark, 0);
    redraw();
  }

  unmark() {
    this.mark = null;
    redraw();
  }

  pick(place) {
    const robot = robotAt(place, this.frame, this.room);
    this.tell("picked", { x: place[0], y: place[1], robot, zone: zoneAt(place, this.room) });
  }

  // --- drawing --------------------------------------------------------------------------------------

  draw(frame, room) {
    [this.frame, this.room] = [frame, room];
    const { width, height, ratio } = this.fit;
    const draw = this.context;
    draw.setTransform(ratio, 0, 0, ratio, 0, 0);
    draw.clearRect(0, 0, width, height);
    draw.font = "600 17px sans-serif";
    draw.textAlign = "center";
    if (room === null) {
      this.text("No room is open", width / 2, height / 2, INK);
      return;
    }
    this.sheet = room.sheet;
    const [across, down] = room.sheet;
    this.scale = Math.max(Math.min((width - 2 * MARGIN) / across, (height - 2 * MARGIN) / down), 1);
    this.left = (width - across * this.scale) / 2;
    this.top = (height - down * this.scale) / 2;
    this.paper(across, down);
    for (const zone of room.zones) this.zone(zone, frame.at);
    for (const stop of stopsOf(frame, room, this.options.stops)) this.stop(stop, 1.35 * room.radius * this.scale);
    if (frame.ray) this.ray(frame.ray);
    if (frame.eye) this.person(frame);
    room.robots.forEach((_, index) => this.robot(robotOf(frame, room, index), room, frame.at));
    this.text(unheard(frame, room), width / 2, height - 8, WRONG);
    if (frame.at?.xy) this.spot(frame.at);
    if (this.options.draw) this.pencil.draw(draw, (place) => this.on(place));
    if (this.mark) this.cross(this.mark);
  }

  on([x, y]) {
    return [this.left + x * this.scale, this.top + y * this.scale];
  }

  text(words, x, y, colour) {
    const draw = this.context;
    draw.setLineDash([]);
    draw.lineJoin = "round";
    draw.lineWidth = 4;
    draw.strokeStyle = "white";
    draw.strokeText(words, x, y);
    draw.fillStyle = colour;
    draw.fillText(words, x, y);
  }

  stroke(colour, width, dash = []) {
    const draw = this.context;
    draw.strokeStyle = colour;
    draw.lineWidth = width;
    draw.setLineDash(dash);
    draw.stroke();
  }

  paper(across, down) {
    const draw = this.context;
    const { left, top, scale } = this;
    draw.fillStyle = "white";
    draw.fillRect(left, top, across * scale, down * scale);
    draw.beginPath();
    for (let x = 0.1; x < across - 0.001; x += 0.1) {
      draw.moveTo(left + x * scale, top);
      draw.lineTo(left + x * scale, top + down * scale);
    }
    for (let y = 0.1; y < down - 0.001; y += 0.1) {
      draw.moveTo(left, top + y * scale);
      draw.lineTo(left + across * scale, top + y * scale);
    }
    this.stroke("#edf0f4", 1);
    draw.beginPath();
    draw.rect(left, top, across * scale, down * scale);
    this.stroke("#8793a1", 1.5);
    const size = `${Math.round(across * 100)} × ${Math.round(down * 100)} cm`;
    draw.textAlign = "left";
    this.text(`Sheet ${size}, lines every 10 cm`, left, top - 11, QUIET);
    draw.textAlign = "center";
  }

  zone({ name, polygon }, at) {
    const draw = this.context;
    const pointed = at?.zone === name;
    draw.beginPath();
    for (const corner of polygon) draw.lineTo(...this.on(corner));
    draw.closePath();
    draw.fillStyle = pointed ? "rgba(31, 95, 168, 0.28)" : "rgba(31, 95, 168, 0.10)";
    draw.fill();
    this.stroke(ZONE, pointed ? 4 : 2);
    const [x, y] = this.on(middle(polygon));
    this.text(name, x, y + 6, ZONE);
  }

  stop({ x, y, text, now }, around) {
    const draw = this.context;
    const [u, v] = this.on([x, y]);
    const arm = now ? around : 8;
    draw.beginPath();
    draw.moveTo(u - arm, v);
    draw.lineTo(u + arm, v);
    draw.moveTo(u, v - arm);
    draw.lineTo(u, v + arm);
    this.stroke(QUIET, now ? 3 : 2);
    if (now) {
      draw.beginPath();
      draw.arc(u, v, around, 0, 2 * Math.PI);
      this.stroke(INK, 3, [6, 5]);
    }
    this.text(text, u, v - arm - 7, now ? INK : QUIET);
  }

  ray([[ax, ay], [bx, by]]) {
    const draw = this.context;
    draw.beginPath();
    draw.moveTo(...this.on([ax, ay]));
    draw.lineTo(...this.on([bx, by]));
    this.stroke("rgba(176, 69, 10, 0.45)", 3, [12, 6]);
  }

  // The person's side, in words at the sheet's edge.
  person({ eye, placed }) {
    const [u, v] = this.on(eye);
    const x = Math.min(Math.max(u, 80), this.fit.width - 80);
    const y = Math.min(Math.max(v, this.top - 11), this.top + this.sheet[1] * this.scale + 22);
    this.text(placed ? "person" : "person (place not known yet)", x, y, QUIET);
  }

  robot(robot, room, at) {
    if (!robot.heard) return;
    const draw = this.context;
    const [u, v] = this.on([robot.x, robot.y]);
    const radius = Math.max(room.radius * this.scale, 9);
    const pointed = at?.robot === robot.name;
    draw.globalAlpha = robot.lifted ? 0.55 : 1;
    draw.beginPath();
    draw.arc(u, v, radius, 0, 2 * Math.PI);
    draw.fillStyle = "#e4e8ee";
    draw.fill();
    this.stroke(pointed ? RAY : INK, pointed ? 4 : 2, robot.lifted ? [4, 4] : []);
    this.lights(robot, u, v, radius, room.led_zero);
    this.nose(u, v, robot.heading, radius);
    draw.globalAlpha = 1;
    this.text(robot.name, u, v + radius + 18, INK);
    if (robot.words) this.text(robot.words, u, v + radius + 37, WRONG);
  }

  lights(robot, u, v, radius, first) {
    const draw = this.context;
    for (let k = 0; k < LEDS; k += 1) {
      const angle = robot.heading + first + (k * 2 * Math.PI) / LEDS;
      draw.beginPath();
      draw.arc(u + 0.72 * radius * Math.cos(angle), v + 0.72 * radius * Math.sin(angle), 0.19 * radius, 0, 2 * Math.PI);
      draw.fillStyle = robot.lights[k] ? lightColour(robot.lights[k]) : "#9aa5b1";
      draw.fill();
      if (robot.lights[k]) this.stroke(INK, 1);
    }
  }

  nose(u, v, heading, radius) {
    const draw = this.context;
    const tip = (angle, far) => [u + far * radius * Math.cos(heading + angle), v + far * radius * Math.sin(heading + angle)];
    draw.beginPath();
    draw.moveTo(...tip(0, 0.48));
    draw.lineTo(...tip(2.5, 0.42));
    draw.lineTo(...tip(-2.5, 0.42));
    draw.closePath();
    draw.fillStyle = INK;
    draw.fill();
  }

  spot({ xy, ellipse, decided }) {
    const draw = this.context;
    const [u, v] = this.on(xy);
    if (ellipse) {
      draw.beginPath();
      draw.ellipse(u, v, ellipse[0] * this.scale, ellipse[1] * this.scale, ellipse[2], 0, 2 * Math.PI);
      draw.fillStyle = "rgba(176, 69, 10, 0.12)";
      draw.fill();
      this.stroke(SPOT, 2, decided ? [] : [7, 5]);
    }
    draw.beginPath();
    draw.arc(u, v, 5, 0, 2 * Math.PI);
    draw.fillStyle = SPOT;
    draw.fill();
    this.stroke("white", 2);
  }

  cross(place) {
    const draw = this.context;
    const [u, v] = this.on(place);
    draw.beginPath();
    draw.rect(u - 9, v - 9, 18, 18);
    this.stroke(INK, 3);
    this.text(`${Math.round(place[0] * 100)}, ${Math.round(place[1] * 100)} cm`, u, v - 16, INK);
  }
}
