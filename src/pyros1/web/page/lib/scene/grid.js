// The grid on the ground of the fixed frame.

import * as THREE from "../../vendor/three/three.module.min.js";

export class Grid {
  constructor() {
    this.object = new THREE.Group();
    this.word = "";
    this.problem = "";
    this.controls = {
      count: { text: "cells", kind: "number", usual: 20, least: 1, most: 200, step: 1 },
      cell: { text: "size of a cell", kind: "number", usual: 1, least: 0.01, most: 1000, step: 0.1 },
      flat: { text: "one colour", kind: "check", usual: false },
      tint: { text: "colour", kind: "colour", usual: "#a0a0a4" },
    };
    this.options = Object.fromEntries(Object.entries(this.controls).map(([key, { usual }]) => [key, usual]));
  }

  // Colours of the page, of the lines in the middle and of the others.
  colours(middle, others) {
    this.page = [middle, others];
    this._draw();
  }

  set(options) {
    Object.assign(this.options, options);
    this._draw();
  }

  show(shown) {
    this.object.visible = shown;
  }

  close() {
    this._clear();
  }

  _draw() {
    this._clear();
    const { flat, tint } = this.options;
    const count = Math.round(within(this.options.count, this.controls.count)); // a link may say anything
    const size = count * within(this.options.cell, this.controls.cell);
    const lines = new THREE.GridHelper(size, count, ...(flat ? [tint, tint] : this.page));
    lines.rotateX(Math.PI / 2);
    this.object.add(lines);
    this.word = `${Number(size.toPrecision(4))} m`;
  }

  _clear() {
    for (const each of [...this.object.children]) {
      this.object.remove(each);
      each.dispose();
    }
  }
}

function within(value, { least, most, usual }) {
  return Number.isFinite(value) ? Math.min(most, Math.max(least, value)) : usual;
}
