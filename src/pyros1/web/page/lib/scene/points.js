// Clouds and scans as points. Places and values go to the graphics card as they come; its shader makes the colours.

import * as THREE from "../../vendor/three/three.module.min.js";

// Return the positions of a scan, what to colour them by, and which of the ranges they are: [Float32Array of x, y, z,
// Float32Array of values, Uint32Array of indices].
export function scanPoints(facts, numbers) {
  const { start, step, count, intensities } = facts;
  const [least, most] = [facts.least ?? 0, facts.most ?? Number.MAX_VALUE]; // null: without an end
  const positions = new Float32Array(3 * count);
  const values = new Float32Array(count);
  const indices = new Uint32Array(count);
  let kept = 0;
  for (let index = 0; index < count; index += 1) {
    const range = numbers[index];
    if (!(range >= least && range <= most)) continue;
    const angle = start + index * step;
    positions[3 * kept] = range * Math.cos(angle);
    positions[3 * kept + 1] = range * Math.sin(angle);
    values[kept] = intensities ? numbers[count + index] : range;
    indices[kept] = index;
    kept += 1;
  }
  return [positions.subarray(0, 3 * kept), values.subarray(0, kept), indices.subarray(0, kept)];
}

// Values as bytes, from the least (0) to the greatest (255).
export function levels(values) {
  let [least, most] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < least) least = value;
    if (value > most && value < Infinity) most = value;
  }
  const scale = most > least ? 255 / (most - least) : 0;
  return Uint8Array.from(values, (value) => Math.min(255, (value - least) * scale));
}

const VERTEX = `
  attribute float level;
  attribute vec4 bgr;
  uniform float size;
  uniform int mode; // 0: packed colours, 1: levels, 2: height, 3: one colour
  uniform vec3 tint;
  uniform vec2 bounds;
  varying vec3 shade;
  vec3 rainbow(float place) { // violet to red, as rviz has it
    float turn = (1.0 - clamp(place, 0.0, 1.0)) * 5.0;
    float part = fract(turn);
    if (turn < 1.0) return vec3(1.0, part, 0.0);
    if (turn < 2.0) return vec3(1.0 - part, 1.0, 0.0);
    if (turn < 3.0) return vec3(0.0, 1.0, part);
    if (turn < 4.0) return vec3(0.0, 1.0 - part, 1.0);
    if (turn < 5.0) return vec3(part, 0.0, 1.0);
    return vec3(1.0, 0.0, 1.0);
  }
  void main() {
    if (mode == 0) shade = bgr.zyx;
    else if (mode == 1) shade = rainbow(level);
    else if (mode == 3) shade = tint;
    else shade = rainbow(bounds.y > bounds.x ? (position.z - bounds.x) / (bounds.y - bounds.x) : 0.0);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_PointSize = size;
  }`;
const FRAGMENT = `
  varying vec3 shade;
  uniform float alpha;
  void main() { gl_FragColor = vec4(shade, alpha); }`;
const MODES = { rgb: 0, value: 1, z: 2 };

// Points that keep their room on the graphics card while their number changes.
export class PointSet {
  constructor(size = 3) {
    this.material = new THREE.ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT,
      uniforms: { size: { value: size }, alpha: { value: 1 }, mode: { value: 1 }, tint: { value: new THREE.Color() }, bounds: { value: new THREE.Vector2(0, 1) } },
    });
    this.object = new THREE.Points(new THREE.BufferGeometry(), this.material);
    this.object.frustumCulled = false;
    this.object.userData.bound = () => this._bound();
    this.mode = 1;
    this.one = false;
  }

  set size(pixels) {
    this.material.uniforms.size.value = pixels * Math.min(2, globalThis.devicePixelRatio || 1);
  }

  set alpha(alpha) {
    this.material.uniforms.alpha.value = alpha;
    this.material.transparent = alpha < 1;
  }

  // One colour for all, or null for those that they have.
  set flat(colour) {
    const { mode, tint } = this.material.uniforms;
    this.one = colour !== null;
    mode.value = this.one ? 3 : this.mode;
    if (this.one) tint.value.setStyle(colour, THREE.LinearSRGBColorSpace); // the shader's colours are as they are shown
  }

  // positions: Float32Array of x, y, z. colour: "rgb" with bytes (blue, green, red, anything), "value" with bytes, or
  // "z" with none. bounds: [least, most] height.
  set(positions, colour, bytes, bounds = [0, 1]) {
    const count = positions.length / 3;
    this._put("position", positions, 3, false);
    if (colour === "rgb") this._put("bgr", bytes, 4, true);
    if (colour === "value") this._put("level", bytes, 1, true);
    this.mode = MODES[colour];
    if (!this.one) this.material.uniforms.mode.value = this.mode;
    this.material.uniforms.bounds.value.set(...bounds);
    this.object.geometry.setDrawRange(0, count);
  }

  // Room is made for some more, so that a cloud whose size changes a little keeps it.
  _put(name, numbers, size, normalized) {
    const { geometry } = this.object;
    let attribute = geometry.getAttribute(name);
    if (!attribute || attribute.array.length < numbers.length || attribute.array.length > 4 * numbers.length + 4096) {
      attribute = new THREE.BufferAttribute(new numbers.constructor(Math.ceil(numbers.length / size * 1.1) * size), size, normalized);
      attribute.setUsage(THREE.StreamDrawUsage);
      if (geometry.hasAttribute(name)) geometry.dispose();
      geometry.setAttribute(name, attribute);
    }
    attribute.array.set(numbers);
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(0, numbers.length);
    attribute.needsUpdate = true;
  }

  // Say what room they take; what is kept of larger clouds does not count, nor do points without a place.
  _bound() {
    const { positions, count } = this.places;
    const box = new THREE.Box3();
    const point = new THREE.Vector3();
    for (let index = 0; index < count; index += 1) {
      point.fromArray(positions, 3 * index);
      if (Number.isFinite(point.x + point.y + point.z)) box.expandByPoint(point);
    }
    this.object.geometry.boundingBox = box;
  }

  // Where they are: {positions, count}.
  get places() {
    const { geometry } = this.object;
    return { positions: geometry.getAttribute("position")?.array || [], count: geometry.drawRange.count };
  }
}
