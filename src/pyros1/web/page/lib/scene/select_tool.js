// rviz's tool "Select": a click or a box shows details of objects: their display, position and values.
//
// A display returns its selectable parts from parts() -> [{object, about(place) -> [[name, value]], points}]. points are
// those of a PointSet: {positions, count, about(index) -> [[name, value]]}. The place is the clicked position, or null.

import * as THREE from "../../vendor/three/three.module.min.js";
import { fill, h } from "../dom.js";
import { pointsIn, overlaps } from "./picking.js";
import { dispose } from "./stage.js";

const HIT_DISTANCE = 5; // pixels around a click in which a point or a line counts as hit
const MAX_SELECTED = 100; // maximum number of objects
const MAX_POINTS = 50; // maximum number of points of a cloud
const COLOUR = 0xffb000;

export class SelectTool {
  // place: the element over the scene; entries() -> [{key, kind, display}].
  constructor(stage, place, entries) {
    this.stage = stage;
    this.place = place;
    this.entries = entries;
    this.selected = []; // {entry, part, place, indices, total}
    this.marks = new THREE.Group();
    stage.scene.add(this.marks);
    this.panel = h("div.selection", { role: "region", "aria-label": "selection" });
    this.frame = h("div.lasso", { hidden: true });
    place.append(this.frame, this.panel);
    this.listen = [["pointerdown", (event) => this._down(event)], ["pointermove", (event) => this._move(event)], ["pointerup", (event) => this._up(event)]];
    for (const [name, call] of this.listen) stage.canvas.addEventListener(name, call);
    stage.claimed = true;
    this.follow = () => this._follow();
    stage.before.push(this.follow);
    this._showDetails();
  }

  close() {
    for (const [name, call] of this.listen) this.stage.canvas.removeEventListener(name, call);
    this.stage.before.splice(this.stage.before.indexOf(this.follow), 1);
    this.stage.claimed = false;
    this.stage.scene.remove(this.marks);
    dispose(this.marks);
    this.frame.remove();
    this.panel.remove();
    this.stage.draw();
  }

  _down(event) {
    if (event.button !== 0) return;
    this.from = [event.offsetX, event.offsetY];
    this.stage.canvas.setPointerCapture(event.pointerId);
  }

  _move({ offsetX, offsetY }) {
    if (!this.from) return;
    const [left, right] = [this.from[0], offsetX].sort((one, other) => one - other);
    const [top, bottom] = [this.from[1], offsetY].sort((one, other) => one - other);
    this.frame.hidden = Math.max(right - left, bottom - top) <= HIT_DISTANCE;
    Object.assign(this.frame.style, { left: `${left}px`, top: `${top}px`, width: `${right - left}px`, height: `${bottom - top}px` });
  }

  _up({ offsetX, offsetY, shiftKey }) {
    if (!this.from) return;
    const [x, y] = this.from;
    this.from = null;
    this.frame.hidden = true;
    const found = Math.max(Math.abs(offsetX - x), Math.abs(offsetY - y)) > HIT_DISTANCE ? this._objectsIn(x, y, offsetX, offsetY) : this._objectAt(x, y);
    this.selected = [...(shiftKey ? this.selected : []), ...found].slice(0, MAX_SELECTED);
    this._mark();
    this._showDetails();
  }

  // Return the visible parts, with their displays.
  _parts() {
    this.stage.scene.updateMatrixWorld(true);
    return this.entries().flatMap((entry) => (entry.display.parts?.() || []).map((part) => ({ entry, part }))).filter(({ part }) => isVisible(part.object));
  }

  // Return the nearest object under a position of the canvas.
  _objectAt(x, y) {
    const { camera } = this.stage;
    const found = [];
    const caster = this.stage.ray(x, y);
    for (const { entry, part } of this._parts()) {
      if (part.points) {
        const { nearest, deep } = this._pointsIn(part, x - HIT_DISTANCE, y - HIT_DISTANCE, x + HIT_DISTANCE, y + HIT_DISTANCE, 0);
        if (nearest >= 0) found.push({ entry, part, place: null, indices: [nearest], total: 1, deep });
        continue;
      }
      const hits = [];
      part.object.traverseVisible((each) => {
        if (!each.isMesh && !each.isLine && !each.isSprite && !each.isPoints) return;
        const far = new THREE.Box3().setFromObject(each).distanceToPoint(camera.position);
        const around = HIT_DISTANCE * this.stage.pixel(camera.position.clone().add(new THREE.Vector3(0, 0, far)));
        Object.assign(caster.params, { Line: { threshold: around }, Points: { threshold: around } });
        each.raycast(caster, hits);
      });
      const [hit] = hits.sort((one, other) => one.distance - other.distance);
      if (hit) found.push({ entry, part, place: hit.point, deep: hit.point.clone().project(camera).z });
    }
    return found.sort((one, other) => one.deep - other.deep).slice(0, 1);
  }

