// Markers of all types; see https://wiki.ros.org/rviz/DisplayTypes/Marker.

import * as THREE from "../../vendor/three/three.module.min.js";
import { poseRows } from "./select_tool.js";
import { dispose, setPose } from "./stage.js";
import { label } from "./label.js";
import { meshOf } from "./meshes.js";
import { PointSet } from "./points.js";
import { pairs, ribbons } from "./ribbons.js";

const [ARROW, CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TEXT, MESH, TRIANGLES] = Array(12).keys();
const TYPE_NAMES = ["ARROW", "CUBE", "SPHERE", "CYLINDER", "LINE_STRIP", "LINE_LIST", "CUBE_LIST", "SPHERE_LIST", "POINTS", "TEXT_VIEW_FACING", "MESH_RESOURCE", "TRIANGLE_LIST"];
const CUBE_SHAPE = new THREE.BoxGeometry(1, 1, 1);
const SPHERE_SHAPE = new THREE.SphereGeometry(0.5, 20, 14);
const CYLINDER_SHAPE = new THREE.CylinderGeometry(0.5, 0.5, 1, 24).rotateX(Math.PI / 2);
const SHARED_SHAPES = new Set([CUBE_SHAPE, SPHERE_SHAPE, CYLINDER_SHAPE]);
const LIST_TYPES = new Set([LINE_STRIP, LINE_LIST, CUBE_LIST, SPHERE_LIST, POINTS, TRIANGLES]);
const HEAD_LENGTH = 0.23; // fraction of an arrow's length
const TEXT_SCALE = 0.82; // the size of rviz's letters at scale.z 1
const MIN_SIZE = 1e-6; // minimum size, so that the matrix of a flat marker can be inverted
const MAX_NAMESPACES = 50;
const MAX_FAULTS = 20;

// Return why neither this page nor rviz draws a marker; empty if it is drawn.
export function faultOf({ type, scale, finite = true, points: { length: points }, colors: { length: colours } }) {
  if (!finite) return "some of its numbers are not finite, or too large";
  const sizes = { [LINE_STRIP]: [0], [LINE_LIST]: [0], [POINTS]: [0, 1], [TEXT]: [2] }[type];
  const needed = sizes || (type === ARROW && !points ? [0, 1] : []);
  const none = needed.find((axis) => (sizes && type !== POINTS ? !(scale[axis] > 0) : !scale[axis]));
  if (none !== undefined) return `scale.${"xyz"[none]} is ${scale[none]}`;
  if ((type === POINTS || type === SPHERE_LIST) && scale[0] * scale[1] < 0) return "its points are seen from behind: one of scale.x and scale.y is negative";
  if (!sizes && scale.slice(0, type === ARROW ? 2 : 3).every((size) => !size)) return "its scale is 0";
  if (type === ARROW && points && points !== 2) return `an arrow has two points or none, not ${points}`;
  if (type === LINE_LIST && points % 2) return `${points} points are not pairs`;
  if (type === TRIANGLES && points % 3) return `${points} points are not triples`;
  const fits = colours === 0 || colours === points || (type === TRIANGLES && colours === points / 3);
  if (LIST_TYPES.has(type) && !fits) return `it has ${colours} colors, but ${points} points`;
  return "";
}

