// Tools of the mouse: measure, and rviz's "2D Nav Goal" and "2D Pose Estimate".

import * as THREE from "../../vendor/three/three.module.min.js";
import { arrowOf } from "./markers.js";
import { dispose, put } from "./stage.js";

const COVARIANCE = Object.assign(new Array(36).fill(0), { 0: 0.25, 7: 0.25, 35: 0.06853891909122467 }); // as rviz: 0.5 m, 15°

// What a pose on the ground becomes.
export const MESSAGES = {
  goal: (pose, frame) => ["/move_base_simple/goal", "geometry_msgs/PoseStamped", { header: { frame_id: frame, stamp: "now" }, pose }],
  estimate: (pose, frame) => ["/initialpose", "geometry_msgs/PoseWithCovarianceStamped",
    { header: { frame_id: frame, stamp: "now" }, pose: { pose, covariance: COVARIANCE } }],
};

// Drag an arrow on the ground: press at its place, release in its direction. done(x, y, yaw)
export class ArrowTool {
  constructor(stage, colour, done) {
    this.stage = stage;
    this.done = done;
    this.material = new THREE.MeshStandardMaterial({ color: colour });
    this.arrow = arrowOf(1, 0.3, 0.08, 0.22, this.material);
    this.arrow.visible = false;
    stage.scene.add(this.arrow);
    this.listen = [["pointerdown", (event) => this._down(event)], ["pointermove", (event) => this._move(event)], ["pointerup", (event) => this._up(event)]];
    for (const [name, call] of this.listen) stage.canvas.addEventListener(name, call);
    stage.controls.enabled = false;
  }

  close() {
    for (const [name, call] of this.listen) this.stage.canvas.removeEventListener(name, call);
    this.stage.scene.remove(this.arrow);
    dispose(this.arrow);
    this.stage.controls.enabled = true;
    this.stage.draw();
  }

  _down(event) {
    this.from = this.stage.ground(event.offsetX, event.offsetY);
    if (!this.from) return;
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.yaw = 0;
    this._show();
  }

  _move(event) {
    const to = this.from && this.stage.ground(event.offsetX, event.offsetY);
    if (!to) return;
    if (to.distanceTo(this.from) > 0.02) this.yaw = Math.atan2(to.y - this.from.y, to.x - this.from.x);
    this._show();
  }

  _up() {
    const { from } = this;
    this.from = null;
    if (from) this.done(from.x, from.y, this.yaw);
  }

  _show() {
    this.arrow.visible = true;
    put(this.arrow, [this.from.x, this.from.y, 0.02, 0, 0, Math.sin(this.yaw / 2), Math.cos(this.yaw / 2)]);
    this.stage.draw();
  }
}

// Click two places on the ground; told(text) says how far they are from each other.
export class MeasureTool {
  constructor(stage, told) {
    this.stage = stage;
    this.points = [];
    this.line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xe8590c, depthTest: false }));
    this.line.frustumCulled = false;
    stage.scene.add(this.line);
    this.click = (event) => {
      const point = stage.ground(event.offsetX, event.offsetY);
      if (!point) return;
      if (this.points.length === 2) this.points = [];
      this.points.push(point);
      this.line.geometry.setFromPoints(this.points.map(({ x, y }) => new THREE.Vector3(x, y, 0.01)));
      const [from, to] = this.points;
      told(to ? `${from.distanceTo(to).toFixed(3)} m` : `(${point.x.toFixed(3)}, ${point.y.toFixed(3)}) …`);
      stage.draw();
    };
    told("click two places on the ground");
    stage.canvas.addEventListener("click", this.click);
  }

  close() {
    this.stage.canvas.removeEventListener("click", this.click);
    this.stage.scene.remove(this.line);
    dispose(this.line);
    this.stage.draw();
  }
}
