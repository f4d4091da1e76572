// Lines that face the camera, with a width in metres, like rviz's markers and "billboards", or in pixels. They consist of
// triangles: software renderers omit lines near the camera if some of them end behind it.

import * as THREE from "../../vendor/three/three.module.min.js";

const VERTEX_SHADER = `
  attribute vec3 along;
  attribute float side;
  attribute vec4 colour;
  uniform float width;
  uniform float pixels;
  uniform float high;
  varying vec4 shade;
  void main() {
    shade = colour;
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    vec3 across = cross(mat3(modelViewMatrix) * along, isOrthographic ? vec3(0.0, 0.0, 1.0) : -place.xyz);
    float size = length(across);
    float metres = width;
    if (pixels > 0.0) metres = pixels * 2.0 * (isOrthographic ? 1.0 : -place.z) / (projectionMatrix[1][1] * high);
    if (size > 0.0) place.xyz += across / size * side * metres;
    gl_Position = projectionMatrix * place;
  }`;
const FRAGMENT_SHADER = `
  varying vec4 shade;
  void main() { gl_FragColor = shade; }`;

// places: Float32Array of x, y, z. colours: Uint8Array of red, green, blue and alpha for each place. width: in metres, or in
// pixels if that is the unit.
// given: chains [[start, end]] of indices of connected places.
export function ribbons(places, colours, width, given, unit = "metres") {
  // A line that becomes narrower than a pixel at a bend has gaps there, or vanishes: each part is drawn separately.
  const chains = unit === "pixels" ? given.flatMap(segments) : given;
  const count = chains.reduce((sum, [start, end]) => sum + end - start, 0);
  const positions = new Float32Array(6 * count);
  const ways = new Float32Array(6 * count);
  const sides = new Float32Array(2 * count);
  const shades = new Uint8Array(8 * count);
  const corners = [];
  const spine = [];
  let at = 0;
  for (const [start, end] of chains) {
    for (let index = start; index < end; index += 1, at += 1) {
      const [before, after] = [Math.max(start, index - 1), Math.min(end - 1, index + 1)];
      const way = [0, 1, 2].map((axis) => places[3 * after + axis] - places[3 * before + axis]);
      for (const half of [0, 1]) {
        positions.set(places.subarray(3 * index, 3 * index + 3), 6 * at + 3 * half);
        ways.set(way, 6 * at + 3 * half);
        shades.set(colours.subarray(4 * index, 4 * index + 4), 8 * at + 4 * half);
        sides[2 * at + half] = half - 0.5;
      }
      if (index === start) continue;
      corners.push(2 * at - 2, 2 * at - 1, 2 * at, 2 * at, 2 * at - 1, 2 * at + 1);
      spine.push(2 * at - 2, 2 * at);
    }
  }
  const geometry = new THREE.BufferGeometry().setIndex(corners);
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute("along", new THREE.BufferAttribute(ways, 3));
  geometry.setAttribute("side", new THREE.BufferAttribute(sides, 1));
  geometry.setAttribute("colour", new THREE.BufferAttribute(shades, 4, true));
  geometry.userData.spine = new THREE.BufferGeometry().setIndex(spine).setAttribute("position", geometry.getAttribute("position"));
  const uniforms = { width: { value: width }, pixels: { value: unit === "pixels" ? width : 0 }, high: { value: 1 } };
  return new Ribbons(geometry, new THREE.ShaderMaterial({
    vertexShader: VERTEX_SHADER, fragmentShader: FRAGMENT_SHADER, uniforms, side: THREE.DoubleSide, transparent: isTransparent(colours), depthWrite: !isTransparent(colours),
  }));
}

const seen = new THREE.Vector4();

// Ribbons count as lines, though they are meshes.
export class Ribbons extends THREE.Mesh {
  constructor(geometry, material) {
    super(geometry, material);
    this.frustumCulled = false;
  }

  onBeforeRender(renderer) {
    /** @type {THREE.ShaderMaterial} */ (this.material).uniforms.high.value = renderer.getCurrentViewport(seen).w / renderer.getPixelRatio();
  }

  // Hit the line in the middle: the sides are known only to the graphics card.
  raycast(caster, hits) {
    const middle = new THREE.LineSegments(this.geometry.userData.spine);
    middle.matrixWorld.copy(this.matrixWorld);
    const from = hits.length;
    middle.raycast(caster, hits);
    for (const hit of hits.slice(from)) hit.object = this;
  }
}

// Return whether any of the colours is transparent.
export function isTransparent(colours) {
  for (let index = 3; index < colours.length; index += 4) if (colours[index] < 255) return true;
  return false;
}

// Return one colour for many places. colour: a THREE.Color, or CSS.
export function repeatColour(colour, alpha, count) {
  const { r, g, b } = colour.isColor ? colour.clone().convertLinearToSRGB() : new THREE.Color().setStyle(colour, THREE.LinearSRGBColorSpace);
  const bytes = new Uint8Array(4 * count);
  for (let index = 0; index < count; index += 1) bytes.set([r, g, b, alpha].map((value) => Math.round(255 * value)), 4 * index);
  return bytes;
}

// Split a chain into chains of two neighbours each.
function segments([start, end]) {
  return Array.from({ length: Math.max(0, end - start - 1) }, (_, index) => [start + index, start + index + 2]);
}

// Return chains of two places each.
export function pairs(count) {
  return Array.from({ length: count / 2 }, (_, index) => [2 * index, 2 * index + 2]);
}
