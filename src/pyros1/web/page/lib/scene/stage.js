// The stage of a 3D scene: camera, light, grid, and a picture only when something has changed. z is up, as in ROS.

import * as THREE from "../../vendor/three/three.module.min.js";
import { OrbitControls } from "../../vendor/three/OrbitControls.js";
import { h } from "../dom.js";
import { Grid } from "./grid.js";
import { Ribbons } from "./ribbons.js";
import { Seat } from "./seat.js";
import { Walk } from "./walk.js";

// Where the camera stands, from what it looks at. "flat" is without perspective, from above; in "walk" one turns around the
// eye; "ground" moves on the ground; "third" stays behind the frame that is followed, as it turns; "frame" sits in it.
const VIEWS = {
  orbit: { position: [-6, -6, 5] },
  top: { position: [-0.001, 0, 14] }, // x is up in the picture
  side: { position: [0, -14, 0.5] },
  front: { position: [14, 0, 0.5] },
  flat: { position: [-0.001, 0, 100], flat: true },
  walk: { position: [-4, 0, 1.5], walks: true },
  ground: { position: [-6, -6, 5] },
  third: { position: [-5, 0, 2.5] },
  frame: { position: [0, 0, 0], walks: true, sits: true },
};
/** @typedef {{name?: string, position?: number[], target?: number[], zoom?: number, axis?: string, along?: boolean}} View */

const FARTHEST = 1e7; // metres
const FLAT_HEIGHT = 16; // metres that the flat view shows from top to bottom

