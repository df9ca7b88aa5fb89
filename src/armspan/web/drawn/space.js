// The live scene. Everything is in `sheet` (x right, y toward the person, z into the table [m]) in one turned group.
import { OrbitControls, THREE } from "nicegui-scene";

import { INK, RAY, SPOT, ZONE, fitted, middle, robotOf, stopsOf, unheard } from "./common.js";
import { Labels } from "./labels.js";
import { redraw } from "./line.js";
import { Person } from "./person.js";
import { Robot } from "./robot.js";
import { disc, outline, solid, stretch, tube } from "./shapes.js";
import { element, write } from "./words.js";

const AROUND = 0.1; // m of table around the sheet
const TURN = 0.08; // rad that an arrow key turns the view

export class Space {
  constructor(box, { label, options }) {
    this.options = options;
    this.fit = fitted(box, `${label}: arrow keys turn the view, plus and minus zoom`, () => this.resize());
    this.canvas = this.fit.canvas;
    this.canvas.tabIndex = 0;
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.1, 20);
    this.scene = new THREE.Scene();
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#b8bfc8", 2.2));
    const sun = new THREE.DirectionalLight("#ffffff", 1.6);
    sun.position.set(-1, 3, 2);
    this.scene.add(sun);
    this.world = new THREE.Group();
    this.world.rotation.x = Math.PI / 2;
    this.scene.add(this.world);
    this.labels = new Labels(box, this.world, this.camera);
    this.note = element(box, "div", "lively-note");
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.maxPolarAngle = Math.PI / 2 - 0.02;
    this.controls.minDistance = 0.4;
    this.controls.maxDistance = 6;
    this.controls.addEventListener("change", redraw);
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.number = null;
  }

  set(options) {
    this.options = options;
    redraw();
  }

  close() {
    this.fit.close();
    this.controls.dispose();
    this.empty();
    this.renderer.dispose();
    this.renderer.forceContextLoss(); // a browser has few of them
  }

  resize() {
    if (!this.renderer || !this.fit.width || !this.fit.height) return;
    this.renderer.setPixelRatio(this.fit.ratio);
    this.renderer.setSize(this.fit.width, this.fit.height, false);
    this.camera.aspect = this.fit.width / this.fit.height;
    this.camera.updateProjectionMatrix();
    redraw();
  }

  key(event) {
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const zooms = { "+": 0.9, "=": 0.9, "-": 1.1 };
    const turn = turns[event.key] ?? [0, 0];
    const zoom = zooms[event.key] ?? 1;
    if (!turns[event.key] && zoom === 1) return;
    event.preventDefault();
    const { target } = this.controls;
    const from = new THREE.Spherical().setFromVector3(this.camera.position.clone().sub(target));
    from.theta += turn[0] * TURN;
    from.phi = Math.min(Math.max(from.phi + turn[1] * TURN, 0.05), this.controls.maxPolarAngle);
    from.radius = Math.min(Math.max(from.radius * zoom, this.controls.minDistance), this.controls.maxDistance);
    this.camera.position.setFromSpherical(from).add(target);
    this.controls.update();
    redraw();
  }

  // --- what stands still ----------------------------------------------------------------------------

  empty() {
    this.world.traverse((part) => {
      part.geometry?.dispose();
      part.material?.dispose();
    });
    this.world.clear();
    this.labels.clear();
  }

  build(room) {
    this.empty();
    const first = this.number === null;
    this.number = room.number;
    const [across, down] = room.sheet;
    this.furniture(across, down, room.table);
    this.zones = new Map();
    for (const zone of room.zones) this.zone(zone);
    this.robots = room.robots.map(() => new Robot(this.world, this.labels, room));
    this.person = new Person(this.world, this.labels, room.table);
    this.ray = tube(0.004, RAY);
    this.spot = disc(0.009, SPOT);
    this.ellipse = disc(1, SPOT, 0.3);
    this.world.add(this.ray, this.spot, this.ellipse);
    this.stops = room.stops.map(([x, y]) => {
      const mark = disc(0.012, INK, 0.6);
      mark.position.set(x, y, -0.004);
      this.world.add(mark);
      return { mark, label: this.labels.add("stop") };
    });
    if (first) this.look(across, down);
  }

  look(across, down) {
    const far = (0.75 * Math.max(across, down) + 1.1) * Math.max(1, 1.2 / this.camera.aspect);
    this.controls.target.set(across / 2, 0.27, 0.6 * down + 0.12);
    this.camera.position.set(across / 2 + 0.72 * far, 0.27 + 0.74 * far, 0.6 * down + 0.12 + 0.2 * far);
    this.controls.update();
  }

  furniture(across, down, height) {
    const add = (mesh, x, y, z) => {
      mesh.position.set(x, y, z);
      this.world.add(mesh);
    };
    const floor = solid(new THREE.CircleGeometry(2.2, 64), "#dfe4ea");
    add(floor, across / 2, down / 2, height);
    floor.rotation.x = Math.PI;
    const [w, d] = [across + 2 * AROUND, down + 2 * AROUND];
    add(solid(new THREE.BoxGeometry(w, d, 0.03), "#c9a878"), across / 2, down / 2, 0.0165);
    for (const x of [0.05 - AROUND, across + AROUND - 0.05]) {
      for (const y of [0.05 - AROUND, down + AROUND - 0.05]) {
        add(solid(new THREE.BoxGeometry(0.05, 0.05, height - 0.03), "#a98a5d"), x, y, height / 2 + 0.015);
      }
    }
    add(solid(new THREE.BoxGeometry(across, down, 0.002), "#ffffff"), across / 2, down / 2, 0.0005);
    const edge = [[0, 0], [across, 0], [across, down], [0, down]]; // prettier-ignore
    this.world.add(outline(edge, 0.005, "#8793a1", -0.003));
    const size = this.labels.add("quiet");
    this.labels.put(size, [across + 0.05, down / 2, 0], `Sheet ${Math.round(across * 100)} × ${Math.round(down * 100)} cm`);
  }

  zone({ name, polygon }) {
    const edge = outline(polygon, 0.007, ZONE, -0.003);
    this.zones.set(name, edge);
    this.world.add(edge);
    const [x, y] = middle(polygon);
    this.labels.put(this.labels.add("zone"), [x, y, 0], name);
  }

  // --- what moves -----------------------------------------------------------------------------------

  draw(frame, room) {
    if (!this.fit.width || !this.fit.height) return;
    if (room === null) {
      if (this.number !== null) this.empty();
      this.number = null;
    } else {
      if (room.number !== this.number) this.build(room);
      this.move(frame, room);
    }
    write(this.note, room === null ? "No room is open" : unheard(frame, room));
    this.renderer.render(this.scene, this.camera);
    this.labels.draw(this.fit.width, this.fit.height);
  }

  move(frame, room) {
    const at = frame.at;
    this.robots.forEach((robot, index) => {
      const one = robotOf(frame, room, index);
      robot.move(one, at?.robot === one.name);
    });
    for (const [name, edge] of this.zones) edge.material.color.set(at?.zone === name ? RAY : ZONE);
    this.person.move(frame);
    this.ray.visible = Boolean(frame.ray);
    if (frame.ray) stretch(this.ray, ...frame.ray);
    this.spot.visible = Boolean(at?.xy);
    this.ellipse.visible = Boolean(at?.xy && at.ellipse);
    if (at?.xy) this.spot.position.set(...at.xy, -0.006);
    if (this.ellipse.visible) {
      const [long, short, angle] = at.ellipse;
      this.ellipse.position.set(...at.xy, -0.005);
      this.ellipse.scale.set(Math.max(long, 1e-4), Math.max(short, 1e-4), 1);
      this.ellipse.rotation.z = angle;
    }
    const stops = stopsOf(frame, room, this.options.stops);
    this.stops.forEach(({ mark, label }, index) => {
      const stop = stops[index];
      mark.visible = Boolean(stop);
      mark.scale.setScalar(stop?.now ? 1.8 : 1);
      this.labels.put(label, stop ? [stop.x, stop.y + 0.045, 0] : null, stop?.text ?? "");
    });
  }
}
