// Dragging, clicking and menus of interactive markers, and the feedback to the marker's server, like rviz.

import * as THREE from "../../vendor/three/three.module.min.js";
import { fill, h } from "../dom.js";
import { FACING, MODE, axisOf } from "./interactive_markers.js";

const EVENT = { POSE_UPDATE: 1, MENU_SELECT: 2, BUTTON_CLICK: 3, MOUSE_DOWN: 4, MOUSE_UP: 5 };
const KEEP_ALIVE = 500; // milliseconds between poses of a marker that is held still
const ROTATION_PER_PIXEL = 0.01; // radians per pixel

export class Interaction {
  // stage; sets() -> the InteractiveSets; fixed() -> the fixed frame; publish(topic, type, value) -> promise; onError(text).
  constructor(stage, { sets, fixed, publish, onError }) {
    this.stage = stage;
    this.sets = sets;
    this.fixed = fixed;
    this.publish = publish;
    this.onError = onError;
    this.client = `/pyros1_web/${Math.random().toString(36).slice(2, 8)}`;
    this.place = stage.canvas.parentElement;
    this.listen = [
      ["pointerdown", (event) => this._down(event)], ["pointermove", (event) => this._move(event)],
      ["pointerup", (event) => this._up(event)], ["pointercancel", (event) => this._up(event)],
      ["contextmenu", (event) => this._context(event)],
    ];
    for (const [name, call] of this.listen) this.place.addEventListener(name, call, true); // capture: before the camera's controls
    this.before = () => this.sets().forEach((set) => set.faceCamera(stage.camera));
    stage.before.push(this.before);
    this.enabled = true;
    this.waiting = []; // feedback that is not yet published
    this.frameRequest = 0;
  }

  close() {
    for (const [name, call] of this.listen) this.place.removeEventListener(name, call, true);
    this._closeMenu();
    clearInterval(this.heartbeat);
  }

  _hit(event) {
    if (!this.enabled || event.target !== this.stage.canvas) return null;
    const ray = this.stage.ray(event.offsetX, event.offsetY);
    const found = ray.intersectObjects(this.sets().filter((set) => set.object.visible).map((set) => set.object), true);
    for (const { object, point } of found) {
      for (let each = object; each; each = each.parent) {
        const { control } = each.userData;
        if (control) return control.facts.mode === MODE.NONE && !control.marker.facts.menu.length ? null : { control, point, ray: ray.ray };
      }
    }
    return null;
  }

  _down(event) {
    if (event.target !== this.stage.canvas) return;
    this._closeMenu();
    const hit = this._hit(event);
    if (!hit || event.button === 1) return;
    event.stopPropagation();
    if (this.drag) return; // another finger is already dragging
    const { control, point } = hit;
    const { marker } = control;
    if (event.button === 2 || control.facts.mode === MODE.MENU || control.facts.mode === MODE.NONE) {
      this.pending = hit;
      return;
    }
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.stage.canvas.focus({ preventScroll: true });
    const axis = axisOf(control.facts);
    const turn = new THREE.Quaternion();
    if (control.facts.facing === FACING.VIEW) axis.copy(this.stage.camera.getWorldDirection(new THREE.Vector3())).negate();
    else axis.applyQuaternion((control.facts.facing === FACING.FIXED ? marker.outer : marker.inner).getWorldQuaternion(turn));
    const drag = { control, pointer: event.pointerId, name: control.facts.name, mode: control.facts.mode, axis, marker, from: point.clone(), at: [event.offsetX, event.offsetY] };
    this.drag = drag;
    marker.onReplaced = (again) => { drag.marker = again; }; // the server may replace the marker during the drag
    this._feedback(EVENT.POSE_UPDATE, point); // rviz sends these messages in the same order
    this._feedback(EVENT.MOUSE_DOWN, point);
    if (control.facts.mode === MODE.BUTTON) this._feedback(EVENT.BUTTON_CLICK, point);
    this.heartbeat = setInterval(() => this._feedback(EVENT.POSE_UPDATE), KEEP_ALIVE);
  }

  _move(event) {
    if (!this.drag) {
      if (!event.buttons) this._hover(this._hit(event)?.control);
      return;
    }
    if (event.pointerId !== this.drag.pointer) return;
    event.stopPropagation();
    if (DRAG_HANDLERS[this.drag.mode]) {
      const { ray } = this.stage.ray(event.offsetX, event.offsetY);
      if (DRAG_HANDLERS[this.drag.mode](this.drag, ray, event, this.stage.camera)) this._scheduleFeedback();
    }
    this.drag.at = [event.offsetX, event.offsetY];
  }

