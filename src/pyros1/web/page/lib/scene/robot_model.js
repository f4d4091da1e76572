// The display of a robot: its links with the shapes of its URDF, at the poses from /tf.

import * as THREE from "../../vendor/three/three.module.min.js";
import { meshOf, textureOf } from "./meshes.js";
import { poseRows } from "./select_tool.js";
import { dispose, setPose } from "./stage.js";
import { readUrdf } from "./urdf.js";

const DEFAULT_COLOUR = [0.72, 0.74, 0.77, 1];
const UPDATE_DELAY = 30; // milliseconds in which changes of shapes are combined
const MANY_SHAPES = 1000; // shapes
const MAX_NAMED = 3; // maximum number of links and problems to list by name

export class RobotModel {
  // token: of the page's link; changed(): called when its look changes.
  constructor(token, changed) {
    this.object = new THREE.Group();
    this.token = token;
    this.changed = changed;
    this.status = "";
    this.problem = "";
    this.controls = {
      visual: { text: "visual", kind: "check", defaultValue: true },
      collision: { text: "collision", kind: "check", defaultValue: false },
      alpha: { text: "opacity", kind: "number", defaultValue: 1, least: 0, most: 1, step: 0.05 },
      prefix: { text: "tf prefix", kind: "text", defaultValue: "" },
    };
    /** @type {{visual: boolean, collision: boolean, alpha: number, prefix: string, concealed: string[]}} */
    this.options = { visual: true, collision: false, alpha: 1, prefix: "", concealed: [] }; // concealed: names of hidden links
    this.links = new Map(); // name -> {group, joint}
    this.geometries = new Map(); // geometry as JSON -> its shape
    this.generation = 0;
    this.faults = [];
    this.loading = 0; // number of meshes and textures that are being loaded
  }

  // Apply data of the view param.
  update({ text, why }) {
    this._clear();
    this.why = "";
    this.noRobotReason = why || ""; // having no robot is not an error
    this.robot = null;
    if (text) {
      try {
        this.robot = readUrdf(text);
        this._build(this.robot);
      } catch (error) {
        this.why = error.message;
      }
    }
    this.place(this.frames);
  }

  set(options) {
    Object.assign(this.options, options);
    if (!Array.isArray(this.options.concealed)) this.options.concealed = []; // links are untrusted input
    this._applyOptions();
    this.place(this.frames);
  }

  // The frame of the root link; empty if there is no robot.
  get root() {
    const [name] = this.robot?.roots || [];
    return name ? this._frame(name) : "";
  }

  _frame(link) {
    const { prefix } = this.options;
    return prefix ? `${prefix}/${link}` : link;
  }

  // Move each link to its frame. One without a frame is placed as if its joint were at 0.
  place(frames) {
    this.frames = frames;
    const missing = [];
    for (const [name, { group, joint }] of this.links) { // parents come first
      const pose = frames?.pose(this._frame(name));
      if (pose) setPose(group, pose);
      else {
        missing.push(name);
        const parent = joint && this.links.get(joint.parent)?.group;
        group.position.set(0, 0, 0);
        group.quaternion.identity();
        if (parent) {
          applyOrigin(group, joint);
          group.position.applyQuaternion(parent.quaternion).add(parent.position);
          group.quaternion.premultiply(parent.quaternion);
        }
      }
    }
    this._updateStatus(missing);
  }

  show(visible) {
    this.object.visible = visible;
  }

  // Return what can be selected; see select_tool.js.
  parts() {
    const robot = this.robot?.name; // it may be gone when a part's details are requested
    return [...this.links].map(([name, { group, joint }]) => ({
      object: group,
      about: () => [["robot", robot], ["link", name], ["joint", joint ? `${joint.name} (${joint.type})` : "none: it is the root"], ...poseRows(group)],
    }));
  }

  close() {
    clearTimeout(this.updateTimer);
    this._clear();
  }

  _clear() {
    this.generation += 1; // results of earlier loads are ignored
    this.links.clear();
    this.geometries.clear();
    this.faults = [];
    this.loading = 0;
    for (const child of [...this.object.children]) {
      this.object.remove(child);
      dispose(child);
    }
  }

  _build({ links, joints, roots, problems }) {
    this.faults.push(...problems);
    this.shapes = [...links.values()].reduce((sum, { visuals, collisions }) => sum + visuals.length + collisions.length, 0);
    const below = new Map();
    for (const joint of joints) {
      if (!below.has(joint.parent)) below.set(joint.parent, []);
      below.get(joint.parent).push(joint);
    }
    const waiting = roots.map((name) => [name, null]);
    for (let index = 0; index < waiting.length; index += 1) {
      const [name, joint] = waiting[index];
      if (this.links.has(name)) continue;
      this.links.set(name, { group: this._link(links.get(name)), joint });
      for (const each of below.get(name) || []) waiting.push([each.child, each]);
    }
    if (this.links.size < links.size) this.faults.push(`${links.size - this.links.size} links are in a loop of joints`);
    this._applyOptions();
  }

  _link({ name, visuals, collisions }) {
    const group = new THREE.Group();
    group.name = name;
    for (const [list, kind] of [[visuals, "visual"], [collisions, "collision"]]) {
      for (const shape of list) {
        const outer = new THREE.Group();
        outer.userData.kind = kind;
        applyOrigin(outer, shape);
        group.add(outer);
        this._shape(outer, shape, kind);
      }
    }
    this.object.add(group);
    return group;
  }