// Return an object for a marker, or null for an unknown type.
// host: {token, changed(), failed(text)}; meshes are loaded from the server asynchronously.
export function markerObject(marker, host) {
  const { type, scale, color } = marker;
  const fault = faultOf(marker);
  if (fault) {
    host.failed(fault);
    return null;
  }
  if (type === ARROW) return arrowMarker(marker);
  if (type === CUBE || type === SPHERE || type === CYLINDER) {
    const mesh = new THREE.Mesh({ [CUBE]: CUBE_SHAPE, [SPHERE]: SPHERE_SHAPE, [CYLINDER]: CYLINDER_SHAPE }[type], solidMaterial(color));
    mesh.scale.fromArray(scale.map((size) => Math.abs(size) || MIN_SIZE));
    return mesh;
  }
  if (type === LINE_STRIP || type === LINE_LIST) return linesMarker(marker);
  if (type === CUBE_LIST || type === SPHERE_LIST) return instancesMarker(marker, type === CUBE_LIST ? CUBE_SHAPE : SPHERE_SHAPE);
  if (type === POINTS) return pointsMarker(marker);
  if (type === TEXT) {
    const text = label(marker.text, { height: TEXT_SCALE * scale[2], color });
    if (text.userData.missing) host.failed("too many text markers to draw them all");
    return text;
  }
  if (type === TRIANGLES) return trianglesMarker(marker);
  if (type === MESH) return meshMarker(marker, host);
  return null;
}

function meshMarker({ mesh: uri, materials, scale, color }, { token, changed, failed }) {
  const object = new THREE.Group();
  object.scale.fromArray(scale.map((size) => size || MIN_SIZE));
  meshOf(uri, token).then((found) => {
    const tint = color.some((value) => value !== 0) ? color : null; // 0, 0, 0, 0: use the mesh's own colours
    found.traverse((each) => {
      if (!each.isMesh) return;
      if (!materials || (tint && found.userData.bare)) {
        each.material = solidMaterial(color, { side: THREE.DoubleSide });
        return;
      }
      const copies = [each.material].flat().map((material) => material.clone());
      if (tint) for (const material of copies) tintMaterial(material, tint);
      each.material = copies.length === 1 ? copies[0] : copies;
    });
    object.add(found);
    changed();
  }, (error) => failed(error.message));
  return object;
}

// rviz draws a mesh with its own materials, and again in the marker's color: half of each if that color is opaque.
function tintMaterial(material, [red, green, blue, alpha]) {
  const opacity = alpha < 1 ? 1 - (1 - alpha) ** 2 : 1;
  const share = alpha < 1 ? 1 / (2 - alpha) : 0.5;
  const tint = new THREE.Color().setRGB(red, green, blue, THREE.SRGBColorSpace);
  if (material.map && material.emissive) { // a texture has more than one colour
    material.color.multiplyScalar(1 - share);
    material.emissive.copy(tint.multiplyScalar(share));
  } else material.color.convertLinearToSRGB().lerp(tint.convertLinearToSRGB(), share).convertSRGBToLinear();
  material.opacity *= opacity;
  Object.assign(material, { transparent: material.opacity < 1, depthWrite: material.opacity >= 1 });
}

// Dispose of a marker, but not of the shared shapes.
export function disposeMarker(object) {
  object.traverse((each) => {
    if (SHARED_SHAPES.has(each.geometry)) each.geometry = undefined;
  });
  dispose(object);
}

function solidMaterial([red, green, blue, alpha], more = {}) {
  return new THREE.MeshLambertMaterial({
    color: new THREE.Color(red, green, blue).convertSRGBToLinear(), opacity: alpha, transparent: alpha < 1, depthWrite: alpha > 0.99, ...more,
  });
}