export class Stage {
  constructor(place) {
    this.scene = new THREE.Scene();
    this.background = ""; // as CSS writes colours; "" for the page's
    /** @type {(() => void) | null} */
    this.moved = null; // called when the user has turned the view
    /** @type {[THREE.PerspectiveCamera, THREE.OrthographicCamera]} */
    this.cameras = [new THREE.PerspectiveCamera(45, 1, 0.01, 5000), new THREE.OrthographicCamera(-1, 1, 1, -1, 0.01, 5000)];
    for (const camera of this.cameras) camera.up.set(0, 0, 1); // before the controls, which turn around it
    /** @type {THREE.PerspectiveCamera | THREE.OrthographicCamera} */
    this.camera = this.cameras[0];
    this.canvas = h("canvas", { tabIndex: 0, "aria-label": "3D scene" });
    place.append(this.canvas);
    // Smooth edges take six times as long where the processor draws instead of a graphics card.
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: hasCard() });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.listenToKeyEvents(this.canvas); // arrows move the view
    this.controls.addEventListener("change", () => this.draw());
    let before = "";
    const now = () => JSON.stringify(this.place);
    this.controls.addEventListener("start", () => { before = now(); });
    this.controls.addEventListener("end", () => { if (now() !== before) this.moved?.(); });
    const sun = new THREE.DirectionalLight(0xffffff, 2.2);
    sun.position.set(3, -5, 8);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x888899, 2.4), sun);
    this.grid = new Grid();
    this.scene.add(this.grid.object);
    this.walk = new Walk(this);
    this.seat = new Seat(this);
    this.frames = 0;
    this.lag = 0; // milliseconds that the last picture took
    this.before = []; // called before each picture
    this.after = []; // called after each picture, to draw more into it
    this.view("orbit");
    this.colours();
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(place);
    this.parent = place;
    this.resize();
  }

  close() {
    this.closed = true;
    this.observer.disconnect();
    this.controls.dispose();
    this.walk.close();
    this.scene.traverse((each) => dispose(each));
    this.renderer.dispose();
    this.renderer.forceContextLoss(); // a browser has few
  }

  // Look from somewhere at a target. One that walks begins where one is, if one was somewhere.
  view(name, target = [0, 0, 0], from = null) {
    this.name = Object.hasOwn(VIEWS, name) ? name : "orbit";
    const { position, flat, walks, sits } = VIEWS[this.name];
    const eye = walks && from ? from : target.map((value, index) => value + position[index]);
    this.camera = this.cameras[flat ? 1 : 0];
    this.controls.object = this.camera;
    this.controls.enableRotate = !flat && !walks;
    this.controls.enableZoom = this.controls.enablePan = !walks;
    this.controls.screenSpacePanning = this.name !== "ground";
    this.walk.enabled = walks;
    this.turned = 0;
    this._grip();
    this.camera.zoom = 1;
    this.camera.up.set(0, 0, 1);
    this.controls.target.fromArray(target);
    this.camera.position.fromArray(eye);
    this.controls.update();
    if (sits) this.seat.sit();
    this.resize();
  }

  // Whether a tool has the left button of the mouse; the others still move the view.
  set claimed(claimed) {
    this._claimed = claimed;
    this._grip();
  }

  get claimed() {
    return this._claimed;
  }

  _grip() {
    const { flat } = VIEWS[this.name];
    this.controls.mouseButtons.LEFT = this._claimed ? null : flat ? THREE.MOUSE.PAN : THREE.MOUSE.ROTATE;
    this.controls.touches.ONE = this._claimed ? null : flat ? THREE.TOUCH.PAN : THREE.TOUCH.ROTATE;
  }

  // The view as numbers, of metres to three digits, and back; they may come from a link.
  /** @returns {View} */
  get place() {
    /** @type {View} */
    const place = this.sits ? this.seat.place : { position: this.camera.position.toArray(), target: this.controls.target.toArray(), zoom: this.camera.zoom };
    for (const name of ["position", "target"]) place[name] = place[name].map((value) => Number(value.toFixed(3)));
    return { name: this.name, ...place };
  }

  set place(/** @type {View} */ { name, position, target, zoom, axis }) {
    const good = (numbers) => Array.isArray(numbers) && numbers.length === 3 && numbers.every(Number.isFinite);
    this.view(name);
    if (this.sits) this.seat.sit(good(position) && good(target) ? { axis, position, target } : { axis });
    if (this.sits || !good(position) || !good(target)) return;
    this.controls.target.fromArray(target);
    this.turned = null; // it has turned with the frame already
    const above = position[0] === target[0] && position[1] === target[1]; // then x is up in the picture, as in the view "top"
    this.camera.position.set(above ? position[0] - 0.001 : position[0], position[1], position[2]);
    this.camera.zoom = zoom > 0 ? zoom : 1;
    this.controls.update();
    this.resize();
  }

  // The pixels of the picture, across and down.
  get size() {
    return [this.canvas.clientWidth, this.canvas.clientHeight];
  }

  // The metres that a pixel of the picture covers at a place.
  pixel(place) {
    const [deep, flat] = this.cameras;
    const high = this.camera === flat ? FLAT_HEIGHT / flat.zoom : 2 * place.distanceTo(deep.position) * Math.tan(deep.fov * Math.PI / 360);
    return high / (this.canvas.clientHeight || 1);
  }

  // Whether all of a thing is in the picture.
  shows(object) {
    const { min, max } = new THREE.Box3().setFromObject(object);
    this.camera.updateMatrixWorld();
    for (const x of [min.x, max.x]) for (const y of [min.y, max.y]) for (const z of [min.z, max.z]) {
      const corner = new THREE.Vector3(x, y, z).project(this.camera);
      if (Math.max(Math.abs(corner.x), Math.abs(corner.y), Math.abs(corner.z)) > 1) return false;
    }
    return true;
  }

  // Look at things as a whole, from where one looks now. Returns whether there is anything.
  fit(...objects) {
    const box = new THREE.Box3();
    for (const object of objects) object.traverse((each) => {
      each.userData.bound?.();
      const own = roomOf(each);
      if (own) box.union(own);
    });
    const ball = box.getBoundingSphere(new THREE.Sphere());
    if (box.isEmpty() || !(ball.radius > 0)) return false;
    const narrow = Math.max(1, 1 / this.cameras[0].aspect); // a picture that is high shows less to the sides
    const way = this.camera.position.clone().sub(this.controls.target).setLength(Math.max(0.5, 2.95 * narrow * ball.radius));
    this.controls.target.copy(ball.center);
    this.camera.position.copy(ball.center).add(way);
    if (this.camera === this.cameras[1]) this.camera.zoom = FLAT_HEIGHT / Math.max(1, 2.4 * narrow * ball.radius);
    this.controls.update();
    this.resize();
    return true;
  }

  // Whether one sits in the frame that is followed, or in the fixed one.
  get sits() {
    return Boolean(VIEWS[this.name].sits);
  }

  // Go along with something that has moved.
  follow([x, y, z, ...turn]) {
    if (this.sits) {
      this.seat.take([x, y, z, ...turn]);
      return;
    }
    if (this.name === "third") this._turn(turn);
    const step = new THREE.Vector3(x, y, z);
    const before = this.followed;
    this.followed = step.clone();
    if (before) step.sub(before);
    else step.sub(this.controls.target); // begin by looking at it
    if (step.lengthSq() < 1e-12) return;
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
  }

  // Stay behind something that turns.
  _turn(/** @type {number[]} */ [x, y, z, w]) {
    const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
    const way = this.camera.position.clone().sub(this.controls.target).applyAxisAngle(new THREE.Vector3(0, 0, 1), yaw - (this.turned ?? yaw));
    this.turned = yaw;
    this.camera.position.copy(this.controls.target).add(way);
    this.controls.update();
  }

  // Colours follow the page's, but for a background of one's own.
  colours() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => new THREE.Color(style.getPropertyValue(name).trim() || "#888888");
    this.renderer.setClearColor(this.background ? new THREE.Color(this.background) : colour("--page"));
    this.grid.colours(colour("--muted"), colour("--border"));
    this.draw();
  }

  resize() {
    const { clientWidth, clientHeight } = this.parent || this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    const [deep, flat] = this.cameras;
    deep.aspect = clientWidth / clientHeight;
    [flat.left, flat.right] = [-1, 1].map((side) => side * FLAT_HEIGHT / 2 * deep.aspect);
    [flat.bottom, flat.top] = [-FLAT_HEIGHT / 2, FLAT_HEIGHT / 2];
    for (const camera of this.cameras) camera.updateProjectionMatrix();
    this.draw();
  }

  // Draw soon, once.
  draw() {
    if (this.due || this.closed) return;
    this.due = requestAnimationFrame(() => {
      this.due = 0;
      if (this.closed) return;
      this.render();
      this.frames += 1;
      const start = performance.now();
      requestAnimationFrame((now) => { this.lag = now - start; }); // it comes when the card has done its work
    });
  }

  // Draw now.
  render() {
    for (const each of this.before) each();
    this.renderer.render(this.scene, this.camera);
    for (const each of this.after) each();
  }

  // The point of the ground (z = 0) under a place of the canvas in pixels; null if there is none.
  ground(x, y) {
    return this.ray(x, y).ray.intersectPlane(new THREE.Plane(new THREE.Vector3(0, 0, 1), 0), new THREE.Vector3());
  }

  // The ray from the eye through a place of the canvas.
  ray(x, y) {
    const ray = new THREE.Raycaster();
    const box = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld(); // it may have moved since the last picture was drawn
    ray.setFromCamera(new THREE.Vector2(2 * x / box.width - 1, 1 - 2 * y / box.height), this.camera);
    return ray;
  }

  // The nearest place of something solid under a place of the canvas, else of the ground; null if there is none.
  surface(x, y) {
    const solid = [];
    this.scene.traverseVisible((each) => { if (each instanceof THREE.Mesh && !(each instanceof Ribbons) && !each.userData.tool) solid.push(each); });
    return this.ray(x, y).intersectObjects(solid, false)[0]?.point || this.ground(x, y);
  }

  png() {
    this.render();
    return new Promise((resolve) => { this.canvas.toBlob(resolve, "image/png"); });
  }
}

// The room that an object takes without its children; null if it is none, or none that could be seen: one mesh with wrong
// numbers must not hide the others.
function roomOf(object) {
  if (!object.geometry) return null;
  object.updateWorldMatrix(true, false);
  if (object.isInstancedMesh) object.computeBoundingBox();
  else if (!object.geometry.boundingBox) object.geometry.computeBoundingBox();
  const own = (object.isInstancedMesh ? object : object.geometry).boundingBox.clone().applyMatrix4(object.matrixWorld);
  return [...own.min.toArray(), ...own.max.toArray()].every((value) => Math.abs(value) < FARTHEST) ? own : null;
}

// Browsers say by name who draws.
function hasCard() {
  const probe = document.createElement("canvas").getContext("webgl2");
  const names = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = names ? probe.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return !/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

// Free what a part of the scene holds on the graphics card.
export function dispose(object) {
  object.traverse((each) => {
    each.geometry?.dispose();
    for (const material of [each.material].flat()) {
      material?.map?.dispose();
      material?.dispose();
    }
  });
}

// Put an object at a pose: [x, y, z, qx, qy, qz, qw].
export function put(object, pose) {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[3], pose[4], pose[5], pose[6]).normalize(); // 0, 0, 0, 0 turns nothing
}
