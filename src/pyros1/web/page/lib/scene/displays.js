// What topics look like in the scene. A display has an object, takes pushes of the view scene_topic, and has options.

import * as THREE from "../../vendor/three/three.module.min.js";
import { Density, Pace } from "./density.js";
import * as draw from "./draw.js";
import { MapPlane, SCHEMES } from "./map.js";
import { plural } from "../format.js";
import { MarkerSet } from "./markers.js";
import { PointSet, levels, scanPoints } from "./points.js";
import { numbers, placed } from "./select.js";
import { dispose, put } from "./stage.js";

// What one can choose: {key: {text, kind: "number" | "check" | "choice" | "colour" | "text", usual, least, most, step, choices}}.
const SIZE = { text: "size", kind: "number", usual: 3, least: 1, most: 30, step: 1 };
const ALPHA = { text: "opacity", kind: "number", usual: 1, least: 0, most: 1, step: 0.05 };
const AXES = { text: "as axes", kind: "check", usual: false };
const COVARIANCE = { text: "covariance", kind: "check", usual: true };
const TINT = { text: "colour", kind: "colour", usual: "" }; // the display's own
const FLAT = { flat: { text: "one colour", kind: "check", usual: false }, tint: TINT };
const MOST = { text: "points at most", kind: "number", usual: 1500000, least: 1000, most: 1500000, step: 1000 };
const CLOUD = { most: MOST, size: { ...SIZE, usual: 2 }, by: { text: "colour by", kind: "choice", usual: "", choices: [""] }, ...FLAT, alpha: ALPHA };
const SCREW = { scale: { text: "length of 1", kind: "number", usual: 1, least: 0.001, most: 1000, step: 0.1 } };
const OPTIONS = {
  DepthCloud: { colour: { text: "colours of", kind: "choice", usual: "", none: "no picture" }, info: { text: "CameraInfo", kind: "text", usual: "", none: "beside it" }, most: MOST, size: { ...SIZE, usual: 2 }, alpha: ALPHA },
  AccelStamped: SCREW, TwistStamped: SCREW, WrenchStamped: SCREW,
  LaserScan: { size: SIZE, ...FLAT, alpha: ALPHA }, PointCloud: CLOUD, PointCloud2: CLOUD,
  Map: { scheme: { text: "colours", kind: "choice", usual: "map", choices: SCHEMES }, alpha: { ...ALPHA, usual: 0.85 } },
  GridCells: { tint: TINT }, Imu: { tint: TINT }, Path: { tint: TINT }, PointStamped: { tint: TINT }, Polygon: { tint: TINT }, Range: { tint: TINT },
  Odometry: { tint: TINT, keep: { text: "keep", kind: "number", usual: 100, least: 1, most: 1000, step: 1 }, covariance: COVARIANCE, axes: AXES },
  Pose: { tint: TINT, axes: AXES }, PoseArray: { tint: TINT, axes: AXES }, PoseWithCovariance: { tint: TINT, covariance: COVARIANCE, axes: AXES },
};
const NUMBERS = new Float32Array(0);
const IDENTITY = [0, 0, 0, 0, 0, 0, 1];

export class Display {
  // kind: rviz's name of the display; changed(): called when it looks different without a push; pictures(): topics of them.
  constructor(colour, kind, { token = "", changed = () => {}, pictures = () => [] } = {}) {
    this.object = new THREE.Group();
    this.colour = colour;
    this.kind = kind;
    this.word = ""; // what it shows, for the list
    this.problem = "";
    this.controls = { ...OPTIONS[kind] };
    if (this.controls.tint) this.controls.tint = { ...TINT, usual: colour };
    if (this.controls.colour) this.controls.colour = { ...this.controls.colour, choices: pictures };
    this.options = Object.fromEntries(Object.entries(this.controls).map(([key, { usual }]) => [key, usual]));
    this.host = { token, changed };
    this.density = new Density();
    this.pace = new Pace();
  }

  // The arguments that its stream has besides topic and fixed frame.
  get args() {
    const { size, alpha, most, flat, tint, ...others } = this.options;
    return most ? { ...others, most: Math.min(most, this.density.enough), numbers: this.inspected === true } : {};
  }

  // Told whether one asks for the numbers behind the points.
  inspect(inspected) {
    this.inspected = inspected;
  }

  // What can be selected; see select.js.
  parts() {
    if (this.markers) return this.markers.parts();
    const about = () => [["frame", this.frame], ["shows", this.word], ...placed(this.object)];
    if (this.points) return [{ object: this.points.object, about: () => [["frame", this.frame]], points: { ...this.points.places, about: (index) => this._aboutPoint(index) } }];
    if (this.plane) return [{ object: this.object, about: (place) => [["frame", this.frame], ["shows", this.word], ...this.plane.about(place)] }];
    return [{ object: this.object, about }];
  }

  _aboutPoint(index) {
    const { indices, values, by, bytes } = this.told || {};
    const place = [...this.points.places.positions.slice(3 * index, 3 * index + 3)];
    const rows = [["point", indices ? indices[index] : `${index} of those that are drawn`], ["x, y, z", numbers(place)]];
    if (values) rows.push([by, numbers([values[index]])]);
    if (bytes) rows.push([by, `${bytes[4 * index + 2]}, ${bytes[4 * index + 1]}, ${bytes[4 * index]}`]);
    return rows;
  }

  set(options) {
    Object.assign(this.options, options);
    if (options.most) this.density.forget(); // the user knows best
    this._style();
    if (this.last && !this._trailing) this._draw(...this.last);
    this.markers?.show(this.options);
  }

