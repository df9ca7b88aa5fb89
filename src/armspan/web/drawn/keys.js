// Esc, and the space bar outside of text, stop the robots at once.
import { send } from "./line.js";
import { write } from "./words.js";

const FOR = 4000; // ms that the words stay
const TYPES = ["keydown", "keyup"];
const TYPED = "input, textarea, select, [contenteditable]:not([contenteditable=false])";
const NO_TEXT = ["button", "checkbox", "radio", "range", "submit", "reset"];

export class Keys {
  constructor(box) {
    box.setAttribute("role", "alert");
    this.box = box;
    this.pressed = -Infinity;
    this.key = (event) => this.onKey(event);
    for (const type of TYPES) window.addEventListener(type, this.key, { capture: true });
  }

  // A button is clicked when the space bar goes up again: that is kept from it, too.
  onKey(event) {
    if (event.key !== "Escape" && !(event.key === " " && !typing(event.target))) return;
    event.preventDefault();
    event.stopPropagation();
    if (event.type === "keyup" || event.repeat) return;
    this.pressed = performance.now();
    this.show(send("stop") ? "Stop sent" : "No connection to Armspan: the stop may not have arrived");
  }

  draw(frame, room) {
    if (performance.now() - this.pressed > FOR) return;
    if (room === null) this.show("Stop sent; no room is open");
    else if (frame.stopped) this.show("All robots stopped");
  }

  show(text) {
    write(this.box, text);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => write(this.box, ""), FOR);
  }

  close() {
    for (const type of TYPES) window.removeEventListener(type, this.key, { capture: true });
    clearTimeout(this.timer);
  }
}

function typing(target) {
  const field = target instanceof Element ? target.closest(TYPED) : null;
  return field !== null && !(field.tagName === "INPUT" && NO_TEXT.includes(field.type));
}