  async _shape(outer, { geometry, material }, kind) {
    const { generation } = this;
    const paint = kind === "collision" ? { color: [0.9, 0.5, 0.15, 0.5], texture: "" } : material;
    const own = paintOf(paint);
    if (geometry.kind !== "mesh") {
      outer.add(new THREE.Mesh(this._sharedGeometry(geometry), own));
      if (!paint?.texture) return;
    }
    this.loading += 1;
    try {
      if (paint?.texture) own.map = await textureOf(paint.texture, this.token);
      own.needsUpdate = true;
      if (geometry.kind === "mesh") {
        const mesh = await meshOf(geometry.uri, this.token);
        if (generation !== this.generation) return;
        const painted = mesh.userData.painted && kind === "visual";
        mesh.traverse((each) => {
          if (each.isMesh) each.material = painted ? cloneMaterial(each.material) : own.map || !each.material.vertexColors ? own : cloneMaterial(each.material);
        });
        const scaled = new THREE.Group();
        scaled.scale.fromArray(geometry.scale);
        scaled.add(mesh);
        outer.add(scaled);
      }
    } catch (error) {
      if (generation === this.generation) this.faults.push(error.message);
    } finally {
      if (generation === this.generation) {
        this.loading -= 1;
        this._applyOptions(outer);
        this._scheduleUpdate();
      }
    }
  }

  // Equal shapes share one geometry, with fewer corners if there are many shapes.
  _sharedGeometry(geometry) {
    const key = JSON.stringify(geometry);
    if (!this.geometries.has(key)) this.geometries.set(key, geometryOf(geometry, this.shapes > MANY_SHAPES ? 12 : 32));
    return this.geometries.get(key);
  }

  // Thousands of shapes may be loaded at once: combine their notifications.
  _scheduleUpdate() {
    this.updateTimer ||= setTimeout(() => {
      this.updateTimer = 0;
      this.place(this.frames);
      this.changed();
    }, UPDATE_DELAY);
  }

  // Update visibility and transparency.
  _applyOptions(part = this.object) {
    const { alpha, concealed } = this.options;
    for (const [name, { group }] of this.links) group.visible = !concealed.includes(name);
    part.traverse((each) => {
      if (each.userData.kind) each.visible = this.options[each.userData.kind];
      for (const material of each instanceof THREE.Mesh ? [each.material].flat() : []) {
        material.userData.alpha ??= material.opacity;
        material.opacity = material.userData.alpha * alpha;
        material.transparent = material.opacity < 1;
        material.depthWrite = material.opacity > 0.5;
        material.needsUpdate = true;
      }
    });
  }

  // Return whether tf has the missing links in another tree.
  _isInOtherTree(missing) {
    return missing.some((name) => this.frames?.unconnected?.has(this._frame(name)));
  }

  _updateStatus(missing) {
    const faults = [...new Set(this.faults)];
    if (this.why) this.problem = this.why;
    else if (faults.length) this.problem = listSome(faults, "; ");
    else if (missing.length && this._isInOtherTree(missing)) this.problem = `no transform from ${this.frames.fixed} to ${listSome(missing, ", ")}, drawn with joints at 0: ${this.frames.disconnected}`;
    else if (missing.length && missing.length === this.links.size) this.problem = "no transforms (tf) of its links: all joints are drawn at 0. To publish them: pyros1 run robot_state_publisher robot_state_publisher";
    else if (missing.length) this.problem = `no tf of ${listSome(missing, ", ")}: drawn with the joint at 0`;
    else this.problem = "";
    const count = this.links.size;
    this.status = this.noRobotReason || `${this.robot?.name || "robot"}: ${count} link${count === 1 ? "" : "s"}${this.loading ? ` (${this.loading} shapes are loading)` : ""}`;
  }
}

function listSome(list, between) {
  const more = list.length - MAX_NAMED;
  return list.slice(0, MAX_NAMED).join(between) + (more > 0 ? `${between}and ${more} more` : "");
}

function applyOrigin(object, { xyz, rpy }) {
  object.position.set(...xyz);
  object.quaternion.setFromEuler(new THREE.Euler(rpy[0], rpy[1], rpy[2], "ZYX"));
}

function geometryOf(geometry, corners) {
  if (geometry.kind === "box") return new THREE.BoxGeometry(...geometry.size);
  if (geometry.kind === "sphere") return new THREE.SphereGeometry(geometry.radius, corners, Math.round(corners * 0.63));
  return new THREE.CylinderGeometry(geometry.radius, geometry.radius, geometry.length, corners).rotateX(Math.PI / 2);
}

function paintOf(material) {
  const [red, green, blue, alpha] = material?.color || (material?.texture ? [1, 1, 1, 1] : DEFAULT_COLOUR);
  return new THREE.MeshStandardMaterial({
    color: new THREE.Color().setRGB(red, green, blue, THREE.SRGBColorSpace), opacity: alpha, roughness: 0.75, side: THREE.DoubleSide,
  });
}

function cloneMaterial(material) {
  return Array.isArray(material) ? material.map((each) => each.clone()) : material.clone();
}
