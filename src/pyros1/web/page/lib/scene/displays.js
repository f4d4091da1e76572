// Displays of topics in the scene. A display has an object, receives data of the view scene_topic, and has options.

import * as THREE from "../../vendor/three/three.module.min.js";
import { PointBudget, RateMeter } from "./point_budget.js";
import * as draw from "./shapes.js";
import { MapPlane } from "./map.js";
import { plural } from "../format.js";
import { MarkerSet } from "./markers.js";
import { MAX_POINTS_CONTROL, OPTIONS, TINT_CONTROL } from "./options.js";
import { PointSet, levels, scanPoints } from "./points.js";
import { formatNumbers, poseRows } from "./select_tool.js";
import { dispose, setPose } from "./stage.js";

const NO_NUMBERS = new Float32Array(0);
const COORDINATES = ["x", "y", "z"];
const IDENTITY = [0, 0, 0, 0, 0, 0, 1];

export class Display {
  // kind: rviz's name of the display; changed(): called when its look changes without new data; pictures(): image topics.
  constructor(colour, kind, /** @type {{token?: string, changed?: (what?: string) => void, pictures?: () => string[]}} */ { token = "", changed = () => {}, pictures = () => [] } = {}) {
    this.object = new THREE.Group();
    this.colour = colour;
    this.kind = kind;
    this.status = ""; // text for the list of displays
    this.problem = "";
    this.controls = { ...OPTIONS[kind] };
    if (this.controls.tint === TINT_CONTROL) this.controls.tint = { ...TINT_CONTROL, defaultValue: colour };
    if (this.controls.colour) this.controls.colour = { ...this.controls.colour, choices: pictures };
    this.options = Object.fromEntries(Object.entries(this.controls).map(([key, { defaultValue }]) => [key, defaultValue]));
    this.host = { token, changed };
    this.budget = new PointBudget();
    this.rate = new RateMeter();
    this.count = 0; // points drawn
    this.every = 1; // of this many points, one is drawn
  }

  // The arguments of its stream, in addition to topic and fixed frame.
  get args() {
    const { by, colour, info, most, auto, low, high } = this.options;
    return most ? { by, colour, info, most: Math.min(most, this.budget.maxPoints), bounds: auto ? null : [low, high], numbers: this.inspected === true } : {};
  }

  // Set whether the server should also send the indices of the points.
  inspect(inspected) {
    this.inspected = inspected;
  }

  // Return what can be selected; see select_tool.js.
  parts() {
    const { points, plane } = this; // they may be gone when a part's details are requested
    if (this.markers) return this.markers.parts();
    const about = () => [["frame", this.frame], ["shows", this.status], ...poseRows(this.object)];
    if (points) return [{ object: points.object, about: () => [["frame", this.frame]], points: { ...points.places, about: (index) => this._aboutPoint(points, index) } }];
    if (plane) return [{ object: this.object, about: (place) => [["frame", this.frame], ["shows", this.status], ...plane.about(place)] }];
    return [{ object: this.object, about }];
  }

  _aboutPoint(points, index) {
    const { indices, values, by, bytes } = this.pointData || {};
    const place = [...points.places.positions.slice(3 * index, 3 * index + 3)];
    const rows = [["point", indices ? indices[index] : `${index} of the points drawn`], ["x, y, z", formatNumbers(place)]];
    if (values) rows.push([by, formatNumbers([values[index]])]);
    if (bytes) rows.push([by, `${bytes[4 * index + 2]}, ${bytes[4 * index + 1]}, ${bytes[4 * index]}`]);
    return rows;
  }

  set(options) {
    for (const [key, value] of Object.entries(options)) this.options[key] = validOption(value, this.controls[key]);
    if (options.most) this.budget.reset(); // the user's choice overrides the automatic one
    if (options.decay !== undefined) this._forget();
    this._style();
    if (this.lastMessage) {
      if (this.options.keep && this.object.children.length) this._removeChild(this.object.children.at(-1));
      this._draw(...this.lastMessage, true);
    }
    this.markers?.show(this.options);
  }

