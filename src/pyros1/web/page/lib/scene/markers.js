// Markers in all their kinds; see https://wiki.ros.org/rviz/DisplayTypes/Marker.

import * as THREE from "../../vendor/three/three.module.min.js";
import { placed } from "./select.js";
import { dispose, put } from "./stage.js";
import { label } from "./label.js";
import { meshOf } from "./meshes.js";

const [ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TEXT, MESH, TRIANGLES] = Array(12).keys();
const NAMES = ["ARROW", "CUBE", "SPHERE", "CYLINDER", "LINE_STRIP", "LINE_LIST", "CUBE_LIST", "SPHERE_LIST", "POINTS", "TEXT_VIEW_FACING", "MESH_RESOURCE", "TRIANGLE_LIST"];
const BOX = new THREE.BoxGeometry(1, 1, 1);
const BALL = new THREE.SphereGeometry(0.5, 20, 14);
const CAN = new THREE.CylinderGeometry(0.5, 0.5, 1, 24).rotateX(Math.PI / 2);
const SHARED = new Set([BOX, BALL, CAN]);
const MOST_NAMESPACES = 50;
const MOST_FAULTS = 20;

// Return an object for a marker, or null for a kind that is not drawn.
// host: {token, changed(), failed(text)}; meshes come from the server, later.
export function markerObject(marker, host) {
  const { type, scale, color } = marker;
  if (type === ARROW) return arrowMarker(marker);
  if (type === CUBE || type === SPHERE || type === CYLINDER) {
    const mesh = new THREE.Mesh([null, BOX, BALL, CAN][type], solid(color));
    mesh.scale.set(...scale.map((size) => Math.abs(size) || 1e-6));
    return mesh;
  }
  if (type === LINE_STRIP || type === LINE_LIST) return lines(marker);
  if (type === CUBE_LIST || type === SPHERE_LIST) return many(marker, type === CUBE_LIST ? BOX : BALL);
  if (type === POINTS) return points(marker);
  if (type === TEXT) {
    const text = label(marker.text, { height: Math.max(0.01, scale[2]), color });
    if (text.userData.missing) host.failed("there are too many texts to draw them all");
    return text;
  }
  if (type === TRIANGLES) return triangles(marker);
  if (type === MESH) return mesh(marker, host);
  return null;
}

function mesh({ mesh: uri, materials, scale, color }, { token, changed, failed }) {
  const object = new THREE.Group();
  object.scale.set(...scale.map((size) => size || 1));
  meshOf(uri, token).then((found) => {
    const embedded = materials && found.userData.painted;
    const tint = color[3] > 0 && (color[0] || color[1] || color[2]) ? color : null; // 0, 0, 0, 0: as it is
    found.traverse((each) => {
      if (!each.isMesh) return;
      each.material = embedded ? [each.material].flat().map((material) => material.clone()) : solid(color, { side: THREE.DoubleSide });
      if (embedded && tint) for (const material of each.material) material.color.multiply(new THREE.Color().setRGB(...tint.slice(0, 3), THREE.SRGBColorSpace));
      if (embedded && each.material.length === 1) [each.material] = each.material;
    });
    object.add(found);
    changed();
  }, (error) => failed(error.message));
  return object;
}

// Free what a marker holds, but not the shapes that all share.
export function disposeMarker(object) {
  object.traverse((each) => {
    if (SHARED.has(each.geometry)) each.geometry = undefined;
  });
  dispose(object);
}

function solid([red, green, blue, alpha], more = {}) {
  return new THREE.MeshStandardMaterial({
    color: new THREE.Color(red, green, blue).convertSRGBToLinear(), opacity: alpha, transparent: alpha < 1, depthWrite: alpha > 0.99,
    roughness: 0.8, metalness: 0, ...more,
  });
}

function arrowMarker({ points: ends, scale, color }) {
  const material = solid(color);
  if (ends.length >= 2) { // from one point to another: shaft, head and length of the head
    const from = new THREE.Vector3(...ends[0]);
    const to = new THREE.Vector3(...ends[1]);
    const length = from.distanceTo(to);
    const head = scale[2] > 0 ? Math.min(scale[2], length) : length * 0.23;
    const arrow = arrowOf(length, head, scale[0], scale[1], material);
    arrow.position.copy(from);
    if (length > 0) arrow.quaternion.setFromUnitVectors(new THREE.Vector3(1, 0, 0), to.sub(from).normalize());
    const group = new THREE.Group();
    group.add(arrow);
    return group;
  }
  const group = new THREE.Group();
  group.add(arrowOf(scale[0], scale[0] * 0.23, scale[1], scale[1] * 2, material));
  return group;
}

// An arrow along x.
export function arrowOf(length, head, shaft, width, material) {
  const group = new THREE.Group();
  const turn = -Math.PI / 2;
  const body = new THREE.Mesh(new THREE.CylinderGeometry(shaft / 2, shaft / 2, Math.max(1e-6, length - head), 14), material);
  body.geometry.rotateZ(turn).translate((length - head) / 2, 0, 0);
  const tip = new THREE.Mesh(new THREE.ConeGeometry(width / 2, Math.max(1e-6, head), 18), material);
  tip.geometry.rotateZ(turn).translate(length - head / 2, 0, 0);
  group.add(body, tip);
  return group;
}