  // Return everything that overlaps a box.
  _objectsIn(x, y, toX, toY) {
    const box = this._box(x, y, toX, toY);
    const matrix = this._projection().elements;
    const found = [];
    for (const { entry, part } of this._parts()) {
      if (part.points) {
        const { total, indices } = this._pointsIn(part, x, y, toX, toY, MAX_POINTS);
        if (total) found.push({ entry, part, place: null, indices, total });
      } else if (overlaps(corners(new THREE.Box3().setFromObject(part.object)), matrix, box)) found.push({ entry, part, place: null });
    }
    return found;
  }

  _pointsIn({ object, points }, x, y, toX, toY, most) {
    const matrix = this._projection().multiply(object.matrixWorld).elements;
    return pointsIn(points.positions, points.count, matrix, this._box(x, y, toX, toY), most);
  }

  _projection() {
    const { camera } = this.stage;
    return new THREE.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  }

  // Convert a part of the canvas in pixels to [left, low, right, high] from -1 to 1.
  _box(x, y, toX, toY) {
    const { clientWidth, clientHeight } = this.stage.canvas;
    const across = [x, toX].map((value) => 2 * value / clientWidth - 1).sort((one, other) => one - other);
    const up = [y, toY].map((value) => 1 - 2 * value / clientHeight).sort((one, other) => one - other);
    return [across[0], up[0], across[1], up[1]];
  }

  _mark() {
    dispose(this.marks);
    this.marks.clear();
    for (const { part: { object, points }, indices } of this.selected) {
      if (!points) {
        const mark = new THREE.BoxHelper(object, COLOUR);
        mark.userData.of = object;
        this.marks.add(mark);
        continue;
      }
      const places = indices.map((index) => new THREE.Vector3().fromArray(points.positions, 3 * index).applyMatrix4(object.matrixWorld));
      const dots = new THREE.Points(new THREE.BufferGeometry().setFromPoints(places), new THREE.PointsMaterial({ color: COLOUR, size: 9, sizeAttenuation: false, depthTest: false }));
      this.marks.add(dots);
    }
    this.stage.draw();
  }

  // Move marks with their objects, and hide them together. Called before each frame.
  _follow() {
    for (const mark of [...this.marks.children]) {
      if (!(mark instanceof THREE.BoxHelper)) continue;
      mark.visible = isVisible(mark.userData.of);
      if (mark.visible) mark.update();
    }
  }

  _showDetails() {
    fill(this.panel, this.selected.length
      ? this.selected.map((each) => this._about(each))
      : h("p.muted", {}, "Click something, or drag a box around it. Hold Shift to add to the selection."));
  }

  _about({ entry, part, place, indices, total }) {
    const rows = [["display", entry.kind], ...part.about(place)];
    const list = (pairs) => h("dl.mono", {}, pairs.map(([name, value]) => [h("dt", {}, name), h("dd", {}, String(value))]));
    const more = indices && total > indices.length;
    return h("section", {}, h("h4.mono", {}, entry.title), list(rows), (indices || []).map((index) => list(part.points.about(index))),
      more && h("p.muted", {}, `and ${total - indices.length} more points`));
  }
}

// Return whether an object is in the scene and visible.
function isVisible(object) {
  for (let each = object; each; each = each.parent) {
    if (!each.visible) return false;
    if (each.isScene) return true;
  }
  return false;
}

function corners({ min, max }) {
  if (!(max.x >= min.x)) return []; // it is empty
  return [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [bits & 1 ? max.x : min.x, bits & 2 ? max.y : min.y, bits & 4 ? max.z : min.z]);
}

// Return the pose of an object in the fixed frame, for parts.
export function poseRows(object) {
  const place = object.getWorldPosition(new THREE.Vector3());
  const { x, y, z } = new THREE.Euler().setFromQuaternion(object.getWorldQuaternion(new THREE.Quaternion()), "ZYX");
  return [["position", formatNumbers(place.toArray())], ["roll, pitch, yaw", formatNumbers([x, y, z])]];
}

export function formatNumbers(values) {
  return values.map((value) => Number(value.toPrecision(6))).join(", ");
}
