// Mouse tools: measure, and rviz's "2D Nav Goal", "2D Pose Estimate" and "Publish Point".

import * as THREE from "../../vendor/three/three.module.min.js";
import { arrowOf } from "./markers.js";
import { dispose, setPose } from "./stage.js";

const MAX_CLICK_MOVE = 4; // pixels that the pointer may move during a click
const COVARIANCE = Object.assign(new Array(36).fill(0), { 0: 0.25, 7: 0.25, 35: 0.06853891909122467 }); // rviz's defaults: 0.5 m, 15°

// Tool -> function that returns the type and value to publish for a pose on the ground.
export const MESSAGES = {
  goal: (pose, frame) => ["geometry_msgs/PoseStamped", { header: { frame_id: frame, stamp: "now" }, pose }],
  point: ({ position }, frame) => ["geometry_msgs/PointStamped", { header: { frame_id: frame, stamp: "now" }, point: position }],
  estimate: (pose, frame) => ["geometry_msgs/PoseWithCovarianceStamped",
    { header: { frame_id: frame, stamp: "now" }, pose: { pose, covariance: COVARIANCE } }],
};

// Drag an arrow on the ground: press at its start, release in its direction. done(x, y, yaw)
export class ArrowTool {
  constructor(stage, colour, done) {
    this.stage = stage;
    this.done = done;
    this.yaw = 0;
    this.material = new THREE.MeshStandardMaterial({ color: colour });
    this.arrow = arrowOf(1, 0.3, 0.08, 0.22, this.material);
    this.arrow.visible = false;
    stage.scene.add(this.arrow);
    this.listen = [["pointerdown", (event) => this._down(event)], ["pointermove", (event) => this._move(event)], ["pointerup", (event) => this._up(event)], ["pointercancel", () => this._forget()]];
    for (const [name, call] of this.listen) stage.canvas.addEventListener(name, call);
    stage.claimed = true; // other buttons and two fingers still move the view
  }

  close() {
    for (const [name, call] of this.listen) this.stage.canvas.removeEventListener(name, call);
    this.stage.scene.remove(this.arrow);
    dispose(this.arrow);
    this.stage.claimed = false;
    this.stage.draw();
  }

  _down(event) {
    if (this.from) { // a second finger moves the view
      this._forget();
      return;
    }
    if (event.button !== 0) return;
    this.from = this.stage.ground(event.offsetX, event.offsetY);
    if (!this.from) return;
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.yaw = 0;
    this._show(this.from);
  }

  _move(event) {
    const to = this.from && this.stage.ground(event.offsetX, event.offsetY);
    if (!to) return;
    if (to.distanceTo(this.from) > 0.02) this.yaw = Math.atan2(to.y - this.from.y, to.x - this.from.x);
    this._show(this.from);
  }

  _up({ button }) {
    const { from } = this;
    if (!from || button !== 0) return;
    this.from = null;
    this.done(from.x, from.y, this.yaw);
  }

  _forget() {
    this.from = null;
    this.arrow.visible = false;
    this.stage.draw();
  }

  _show({ x, y }) {
    this.arrow.visible = true;
    setPose(this.arrow, [x, y, 0.02, 0, 0, Math.sin(this.yaw / 2), Math.cos(this.yaw / 2)]);
    this.stage.draw();
  }
}

// Click on an object or on the ground; dragging turns the view. done(point)
export class PointTool {
  constructor(stage, done) {
    this.stage = stage;
    this.listen = {
      pointerdown: ({ clientX, clientY }) => { this.from = [clientX, clientY]; },
      click: ({ clientX, clientY, offsetX, offsetY }) => {
        if (this.from && Math.hypot(clientX - this.from[0], clientY - this.from[1]) > MAX_CLICK_MOVE) return;
        const point = stage.surface(offsetX, offsetY);
        if (point) done(point);
      },
    };
    for (const [name, call] of Object.entries(this.listen)) stage.canvas.addEventListener(name, call);
  }

  close() {
    for (const [name, call] of Object.entries(this.listen)) this.stage.canvas.removeEventListener(name, call);
  }
}

// Click on objects or on the ground; onMeasured(text) reports the distances between the points, and the total.
export class MeasureTool {
  constructor(stage, onMeasured) {
    this.stage = stage;
    this.points = [];
    this.line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xe8590c, depthTest: false }));
    this.dots = new THREE.Points(this.line.geometry, new THREE.PointsMaterial({ color: 0xe8590c, depthTest: false, size: 7, sizeAttenuation: false }));
    for (const each of [this.line, this.dots]) {
      each.frustumCulled = false;
      each.renderOrder = 10;
      stage.scene.add(each);
    }
    this.clicked = new PointTool(stage, (point) => this._add(point, onMeasured));
    this.anew = () => this._begin(onMeasured);
    stage.canvas.addEventListener("dblclick", this.anew);
    this._begin(onMeasured);
  }

  close() {
    this.clicked.close();
    this.stage.canvas.removeEventListener("dblclick", this.anew);
    this.stage.scene.remove(this.line, this.dots);
    dispose(this.line);
    this.dots.material.dispose();
    this.stage.draw();
  }

  _begin(onMeasured) {
    this.points = [];
    this._show();
    onMeasured("click points on objects or on the ground; double-click to start again");
  }

  _add(point, onMeasured) {
    this.points.push(point);
    this._show();
    const [{ x, y, z }, before] = [point, this.points.at(-2)];
    const all = this.points.slice(1).reduce((sum, each, index) => sum + each.distanceTo(this.points[index]), 0);
    onMeasured(`(${x.toFixed(3)}, ${y.toFixed(3)}, ${z.toFixed(3)})${before ? ` ${before.distanceTo(point).toFixed(3)} m` : " …"}${this.points.length > 2 ? `, in all ${all.toFixed(3)} m` : ""}`);
  }

  _show() {
    this.line.geometry.dispose();
    this.line.geometry = new THREE.BufferGeometry().setFromPoints(this.points);
    this.dots.geometry = this.line.geometry;
    this.stage.draw();
  }
}
