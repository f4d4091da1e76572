// The effort of a robot's joints: an arc around each, or an arrow along it, in proportion to the maximum effort.

import * as THREE from "../../vendor/three/three.module.min.js";
import { arrowOf } from "./markers.js";
import { formatNumbers, poseRows } from "./select_tool.js";
import { dispose, setPose } from "./stage.js";
import { readUrdf } from "./urdf.js";

const ARC_ANGLE = 1.5 * Math.PI; // angle of an arc in radians; its tip shows the direction
const ARC_THICKNESS = 0.06; // fraction of an arc's radius
const MIN_EFFORT = 0.02; // fraction of the maximum effort; below that nothing is drawn
const IMMOVABLE = new Set(["fixed", "floating"]);

export class EffortSet {
  // host: {robot, changed()}
  constructor({ robot, changed }) {
    this.object = new THREE.Group();
    this.shapes = new Map(); // joint -> {group, inner}
    this.joints = new Map();
    this.now = { names: [], efforts: [] };
    this.controls = {
      scale: { text: "size", kind: "number", defaultValue: 0.3, least: 0.01, most: 100, step: 0.05 },
      alpha: { text: "opacity", kind: "number", defaultValue: 0.8, least: 0, most: 1, step: 0.05 },
      description: { text: "robot", kind: "text", defaultValue: "/robot_description", none: "/robot_description" },
      prefix: { text: "tf prefix", kind: "text", defaultValue: "", none: "none" },
    };
    /** @type {Record<string, any>} */
    this.options = Object.fromEntries(Object.entries(this.controls).map(([key, { defaultValue }]) => [key, defaultValue]));
    this.status = "no message yet";
    this.problem = "";
    this.robot = robot.stream("param", this._param, {
      data: (data) => { this._readUrdf(data); changed(); },
      problem: (text) => { this.why = text; this._updateStatus([]); changed(); },
    });
  }

  get _param() {
    return { param: this.options.description || this.controls.description.defaultValue };
  }

  set(options) {
    Object.assign(this.options, options);
    if (options.description !== undefined) this.robot.change(this._param);
    this._draw();
  }

  // Apply data of the view scene_topic.
  update(data) {
    this.now = data;
    this._draw();
  }

  place(frames) {
    this.frames = frames;
    this._draw();
  }

  show(shown) {
    this.object.visible = shown;
  }

  close() {
    this.robot.close();
    this._clear();
  }

  // Return what can be selected; see select_tool.js.
  parts() {
    return [...this.shapes].map(([name, { group, effort, limit }]) => ({
      object: group,
      about: () => [["joint", name], ["effort", formatNumbers([effort])], ["limit", limit ? formatNumbers([limit]) : "none"], ...poseRows(group)],
    }));
  }

  _readUrdf({ text, why }) {
    this._clear();
    this.joints = new Map();
    this.why = why || "";
    try {
      if (text) this.joints = new Map(readUrdf(text).joints.map((joint) => [joint.name, joint]));
    } catch (error) {
      this.why = error.message;
    }
    this._draw();
  }

  _draw() {
    const { names, efforts } = this.now;
    const { scale, alpha, prefix } = this.options;
    const greatest = Math.max(...efforts.map(Math.abs), 1e-9); // for joints without a limit
    const unknown = [];
    const shown = new Set();
    names.forEach((name, index) => {
      const joint = this.joints.get(name);
      if (!joint) unknown.push(name);
      const pose = joint && this.frames?.pose(prefix ? `${prefix}/${joint.child}` : joint.child);
      if (!pose || IMMOVABLE.has(joint.type)) return;
      shown.add(name);
      const effort = efforts[index];
      const part = Math.abs(effort) / (joint.effort || greatest);
      const shape = this._shape(name, joint);
      Object.assign(shape, { effort, limit: joint.effort });
      setPose(shape.group, pose);
      shape.group.visible = part >= MIN_EFFORT;
      const size = Math.max(MIN_EFFORT, Math.min(1, part)) * scale;
      const side = effort < 0 ? -size : size; // half a turn about x reverses the direction
      shape.inner.scale.set(size, side, side);
      shape.material.color.setHSL((1 - Math.min(1, part)) / 3, 0.85, 0.45); // green to red
      shape.material.opacity = alpha;
    });
    for (const [name, { group }] of this.shapes) if (!shown.has(name)) group.visible = false;
    this._updateStatus(unknown);
  }

  _shape(name, { axis, type }) {
    const known = this.shapes.get(name);
    if (known) return known;
    const material = new THREE.MeshStandardMaterial({ roughness: 0.8, transparent: true, side: THREE.DoubleSide });
    const inner = new THREE.Group().add(type === "prismatic" ? arrowOf(1, 0.3, 0.08, 0.22, material).rotateY(-Math.PI / 2) : arc(material));
    const turned = new THREE.Group().add(inner); // its z is the joint's axis
    const way = new THREE.Vector3(...axis);
    if (way.lengthSq() > 1e-12) turned.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), way.normalize());
    const group = new THREE.Group().add(turned);
    this.object.add(group);
    const shape = { group, inner, material };
    this.shapes.set(name, shape);
    return shape;
  }

  _updateStatus(unknown) {
    const { names, efforts } = this.now;
    if (this.why) this.problem = this.why;
    else if (this.joints.size && unknown.length) this.problem = `not in the robot's description: ${unknown.slice(0, 3).join(", ")}${unknown.length > 3 ? ` and ${unknown.length - 3} more` : ""}`;
    else this.problem = "";
    const parts = names.map((name, index) => [name, this.joints.get(name)?.effort ? Math.abs(efforts[index]) / this.joints.get(name).effort : 0]);
    const [most, part] = parts.sort((one, other) => other[1] - one[1])[0] || [];
    if (this.now.kind) this.status = !names.length ? "its messages have no efforts" : `${names.length} joints${part > 0 ? `; ${most} has ${Math.round(100 * part)}% of its limit` : ""}`;
  }

  _clear() {
    this.shapes.clear();
    for (const child of [...this.object.children]) {
      this.object.remove(child);
      dispose(child);
    }
  }
}

// An arc of radius 1 around z, with an arrow head.
function arc(material) {
  const group = new THREE.Group();
  const tip = new THREE.Mesh(new THREE.ConeGeometry(3.5 * ARC_THICKNESS, 8 * ARC_THICKNESS, 18).translate(0, 4 * ARC_THICKNESS, 0), material);
  tip.position.set(Math.cos(ARC_ANGLE), Math.sin(ARC_ANGLE), 0);
  tip.rotation.z = ARC_ANGLE;
  group.add(new THREE.Mesh(new THREE.TorusGeometry(1, ARC_THICKNESS, 10, 48, ARC_ANGLE), material), tip);
  return group;
}
