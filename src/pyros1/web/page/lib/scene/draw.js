// Messages of small kinds as objects. Each function takes the facts of pyros1/web/scene/shapes.py, their numbers as
// Float32Array, and a colour; it returns [object, word].

import * as THREE from "../../vendor/three/three.module.min.js";
import { arrowOf } from "./markers.js";
import { label } from "./label.js";
import { plural } from "../format.js";
import { rainbow } from "./colours.js";
import { put } from "./stage.js";

const MOST_ARROWS = 2000;
const STRAIGHT = 0xc92a2a;
const AROUND = 0xe0a000;

export function path({ count }, poses, colour) {
  const positions = new Float32Array(3 * count);
  for (let index = 0; index < count; index += 1) positions.set(poses.subarray(7 * index, 7 * index + 3), 3 * index);
  return [line(positions, colour), plural(count, "pose")];
}

export function poses({ count, spread, turn }, numbers, colour, style = {}) {
  const group = new THREE.Group();
  const material = matter(colour);
  for (let index = 0; index < Math.min(count, MOST_ARROWS); index += 1) {
    const place = new THREE.Group();
    put(place, numbers.subarray(7 * index, 7 * index + 7));
    place.add(style.axes ? new THREE.AxesHelper(0.5) : arrowOf(0.5, 0.15, 0.03, 0.09, material));
    group.add(place);
  }
  if (spread && count && style.covariance !== false) {
    group.add(ellipsoid(spread, numbers));
    if (turn > 0) group.children[0].add(fan(Math.min(Math.PI, turn)));
  }
  return [group, count === 1 ? "" : `${count} poses${count > MOST_ARROWS ? `, ${MOST_ARROWS} are drawn` : ""}`];
}

// Where the position is, up to one standard deviation.
function ellipsoid(spread, place) {
  const ball = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), matter(0xcc33cc, 0.3));
  const [one, two, three] = spread.map((axis) => new THREE.Vector3(...axis));
  for (const axis of [one, two, three]) if (axis.lengthSq() < 1e-10) axis.setScalar(1e-5);
  ball.matrixAutoUpdate = false;
  ball.matrix.makeBasis(one, two, three).setPosition(place[0], place[1], place[2]);
  return ball;
}

// How sure the direction is, up to one standard deviation.
function fan(angle) {
  const shape = new THREE.CircleGeometry(0.5, 24, -angle, 2 * angle);
  return new THREE.Mesh(shape, matter(0xffff80, 0.35));
}

export function point({ point: [x, y, z] }, _, colour) {
  const ball = new THREE.Mesh(new THREE.SphereGeometry(0.1, 20, 14), matter(colour));
  ball.position.set(x ?? 0, y ?? 0, z ?? 0);
  return [ball, [x, y, z].map((value) => value?.toFixed(3) ?? "nan").join(", ")];
}

export function polygon({ count }, corners, colour) {
  const closed = new Float32Array(3 * (count + 1));
  closed.set(corners.subarray(0, 3 * count));
  if (count) closed.set(corners.subarray(0, 3), 3 * count);
  return [line(closed, colour), `${count} corners`];
}

export function cells({ count, more, size }, middles, colour) {
  const [width, height] = size.map((value) => value || 0.01);
  const mesh = new THREE.InstancedMesh(new THREE.PlaneGeometry(width * 0.95, height * 0.95), new THREE.MeshBasicMaterial({ color: colour, side: THREE.DoubleSide, transparent: true, opacity: 0.8 }), count);
  const matrix = new THREE.Matrix4();
  for (let index = 0; index < count; index += 1) mesh.setMatrixAt(index, matrix.makeTranslation(...middles.subarray(3 * index, 3 * index + 3)));
  mesh.frustumCulled = false;
  return [mesh, `${count} cells${more ? `, ${more} more are not drawn` : ""}`];
}

// A force and a torque, or a straight and a turning velocity: an arrow, and an arrow with an arc around it.
export function screw({ straight, around, units }, _, colour, { scale = 1 } = {}) {
  const group = new THREE.Group();
  const [force, torque] = [straight, around].map((values) => new THREE.Vector3(...values.map((value) => value ?? 0)));
  for (const [vector, tint] of [[force, STRAIGHT], [torque, AROUND]]) {
    const length = vector.length() * scale;
    if (length < 1e-4) continue;
    const arrow = arrowOf(length, Math.min(0.25, length * 0.3), 0.03, 0.09, matter(tint));
    arrow.quaternion.setFromUnitVectors(new THREE.Vector3(1, 0, 0), vector.clone().normalize());
    if (vector === torque) {
      const arc = new THREE.Mesh(new THREE.TorusGeometry(Math.min(0.4, length / 4) + 0.02, 0.012, 8, 36, 1.6 * Math.PI), matter(tint));
      arc.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(1, 0, 0));
      arc.position.set(length / 2, 0, 0);
      arrow.add(arc);
    }
    group.add(arrow);
  }
  return [group, `${force.length().toFixed(2)} ${units[0]}, ${torque.length().toFixed(2)} ${units[1]}`];
}

// One number, by its colour.
export function measured({ value, unit, least, most }) {
  const rgb = [0, 0, 0];
  rainbow(((value ?? least) - least) / (most - least), rgb, 0);
  const group = new THREE.Group();
  const word = `${value === null ? "nan" : Number(value.toPrecision(6))} ${unit}`.trim();
  const text = label(word, { height: 0.12, color: [0.55, 0.55, 0.6, 1] });
  text.position.set(0, 0, 0.2);
  group.add(new THREE.Mesh(new THREE.SphereGeometry(0.1, 20, 14), matter(new THREE.Color(...rgb))), text);
  return [group, word];
}

export function range({ range: length, angle, inside }, _, colour) {
  if (!inside || !length) return [new THREE.Group(), "nothing in range"];
  const radius = length * Math.tan(Math.min(1.5, angle / 2));
  const cone = new THREE.ConeGeometry(radius, length, 32, 1, true).rotateZ(Math.PI / 2).translate(length / 2, 0, 0);
  const material = matter(colour, 0.5);
  return [new THREE.Mesh(cone, material), `${length.toFixed(2)} m`];
}

export function imu({ orientation, acceleration }, _, colour) {
  const group = new THREE.Group();
  const box = new THREE.Mesh(new THREE.BoxGeometry(0.4, 0.25, 0.1), matter(colour, 0.7));
  put(box, [0, 0, 0, ...orientation.map((value) => value ?? 0)]);
  const push = new THREE.Vector3(...acceleration.map((value) => value ?? 0));
  group.add(box);
  if (push.length() > 1e-6) group.add(new THREE.ArrowHelper(push.clone().normalize(), new THREE.Vector3(), push.length() / 9.81, 0xe8590c));
  return [group, `${push.length().toFixed(2)} m/s²`];
}

function line(positions, colour) {
  const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(positions, 3));
  const object = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: colour }));
  object.frustumCulled = false;
  return object;
}

function matter(colour, opacity = 1) {
  return new THREE.MeshStandardMaterial({ color: colour, roughness: 0.8, opacity, transparent: opacity < 1, depthWrite: opacity === 1, side: opacity < 1 ? THREE.DoubleSide : THREE.FrontSide });
}
