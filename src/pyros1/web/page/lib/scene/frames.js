// Coordinate frames as axes with names, and lines to their parents.

import * as THREE from "../../vendor/three/three.module.min.js";
import { visibleLabels } from "./label_overlap.js";
import { axesOf } from "./axes.js";
import { label } from "./label.js";
import { pairs, ribbons, repeatColour } from "./ribbons.js";
import { poseRows } from "./select_tool.js";
import { dispose, setPose } from "./stage.js";

const NAME_HEIGHT = 0.12; // metres; height of a name
const FONT_SIZE = 13; // pixels
const IDENTITY = [0, 0, 0, 0, 0, 0, 1];

export class FrameSet {
  constructor() {
    this.object = new THREE.Group();
    this.axes = new Map();
    this.lines = new THREE.Group();
    this.object.add(this.lines);
    this.poses = new Map(); // name -> [x, y, z, qx, qy, qz, qw] in the fixed frame
    this.parents = new Map(); // name -> its parent's name
    this.unconnected = new Set(); // names
    this.trees = []; // [root, number of frames] of those that are not connected
    this.controls = {
      names: { text: "names", kind: "check", defaultValue: true },
      axes: { text: "axes", kind: "check", defaultValue: true },
      lines: { text: "lines to parent frames", kind: "check", defaultValue: true },
      size: { text: "length of axes", kind: "number", defaultValue: 0.3, least: 0.01, most: 100, step: 0.05 },
    };
    /** @type {{names: boolean, axes: boolean, lines: boolean, size: number, concealed: string[]}} */
    this.options = { names: true, axes: true, lines: true, size: 0.3, concealed: [] }; // concealed: names of hidden frames
    this.status = "no frames yet";
    this.problem = "";
  }

  // Apply data of the view scene_frames.
  update({ fixed, names, parents, lost = [], trees = [] }, blob) {
    this.fixed = fixed;
    this.unconnected = new Set(lost);
    this.trees = trees;
    const poses = new Float64Array(blob.buffer, blob.offset);
    const places = this.poses = new Map(names.map((name, index) => [name, poses.subarray(7 * index, 7 * index + 7)]));
    this.parents = new Map(names.map((name, index) => [name, parents[index]]));
    for (const [name, axes] of this.axes) {
      if (places.has(name)) continue;
      this.object.remove(axes);
      dispose(axes);
      this.axes.delete(name);
    }
    /** @type {number[]} */
    const ends = [];
    names.forEach((name, index) => {
      const pose = places.get(name);
      setPose(this._axes(name), pose);
      const parent = places.get(parents[index]);
      if (parent && !this.options.concealed.includes(name)) ends.push(...pose.subarray(0, 3), ...parent.subarray(0, 3));
    });
    const nameless = [...this.axes.values()].filter((axes) => axes.children[1].userData.missing).length;
    this.status = names.length ? `${names.length} frames${nameless ? `, ${nameless} without their names, as there are too many` : ""}` : lost.length ? "" : "no frames yet";
    this.problem = names.length ? "" : this.disconnected;
    dispose(this.lines);
    this.lines.clear();
    const count = ends.length / 3;
    if (count) this.lines.add(ribbons(Float32Array.from(ends), repeatColour("#e0a000", 1, count), 1, pairs(count), "pixels"));
  }

  // Explain why frames are not connected to the fixed one; empty if there are none.
  get disconnected() {
    if (!this.unconnected.size) return "";
    const each = this.trees.map(([root, count]) => `${root} (${count} frame${count === 1 ? "" : "s"})`).join(", ");
    const one = this.trees.length === 1;
    const no = this.poses.size ? `${this.unconnected.size} frames are not connected to ${this.fixed}` : `no frame is connected to ${this.fixed}`;
    return each ? `${no}; there ${one ? "is the tree" : "are the trees"} ${each}: choose ${one ? "its root" : "one of these roots"} as fixed frame` : no;
  }

  _axes(name) {
    let axes = this.axes.get(name);
    if (!axes) {
      axes = new THREE.Group();
      axes.add(axesOf(1, 0.1)); // as thick as rviz's
      axes.add(nameOf(name));
      this._look(axes, name);
      this.object.add(axes);
      this.axes.set(name, axes);
    }
    return axes;
  }

  // Update the colours after a change of the theme.
  colours() {
    for (const [name, axes] of this.axes) {
      dispose(axes.children[1]);
      axes.remove(axes.children[1]);
      axes.add(nameOf(name));
    }
  }

  // Keep names at the size of the page's text at any distance; of overlapping ones, only the nearest is visible.
  // Called before each frame; camera, size and pixel(place) of the stage are used.
  faceCamera(stage) {
    const [width, height] = stage.size;
    const visibleNames = [];
    for (const axes of this.axes.values()) {
      if (!axes.visible) continue;
      const name = axes.children[1];
      const pixel = stage.pixel(axes.position);
      const size = FONT_SIZE * pixel / NAME_HEIGHT;
      name.scale.copy(name.userData.size).multiplyScalar(size);
      name.position.z = 0.75 * NAME_HEIGHT * size;
      const { x, y, z } = axes.localToWorld(name.position.clone()).project(stage.camera);
      const [wide, high] = [name.scale.x / pixel, name.scale.y / pixel];
      visibleNames.push({ name, z, left: (x + 1) * width / 2 - wide / 2, top: (1 - y) * height / 2 - high / 2, wide, high });
    }
    visibleNames.sort((one, other) => one.z - other.z);
    const free = visibleLabels(visibleNames);
    visibleNames.forEach(({ name }, index) => { name.visible = this.options.names && free[index]; });
  }

  show(visible) {
    this.object.visible = visible;
  }

  close() {
    dispose(this.object);
  }

  // Return what can be selected; see select_tool.js.
  parts() {
    return [...this.axes].map(([name, axes]) => ({ object: axes, about: () => [["frame", name], ["parent", this.parents.get(name) || "none"], ...poseRows(axes)] }));
  }

  // Return the pose of a frame in the fixed one; undefined if they are not connected.
  pose(name) {
    return this.poses.get(name) || (name === this.fixed ? IDENTITY : undefined);
  }

  // Set what is visible: {names, axes, lines, size in metres}.
  set(options) {
    Object.assign(this.options, options);
    if (!Array.isArray(this.options.concealed)) this.options.concealed = []; // links are untrusted input
    for (const [name, axes] of this.axes) this._look(axes, name);
    this.lines.visible = this.options.lines;
  }

  _look(frame, name) {
    const [axes] = frame.children;
    frame.visible = !this.options.concealed.includes(name);
    axes.visible = this.options.axes;
    axes.scale.setScalar(this.options.size);
  }
}

// A label that is readable on any background.
function nameOf(name) {
  const dark = getComputedStyle(document.documentElement).colorScheme.includes("dark");
  const text = label(name, { height: NAME_HEIGHT, color: dark ? [1, 1, 1, 1] : [0.1, 0.12, 0.15, 1], outline: dark ? "#14171bdd" : "#ffffffdd", onTop: true });
  text.userData.size = text.scale.clone();
  return text;
}
