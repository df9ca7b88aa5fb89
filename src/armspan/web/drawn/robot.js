// A robot in the scene: a disc with its front, six lights and a name.
import { THREE } from "nicegui-scene";

import { INK, LEDS, RAY } from "./common.js";
import { disc, solid } from "./shapes.js";

const TALL = 0.022; // m
const LIFTED = 0.05; // m above the sheet that a lifted robot is drawn
const DARK = 0x8a94a0;

export class Robot {
  constructor(world, labels, room) {
    const { radius } = room;
    this.labels = labels;
    this.group = new THREE.Group();
    const body = solid(new THREE.CylinderGeometry(radius, radius, TALL, 32), "#f2f4f7");
    body.rotation.x = Math.PI / 2;
    body.position.z = -TALL / 2;
    const foot = solid(new THREE.CylinderGeometry(1.04 * radius, 1.04 * radius, 0.008, 32), INK);
    foot.rotation.x = Math.PI / 2;
    foot.position.z = -0.004;
    this.ring = new THREE.Mesh(
      new THREE.RingGeometry(1.15 * radius, 1.4 * radius, 36),
      new THREE.MeshBasicMaterial({ color: RAY, side: THREE.DoubleSide }),
    );
    this.ring.position.z = -0.003;
    this.group.add(body, foot, this.ring, front(radius));
    this.lights = [];
    for (let k = 0; k < LEDS; k += 1) {
      const angle = room.led_zero + (k * 2 * Math.PI) / LEDS;
      const light = disc(0.2 * radius, DARK);
      light.position.set(0.72 * radius * Math.cos(angle), 0.72 * radius * Math.sin(angle), -TALL - 0.001);
      this.group.add(light);
      this.lights.push(light);
    }
    this.label = labels.add("robot");
    world.add(this.group);
  }

  move(one, pointed) {
    this.group.visible = one.heard;
    const high = one.lifted ? LIFTED : 0;
    this.group.position.set(one.x, one.y, -high);
    this.group.rotation.z = one.heading;
    this.ring.visible = pointed;
    this.lights.forEach((light, k) => light.material.color.setHex(one.lights[k] || DARK));
    const place = one.heard ? [one.x, one.y, -high - TALL - 0.045] : null;
    this.labels.put(this.label, place, one.words ? `${one.name}: ${one.words}` : one.name);
  }
}

function front(radius) {
  const shape = new THREE.Shape();
  shape.moveTo(0.48 * radius, 0);
  shape.lineTo(-0.34 * radius, 0.26 * radius);
  shape.lineTo(-0.34 * radius, -0.26 * radius);
  const mesh = new THREE.Mesh(
    new THREE.ShapeGeometry(shape),
    new THREE.MeshBasicMaterial({ color: INK, side: THREE.DoubleSide }),
  );
  mesh.position.z = -TALL - 0.0012;
  return mesh;
}
