// The view of one who sits in a frame and turns with it, rviz's FrameAligned. The mouse and the keys are those of the walk.

import * as THREE from "../../vendor/three/three.module.min.js";

// Where one looks in the frame, and which way is up. Along z it is as in a camera's frame, whose y points down (REP 103).
const AXES = {
  x: [[1, 0, 0], [0, 0, 1]], "-x": [[-1, 0, 0], [0, 0, 1]],
  y: [[0, 1, 0], [0, 0, 1]], "-y": [[0, -1, 0], [0, 0, 1]],
  z: [[0, 0, 1], [0, -1, 0]], "-z": [[0, 0, -1], [1, 0, 0]],
};
const ALONG = 1e-4; // radians, about: who turned less looks along the axis

export class Seat {
  constructor(stage) {
    this.stage = stage;
    this.axis = "x";
    this.frame = new THREE.Matrix4(); // in the fixed frame
  }

  // Sit down in the frame, at its origin or at a place in it.
  sit(/** @type {{axis?: string, position?: number[], target?: number[]}} */ { axis, position = [0, 0, 0], target } = {}) {
    this.axis = Object.hasOwn(AXES, axis) ? axis : "x";
    this.frame = new THREE.Matrix4();
    this.stage.camera.position.fromArray(position);
    this._face(target || AXES[this.axis][0].map((value, index) => value + position[index]));
  }

  // Look along an axis of the frame, from where one is.
  look(axis) {
    this.axis = axis;
    const eye = this.stage.camera.position.clone();
    this._face(eye.applyMatrix4(this.frame.clone().invert()).add(new THREE.Vector3(...AXES[axis][0])).toArray());
  }

  // Look at a place in the frame.
  _face(target) {
    const { camera, controls } = this.stage;
    camera.up.set(...AXES[this.axis][1]).transformDirection(this.frame);
    controls.target.set(...target).applyMatrix4(this.frame);
    controls.update();
  }

  // Where one is in the frame, and the axis; along: whether one looks along it.
  get place() {
    const back = this.frame.clone().invert();
    const [eye, target] = [this.stage.camera.position, this.stage.controls.target].map((each) => each.clone().applyMatrix4(back));
    const along = target.clone().sub(eye).angleTo(new THREE.Vector3(...AXES[this.axis][0])) < ALONG;
    return { axis: this.axis, along, position: eye.toArray(), target: target.toArray() };
  }

  // The frame is at a pose now.
  take([x, y, z, ...turn]) {
    const frame = new THREE.Matrix4().makeRotationFromQuaternion(new THREE.Quaternion(...turn).normalize()).setPosition(x, y, z);
    if (frame.equals(this.frame)) return;
    const { position, target } = this.place;
    this.frame = frame;
    this.stage.camera.position.set(...position).applyMatrix4(frame);
    this._face(target);
  }
}
