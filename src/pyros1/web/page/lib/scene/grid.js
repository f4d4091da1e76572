// The grid on the ground plane of the fixed frame.

import * as THREE from "../../vendor/three/three.module.min.js";
import { pairs, ribbons, repeatColour } from "./ribbons.js";
import { dispose } from "./stage.js";

const PLANE_ROTATIONS = { xy: [0, 0], xz: [Math.PI / 2, 0], yz: [0, -Math.PI / 2] }; // about x and y

export class Grid {
  constructor() {
    this.object = new THREE.Group();
    this.page = [new THREE.Color(), new THREE.Color()]; // its colours of the lines: those in the middle, and the others
    this.status = "";
    this.problem = "";
    this.controls = {
      count: { text: "cells", kind: "number", defaultValue: 20, least: 1, most: 200, step: 1 },
      cell: { text: "cell size", kind: "number", defaultValue: 1, least: 0.01, most: 1000, step: 0.1 },
      flat: { text: "single colour", kind: "check", defaultValue: false },
      tint: { text: "colour", kind: "colour", defaultValue: "#a0a0a4" },
      alpha: { text: "opacity", kind: "number", defaultValue: 1, least: 0, most: 1, step: 0.05 },
      line: { text: "lines", kind: "choice", defaultValue: "pixel", choices: ["pixel", "metres"] },
      width: { text: "their width", kind: "number", defaultValue: 0.03, least: 0.001, most: 100, step: 0.01 },
      plane: { text: "plane", kind: "choice", defaultValue: "xy", choices: Object.keys(PLANE_ROTATIONS) },
      ...Object.fromEntries(["x", "y", "z"].map((axis) => [axis, { text: `offset ${axis}`, kind: "number", defaultValue: 0, least: -1e6, most: 1e6, step: 0.1 }])),
    };
    /** @type {Record<string, any>} */
    this.options = Object.fromEntries(Object.entries(this.controls).map(([key, { defaultValue }]) => [key, defaultValue]));
  }

  // Set the page's colours for the lines in the middle and the others.
  colours(middle, others) {
    this.page = [middle, others];
    this._draw();
  }

  set(options) {
    Object.assign(this.options, options);
    this._draw();
  }

  show(visible) {
    this.object.visible = visible;
  }

  close() {
    this._clear();
  }

  _draw() {
    this._clear();
    const { flat, tint, line, plane } = this.options;
    const value = (name) => clampOption(this.options[name], this.controls[name]); // links are untrusted input
    const count = Math.round(value("count"));
    const size = count * value("cell");
    const [middle, others] = flat ? [tint, tint].map((each) => new THREE.Color(each)) : this.page;
    const { places, colours } = linesOf(count, size, middle, others, value("alpha"));
    const broad = line === "metres";
    this.object.add(ribbons(places, colours, broad ? value("width") : 1, pairs(places.length / 3), broad ? "metres" : "pixels"));
    const [about, over] = PLANE_ROTATIONS[plane] || PLANE_ROTATIONS.xy;
    this.object.rotation.set(about, over, 0);
    this.object.position.set(value("x"), value("y"), value("z"));
    this.status = `${Number(size.toPrecision(4))} m`;
  }

  _clear() {
    for (const each of [...this.object.children]) {
      this.object.remove(each);
      dispose(each);
    }
  }
}

function clampOption(/** @type {any} */ value, { least, most, defaultValue }) {
  return Number.isFinite(value) ? Math.min(most, Math.max(least, value)) : defaultValue;
}

// Return the ends of the lines, and their colours. The middle lines come last, so that they are drawn over the others.
function linesOf(count, size, middle, others, alpha) {
  const rows = Array.from({ length: count + 1 }, (_, row) => row / count - 0.5).sort((one, other) => Math.abs(other) - Math.abs(one));
  const half = size / 2;
  const places = rows.flatMap((row) => [-half, row * size, 0, half, row * size, 0, row * size, -half, 0, row * size, half, 0]);
  const colours = new Uint8Array(rows.length * 16);
  rows.forEach((row, index) => colours.set(repeatColour(row === 0 ? middle : others, alpha, 4), 16 * index));
  return { places: Float32Array.from(places), colours };
}