function colourOf(marker, index) {
  return marker.colors.length === marker.points.length ? marker.colors[index] : marker.color;
}

function vertices(marker) {
  const positions = new Float32Array(3 * marker.points.length);
  const colours = new Float32Array(3 * marker.points.length);
  marker.points.forEach((point, index) => {
    positions.set(point, 3 * index);
    const [red, green, blue] = colourOf(marker, index);
    const colour = new THREE.Color(red, green, blue).convertSRGBToLinear();
    colours.set([colour.r, colour.g, colour.b], 3 * index);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  return geometry;
}

function lines(marker) {
  const alpha = marker.color[3] || 1;
  const material = new THREE.LineBasicMaterial({ vertexColors: true, opacity: alpha, transparent: alpha < 1 });
  const kind = marker.type === LINE_STRIP ? THREE.Line : THREE.LineSegments;
  const thin = new kind(vertices(marker), material);
  thin.frustumCulled = false;
  return thin;
}

function points(marker) {
  const material = new THREE.PointsMaterial({ vertexColors: true, size: Math.max(0.001, marker.scale[0]), sizeAttenuation: true });
  const object = new THREE.Points(vertices(marker), material);
  object.frustumCulled = false;
  return object;
}

function many(marker, geometry) {
  const mesh = new THREE.InstancedMesh(geometry, solid([1, 1, 1, marker.color[3] || 1]), marker.points.length);
  const matrix = new THREE.Matrix4();
  const [x, y, z] = marker.scale.map((size) => Math.abs(size) || 1e-6);
  marker.points.forEach((point, index) => {
    matrix.makeScale(x, y, z).setPosition(...point);
    mesh.setMatrixAt(index, matrix);
    const [red, green, blue] = colourOf(marker, index);
    mesh.setColorAt(index, new THREE.Color(red, green, blue).convertSRGBToLinear());
  });
  mesh.frustumCulled = false;
  return mesh;
}

function triangles(marker) {
  const whole = { ...marker, points: marker.points.slice(0, marker.points.length - (marker.points.length % 3)) };
  if (marker.colors.length === marker.points.length / 3) { // a colour for each triangle
    whole.colors = whole.points.map((_, index) => marker.colors[Math.floor(index / 3)]);
  } else if (marker.colors.length === marker.points.length) whole.colors = marker.colors.slice(0, whole.points.length);
  const geometry = vertices(whole);
  geometry.computeVertexNormals();
  const mesh = new THREE.Mesh(geometry, solid([1, 1, 1, marker.color[3] || 1], { vertexColors: true, side: THREE.DoubleSide }));
  mesh.scale.set(...marker.scale.map((size) => size || 1));
  return mesh;
}

// The markers of a topic.
export class MarkerSet {
  // host: {token, changed()}
  constructor(host) {
    this.object = new THREE.Group();
    this.known = new Map();
    this.namespaces = new Set();
    this.faults = new Set();
    const failed = (text) => {
      if (this.faults.size < MOST_FAULTS) this.faults.add(text);
      host.changed("words");
    };
    this.host = { ...host, failed };
  }

  // Take a push of the view scene_topic.
  take({ new: added, gone, poses, all }) {
    if (all) for (const key of [...this.known.keys()]) this._remove(key);
    for (const [ns, id] of gone) this._remove(`${ns}\n${id}`);
    for (const marker of added) {
      const key = `${marker.ns}\n${marker.id}`;
      this._remove(key);
      if (this.namespaces.size < MOST_NAMESPACES) this.namespaces.add(marker.ns);
      const frame = poses[marker.frame];
      const object = frame && markerObject(marker, this.host);
      if (!object) continue;
      const outer = new THREE.Group();
      const inner = new THREE.Group();
      outer.userData.ns = marker.ns;
      outer.userData.facts = marker;
      if (marker.locked) outer.userData.frame = marker.frame;
      put(outer, frame);
      put(inner, marker.pose);
      inner.add(object);
      outer.add(inner);
      this.object.add(outer);
      this.known.set(key, outer);
    }
  }

  // Show only some namespaces: options are {"ns:NAME": shown}.
  show(options) {
    for (const outer of this.known.values()) outer.visible = options[`ns:${outer.userData.ns}`] ?? true;
  }

  // Markers that are locked to a frame go with it.
  place(frames) {
    for (const outer of this.known.values()) {
      const pose = outer.userData.frame && frames.pose(outer.userData.frame);
      if (pose) put(outer, pose);
    }
  }

  // What can be selected; see select.js.
  parts() {
    return [...this.known.values()].map((outer) => {
      const { ns, id, type, frame, text, points: { length } } = outer.userData.facts;
      const rows = [["namespace", ns], ["id", id], ["type", NAMES[type] || type], ["frame", frame]];
      if (text) rows.push(["text", text]);
      if (length) rows.push(["points", length]);
      return { object: outer, about: () => [...rows, ...placed(outer.children[0])] };
    });
  }

  get count() {
    return this.known.size;
  }

  _remove(key) {
    const object = this.known.get(key);
    if (!object) return;
    this.known.delete(key);
    this.object.remove(object);
    disposeMarker(object);
  }
}
