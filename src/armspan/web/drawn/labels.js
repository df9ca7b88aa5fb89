// Words over the scene, in the page's own type so that they stay readable.
import { THREE } from "nicegui-scene";

import { element, write } from "./words.js";

const place = new THREE.Vector3();

export class Labels {
  constructor(box, world, camera) {
    this.box = element(box, "div", "lively-labels");
    this.world = world;
    this.camera = camera;
    this.all = [];
  }

  clear() {
    this.box.replaceChildren();
    this.all = [];
  }

  add(kind) {
    const label = { box: element(this.box, "span", `lively-name ${kind}`), at: null, edge: kind === "quiet" ? 90 : 0 };
    this.all.push(label);
    return label;
  }

  // Put a label at a place in `sheet` [m], or nowhere.
  put(label, at, text) {
    label.at = at;
    write(label.box, text);
  }

  draw(width, height) {
    for (const { box, at, edge } of this.all) {
      if (at) place.set(...at).applyMatrix4(this.world.matrixWorld).project(this.camera);
      const seen = at && place.z < 1;
      box.hidden = !seen;
      if (!seen) continue;
      const x = Math.min(Math.max(((place.x + 1) / 2) * width, edge), width - edge);
      const y = ((1 - place.y) / 2) * height;
      box.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
    }
  }
}