  take(data, blob) {
    if (data.kind !== "patch" && data.kind !== this.drawn) {
      if (this.drawn) this._forget(); // the topic has another type now
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
    this.astray = data.pose ? "" : this.frame;
    if (!data.pose) {
      this.problem = `no way to the frame ${data.frame || "“”"}`;
      this.lost = true;
      this.object.visible = false;
      return;
    }
    this.problem = "";
    this.lost = false;
    this.object.visible = !this.hidden;
    if (!this._trailing) put(this.object, data.pose);
    this._draw(data, blob);
  }

  // Things that stand still in their frame go with it when it moves.
  place(frames) {
    const pose = this.plane && frames.pose(this.frame);
    if (pose) put(this.object, pose);
    this.markers?.place(frames);
  }

  // Told how many milliseconds the last picture took. Returns whether its stream should send less or more.
  hurry(lag, fresh) {
    const { count, every } = this;
    return Boolean(count) && !this.hidden && this.density.told(lag, { count, all: every === 1, fresh });
  }

  show(shown) {
    this.hidden = !shown;
    this.object.visible = shown && !this.lost;
  }

  close() {
    this._clear();
    dispose(this.object);
  }

  // A link may say anything.
  get tint() {
    return /^#[0-9a-f]{6}$/i.test(this.options.tint) ? this.options.tint : this.colour;
  }

  get _trailing() {
    return this.kind === "Odometry";
  }

  _draw(data, blob) {
    if (this[`_${data.kind}`]) this[`_${data.kind}`](data, blob);
    else if (draw[data.kind]) this._shape(data, blob);
  }

  _shape(data, blob) {
    this.last = [data, blob];
    const values = blob ? new Float32Array(blob.buffer, blob.offset) : NUMBERS;
    const [object, word] = draw[data.kind](data, values, this.tint, this.options);
    this.word = word;
    if (!this._trailing) this._clear();
    else {
      const place = new THREE.Group();
      put(place, data.pose);
      place.add(object);
      this.object.add(place);
      while (this.object.children.length > this.options.keep) this._drop(this.object.children[0]);
      return;
    }
    this.object.add(object);
  }

  _scan(data, blob) {
    this.points ||= this._own(new PointSet());
    const [positions, values, indices] = scanPoints(data, new Float32Array(blob.buffer, blob.offset));
    this.told = { indices, values, by: data.intensities ? "intensity" : "range" };
    this.points.set(positions, "value", levels(values));
    this._style();
    this.word = plural(positions.length / 3, "point");
  }

  _cloud({ count, every, fields, by, colour, least, most, numbers: told }, blob) {
    this.points ||= this._own(new PointSet(2));
    const positions = new Float32Array(blob.buffer, blob.offset, 3 * count);
    const more = (told ? 4 : 0) * count; // bytes before the colours: indices, and then values
    const after = blob.offset + 12 * count;
    const levelled = told && colour === "value";
    const bytes = new Uint8Array(blob.buffer, after + (levelled ? 2 : 1) * more);
    this.told = told && { by, indices: new Uint32Array(blob.buffer, after, count), values: levelled && new Float32Array(blob.buffer, after + more, count), bytes: colour === "rgb" && bytes };
    this.points.set(positions, colour, bytes, [least, most]);
    if (this.controls.by && this.controls.by.choices.length !== fields.length + 1) {
      this.controls.by = { ...CLOUD.by, choices: ["", ...fields] };
      this.host.changed("controls");
    }
    this._style();
    Object.assign(this, { count, every });
    const why = this.density.enough < this.options.most ? ": this browser draws slowly" : "";
    this.pace.tick(performance.now());
    this.word = `${plural(count, "point")}${every > 1 ? ` (one of ${every}${why}), ${this.pace}` : ""}, colour: ${by}`;
  }

  _map(data, blob) {
    this.plane ||= this._own(new MapPlane());
    this._style();
    this.plane.set(data, new Int8Array(blob.buffer, blob.offset));
    const { every } = this.plane;
    this.word = `${data.width} × ${data.height} cells${every > 1 ? `, one of ${every} across and down is shown` : ""}`;
  }

  _markers(data) {
    this.markers ||= this._own(new MarkerSet({ ...this.host, changed: (what) => { this._say(); this.host.changed(what); } }));
    this.markers.take(data);
    this.markers.show(this.options);
    const { namespaces } = this.markers;
    const known = Object.keys(this.controls).length;
    for (const name of namespaces) this.controls[`ns:${name}`] ||= { text: name || "“”", kind: "check", usual: true };
    if (Object.keys(this.controls).length !== known) this.host.changed("controls");
    this.astray = Object.entries(data.poses).find(([, pose]) => !pose)?.[0];
    this.frame = Object.keys(data.poses)[0] ?? this.frame;
    this._say();
  }

  _say() {
    const { count, faults } = this.markers;
    this.word = plural(count, "marker");
    this.problem = this.astray === undefined ? [...faults][0] || "" : `no way to the frame ${this.astray}`;
  }

  _style() {
    const { size, alpha, scheme, flat } = this.options;
    if (this.points) Object.assign(this.points, { size, alpha, flat: flat ? this.tint : null });
    if (this.plane) this.plane.style({ scheme, alpha });
  }

  _own(part) {
    this.object.add(part.object);
    return part;
  }

  _drop(child) {
    this.object.remove(child);
    dispose(child);
  }

  _forget() {
    this._clear();
    this.points = this.plane = this.markers = this.last = this.told = undefined;
    put(this.object, IDENTITY);
  }

  _clear() {
    for (const child of [...this.object.children]) this._drop(child);
  }
}