  _up(event) {
    if (this.pending) {
      const { control, point } = this.pending;
      this.pending = null;
      event.stopPropagation();
      if (control.marker.facts.menu.length) this._menu(control, point, event);
      return;
    }
    const { drag } = this;
    if (!drag || event.pointerId !== drag.pointer) return;
    event.stopPropagation();
    clearInterval(this.heartbeat);
    cancelAnimationFrame(this.frameRequest);
    this.frameRequest = 0;
    this._feedback(EVENT.POSE_UPDATE, drag.from);
    this._feedback(EVENT.MOUSE_UP, drag.from);
    this.drag = null;
    drag.marker.onReplaced = null;
    if (drag.marker.hasPendingUpdate) {
      drag.marker.hasPendingUpdate = false;
      drag.marker.set.update({ new: [], gone: [], moved: [drag.marker.facts] });
      this.stage.draw();
    }
  }

  _context(event) {
    if (this._hit(event)) event.preventDefault();
  }

  // Send a pose at most once per frame, however often the mouse moves.
  _scheduleFeedback() {
    this.stage.draw();
    this.frameRequest ||= requestAnimationFrame(() => this._send());
  }

  _send() {
    this.frameRequest = 0;
    if (this.drag) this._feedback(EVENT.POSE_UPDATE);
  }

  _feedback(event, /** @type {THREE.Vector3 | null} */ point = null, control = this.drag?.control, entry = 0) {
    const marker = this.drag?.marker || control.marker;
    const { inner, outer, facts } = marker;
    // Like rviz: if the marker is locked to its frame, its feedback uses that frame, otherwise the fixed frame.
    const position = facts.locked ? inner.position : inner.getWorldPosition(new THREE.Vector3());
    const quaternion = facts.locked ? inner.quaternion : inner.getWorldQuaternion(new THREE.Quaternion());
    const mouse = point ? point.clone() : new THREE.Vector3();
    if (point && facts.locked) outer.worldToLocal(mouse);
    const xyz = ({ x, y, z }) => ({ x, y, z });
    const value = {
      header: { frame_id: facts.locked ? facts.frame : this.fixed() }, client_id: this.client, marker_name: facts.name,
      control_name: control.facts.name, event_type: event, menu_entry_id: entry,
      pose: { position: xyz(position), orientation: { ...xyz(quaternion), w: quaternion.w } },
      mouse_point: xyz(mouse), mouse_point_valid: Boolean(point),
    };
    this._queueFeedback({ topic: `${marker.set.topic}/feedback`, value, step: event === EVENT.POSE_UPDATE && !point });
  }

  // Publish one after the other, to keep the order; of the intermediate poses, only the latest is sent.
  async _queueFeedback(message) {
    if (message.step && this.waiting.at(-1)?.step) this.waiting.pop();
    this.waiting.push(message);
    if (this.publishing) return;
    this.publishing = true;
    while (this.waiting.length) {
      const { topic, value } = this.waiting.shift();
      try {
        await this.publish(topic, "visualization_msgs/InteractiveMarkerFeedback", value);
      } catch (error) {
        this.onError(error.message);
      }
    }
    this.publishing = false;
  }

  _hover(control) {
    if (control === this.hovered) return;
    const glow = (each, strength) => each?.group.traverse(({ material }) => {
      for (const one of material ? [material].flat() : []) one.emissive?.setScalar(strength);
    });
    glow(this.hovered, 0);
    glow(control, 0.25);
    this.hovered = control;
    this.stage.canvas.style.cursor = control ? "pointer" : "";
    this.stage.canvas.title = control ? control.facts.description || control.marker.facts.description || "" : "";
    this.stage.draw();
  }

  _menu(control, point, event) {
    const { menu } = control.marker.facts;
    const seen = new Set();
    const branch = (parent, deep) => menu.filter((entry) => entry.parent === parent && !seen.has(entry.id)).map((entry) => {
      seen.add(entry.id);
      const inner = deep < 6 ? branch(entry.id, deep + 1) : [];
      const choose = () => { this._closeMenu(); this._feedback(EVENT.MENU_SELECT, point, control, entry.id); };
      return h("li", {}, inner.length
        ? [h("span.muted", {}, entry.title), h("ul", {}, inner)]
        : h("button.quiet", { role: "menuitem", onclick: choose }, entry.title));
    });
    this.menu = fill(h("div.scene-menu", { role: "menu", onkeydown: (key) => { if (key.key === "Escape") this._closeMenu(); } }), h("ul", {}, branch(0, 0)));
    this.place.append(this.menu);
    const box = this.place.getBoundingClientRect();
    this.menu.style.left = `${Math.max(0, Math.min(event.clientX - box.left, box.width - this.menu.offsetWidth - 4))}px`;
    this.menu.style.top = `${Math.max(0, Math.min(event.clientY - box.top, box.height - this.menu.offsetHeight - 4))}px`;
    this.menu.querySelector("button")?.focus();
  }

