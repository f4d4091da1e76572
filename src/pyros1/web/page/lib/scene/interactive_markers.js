// Interactive markers: their shapes and poses. interaction.js handles the mouse.

import * as THREE from "../../vendor/three/three.module.min.js";
import { arrowOf, disposeMarker, markerObject } from "./markers.js";
import { label } from "./label.js";
import { poseRows as placeOf } from "./select_tool.js";
import { setPose } from "./stage.js";

export const MODE = { NONE: 0, MENU: 1, BUTTON: 2, MOVE_AXIS: 3, MOVE_PLANE: 4, ROTATE_AXIS: 5, MOVE_ROTATE: 6, MOVE_3D: 7, ROTATE_3D: 8, MOVE_ROTATE_3D: 9 };
export const FACING = { INHERIT: 0, FIXED: 1, VIEW: 2 };
const X = new THREE.Vector3(1, 0, 0);

export class InteractiveSet {
  // host: {token, changed()}
  constructor(topic, { token, changed }) {
    this.object = new THREE.Group();
    this.topic = topic.replace(/\/update$/, "");
    this.known = new Map(); // server and name -> {facts, outer, inner, controls}
    this.controls = { names: { text: "descriptions", kind: "check", defaultValue: true } };
    this.options = { names: true };
    this.faults = new Set();
    this.status = "no markers yet";
    this.problem = "";
    this.host = { token, changed, failed: (text) => { if (this.faults.size < 20) this.faults.add(text); this._updateStatus(); changed("words"); } };
  }

  // Apply data of the view scene_interactive.
  update({ all, new: added, moved, gone }) {
    if (all) for (const key of [...this.known.keys()]) this._remove(key);
    for (const [server, name] of gone) this._remove(`${server}\n${name}`);
    for (const facts of added) this._addMarker(facts);
    for (const { server, name, frame, pose } of moved) {
      const marker = this.known.get(`${server}\n${name}`);
      if (!marker) continue;
      Object.assign(marker.facts, { frame, pose });
      marker.placed = false;
      if (marker.onReplaced) marker.hasPendingUpdate = true; // the user is dragging it
      else setPose(marker.inner, pose);
    }
    this.place(this.frames);
  }

  set(options) {
    Object.assign(this.options, options);
    for (const { title } of this.known.values()) if (title) title.visible = this.options.names;
  }

  show(visible) {
    this.object.visible = visible;
  }

  // Markers with stamp 0 move with their frame; others stay where they were when they were received.
  place(frames) {
    this.frames = frames;
    this.unknownFrame = "";
    for (const marker of this.known.values()) {
      if (marker.placed && !marker.facts.locked) continue;
      const pose = frames?.pose(marker.facts.frame);
      marker.outer.visible = Boolean(pose || marker.placed);
      if (pose) {
        setPose(marker.outer, pose);
        marker.placed = true;
      } else this.unknownFrame ||= marker.facts.frame;
    }
    this._updateStatus();
  }

  // Return what can be selected; see select_tool.js.
  parts() {
    return [...this.known.values()].map(({ facts, outer, inner }) => ({
      object: outer,
      about: () => [["server", facts.server], ["name", facts.name], ["description", facts.description], ["frame", facts.frame], ...placeOf(inner)],
    }));
  }

  // Turn controls that face the camera. Called before each frame.
  faceCamera(camera) {
    for (const marker of this.known.values()) {
      for (const { facts, group } of marker.controls) {
        if (facts.facing === FACING.INHERIT) continue;
        const inner = marker.inner.getWorldQuaternion(new THREE.Quaternion()).invert();
        if (facts.facing === FACING.FIXED) group.quaternion.copy(inner.multiply(marker.outer.quaternion));
        else if (facts.independent) group.quaternion.identity();
        else { // x points at the camera, and z is up in the image
          const view = camera.getWorldQuaternion(new THREE.Quaternion());
          const basis = new THREE.Matrix4().makeBasis(new THREE.Vector3(0, 0, 1), X, new THREE.Vector3(0, 1, 0));
          group.quaternion.copy(inner.multiply(view).multiply(new THREE.Quaternion().setFromRotationMatrix(basis)));
        }
      }
    }
  }