  update(data, blob) {
    if (data.kind !== "patch" && data.kind !== this.drawn) {
      if (this.drawn) this._forget(); // the type of the topic has changed
      this.drawn = data.kind;
    }
    if (data.kind === "markers") {
      this._markers(data);
      return;
    }
    if (data.kind === "patch") {
      this.plane?.patch(data, new Int8Array(blob.buffer, blob.offset));
      return;
    }
    this.frame = (data.frame ?? "").replace(/^\//, "");
    this.missingFrame = data.pose ? "" : this.frame;
    if (!data.pose) {
      this.problem = noTransformMessage(data.frame);
      this.hasNoPose = true;
      this.object.visible = false;
      return;
    }
    this.problem = data.odd || "";
    this.hasNoPose = false;
    this.object.visible = !this.hidden;
    if (!this._keepsOld) setPose(this.object, data.pose);
    this._draw(data, blob);
  }

  // Move objects that are fixed to a moving frame.
  place(frames) {
    const pose = this.plane && frames.pose(this.frame);
    if (pose) setPose(this.object, pose);
    this.markers?.place(frames);
  }

  // Report how many milliseconds the last frame took. Returns whether its stream should send fewer or more points.
  reportFrame(lag, fresh) {
    const { count, every } = this;
    return Boolean(count) && !this.hidden && this.budget.reportFrame(lag, { count, all: every === 1, fresh });
  }

  show(visible) {
    this.hidden = !visible;
    this.object.visible = visible && !this.hasNoPose;
  }

  close() {
    this._clear();
    dispose(this.object);
  }

  get tint() {
    return this.options.tint || this.colour;
  }

  // Whether older messages stay at their positions.
  get _keepsOld() {
    return this.options.keep > 0 || this.options.decay > 0;
  }

  _draw(data, blob, again = false) {
    if (this[`_${data.kind}`]) this[`_${data.kind}`](data, blob);
    else if (draw[data.kind]) this._shape(data, blob, again);
  }

  _shape(data, blob, again) {
    const values = blob ? new Float32Array(blob.buffer, blob.offset) : NO_NUMBERS;
    if (!again && this._isNearLast(values)) return;
    this.lastMessage = [data, blob];
    const [object, status] = draw[data.kind](data, values, this.tint, this.options);
    this.status = status;
    if (!this._keepsOld) {
      this._clear();
      this.object.add(object);
      return;
    }
    this._placeAt(data.pose).add(object);
    while (this.object.children.length > this.options.keep) this._removeChild(this.object.children[0]);
  }

  // Return whether a pose is too close to the last one drawn.
  _isNearLast(pose) {
    const { step, angle } = this.options;
    if (step === undefined) return false;
    const lastPose = this.lastPose;
    if (lastPose && pose.length >= 7) {
      const far = Math.hypot(...[0, 1, 2].map((axis) => pose[axis] - lastPose[axis]));
      if (far < step && rotationOf(lastPose).angleTo(rotationOf(pose)) < angle) return true;
    }
    this.lastPose = pose.slice(0, 7);
    return false;
  }

  // Return a separate group for a message.
  _placeAt(pose) {
    const place = new THREE.Group();
    setPose(place, pose);
    this.object.add(place);
    return place;
  }

  // Return the points to fill with a message: the existing ones, or new ones if old ones are kept for a while.
  _pointsFor({ pose, count }) {
    const { decay } = this.options;
    if (!(decay > 0)) return this.points ||= this._addPart(new PointSet());
    const place = this._placeAt(pose);
    const points = new PointSet();
    place.add(points.object);
    place.userData.count = count;
    let all = this.object.children.reduce((sum, { userData }) => sum + userData.count, 0);
    for (const oldest of [...this.object.children]) {
      if (all <= MAX_POINTS_CONTROL.most || oldest === place) break;
      all -= oldest.userData.count;
      this._removeChild(oldest);
    }
    setTimeout(() => {
      if (place.parent !== this.object) return;
      this._removeChild(place);
      this.host.changed();
    }, 1000 * decay);
    return points;
  }

  _scan(data, blob) {
    this.points = this._pointsFor(data);
    const by = this.options.by || (data.intensities ? "intensity" : "range");
    const [positions, values, indices] = scanPoints(data, new Float32Array(blob.buffer, blob.offset), by);
    this.pointData = { indices, values, by };
    this._style();
    const { auto, low, high } = this.options;
    if (COORDINATES.includes(by)) this.points.set(positions, by);
    else this.points.set(positions, "value", levels(values, auto ? null : [low, high]));
    this._updateFields(["intensity", "range", ...COORDINATES]);
    this.status = plural(positions.length / 3, "point");
  }

  _cloud(data, blob) {
    const { count, every, fields, by, colour, numbers: hasNumbers } = data;
    this.points = this._pointsFor(data);
    const positions = new Float32Array(blob.buffer, blob.offset, 3 * count);
    const more = (hasNumbers ? 4 : 0) * count; // bytes before the colours: indices, and then values
    const after = blob.offset + 12 * count;
    const levelled = hasNumbers && colour === "value";
    const bytes = new Uint8Array(blob.buffer, after + (levelled ? 2 : 1) * more);
    this.pointData = hasNumbers && { by, indices: new Uint32Array(blob.buffer, after, count), values: levelled && new Float32Array(blob.buffer, after + more, count), bytes: colour.startsWith("rgb") && bytes };
    this._style();
    this.points.set(positions, colour, bytes);
    this._updateFields(fields);
    this.count = count;
    this.every = every;
    const why = this.budget.maxPoints < this.options.most ? ": this browser draws slowly" : "";
    this.rate.tick(performance.now());
    this.status = `${plural(count, "point")}${every > 1 ? ` (one of ${every}${why}), ${this.rate}` : ""}, colour: ${by}`;
  }

  // Update the fields that points can be coloured by.
  _updateFields(fields) {
    if (!this.controls.by || this.controls.by.choices.length === fields.length + 1) return;
    this.controls.by = { ...this.controls.by, choices: ["", ...fields] };
    this.host.changed("controls");
  }

  _map(data, blob) {
    this.plane ||= this._addPart(new MapPlane());
    this._style();
    this.plane.set(data, new Int8Array(blob.buffer, blob.offset));
    const { every } = this.plane;
    this.status = `${data.width} × ${data.height} cells${every > 1 ? `, one of ${every} across and down is shown` : ""}`;
  }

  _markers(data) {
    this.markers ||= this._addPart(new MarkerSet({ ...this.host, changed: (what) => { this._updateStatus(); this.host.changed(what); } }));
    this.markers.update(data);
    this.markers.show(this.options);
    const { namespaces } = this.markers;
    const known = Object.keys(this.controls).length;
    for (const name of namespaces) this.controls[`ns:${name}`] ||= { text: name || "“”", kind: "check", defaultValue: true };
    if (Object.keys(this.controls).length !== known) this.host.changed("controls");
    this.missingFrame = Object.entries(data.poses).find(([, pose]) => !pose)?.[0];
    this.frame = Object.keys(data.poses)[0] ?? this.frame;
    this._updateStatus();
  }

  _updateStatus() {
    if (!this.markers) return; // the markers are gone, but one of their meshes has just been loaded
    const { count, faults, invisible } = this.markers;
    this.status = `${plural(count, "marker")}${invisible.size ? `, ${invisible.size} transparent (color.a is 0)` : ""}`;
    this.problem = this.missingFrame === undefined ? [...faults.values()][0] || "" : noTransformMessage(this.missingFrame);
  }

  _style() {
    const { options } = this;
    const { style, size, metres, alpha, auto, low, high, rainbow, inverted, first, last, local } = options;
    this.points?.setStyle({ style, size, extent: [metres, metres, metres], alpha, flat: options.flat ? this.tint : null, rainbow, inverted, low: first, high: last, bounds: auto ? null : [low, high], local });
    this.plane?.style(options);
  }

  _addPart(part) {
    this.object.add(part.object);
    return part;
  }

  _removeChild(child) {
    this.object.remove(child);
    dispose(child);
  }

  _forget() {
    this._clear();
    this.points = this.plane = this.markers = this.lastMessage = this.pointData = this.lastPose = undefined;
    setPose(this.object, IDENTITY);
  }

  _clear() {
    for (const child of [...this.object.children]) this._removeChild(child);
  }
}

function noTransformMessage(frame) {
  return frame ? `no transform to the frame ${frame}` : "its header.frame_id is empty";
}

function rotationOf(pose) {
  const place = new THREE.Object3D();
  setPose(place, pose);
  return place.quaternion;
}

// Return an option's value if it is valid, else the default or a limit: it may come from a link, which is untrusted input.
function validOption(value, /** @type {Partial<import("./options.js").Control>} */ { kind, least = -Infinity, most = Infinity, defaultValue } = {}) {
  if (kind === "number") return Number.isFinite(value) ? Math.min(most, Math.max(least, value)) : defaultValue;
  if (kind === "colour") return /^#[0-9a-f]{6}$/i.test(value) ? value : defaultValue;
  return value;
}
