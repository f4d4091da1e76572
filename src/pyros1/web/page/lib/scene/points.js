// Clouds and scans as points. Positions and values are sent to the graphics card unchanged; a shader computes the colours.
// Points are pixels, or have a size in metres: then each is a square or a disc that faces the camera, or a box.

import * as THREE from "../../vendor/three/three.module.min.js";
import { isTransparent } from "./ribbons.js";

// Return the points of a scan: [Float32Array of x, y, z, Float32Array of the values that colour them (the ranges if by is
// "range"), Uint32Array of the indices of their ranges].
export function scanPoints(facts, numbers, by = "") {
  const { start, step, count, intensities } = facts;
  const [least, most] = [facts.least ?? 0, facts.most ?? Number.MAX_VALUE]; // null: unlimited
  const positions = new Float32Array(3 * count);
  const values = new Float32Array(count);
  const indices = new Uint32Array(count);
  let kept = 0;
  for (let index = 0; index < count; index += 1) {
    const range = numbers[index];
    if (!(range >= least && range < most)) continue; // like rviz, which excludes the maximum
    const angle = start + index * step;
    positions[3 * kept] = range * Math.cos(angle);
    positions[3 * kept + 1] = range * Math.sin(angle);
    values[kept] = intensities && by !== "range" ? numbers[count + index] : range;
    indices[kept] = index;
    kept += 1;
  }
  return [positions.subarray(0, 3 * kept), values.subarray(0, kept), indices.subarray(0, kept)];
}

// Scale values to bytes, from the minimum (0) to the maximum (255), or between given bounds.
export function levels(values, /** @type {number[] | null} */ bounds = null) {
  const [least, most] = bounds || extent(values);
  const scale = bounds && most < least || most > least ? 255 / (most - least) : 0;
  return Uint8Array.from(values, (value) => Math.min(255, Math.max(0, (value - least) * scale)));
}

function extent(values) {
  let [least, most] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < least) least = value;
    if (value > most && value < Infinity) most = value;
  }
  return [least, most];
}

const VERTEX_SHADER = `
  attribute float level;
  attribute vec4 bgr;
  uniform float size;
  uniform int mode; // 0: packed colours, 1: levels, 2: along an axis, 3: one colour, 4: packed colours with alpha
  uniform vec3 tint;
  uniform float alpha;
  uniform vec4 axis;
  uniform vec2 bounds;
  uniform bool rainbow;
  uniform bool inverted;
  uniform vec3 low;
  uniform vec3 high;
  varying vec4 shade;
  vec3 ramp(float place) { // red to violet, like rviz's
    float part = clamp(place, 0.0, 1.0);
    if (!rainbow) return mix(low, high, part);
    float turn = (inverted ? 1.0 - part : part) * 5.0;
    float rest = fract(turn);
    if (turn < 1.0) return vec3(1.0, rest, 0.0);
    if (turn < 2.0) return vec3(1.0 - rest, 1.0, 0.0);
    if (turn < 3.0) return vec3(0.0, 1.0, rest);
    if (turn < 4.0) return vec3(0.0, 1.0 - rest, 1.0);
    if (turn < 5.0) return vec3(rest, 0.0, 1.0);
    return vec3(1.0, 0.0, 1.0);
  }
  vec3 colour(vec3 place) {
    if (mode == 0 || mode == 4) return bgr.zyx;
    if (mode == 1) return ramp(level);
    if (mode == 3) return tint;
    return ramp(bounds.y != bounds.x ? (dot(axis, vec4(place, 1.0)) - bounds.x) / (bounds.y - bounds.x) : 0.0);
  }
  #ifdef SOLID
  attribute vec3 place;
  uniform vec3 extent;
  uniform bool facing;
  varying vec2 inside;
  void main() {
    shade = vec4(colour(place), mode == 4 ? alpha * bgr.w : alpha);
    inside = position.xy * 2.0;
    if (facing) {
      vec4 middle = modelViewMatrix * vec4(place, 1.0);
      middle.xy += position.xy * extent.xy;
      gl_Position = projectionMatrix * middle;
    } else {
      gl_Position = projectionMatrix * modelViewMatrix * vec4(place + position * extent, 1.0);
      shade.rgb *= dot(abs(normal), vec3(0.6, 0.45, 0.9)); // like rviz's: each side has its own brightness
    }
  }
  #else
  void main() {
    shade = vec4(colour(position), mode == 4 ? alpha * bgr.w : alpha);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_PointSize = size;
  }
  #endif`;
const FRAGMENT_SHADER = `
  varying vec4 shade;
  #ifdef SOLID
  uniform bool disc;
  varying vec2 inside;
  #endif
  void main() {
    gl_FragColor = shade;
    #ifdef SOLID
    float far = dot(inside, inside);
    if (disc && far > 1.0) discard;
    if (disc) gl_FragColor.rgb *= 0.7 + 0.3 * sqrt(max(0.0, 1.0 - far));
    #endif
  }`;
