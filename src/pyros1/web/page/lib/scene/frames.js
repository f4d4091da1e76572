// Frames as axes with names, and lines to their parents.

import * as THREE from "../../vendor/three/three.module.min.js";
import { label } from "./label.js";
import { dispose, put } from "./stage.js";

export class FrameSet {
  constructor() {
    this.object = new THREE.Group();
    this.axes = new Map();
    this.lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xe0a000 }));
    this.lines.frustumCulled = false;
    this.object.add(this.lines);
    this.names = true;
    this.size = 0.3;
  }

  // Take a push of the view scene_frames.
  take({ names, parents }, blob) {
    const poses = new Float64Array(blob.buffer, blob.offset);
    const places = new Map(names.map((name, index) => [name, poses.subarray(7 * index, 7 * index + 7)]));
    for (const [name, axes] of this.axes) {
      if (places.has(name)) continue;
      this.object.remove(axes);
      dispose(axes);
      this.axes.delete(name);
    }
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
      axes.add(new THREE.AxesHelper(this.size));
      const text = label(name, { height: 0.12, color: [0.55, 0.55, 0.6, 1] });
      text.position.set(0, 0, 0.12);
      text.visible = this.names;
      axes.add(text);
      this.object.add(axes);
      this.axes.set(name, axes);
    }
    return axes;
  }

  showNames(shown) {
    this.names = shown;
    for (const axes of this.axes.values()) axes.children[1].visible = shown;
  }
}
