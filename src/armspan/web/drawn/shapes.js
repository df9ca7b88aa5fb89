// The few shapes that the scene is made of.
import { THREE } from "nicegui-scene";

const UP = new THREE.Vector3(0, 1, 0);
const from = new THREE.Vector3();
const along = new THREE.Vector3();

export function solid(geometry, colour, opacity = 1) {
  const material = new THREE.MeshLambertMaterial({ color: colour, opacity, transparent: opacity < 1 });
  return new THREE.Mesh(geometry, material);
}

// A flat disc that is seen from both sides and glows by itself.
export function disc(radius, colour, opacity = 1) {
  const material = new THREE.MeshBasicMaterial({ color: colour, opacity, transparent: opacity < 1, side: THREE.DoubleSide });
  return new THREE.Mesh(new THREE.CircleGeometry(radius, 36), material);
}

// A tube one metre long, for `stretch`.
export function tube(radius, colour) {
  return solid(new THREE.CylinderGeometry(radius, radius, 1, 24), colour);
}

export function stretch(mesh, a, b) {
  from.set(...a);
  along.set(...b).sub(from);
  const length = Math.max(along.length(), 1e-6);
  mesh.position.copy(from).addScaledVector(along, 0.5);
  mesh.quaternion.setFromUnitVectors(UP, along.divideScalar(length));
  mesh.scale.set(1, length, 1);
}

// A closed line of a width [m], as flat quads: WebGL's own lines are a pixel wide.
export function outline(polygon, width, colour, z) {
  const corners = [];
  polygon.forEach(([ax, ay], index) => {
    const [bx, by] = polygon[(index + 1) % polygon.length];
    const length = Math.hypot(bx - ax, by - ay) || 1;
    const [ux, uy] = [((bx - ax) / length) * (width / 2), ((by - ay) / length) * (width / 2)];
    const a = [ax - ux, ay - uy];
    const b = [bx + ux, by + uy];
    const quad = [[a[0] - uy, a[1] + ux], [a[0] + uy, a[1] - ux], [b[0] + uy, b[1] - ux], [b[0] - uy, b[1] + ux]]; // prettier-ignore
    for (const k of [0, 1, 2, 0, 2, 3]) corners.push(...quad[k], z);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color: colour, side: THREE.DoubleSide }));
}