const MODES = { rgb: 0, value: 1, x: 2, y: 2, z: 2, rgba: 4 };
const AXES = ["x", "y", "z"];
export const STYLES = ["pixels", "squares", "spheres", "boxes"];
const COLOUR_ATTRIBUTES = { rgb: ["bgr", 4], rgba: ["bgr", 4], value: ["level", 1] };

/**
 * @typedef {object} Look
 * @property {string} [style]
 * @property {number} [size]
 * @property {number[]} [extent]
 * @property {number} [alpha]
 * @property {string | null} [flat]
 * @property {boolean} [rainbow]
 * @property {boolean} [inverted]
 * @property {string} [low]
 * @property {string} [high]
 * @property {number[] | null} [bounds]
 * @property {boolean} [local]
 */
/** @typedef {THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial> | THREE.Points<THREE.BufferGeometry, THREE.ShaderMaterial>} Body */

// Points whose buffers on the graphics card are reused while their number changes.
export class PointSet {
  constructor() {
    const values = {
      size: 3, alpha: 1, mode: 1, tint: new THREE.Color(), axis: new THREE.Vector4(), bounds: new THREE.Vector2(0, 1), rainbow: true, inverted: false,
      low: new THREE.Color(0, 0, 0), high: new THREE.Color(1, 1, 1), extent: new THREE.Vector3(1, 1, 1), facing: true, disc: false,
    };
    /** @type {Record<string, THREE.IUniform<any>>} */
    this.uniforms = Object.fromEntries(Object.entries(values).map(([name, value]) => [name, { value }]));
    this.object = new THREE.Group();
    this.object.userData.bound = () => this._computeBounds();
    this.colour = "value";
    this.isUniform = false;
    this.hasTransparentColours = false; // whether some of its colours are transparent
    this.style = "pixels";
    this.count = 0;
    this.attributes = new Map(); // name -> attribute
    this.mesh = this._build();
  }

  // style: one of STYLES; size: in pixels; extent: in metres; flat: one colour for all, or null for their own;
  // rainbow, inverted, low, high: the colour map; bounds: the range of an axis, or null for the range of the points;
  // local: whether an axis belongs to the points' own frame rather than to the fixed frame.
  setStyle(/** @type {Look} */ { style: wanted = this.style, size, extent: metres, alpha, flat, rainbow, inverted, low, high, bounds = null, local = false }) {
    const { uniforms } = this;
    const style = STYLES.includes(wanted) ? wanted : this.style;
    if (style !== this.style) {
      this.style = style;
      for (const [name, { array, itemSize, normalized }] of this.attributes) this.attributes.set(name, this._attribute(array, itemSize, normalized));
      this.mesh = this._build(this.mesh);
    }
    if (size !== undefined) uniforms.size.value = size * Math.min(2, globalThis.devicePixelRatio || 1);
    if (metres) uniforms.extent.value.set(...metres);
    uniforms.facing.value = style !== "boxes";
    uniforms.disc.value = style === "spheres";
    if (alpha !== undefined) this._setAlpha(alpha);
    if (rainbow !== undefined) Object.assign(uniforms.rainbow, { value: rainbow });
    if (inverted !== undefined) Object.assign(uniforms.inverted, { value: inverted });
    for (const [name, value] of Object.entries({ low, high, tint: flat })) if (value) uniforms[name].value.setStyle(value, THREE.LinearSRGBColorSpace); // the shader's colours are as they are shown
    if (flat !== undefined) this.isUniform = flat !== null;
    this.axisSettings = { bounds, local };
    uniforms.mode.value = this.isUniform ? 3 : MODES[this.colour];
    this.updateAxis();
  }

  // positions: Float32Array of x, y, z. colour: "rgb" or "rgba" with bytes (blue, green, red, and alpha or padding),
  // "value" with bytes, or "x", "y" or "z" without.
  set(positions, colour, bytes) {
    this.count = positions.length / 3;
    this.colour = colour;
    const [name, size] = COLOUR_ATTRIBUTES[colour] || [];
    for (const each of [...this.attributes.keys()]) if (each !== "place" && each !== name) this._drop(each);
    this._setAttribute("place", positions, 3, false);
    if (name) this._setAttribute(name, bytes, size, true);
    if (this.needsRebuild) this.mesh = this._build(this.mesh);
    const { geometry } = this.mesh;
    if (geometry instanceof THREE.InstancedBufferGeometry) geometry.instanceCount = this.count;
    else geometry.setDrawRange(0, this.count);
    this.hasTransparentColours = colour === "rgba" && isTransparent(bytes);
    this._setAlpha(this.uniforms.alpha.value);
    this.uniforms.mode.value = this.isUniform ? 3 : MODES[colour];
    this.updateAxis();
  }