function arrowMarker({ points: ends, scale, color }) {
  const material = solidMaterial(color);
  const group = new THREE.Group();
  if (ends.length) { // from one point to another: shaft diameter, head diameter and head length
    const from = new THREE.Vector3(...ends[0]);
    const to = new THREE.Vector3(...ends[1]);
    const length = from.distanceTo(to);
    const head = scale[2] ? Math.min(Math.max(scale[2], 0), length) : length * HEAD_LENGTH;
    const arrow = arrowOf(length, head, Math.abs(scale[0]), head > 0 ? Math.abs(scale[1]) : 0, material);
    arrow.position.copy(from);
    if (length > 0) arrow.quaternion.setFromUnitVectors(new THREE.Vector3(1, 0, 0), to.sub(from).normalize());
    group.add(arrow);
  } else { // of length 1, as wide as it is long
    const arrow = arrowOf(1, HEAD_LENGTH, 1, 2, material);
    arrow.scale.fromArray(scale.map((size) => size || MIN_SIZE));
    group.add(arrow);
  }
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

// Return the colour of each point.
function coloursOf({ colors, color, points: { length } }) {
  return colors.length ? colors : Array(length).fill(color);
}

// Return colours with another alpha.
function withAlpha(colours, opacity) {
  return colours.map(([red, green, blue, alpha]) => [red, green, blue, opacity(alpha)]);
}

function positionsOf(marker) {
  return Float32Array.from(marker.points.flat());
}

function colourBytes(colours, [red, green, blue] = [0, 1, 2]) {
  const numbers = new Uint8Array(4 * colours.length);
  colours.forEach((colour, index) => numbers.set([colour[red], colour[green], colour[blue], colour[3]].map((value) => Math.round(255 * value)), 4 * index));
  return numbers;
}

// Return colours with alpha in three.js's linear colour space.
function linearColours(colours) {
  const numbers = new Float32Array(4 * colours.length);
  colours.forEach(([red, green, blue, alpha], index) => {
    const { r, g, b } = new THREE.Color(red, green, blue).convertSRGBToLinear();
    numbers.set([r, g, b, alpha], 4 * index);
  });
  return numbers;
}

// Interpolate colours as they are displayed, like rviz, not in three.js's linear colour space.
function interpolateAsDisplayed(material) {
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader.replace("#include <color_vertex>", "#include <color_vertex>\nvColor.rgb = pow(vColor.rgb, vec3(1.0 / 2.2));");
    shader.fragmentShader = shader.fragmentShader.replace("#include <color_fragment>", "diffuseColor *= vec4(pow(vColor.rgb, vec3(2.2)), vColor.a);");
  };
  return material;
}

function transparency(colours) {
  const through = colours.some(([, , , alpha]) => alpha < 1);
  return { vertexColors: true, transparent: through, depthWrite: !through };
}

// Like rviz: points of lines are transparent only if the marker's color is, too.
function linesMarker(marker) {
  const { points: { length }, color } = marker;
  const colours = color[3] < 1 ? coloursOf(marker) : withAlpha(coloursOf(marker), () => 1);
  return ribbons(positionsOf(marker), colourBytes(colours), marker.scale[0], marker.type === LINE_STRIP ? [[0, length]] : pairs(length));
}

function pointsMarker(marker) {
  const dots = new PointSet();
  dots.setStyle({ style: "squares", extent: [Math.abs(marker.scale[0]), Math.abs(marker.scale[1]), 1] });
  dots.set(positionsOf(marker), "rgba", colourBytes(coloursOf(marker), [2, 1, 0]));
  dots.enablePicking();
  return dots.object;
}

function instancesMarker(marker, shape) {
  const colours = coloursOf(marker);
  const geometry = shape.clone();
  geometry.setAttribute("color", new THREE.InstancedBufferAttribute(linearColours(colours), 4));
  const mesh = new THREE.InstancedMesh(geometry, solidMaterial([1, 1, 1, 1], transparency(colours)), marker.points.length);
  const matrix = new THREE.Matrix4();
  const [x, y, z] = marker.scale.map((size) => Math.abs(size) || MIN_SIZE);
  marker.points.forEach((point, index) => mesh.setMatrixAt(index, matrix.makeScale(x, y, z).setPosition(point[0], point[1], point[2])));
  mesh.frustumCulled = false;
  return mesh;
}

