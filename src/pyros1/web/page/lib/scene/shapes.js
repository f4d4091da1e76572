// Draw messages of simple types. Each function takes the facts of pyros1/web/scene/shapes.py, their numbers as a
// Float32Array, and a colour; it returns [object, status].

import * as THREE from "../../vendor/three/three.module.min.js";
import { axesMaterial, axesOf, axesShape } from "./axes.js";
import { arrowOf } from "./markers.js";
import { label } from "./label.js";
import { plural } from "../format.js";
import { rainbow } from "./rainbow.js";
import { pairs, ribbons, repeatColour } from "./ribbons.js";
import { setPose } from "./stage.js";

/** @typedef {Record<string, any>} Style  the options of a display: see options.js */

const MAX_ARROWS = 2000;

export function path({ count }, numbers, colour, /** @type {Style} */ style = {}) {
  const group = new THREE.Group();
  const positions = new Float32Array(3 * count);
  for (let index = 0; index < count; index += 1) positions.set(numbers.subarray(7 * index, 7 * index + 3), 3 * index);
  group.position.set(style.x ?? 0, style.y ?? 0, style.z ?? 0);
  group.add(style.line === "metres" ? ribbons(positions, repeatColour(colour, style.alpha, count), style.width, [[0, count]]) : line(positions, colour, style.alpha));
  if (style.poses === "axes") addAll(group, copies(count, numbers, new THREE.Mesh(axesShape(style.axesLength, style.axesWidth), axesMaterial(style.alpha))));
  else if (style.poses === "arrows") {
    const { shaft, head } = style;
    addAll(group, copies(count, numbers, arrowOf(shaft + head, head, style.shaftWidth, style.headWidth, material(style.poseTint, style.alpha))));
  }
  return [group, plural(count, "pose")];
}

// Add objects to a group. three.js's add logs an error if it is called without objects.
function addAll(group, things) {
  for (const thing of things) group.add(thing);
}

// Return copies of an object at the given poses, up to MAX_ARROWS.
function copies(count, numbers, thing) {
  return Array.from({ length: Math.min(count, MAX_ARROWS) }, (_, index) => {
    const place = new THREE.Group();
    setPose(place, numbers.subarray(7 * index, 7 * index + 7));
    place.add(thing.clone());
    return place;
  });
}

export function poses({ count, spread, turn }, numbers, colour, /** @type {Style} */ style = {}) {
  const group = new THREE.Group();
  const { alpha, shaft, head } = style;
  if (style.axes) addAll(group, copies(count, numbers, axesOf(style.axesLength, style.axesWidth, alpha)));
  else if (style.lines) addAll(group, copies(count, numbers, flatArrow(style.arrow, colour, alpha)));
  else addAll(group, copies(count, numbers, arrowOf(shaft + head, head, style.shaftWidth, style.headWidth, material(colour, alpha))));
  if (spread && count && style.covariance) {
    if (style.place) group.add(ellipsoid(spread, numbers, style));
    if (style.turn && turn > 0) group.children[0].add(fan(Math.min(Math.PI, turn), style));
  }
  return [group, count === 1 ? "" : `${count} poses${count > MAX_ARROWS ? `, ${MAX_ARROWS} are drawn` : ""}`];
}

function flatArrow(length, colour, alpha) {
  const tip = [0.75 * length, 0.2 * length];
  const ends = [0, 0, 0, length, 0, 0, length, 0, 0, tip[0], tip[1], 0, length, 0, 0, tip[0], -tip[1], 0];
  return line(Float32Array.from(ends), colour, alpha, pairs(ends.length / 3));
}

// The position's uncertainty: an ellipsoid of one standard deviation.
function ellipsoid(spread, place, /** @type {Style} */ { placeTint, placeAlpha, placeScale }) {
  const ball = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), material(placeTint, placeAlpha));
  const [one, two, three] = spread.map((axis) => new THREE.Vector3(...axis).multiplyScalar(placeScale));
  for (const axis of [one, two, three]) if (axis.lengthSq() < 1e-10) axis.setScalar(1e-5);
  ball.matrixAutoUpdate = false;
  ball.matrix.makeBasis(one, two, three).setPosition(place[0], place[1], place[2]);
  return ball;
}

// The direction's uncertainty: a fan of one standard deviation.
function fan(angle, /** @type {Style} */ { turnTint, turnAlpha }) {
  const shape = new THREE.CircleGeometry(0.5, 24, -angle, 2 * angle);
  return new THREE.Mesh(shape, material(turnTint, turnAlpha));
}

export function point({ point: [x, y, z] }, _, colour, /** @type {Style} */ { radius, alpha } = {}) {
  const status = [x, y, z].map((value) => value?.toFixed(3) ?? "nan").join(", ");
  if (!areFinite([x, y, z])) return [new THREE.Group(), status];
  const ball = new THREE.Mesh(new THREE.SphereGeometry(radius, 20, 14), material(colour, alpha));
  ball.position.set(x, y, z);
  return [ball, status];
}