  // Update colours along an axis after the points have moved in the fixed frame.
  updateAxis() {
    const axis = AXES.indexOf(this.colour);
    if (axis < 0 || this.isUniform) return;
    const row = new THREE.Vector4(0, 0, 0, 0).setComponent(axis, 1);
    const { bounds, local } = this.axisSettings || {};
    if (!local) {
      this.object.updateWorldMatrix(true, false);
      row.fromArray([0, 4, 8, 12].map((column) => this.object.matrixWorld.elements[column + axis]));
    }
    this.uniforms.axis.value.copy(row);
    this.uniforms.bounds.value.set(...(bounds || this._extentAlong(row)));
  }

  // Return their extent along an axis.
  _extentAlong({ x, y, z, w }) {
    const { positions, count } = this.places;
    let [least, most] = [Infinity, -Infinity];
    for (let at = 0; at < 3 * count; at += 3) {
      const value = x * positions[at] + y * positions[at + 1] + z * positions[at + 2] + w;
      if (value < least) least = value;
      if (value > most) most = value;
    }
    return least < most ? [least, most] : [0, 0];
  }

  _setAlpha(alpha) {
    this.uniforms.alpha.value = alpha;
    const { material } = this.mesh;
    material.transparent = alpha < 1 || this.hasTransparentColours;
    material.depthWrite = !material.transparent;
  }

  get solid() {
    return this.style !== "pixels";
  }

  _attribute(array, size, normalized) {
    const kind = this.solid ? THREE.InstancedBufferAttribute : THREE.BufferAttribute;
    return new kind(array, size, normalized).setUsage(THREE.StreamDrawUsage);
  }

  // Allocate some reserve, so that a cloud whose size varies a little can reuse its buffers.
  _setAttribute(name, numbers, size, normalized) {
    let attribute = this.attributes.get(name);
    if (!attribute || attribute.array.length < numbers.length || attribute.array.length > 4 * numbers.length + 4096) {
      attribute = this._attribute(new numbers.constructor(Math.ceil(numbers.length / size * 1.1) * size), size, normalized);
      this.attributes.set(name, attribute);
      this.needsRebuild = true;
    }
    attribute.array.set(numbers);
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(0, numbers.length);
    attribute.needsUpdate = true;
  }

  _drop(name) {
    this.attributes.delete(name);
    this.needsRebuild = true;
  }

  // Rebuild the object, for another style or larger buffers.
  _build(/** @type {Body | null} */ before = null) {
    this.needsRebuild = false;
    const { uniforms, solid } = this;
    const material = before && before.userData.solid === solid ? before.material : new THREE.ShaderMaterial({
      vertexShader: VERTEX_SHADER, fragmentShader: FRAGMENT_SHADER, uniforms, defines: solid ? { SOLID: "" } : {}, side: THREE.DoubleSide,
      transparent: before?.material.transparent || false, depthWrite: before?.material.depthWrite ?? true,
    });
    const geometry = solid ? new THREE.InstancedBufferGeometry() : new THREE.BufferGeometry();
    if (geometry instanceof THREE.InstancedBufferGeometry) {
      const body = this.style === "boxes" ? new THREE.BoxGeometry(1, 1, 1) : new THREE.PlaneGeometry(1, 1);
      geometry.setIndex(body.index).setAttribute("position", body.attributes.position).setAttribute("normal", body.attributes.normal);
      geometry.instanceCount = this.count;
    } else geometry.setDrawRange(0, this.count);
    for (const [name, attribute] of this.attributes) geometry.setAttribute(!solid && name === "place" ? "position" : name, attribute);
    /** @type {Body} */
    const mesh = solid ? new THREE.Mesh(geometry, material) : new THREE.Points(geometry, material);
    mesh.frustumCulled = false;
    mesh.userData.solid = solid;
    mesh.raycast = (caster, hits) => this.hit?.(caster, hits);
    if (before) {
      this.object.remove(before);
      before.geometry.dispose();
      if (before.material !== material) before.material.dispose();
    }
    this.object.add(mesh);
    return mesh;
  }

  // Let mouse rays hit the points; this is slow if there are many.
  enablePicking() {
    this._computeBounds();
    this.hit = (caster, hits) => {
      const { positions, count } = this.places;
      const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(positions, 3));
      geometry.setDrawRange(0, count);
      const dots = new THREE.Points(geometry);
      dots.matrixWorld.copy(this.object.matrixWorld);
      const from = hits.length;
      dots.raycast(caster, hits);
      for (const hit of hits.slice(from)) hit.object = this.mesh;
    };
  }

  // Compute the bounding box; unused parts of the buffers do not count, nor do points with NaN.
  _computeBounds() {
    const { positions, count } = this.places;
    const box = new THREE.Box3();
    const point = new THREE.Vector3();
    for (let index = 0; index < count; index += 1) {
      point.fromArray(positions, 3 * index);
      if (Number.isFinite(point.x + point.y + point.z)) box.expandByPoint(point);
    }
    this.mesh.geometry.boundingBox = box;
  }

  // Return the positions: {positions, count}.
  get places() {
    return { positions: this.attributes.get("place")?.array || [], count: this.count };
  }
}
