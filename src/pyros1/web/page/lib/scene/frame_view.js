// The view from a frame, which turns with it: rviz's FrameAligned. Mouse and keys work as in walk.js.

import * as THREE from "../../vendor/three/three.module.min.js";

// The viewing direction in the frame, and which way is up. Along z, as in a camera's frame: y points down (REP 103).
const AXIS_DIRECTIONS = {
  x: [[1, 0, 0], [0, 0, 1]], "-x": [[-1, 0, 0], [0, 0, 1]],
  y: [[0, 1, 0], [0, 0, 1]], "-y": [[0, -1, 0], [0, 0, 1]],
  z: [[0, 0, 1], [0, -1, 0]], "-z": [[0, 0, -1], [1, 0, 0]],
};
const ALIGNED_ANGLE = 1e-4; // radians, approximately; below this the view counts as aligned with the axis

export class FrameView {
  constructor(stage) {
    this.stage = stage;
    this.axis = "x";
    this.frame = new THREE.Matrix4(); // its pose in the fixed frame
  }

  // Enter the frame, at its origin or at a position in it.
  enter(/** @type {{axis?: string, position?: number[], target?: number[]}} */ { axis = "x", position = [0, 0, 0], target } = {}) {
    this.axis = Object.hasOwn(AXIS_DIRECTIONS, axis) ? axis : "x";
    this.frame = new THREE.Matrix4();
    this.stage.camera.position.fromArray(position);
    this._lookAt(target || AXIS_DIRECTIONS[this.axis][0].map((value, index) => value + position[index]));
  }

  // Look along an axis of the frame from the current position.
  look(axis) {
    this.axis = axis;
    const eye = this.stage.camera.position.clone();
    this._lookAt(eye.applyMatrix4(this.frame.clone().invert()).add(new THREE.Vector3(...AXIS_DIRECTIONS[axis][0])).toArray());
  }

  // Look at a position in the frame.
  _lookAt(target) {
    const { camera, controls } = this.stage;
    camera.up.set(...AXIS_DIRECTIONS[this.axis][1]).transformDirection(this.frame);
    controls.target.set(...target).applyMatrix4(this.frame);
    controls.update();
  }

  // The position and target in the frame, and the axis; along: whether the view is aligned with it.
  get place() {
    const back = this.frame.clone().invert();
    const [eye, target] = [this.stage.camera.position, this.stage.controls.target].map((each) => each.clone().applyMatrix4(back));
    const along = target.clone().sub(eye).angleTo(new THREE.Vector3(...AXIS_DIRECTIONS[this.axis][0])) < ALIGNED_ANGLE;
    return { axis: this.axis, along, position: eye.toArray(), target: target.toArray() };
  }

  // Update the pose of the frame.
  update([x, y, z, ...turn]) {
    const frame = new THREE.Matrix4().makeRotationFromQuaternion(new THREE.Quaternion(...turn).normalize()).setPosition(x, y, z);
    if (frame.equals(this.frame)) return;
    const { position, target } = this.place;
    this.frame = frame;
    this.stage.camera.position.set(...position).applyMatrix4(frame);
    this._lookAt(target);
  }
}
