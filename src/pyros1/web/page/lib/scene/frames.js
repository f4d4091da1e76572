// Frames as axes with names, and lines to their parents.

import * as THREE from "../../vendor/three/three.module.min.js";
import { label } from "./label.js";
import { placed } from "./select.js";
import { dispose, put } from "./stage.js";

const HEIGHT = 0.12; // metres of a name
const LETTERS = 13; // pixels
const IDENTITY = [0, 0, 0, 0, 0, 0, 1];

export class FrameSet {
  constructor() {
    this.object = new THREE.Group();
    this.axes = new Map();
    this.lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xe0a000 }));
    this.lines.frustumCulled = false;
    this.object.add(this.lines);
    this.poses = new Map(); // name -> [x, y, z, qx, qy, qz, qw] in the fixed frame
    this.controls = {
      names: { text: "names", kind: "check", usual: true },
      axes: { text: "axes", kind: "check", usual: true },
      lines: { text: "lines to parents", kind: "check", usual: true },
      size: { text: "length of axes", kind: "number", usual: 0.3, least: 0.01, most: 100, step: 0.05 },
    };
    this.options = { names: true, axes: true, lines: true, size: 0.3 };
    this.word = "no frames yet";
    this.problem = "";
  }

  // Take a push of the view scene_frames.
  take({ fixed, names, parents }, blob) {
    this.fixed = fixed;
    const poses = new Float64Array(blob.buffer, blob.offset);
    const places = this.poses = new Map(names.map((name, index) => [name, poses.subarray(7 * index, 7 * index + 7)]));
    this.parents = new Map(names.map((name, index) => [name, parents[index]]));
    for (const [name, axes] of this.axes) {
      if (places.has(name)) continue;
      this.object.remove(axes);
      dispose(axes);
      this.axes.delete(name);
    }
    this.word = names.length ? `${names.length} frames` : "no frames yet";
    const ends = [];
    names.forEach((name, index) => {
      const pose = places.get(name);
      put(this._axes(name), pose);
      const parent = places.get(parents[index]);
      if (parent) ends.push(...pose.subarray(0, 3), ...parent.subarray(0, 3));
    });
    this.lines.geometry.dispose();
    this.lines.geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
  }

  _axes(name) {
    let axes = this.axes.get(name);
    if (!axes) {
      axes = new THREE.Group();
      axes.add(new THREE.AxesHelper(1));
      const text = label(name, { height: HEIGHT, color: [0.55, 0.55, 0.6, 1], onTop: true });
      text.userData.size = text.scale.clone();
      axes.add(text);
      this._look(axes);
      this.object.add(axes);
      this.axes.set(name, axes);
    }
    return axes;
  }

  // Names are no higher than letters of the page, however near one is. Called before each picture.
  face(stage) {
    for (const axes of this.axes.values()) {
      const name = axes.children[1];
      const size = Math.min(HEIGHT, LETTERS * stage.pixel(axes.position)) / HEIGHT;
      name.scale.copy(name.userData.size).multiplyScalar(size);
      name.position.z = 0.75 * HEIGHT * size;
    }
  }

  show(shown) {
    this.object.visible = shown;
  }

  close() {
    dispose(this.object);
  }

  // What can be selected; see select.js.
  parts() {
    return [...this.axes].map(([name, axes]) => ({ object: axes, about: () => [["frame", name], ["parent", this.parents.get(name) || "none"], ...placed(axes)] }));
  }

  // The pose of a frame in the fixed one; undefined if there is no way.
  pose(name) {
    return this.poses.get(name) || (name === this.fixed ? IDENTITY : undefined);
  }

  // What is seen of them: {names, axes, lines, size in metres}.
  set(options) {
    Object.assign(this.options, options);
    for (const axes of this.axes.values()) this._look(axes);
    this.lines.visible = this.options.lines;
  }

  _look(frame) {
    const [axes, name] = frame.children;
    axes.visible = this.options.axes;
    axes.scale.setScalar(this.options.size);
    name.visible = this.options.names;
  }
}