// Either each corner or each triangle has a colour. Like rviz: corner colours are transparent if one of them is, triangle
// colours if the marker's color is; in both cases, the marker's alpha is then applied as well.
function trianglesMarker(marker) {
  const { colors, color, points: corners, scale } = marker;
  const faces = colors.length === corners.length / 3 && colors.length > 0;
  let colours = faces ? corners.map((_, index) => colors[Math.floor(index / 3)]) : coloursOf(marker);
  if (colors.length) colours = withAlpha(colours, (faces ? [color] : colors).some(([, , , alpha]) => alpha < 1) ? (alpha) => alpha * color[3] : () => 1);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positionsOf(marker), 3));
  geometry.setAttribute("color", new THREE.BufferAttribute(linearColours(colours), 4));
  geometry.computeVertexNormals();
  const material = solidMaterial([1, 1, 1, 1], { ...transparency(colours), side: THREE.DoubleSide });
  const mesh = new THREE.Mesh(geometry, interpolateAsDisplayed(material));
  mesh.scale.fromArray(scale.map((size) => size || MIN_SIZE));
  return mesh;
}

// Return whether a marker is invisible because its color.a is 0.
function isUnseen({ type, color, colors, materials }) {
  return color[3] === 0 && !(LIST_TYPES.has(type) && colors.length) && !(type === MESH && materials);
}

// The markers of a topic.
export class MarkerSet {
  // host: {token, changed()}
  constructor(host) {
    this.object = new THREE.Group();
    this.known = new Map();
    this.namespaces = new Set();
    this.faults = new Map(); // key of a marker -> why it is not drawn
    this.invisible = new Set(); // keys of transparent markers
    this.host = host;
  }

  // Apply data of the view scene_topic.
  update({ new: added, gone, poses, all }) {
    if (all) for (const key of [...this.known.keys()]) this._remove(key);
    for (const [ns, id] of gone) this._remove(`${ns}\n${id}`);
    for (const marker of added) {
      const key = `${marker.ns}\n${marker.id}`;
      this._remove(key);
      if (this.namespaces.size < MAX_NAMESPACES) this.namespaces.add(marker.ns);
      const frame = poses[marker.frame];
      const object = frame && markerObject(marker, { ...this.host, failed: (text) => this._failed(key, marker, text) });
      if (!object) continue;
      if (isUnseen(marker)) this.invisible.add(key);
      const outer = new THREE.Group();
      const inner = new THREE.Group();
      outer.userData.ns = marker.ns;
      outer.userData.facts = marker;
      if (marker.locked) outer.userData.frame = marker.frame;
      setPose(outer, frame);
      setPose(inner, marker.pose);
      inner.add(object);
      outer.add(inner);
      this.object.add(outer);
      this.known.set(key, outer);
    }
  }

  // Show only some namespaces: options are {"ns:NAME": visible}.
  show(options) {
    for (const outer of this.known.values()) outer.visible = options[`ns:${outer.userData.ns}`] ?? true;
  }

  // Move the markers that are locked to a frame.
  place(frames) {
    for (const outer of this.known.values()) {
      const pose = outer.userData.frame && frames.pose(outer.userData.frame);
      if (pose) setPose(outer, pose);
    }
  }

  // Return what can be selected; see select_tool.js.
  parts() {
    return [...this.known.values()].map((outer) => {
      const { ns, id, type, frame, text, points: { length } } = outer.userData.facts;
      const rows = [["namespace", ns], ["id", id], ["type", TYPE_NAMES[type] || type], ["frame", frame]];
      if (text) rows.push(["text", text]);
      if (length) rows.push(["points", length]);
      return { object: outer, about: () => [...rows, ...poseRows(outer.children[0])] };
    });
  }

  get count() {
    return this.known.size;
  }

  _failed(key, { ns, id }, text) {
    if (this.faults.size < MAX_FAULTS) this.faults.set(key, `marker ${ns ? `${ns}/` : ""}${id}: ${text}`);
    this.host.changed("words");
  }

  _remove(key) {
    this.faults.delete(key);
    this.invisible.delete(key);
    const object = this.known.get(key);
    if (!object) return;
    this.known.delete(key);
    this.object.remove(object);
    disposeMarker(object);
  }
}