  _closeMenu() {
    this.menu?.remove();
    this.menu = null;
  }
}

// The effect of a drag in each interaction mode. Each function takes the drag, the ray of the mouse, the event and the camera; it returns whether something has moved.
const DRAG_HANDLERS = {
  [MODE.MOVE_AXIS]: (drag, ray) => {
    const place = nearestOnLine(drag.from, drag.axis, ray);
    return place && moveMarker(drag, place);
  },
  [MODE.MOVE_PLANE]: (drag, ray) => {
    const place = intersectPlane(drag.from, drag.axis, ray);
    return place && moveMarker(drag, place);
  },
  [MODE.ROTATE_AXIS]: (drag, ray) => {
    const middle = drag.marker.inner.getWorldPosition(new THREE.Vector3());
    const place = intersectPlane(drag.from, drag.axis, ray);
    return place && rotateAboutAxis(drag, middle, place);
  },
  [MODE.MOVE_ROTATE]: (drag, ray) => {
    const middle = drag.marker.inner.getWorldPosition(new THREE.Vector3());
    const place = intersectPlane(drag.from, drag.axis, ray);
    if (!place) return false;
    const arm = drag.from.clone().sub(middle);
    const high = arm.clone().projectOnVector(drag.axis);
    const far = arm.sub(high).length();
    rotateAboutAxis(drag, middle, place);
    // Rotate the grabbed point, then move the marker until that point is under the mouse.
    const from = place.clone().sub(middle).projectOnPlane(drag.axis).setLength(far).add(high).add(middle);
    drag.from.copy(from);
    return moveMarker(drag, place);
  },
  [MODE.MOVE_3D]: (drag, ray, event, camera) => {
    const place = intersectPlane(drag.from, camera.getWorldDirection(new THREE.Vector3()), ray);
    return place && moveMarker(drag, place);
  },
  [MODE.ROTATE_3D]: (drag, ray, event, camera) => rotateFreely(drag, event, camera),
  [MODE.MOVE_ROTATE_3D]: (drag, ray, event, camera) => DRAG_HANDLERS[event.shiftKey ? MODE.ROTATE_3D : MODE.MOVE_3D](drag, ray, event, camera),
};

// Return the point of a line that is nearest to a ray; null if they are parallel.
function nearestOnLine(from, axis, ray) {
  const between = from.clone().sub(ray.origin);
  const dot = axis.dot(ray.direction);
  const wide = 1 - dot * dot;
  if (wide < 1e-6) return null;
  return from.clone().addScaledVector(axis, (dot * between.dot(ray.direction) - between.dot(axis)) / wide);
}

// Return the intersection of a ray and a plane; null if there is none.
function intersectPlane(from, normal, ray) {
  return ray.intersectPlane(new THREE.Plane().setFromNormalAndCoplanarPoint(normal, from), new THREE.Vector3());
}

function moveMarker(drag, place) {
  const { inner, outer } = drag.marker;
  const world = inner.getWorldPosition(new THREE.Vector3()).add(place).sub(drag.from);
  inner.position.copy(outer.worldToLocal(world));
  drag.from.copy(place);
  return true;
}

function rotateMarker(drag, turn) {
  const { inner, outer } = drag.marker;
  const world = inner.getWorldQuaternion(new THREE.Quaternion()).premultiply(turn);
  inner.quaternion.copy(outer.getWorldQuaternion(new THREE.Quaternion()).invert().multiply(world)).normalize();
  return true;
}

function rotateAboutAxis(drag, middle, place) {
  const [one, two] = [drag.from, place].map((each) => each.clone().sub(middle).projectOnPlane(drag.axis));
  if (one.lengthSq() < 1e-8 || two.lengthSq() < 1e-8) return false;
  const angle = Math.atan2(one.clone().cross(two).dot(drag.axis), one.dot(two));
  drag.from.copy(place);
  return rotateMarker(drag, new THREE.Quaternion().setFromAxisAngle(drag.axis, angle));
}

function rotateFreely(drag, event, camera) {
  const turn = new THREE.Quaternion();
  const [right, down] = [event.offsetX - drag.at[0], event.offsetY - drag.at[1]];
  for (const axis of [new THREE.Vector3(0, right, 0), new THREE.Vector3(down, 0, 0)]) {
    const angle = axis.length() * ROTATION_PER_PIXEL;
    turn.premultiply(new THREE.Quaternion().setFromAxisAngle(axis.normalize().applyQuaternion(camera.quaternion), angle));
  }
  return rotateMarker(drag, turn);
}
