// rviz's FPS view: the left button looks around, the others move sideways and up, the wheel and the keys W, A, S, D, Q and
// E walk.

import * as THREE from "../../vendor/three/three.module.min.js";

const ROTATION_PER_PIXEL = 0.005; // radians per pixel
const METRES_PER_PIXEL = 0.01; // metres per pixel
const METRES_PER_NOTCH = 0.3; // metres per notch of the wheel
const KEY_DIRECTIONS = { w: [0, 1, 0], s: [0, -1, 0], a: [-1, 0, 0], d: [1, 0, 0], e: [0, 0, 1], q: [0, 0, -1], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0] };
const MIN_POLAR_ANGLE = 0.01; // radians; minimum angle to straight up and down

export class Walk {
  constructor(stage) {
    this.stage = stage;
    this.enabled = false;
    this.listen = [["pointerdown", (event) => this._down(event)], ["pointermove", (event) => this._move(event)], ["pointerup", () => this._up()],
      ["wheel", (event) => this._wheel(event)], ["keydown", (event) => this._key(event)]];
    for (const [name, call] of this.listen) stage.canvas.addEventListener(name, call, { passive: false });
  }

  close() {
    for (const [name, call] of this.listen) this.stage.canvas.removeEventListener(name, call);
  }

  // Whether it may use the mouse: tools may use it, or its left button.
  _has(button) {
    return this.enabled && this.stage.controls.enabled && !(button === 0 && this.stage.claimed);
  }

  _down({ button, offsetX, offsetY, shiftKey, pointerId }) {
    if (!this._has(button)) return;
    this.at = [offsetX, offsetY];
    this.turns = button === 0 && !shiftKey;
    this.stage.canvas.setPointerCapture(pointerId);
  }

  _move({ offsetX, offsetY }) {
    if (!this.at) return;
    const [x, y] = [offsetX - this.at[0], offsetY - this.at[1]];
    this.at = [offsetX, offsetY];
    if (this.turns) this._look(-x * ROTATION_PER_PIXEL, -y * ROTATION_PER_PIXEL);
    else this._go(x * METRES_PER_PIXEL, 0, -y * METRES_PER_PIXEL);
  }

  _up() {
    if (!this.at) return;
    this.at = null;
    this.stage.onMove?.();
  }

  _wheel(event) {
    if (!this._has()) return;
    event.preventDefault();
    this._go(0, -Math.sign(event.deltaY) * METRES_PER_NOTCH, 0);
    this.stage.onMove?.();
  }

  _key(event) {
    const way = KEY_DIRECTIONS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!way || !this._has() || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    this._go(...way.map((part) => part * METRES_PER_NOTCH * (event.shiftKey ? 5 : 1)));
    this.stage.onMove?.();
  }

  // Turn left and up, in radians.
  _look(left, up) {
    const { camera, controls } = this.stage;
    const turn = new THREE.Quaternion().setFromUnitVectors(camera.up, new THREE.Vector3(0, 1, 0)); // three.js's spherical coordinates have y up
    const way = new THREE.Spherical().setFromVector3(controls.target.clone().sub(camera.position).applyQuaternion(turn));
    way.theta += left;
    way.phi = Math.min(Math.PI - MIN_POLAR_ANGLE, Math.max(MIN_POLAR_ANGLE, way.phi - up));
    controls.target.setFromSpherical(way).applyQuaternion(turn.invert()).add(camera.position);
    controls.update();
  }

  // Move right, forward and up relative to the view, in metres.
  _go(right, ahead, up) {
    const { camera, controls } = this.stage;
    const step = new THREE.Vector3(right, up, -ahead).applyQuaternion(camera.quaternion);
    camera.position.add(step);
    controls.target.add(step);
    controls.update();
  }
}
