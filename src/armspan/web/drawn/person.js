// The person: head, trunk, and the arms as their bands feel them; faded while the place is not known.
import { THREE } from "nicegui-scene";

import { solid, stretch, tube } from "./shapes.js";

const SKIN = "#d9a98a";
const SHIRT = "#6b7f99";
const HEAD = 0.095; // m
const FADED = 0.35;

export class Person {
  constructor(world, labels, table) {
    this.labels = labels;
    this.floor = table;
    this.head = solid(new THREE.SphereGeometry(HEAD, 24, 16), SKIN);
    this.trunk = tube(0.13, SHIRT);
    this.legs = tube(0.1, "#46546a");
    this.arms = [new Arm(), new Arm()];
    this.group = new THREE.Group();
    this.group.add(this.head, this.trunk, this.legs, ...this.arms.map((arm) => arm.group));
    this.label = labels.add("quiet");
    world.add(this.group);
  }

  move(frame) {
    const { eye } = frame;
    this.group.visible = Boolean(eye);
    this.labels.put(this.label, eye && !frame.placed ? [eye[0], eye[1], eye[2] - 0.2] : null, "place not known yet");
    if (!eye) return;
    this.fade(frame.placed ? 1 : FADED);
    const [x, y, z] = eye;
    const hip = z + 0.44 * (this.floor - z);
    const behind = (far) => [x - far * Math.cos(frame.facing), y + far * Math.sin(frame.facing)];
    this.head.position.set(...behind(0.05), z);
    stretch(this.trunk, [...behind(0.08), z + 0.2], [...behind(0.08), hip]);
    stretch(this.legs, [...behind(0.08), hip], [...behind(0.08), this.floor]);
    this.arms.forEach((arm, index) => arm.move(frame.arms?.[index]));
  }

  fade(opacity) {
    if (this.opacity === opacity) return;
    this.opacity = opacity;
    this.group.traverse(({ material }) => {
      if (!material) return;
      material.opacity = opacity;
      material.transparent = opacity < 1;
      material.needsUpdate = true;
    });
  }
}

class Arm {
  constructor() {
    this.upper = tube(0.036, SHIRT);
    this.lower = tube(0.027, SKIN);
    this.joints = [0.045, 0.034, 0.022].map((radius, k) => solid(new THREE.SphereGeometry(radius, 16, 12), k < 2 ? SHIRT : SKIN));
    this.group = new THREE.Group();
    this.group.add(this.upper, this.lower, ...this.joints);
  }

  move(limb) {
    this.group.visible = Boolean(limb);
    if (!limb) return;
    const [shoulder, elbow, tip] = limb.points;
    stretch(this.upper, shoulder, elbow);
    stretch(this.lower, elbow, tip);
    this.joints.forEach((joint, k) => joint.position.set(...limb.points[k]));
  }
}
