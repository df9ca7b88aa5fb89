// Draws one polygon, corner by corner or as a rectangle. Escape is not used: it stops the robots.
import { INK, WRONG, ZONE, crosses } from "./common.js";

export class Pencil {
  constructor(done, changed) {
    this.done = done;
    this.changed = changed;
    this.clear();
  }

  clear() {
    this.corners = [];
    this.at = null; // where the pointer is
    this.from = null; // where it was pressed
    this.dragged = false;
    this.changed();
  }

  down(place) {
    [this.from, this.at, this.dragged] = [place, place, false];
  }

  move(place, near) {
    this.at = place;
    if (this.from && this.corners.length === 0 && apart(place, this.from) > near) this.dragged = true;
    this.changed();
  }

  up(place, near) {
    const { from, dragged } = this;
    [this.from, this.dragged] = [null, false];
    if (from && dragged) {
      this.corners = rectangle(from, place);
      this.close();
    } else if (from) this.corner(place, near);
  }

  // A corner where the last one is (the second click of a double click) is none.
  corner(place, near) {
    const last = this.corners[this.corners.length - 1];
    if (!last || apart(place, last) > near) this.corners.push(place);
    this.changed();
  }

  back() {
    this.corners.pop();
    this.changed();
  }

  close() {
    if (this.corners.length < 3 || crosses(this.corners)) return;
    const polygon = this.corners.map(([x, y]) => [round(x), round(y)]);
    this.clear();
    this.done(polygon);
  }

  draw(context, on) {
    const shape = this.dragged ? rectangle(this.from, this.at) : this.shape();
    if (shape.length === 0) return;
    const wrong = crosses(shape);
    context.beginPath();
    for (const corner of shape) context.lineTo(...on(corner));
    context.closePath();
    context.fillStyle = wrong ? "rgba(139, 0, 0, 0.15)" : "rgba(31, 95, 168, 0.18)";
    context.fill();
    context.strokeStyle = wrong ? WRONG : ZONE;
    context.lineWidth = 3;
    context.setLineDash(wrong ? [4, 4] : [10, 5]);
    context.stroke();
    context.setLineDash([]);
    for (const corner of this.corners) {
      const [u, v] = on(corner);
      context.fillStyle = wrong ? WRONG : ZONE;
      context.fillRect(u - 5, v - 5, 10, 10);
    }
    this.words(context, wrong, shape.length);
  }

  shape() {
    const last = this.corners[this.corners.length - 1];
    return this.at && last && apart(this.at, last) > 0.005 ? [...this.corners, this.at] : this.corners;
  }

  words(context, wrong, count) {
    let text = "Enter or a double click closes the zone, Backspace takes the last corner back";
    if (wrong) text = "The zone's lines cross: take the last corner back with Backspace";
    else if (count < 3) text = "A zone needs three corners or more";
    const { clientWidth: width, clientHeight: height } = context.canvas;
    context.fillStyle = "white";
    context.fillRect(0, height - 30, width, 30);
    context.fillStyle = wrong ? WRONG : INK;
    context.fillText(text, width / 2, height - 10, width);
  }
}

function apart(a, b) {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

function rectangle([ax, ay], [bx, by]) {
  return [
    [ax, ay],
    [bx, ay],
    [bx, by],
    [ax, by],
  ];
}

function round(value) {
  return Math.round(value * 1000) / 1000;
}
