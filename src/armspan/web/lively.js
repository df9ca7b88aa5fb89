// One view of the live line. The kinds are in `drawn/`; nothing that changes with a frame is in Vue's reactivity.
//
// Options: strips {bands: [name]}, scores {threshold}, plan {draw: bool}, space and plan {stops: bool} (residuals of
// the set-up's stops even after it). Events: plan `picked` {x, y, robot, zone} [m], `drawn` {polygon: [[x, y]]} [m].
import { join } from "armspan-drawn/line.js";

const KINDS = {
  space: async () => (await import("armspan-drawn/space.js")).Space,
  plan: async () => (await import("armspan-drawn/plan.js")).Plan,
  strips: async () => (await import("armspan-drawn/strips.js")).Strips,
  scores: async () => (await import("armspan-drawn/words.js")).Scores,
  say: async () => (await import("armspan-drawn/words.js")).Say,
  aim: async () => (await import("armspan-drawn/words.js")).Aim,
  keys: async () => (await import("armspan-drawn/keys.js")).Keys,
};

export default {
  template: `<div :class="'lively lively-' + kind"><div class="lively-lost" hidden></div><div class="lively-body" ref="body"></div></div>`,
  props: { kind: String, label: String, options: Object },
  emits: ["picked", "drawn"],
  async mounted() {
    const View = await KINDS[this.kind]();
    if (!this.$el.isConnected) return;
    const told = { label: this.label, options: this.options ?? {}, tell: (name, value) => this.$emit(name, value) };
    try {
      this.view = new View(this.$refs.body, told);
    } catch (error) {
      this.$refs.body.textContent = `This browser cannot draw this view: ${error.message}`; // no WebGL, for instance
      return;
    }
    this.leave = join(this.view, this.$el);
  },
  watch: {
    options(options) {
      this.view?.set?.(options ?? {});
    },
  },
  unmounted() {
    this.leave?.();
    this.view?.close?.();
  },
};
