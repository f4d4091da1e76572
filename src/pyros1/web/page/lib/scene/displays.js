// What topics look like in the scene. A display has an object, takes pushes of the view scene_topic, and has settings.

import * as THREE from "../../vendor/three/three.module.min.js";
import { MarkerSet, arrowOf } from "./markers.js";
import { PointSet, cloudColours, cloudPoints, paint, scanPoints } from "./points.js";
import { dispose, put } from "./stage.js";

// Types that can be shown, and rviz's names of their displays.
export const TYPES = {
  "sensor_msgs/LaserScan": "LaserScan",
  "sensor_msgs/PointCloud2": "PointCloud2",
  "nav_msgs/OccupancyGrid": "Map",
  "nav_msgs/Path": "Path",
  "nav_msgs/Odometry": "Odometry",
  "geometry_msgs/PoseStamped": "Pose",
  "geometry_msgs/PoseWithCovarianceStamped": "PoseWithCovariance",
  "geometry_msgs/PoseArray": "PoseArray",
  "geometry_msgs/PointStamped": "PointStamped",
  "sensor_msgs/Range": "Range",
  "sensor_msgs/Imu": "Imu",
  "visualization_msgs/Marker": "Marker",
  "visualization_msgs/MarkerArray": "MarkerArray",
};
const KEPT = 100; // poses of an odometry's trail

export class Display {
  constructor(colour) {
    this.object = new THREE.Group();
    this.colour = colour;
    this.word = ""; // what it shows, for the list
    this.problem = "";
  }

  take(data, blob) {
    if (data.kind === "markers") {
      this.markers ||= this._own(new MarkerSet());
      this.markers.take(data);
      this.word = `${this.markers.count} markers`;
      this.problem = Object.entries(data.poses).filter(([, pose]) => !pose).map(([frame]) => `no way to the frame ${frame}`)[0] || "";
      return;
    }
    if (!data.pose) {
      this.problem = `no way to the frame ${data.frame || "“”"}`;
      this.object.visible = false;
      return;
    }
    this.problem = "";
    this.object.visible = true;
    if (data.kind !== "poses" || !this.trail) put(this.object, data.pose);
    this[data.kind](data, blob);
  }

  close() {
    dispose(this.object);
  }

  scan(data, blob) {
    this.points ||= this._own(new PointSet());
    const [positions, values] = scanPoints(data, new Float32Array(blob.buffer, blob.offset));
    const colours = new Float32Array(positions.length);
    paint(colours, values);
    this.points.set(positions, colours);
    this.word = `${positions.length / 3} points`;
  }

  cloud(data, blob) {
    this.points ||= this._own(new PointSet(2));
    const view = new DataView(blob.buffer, blob.offset);
    const cloud = cloudPoints(data, view);
    this.points.set(cloud.positions, cloudColours(data, cloud, this.by, view));
    this.word = `${data.count} points${data.every > 1 ? `, one of ${data.every}` : ""}`;
  }

  map(data, blob) {
    const { width, height, resolution, origin } = data;
    const cells = new Int8Array(blob.buffer, blob.offset);
    const pixels = new Uint8Array(4 * width * height);
    for (let index = 0; index < cells.length; index += 1) {
      const cell = cells[index];
      const [grey, alpha] = cell < 0 || cell > 100 ? [112, 130] : [255 - Math.round(cell * 2.55), 235];
      pixels.set([grey, grey, grey, alpha], 4 * index);
    }
    this._clear();
    if (!width || !height) return;
    const texture = new THREE.DataTexture(pixels, width, height);
    texture.colorSpace = THREE.SRGBColorSpace;
    texture.needsUpdate = true;
    const plane = new THREE.Mesh(
      new THREE.PlaneGeometry(width * resolution, height * resolution).translate(width * resolution / 2, height * resolution / 2, 0),
      new THREE.MeshBasicMaterial({ map: texture, transparent: true, side: THREE.DoubleSide, depthWrite: false }));
    const place = new THREE.Group();
    put(place, origin.map((value) => value ?? 0));
    place.add(plane);
    this.object.add(place);
    this.word = `${width} × ${height} cells`;
  }

  path(data, blob) {
    const poses = new Float32Array(blob.buffer, blob.offset);
    const positions = new Float32Array(3 * data.count);
    for (let index = 0; index < data.count; index += 1) positions.set(poses.subarray(7 * index, 7 * index + 3), 3 * index);
    this._clear();
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(positions, 3));
    const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: this.colour }));
    line.frustumCulled = false;
    this.object.add(line);
    this.word = `${data.count} poses`;
  }

  poses(data, blob) {
    const poses = new Float32Array(blob.buffer, blob.offset);
    if (!this.trail) this._clear();
    this.arrows ||= new THREE.MeshStandardMaterial({ color: this.colour, roughness: 0.8 });
    for (let index = 0; index < Math.min(data.count, 2000); index += 1) {
      const place = new THREE.Group();
      put(place, poses.subarray(7 * index, 7 * index + 7));
      place.add(arrowOf(0.5, 0.15, 0.03, 0.09, this.arrows));
      this.object.add(place);
    }
    while (this.trail && this.object.children.length > KEPT) this._drop(this.object.children[0]);
    this.word = data.count === 1 ? "" : `${data.count} poses`;
  }

  point({ point }) {
    this._clear();
    const ball = new THREE.Mesh(new THREE.SphereGeometry(0.1, 20, 14), new THREE.MeshStandardMaterial({ color: this.colour }));
    ball.position.set(...point.map((value) => value ?? 0));
    this.object.add(ball);
  }

  range({ range, angle, inside }) {
    this._clear();
    if (!inside || !range) {
      this.word = "nothing in range";
      return;
    }
    const radius = range * Math.tan(Math.min(1.5, angle / 2));
    const cone = new THREE.Mesh(
      new THREE.ConeGeometry(radius, range, 32, 1, true).rotateZ(Math.PI / 2).translate(range / 2, 0, 0),
      new THREE.MeshStandardMaterial({ color: this.colour, opacity: 0.5, transparent: true, side: THREE.DoubleSide, depthWrite: false }));
    this.object.add(cone);
    this.word = `${range.toFixed(2)} m`;
  }

  imu({ orientation, acceleration }) {
    this._clear();
    const box = new THREE.Mesh(new THREE.BoxGeometry(0.4, 0.25, 0.1), new THREE.MeshStandardMaterial({ color: this.colour, opacity: 0.7, transparent: true }));
    put(box, [0, 0, 0, ...orientation.map((value) => value ?? 0)]);
    const push = new THREE.Vector3(...acceleration.map((value) => value ?? 0));
    this.object.add(box);
    if (push.length() > 1e-6) this.object.add(new THREE.ArrowHelper(push.clone().normalize(), new THREE.Vector3(), push.length() / 9.81, 0xe8590c));
  }

  _own(part) {
    this.object.add(part.object);
    return part;
  }

  _drop(child) {
    this.object.remove(child);
    dispose(child);
  }

  _clear() {
    for (const child of [...this.object.children]) this._drop(child);
  }
}