  close() {
    for (const key of [...this.known.keys()]) this._remove(key);
  }

  _addMarker(facts) {
    const key = `${facts.server}\n${facts.name}`;
    const before = this.known.get(key);
    const onReplaced = before?.onReplaced;
    const pose = onReplaced ? [...before.inner.position.toArray(), ...before.inner.quaternion.toArray()] : facts.pose;
    this._remove(key);
    const marker = { set: this, facts, outer: new THREE.Group(), inner: new THREE.Group(), controls: /** @type {object[]} */ ([]), onReplaced, hasPendingUpdate: onReplaced };
    marker.outer.add(marker.inner);
    setPose(marker.inner, pose);
    for (const control of facts.controls) marker.controls.push(this._control(marker, control));
    if (facts.description) {
      marker.title = label(facts.description, { height: 0.12 * facts.scale, color: [0.5, 0.5, 0.55, 1] });
      marker.title.position.set(0, 0, 0.7 * facts.scale);
      marker.title.visible = this.options.names;
      marker.inner.add(marker.title);
    }
    this.object.add(marker.outer);
    this.known.set(key, marker);
    if (onReplaced) onReplaced(marker);
  }

  _control(marker, facts) {
    const group = new THREE.Group();
    const control = { marker, facts, group };
    const shapes = facts.markers.length
      ? facts.markers.map((each) => placeAt(markerObject(each, this.host), each.pose))
      : defaultValue(facts, marker.facts.scale);
    for (const shape of shapes.filter(Boolean)) group.add(shape);
    group.userData.control = control;
    marker.inner.add(group);
    return control;
  }

  _remove(key) {
    const marker = this.known.get(key);
    if (!marker) return;
    this.known.delete(key);
    this.object.remove(marker.outer);
    disposeMarker(marker.outer);
  }

  _updateStatus() {
    const count = this.known.size;
    this.status = count ? `${count} interactive marker${count === 1 ? "" : "s"}` : "no markers yet";
    this.problem = this.unknownFrame ? `no transform to the frame ${this.unknownFrame}` : [...this.faults][0] || "";
  }
}

function placeAt(object, pose) {
  if (!object) return null;
  const outer = new THREE.Group();
  setPose(outer, pose);
  outer.add(object);
  return outer;
}

// Return the axis about which or along which a control moves, in the marker's frame.
export function axisOf(facts) {
  const turn = new THREE.Quaternion(...facts.turn);
  return X.clone().applyQuaternion(turn.lengthSq() < 1e-12 ? turn.identity() : turn.normalize());
}

// Default shapes of controls without markers: arrows, rings, a ball.
function defaultValue(facts, scale) {
  const axis = axisOf(facts);
  const [red, green, blue] = axis.toArray().map(Math.abs);
  const material = new THREE.MeshStandardMaterial({ color: new THREE.Color(red, green, blue), roughness: 0.7, opacity: 0.85, transparent: true, side: THREE.DoubleSide });
  const group = new THREE.Group();
  group.quaternion.setFromUnitVectors(X, axis);
  const { mode } = facts;
  if (mode === MODE.MOVE_AXIS) {
    for (const side of [1, -1]) {
      const arrow = arrowOf(0.28 * scale, 0.14 * scale, 0.08 * scale, 0.16 * scale, material);
      arrow.position.x = side * 0.5 * scale;
      if (side < 0) arrow.rotation.z = Math.PI;
      group.add(arrow);
    }
  } else if (mode === MODE.ROTATE_AXIS || mode === MODE.MOVE_PLANE || mode === MODE.MOVE_ROTATE) {
    const [from, to] = mode === MODE.MOVE_PLANE ? [0, 0.42] : [0.5, 0.62];
    group.add(new THREE.Mesh(new THREE.RingGeometry(from * scale, to * scale, 48).rotateY(Math.PI / 2), material));
    if (mode === MODE.MOVE_PLANE) material.opacity = 0.35;
  } else if (mode !== MODE.NONE) {
    material.color.set(0x9aa5b1);
    group.add(new THREE.Mesh(new THREE.SphereGeometry(0.18 * scale, 24, 16), material));
  }
  return [group];
}