export function polygon({ count }, corners, colour, /** @type {Style} */ { alpha } = {}) {
  const closed = new Float32Array(3 * (count + 1));
  closed.set(corners.subarray(0, 3 * count));
  if (count) closed.set(corners.subarray(0, 3), 3 * count);
  return [line(closed, colour, alpha), plural(count, "corner")];
}

export function cells({ count, more, size }, middles, colour, /** @type {Style} */ { alpha } = {}) {
  const [width, height] = size.map((value) => value || 0.01);
  const mesh = new THREE.InstancedMesh(new THREE.PlaneGeometry(width * 0.95, height * 0.95), new THREE.MeshBasicMaterial({ color: colour, side: THREE.DoubleSide, transparent: alpha < 1, opacity: alpha }), count);
  const matrix = new THREE.Matrix4();
  for (let index = 0; index < count; index += 1) mesh.setMatrixAt(index, matrix.makeTranslation(middles[3 * index], middles[3 * index + 1], middles[3 * index + 2]));
  mesh.frustumCulled = false;
  return [mesh, `${plural(count, "cell")}${more ? `, ${more} more ${more === 1 ? "is" : "are"} not drawn` : ""}`];
}

// A wrench, twist or acceleration: an arrow for the linear part, and an arrow with an arc around it for the angular one.
export function screw({ straight, around, units }, _, colour, { scale, scaleAround, width, tintAround, alpha, small }) {
  const group = new THREE.Group();
  if (!areFinite([...straight, ...around])) return [group, "some of its numbers are not finite"];
  const [force, torque] = [straight, around].map((values) => new THREE.Vector3(...values));
  for (const [vector, times, tint] of [[force, scale, colour], [torque, scaleAround, tintAround]]) {
    const length = vector.length() * times;
    if (length < 1e-4 || (small && length < width)) continue;
    const arrow = arrowOf(1.3 * length, 0.3 * length, 0.1 * width, 0.2 * width, material(tint, alpha));
    arrow.quaternion.setFromUnitVectors(new THREE.Vector3(1, 0, 0), vector.clone().normalize());
    if (vector === torque) {
      const arc = new THREE.Mesh(new THREE.TorusGeometry(length / 4, 0.025 * width, 8, 36, 1.6 * Math.PI), material(tint, alpha));
      arc.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(1, 0, 0));
      arc.position.set(length / 2, 0, 0);
      arrow.add(arc);
    }
    group.add(arrow);
  }
  return [group, `${force.length().toFixed(2)} ${units[0]}, ${torque.length().toFixed(2)} ${units[1]}`];
}

// A number, shown by its colour.
export function measured({ value, unit, least, most, warm }) {
  const rgb = [0, 0, 0];
  const place = ((value ?? least) - least) / (most - least);
  rainbow(warm ? place : 1 - place, rgb, 0); // like rviz: warm is red, and for other quantities low is red
  const group = new THREE.Group();
  const status = `${value === null ? "nan" : Number(value.toPrecision(6))} ${unit}`.trim();
  const text = label(status, { height: 0.12, color: [0.55, 0.55, 0.6, 1] });
  text.position.set(0, 0, 0.2);
  group.add(new THREE.Mesh(new THREE.SphereGeometry(0.1, 20, 14), material(new THREE.Color(...rgb))), text);
  return [group, status];
}

export function range({ range: length, angle, inside }, _, colour, /** @type {Style} */ { alpha } = {}) {
  if (!inside || !length) return [new THREE.Group(), "nothing in range"];
  const radius = length * Math.tan(Math.min(1.5, Math.abs(angle) / 2));
  const cone = new THREE.ConeGeometry(radius, length, 32, 1, true).rotateZ(Math.PI / 2).translate(length / 2, 0, 0);
  return [new THREE.Mesh(cone, material(colour, alpha)), `${length.toFixed(2)} m`];
}

export function imu({ orientation, acceleration }, _, colour) {
  const group = new THREE.Group();
  const box = new THREE.Mesh(new THREE.BoxGeometry(0.4, 0.25, 0.1), material(colour, 0.7));
  setPose(box, [0, 0, 0, ...orientation.map((value) => value ?? 0)]);
  const push = new THREE.Vector3(...acceleration.map((value) => value ?? 0));
  group.add(box);
  if (push.length() > 1e-6) group.add(new THREE.ArrowHelper(push.clone().normalize(), new THREE.Vector3(), push.length() / 9.81, 0xe8590c));
  return [group, `${push.length().toFixed(2)} m/s²`];
}

// Return whether all numbers are finite; others are sent as null.
function areFinite(numbers) {
  return numbers.every((value) => value !== null);
}

function line(positions, colour, opacity = 1, chains = [[0, positions.length / 3]]) {
  return ribbons(positions, repeatColour(colour, opacity, positions.length / 3), 1, chains, "pixels");
}

function material(colour, opacity = 1) {
  return new THREE.MeshLambertMaterial({ color: colour, opacity, transparent: opacity < 1, depthWrite: opacity === 1, side: opacity < 1 ? THREE.DoubleSide : THREE.FrontSide });
}
