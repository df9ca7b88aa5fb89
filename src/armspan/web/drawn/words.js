// The views that are words and bars: what to do now, what is pointed at, how sure the gestures are.
import { percent } from "./common.js";

// The sentence of the session; read out by a screen reader when it changes.
export class Say {
  constructor(box, { label }) {
    box.setAttribute("aria-live", "polite");
    box.setAttribute("aria-label", label);
    this.trouble = element(box, "p", "lively-trouble");
    this.trouble.setAttribute("role", "alert");
    this.say = element(box, "p", "lively-now");
  }

  draw(frame) {
    write(this.trouble, frame.trouble ?? "");
    write(this.say, frame.say ?? "");
  }
}

// What is pointed at, in words.
export class Aim {
  constructor(box, { label }) {
    box.setAttribute("role", "group");
    box.setAttribute("aria-label", label);
    this.box = box;
    this.what = element(box, "span", "lively-what");
    this.chosen = element(box, "span", "lively-chosen");
    this.chosen.setAttribute("aria-live", "polite");
  }

  draw(frame, room) {
    const [kind, words] = aimed(frame, room);
    write(this.what, words);
    if (this.what.dataset.kind !== kind) this.what.dataset.kind = kind;
    const chosen = frame.chosen && frame.t - frame.chosen.t < 2 ? `Chosen: ${frame.chosen.name}` : "";
    write(this.chosen, chosen);
  }
}

function aimed(frame, room) {
  if (room === null) return ["none", "No room is open"];
  const at = frame.at;
  if (!at) return ["none", frame.placed ? "Nothing is pointed at" : "Pointing works after the set-up"];
  if (at.refused || at.xy === null) return ["refused", `No answer: ${at.refused || "no ray"}`];
  const name = at.robot ?? at.zone;
  if (!name) return ["none", "Pointing at no robot and no zone"];
  if (!at.decided) return ["undecided", `undecided: ${name} ${percent(at.p)}`];
  return ["decided", `${name}, ${percent(at.p)}`];
}

// Confidence bars; `options.threshold` [share] is drawn as a line through them, `options.names` are
// labels in words.
export class Scores {
  constructor(box, { label, options }) {
    box.setAttribute("role", "group");
    box.setAttribute("aria-label", label);
    this.box = box;
    this.rows = new Map();
    this.none = element(box, "p", "lively-none");
    this.set(options);
  }

  set(options) {
    this.threshold = options.threshold ?? null;
    this.names = options.names ?? {};
    this.box.style.setProperty("--threshold", `${(this.threshold ?? 0) * 100}%`);
    this.box.classList.toggle("has-threshold", this.threshold !== null);
  }

  draw(frame) {
    const scores = frame.scores ?? [];
    write(this.none, scores.length ? "" : "No gesture is looked for yet");
    if (this.rows.size !== scores.length || scores.some(([label]) => !this.rows.has(label))) this.build(scores);
    for (const [label, share] of scores) {
      const row = this.rows.get(label);
      row.bar.style.transform = `scaleX(${share})`;
      write(row.share, percent(share));
      row.line.classList.toggle("over", this.threshold !== null && share >= this.threshold);
    }
  }

  build(scores) {
    for (const row of this.rows.values()) row.line.remove();
    this.rows.clear();
    for (const [label] of scores) {
      const line = element(this.box, "div", "lively-score");
      element(line, "span", "lively-label").textContent = this.names[label] ?? label.replaceAll("_", " ");
      const track = element(line, "span", "lively-track");
      this.rows.set(label, { line, bar: element(track, "span", "lively-bar"), share: element(line, "span", "lively-share") });
    }
  }
}

export function element(parent, tag, name) {
  const made = document.createElement(tag);
  made.className = name;
  parent.append(made);
  return made;
}

// Touch the page only when the words change: a screen reader reads again what is written again.
export function write(target, text) {
  if (target.textContent !== text) target.textContent = text;
}
