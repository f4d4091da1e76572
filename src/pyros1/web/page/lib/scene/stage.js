// The stage of a 3D scene: camera, light and grid. A frame is drawn only when something has changed. z is up, as in ROS.

import * as THREE from "../../vendor/three/three.module.min.js";
import { OrbitControls } from "../../vendor/three/OrbitControls.js";
import { h } from "../dom.js";
import { Grid } from "./grid.js";
import { Ribbons } from "./ribbons.js";
import { FrameView } from "./frame_view.js";
import { Walk } from "./walk.js";

// The camera's position relative to its target. "flat" is an orthographic view from above; in "walk" the view turns around
// the camera; "ground" moves on the ground; "third" stays behind the followed frame; "frame" is fixed to it.
const VIEWS = {
  orbit: { position: [-6, -6, 5] },
  top: { position: [-0.001, 0, 14] }, // x is up on the screen
  side: { position: [0, -14, 0.5] },
  front: { position: [14, 0, 0.5] },
  flat: { position: [-0.001, 0, 100], flat: true },
  walk: { position: [-4, 0, 1.5], walks: true },
  ground: { position: [-6, -6, 5] },
  third: { position: [-5, 0, 2.5] },
  frame: { position: [0, 0, 0], walks: true, isInFrame: true },
};
/** @typedef {{name?: string, position?: number[], target?: number[], zoom?: number, axis?: string, along?: boolean}} View */

const MAX_COORDINATE = 1e7; // metres
const FLAT_HEIGHT = 16; // metres from top to bottom in the flat view

export class Stage {
  constructor(place) {
    this.scene = new THREE.Scene();
    this.background = ""; // as CSS writes colours; "" for the page's
    /** @type {(() => void) | null} */
    this.onMove = null; // called when the user has turned the view
    /** @type {[THREE.PerspectiveCamera, THREE.OrthographicCamera]} */
    this.cameras = [new THREE.PerspectiveCamera(45, 1, 0.01, 5000), new THREE.OrthographicCamera(-1, 1, 1, -1, 0.01, 5000)];
    for (const camera of this.cameras) camera.up.set(0, 0, 1); // before the controls, which turn around it
    /** @type {THREE.PerspectiveCamera | THREE.OrthographicCamera} */
    this.camera = this.cameras[0];
    this.canvas = h("canvas", { tabIndex: 0, "aria-label": "3D scene" });
    place.append(this.canvas);
    // Antialiasing takes six times as long in software rendering.
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: hasGraphicsCard() });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio || 1));
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.listenToKeyEvents(this.canvas); // arrow keys move the view
    this.controls.addEventListener("change", () => this.draw());
    let before = "";
    const now = () => JSON.stringify(this.place);
    this.controls.addEventListener("start", () => { before = now(); });
    this.controls.addEventListener("end", () => { if (now() !== before) this.onMove?.(); });
    const sun = new THREE.DirectionalLight(0xffffff, 2.2);
    sun.position.set(3, -5, 8);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x888899, 2.4), sun);
    this.grid = new Grid();
    this.scene.add(this.grid.object);
    this.walk = new Walk(this);
    this.frameView = new FrameView(this);
    this.frames = 0;
    this.lag = 0; // milliseconds that the last frame took
    this.before = []; // functions that are called before each frame
    this.after = []; // functions that are called after each frame, to draw more into it
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
    this.renderer.forceContextLoss(); // browsers allow only a few
  }

  // Select a view of a target. Walking starts at the given position, if there is one.
  view(name, target = [0, 0, 0], from = null) {
    this.name = Object.hasOwn(VIEWS, name) ? name : "orbit";
    const { position, flat, walks, isInFrame } = VIEWS[this.name];
    const eye = walks && from ? from : target.map((value, index) => value + position[index]);
    this.camera = this.cameras[flat ? 1 : 0];
    this.controls.object = this.camera;
    this.controls.enableRotate = !flat && !walks;
    this.controls.enableZoom = this.controls.enablePan = !walks;
    this.controls.screenSpacePanning = this.name !== "ground";
    this.walk.enabled = walks;
    this.followedYaw = 0;
    this._assignButtons();
    this.camera.zoom = 1;
    this.camera.up.set(0, 0, 1);
    this.controls.target.fromArray(target);
    this.camera.position.fromArray(eye);
    this.controls.update();
    if (isInFrame) this.frameView.enter();
    this.resize();
  }

  // Whether a tool uses the left mouse button; the others still move the view.
  set claimed(claimed) {
    this._claimed = claimed;
    this._assignButtons();
  }

  get claimed() {
    return this._claimed;
  }

  _assignButtons() {
    const { flat } = VIEWS[this.name];
    this.controls.mouseButtons.LEFT = this._claimed ? null : flat ? THREE.MOUSE.PAN : THREE.MOUSE.ROTATE;
    this.controls.touches.ONE = this._claimed ? null : flat ? THREE.TOUCH.PAN : THREE.TOUCH.ROTATE;
  }

  // The view as numbers, rounded to millimetres; when set, they may come from a link.
  /** @returns {View} */
  get place() {
    /** @type {View} */
    const place = this.isInFrame ? this.frameView.place : { position: this.camera.position.toArray(), target: this.controls.target.toArray(), zoom: this.camera.zoom };
    for (const name of ["position", "target"]) place[name] = place[name].map((value) => Number(value.toFixed(3)));
    return { name: this.name, ...place };
  }

  set place(/** @type {View} */ { name, position, target, zoom = 1, axis }) {
    const good = /** @returns {numbers is number[]} */ (numbers) => Array.isArray(numbers) && numbers.length === 3 && numbers.every(Number.isFinite);
    this.view(name);
    if (this.isInFrame) this.frameView.enter(good(position) && good(target) ? { axis, position, target } : { axis });
    if (this.isInFrame || !good(position) || !good(target)) return;
    this.controls.target.fromArray(target);
    this.followedYaw = null; // the given position already includes the frame's rotation
    const above = position[0] === target[0] && position[1] === target[1]; // then x is up on the screen, as in the view "top"
    this.camera.position.set(above ? position[0] - 0.001 : position[0], position[1], position[2]);
    this.camera.zoom = zoom > 0 ? zoom : 1;
    this.controls.update();
    this.resize();
  }

  // The size of the canvas in pixels.
  get size() {
    return [this.canvas.clientWidth, this.canvas.clientHeight];
  }

  // Return the size of a pixel in metres at a position.
  pixel(place) {
    const [deep, flat] = this.cameras;
    const high = this.camera === flat ? FLAT_HEIGHT / flat.zoom : 2 * place.distanceTo(deep.position) * Math.tan(deep.fov * Math.PI / 360);
    return high / (this.canvas.clientHeight || 1);
  }

  // Return whether all of an object is on the screen.
  shows(object) {
    const { min, max } = new THREE.Box3().setFromObject(object);
    this.camera.updateMatrixWorld();
    for (const x of [min.x, max.x]) for (const y of [min.y, max.y]) for (const z of [min.z, max.z]) {
      const corner = new THREE.Vector3(x, y, z).project(this.camera);
      if (Math.max(Math.abs(corner.x), Math.abs(corner.y), Math.abs(corner.z)) > 1) return false;
    }
    return true;
  }

  // Move the camera to see objects as a whole, from the current direction. Returns whether there is anything.
  fit(...objects) {
    const box = new THREE.Box3();
    for (const object of objects) object.traverse((each) => {
      each.userData.bound?.();
      const own = boundsOf(each);
      if (own) box.union(own);
    });
    const ball = box.getBoundingSphere(new THREE.Sphere());
    if (box.isEmpty() || !(ball.radius > 0)) return false;
    const narrow = Math.max(1, 1 / this.cameras[0].aspect); // a tall image shows less to the sides
    const way = this.camera.position.clone().sub(this.controls.target).setLength(Math.max(0.5, 2.95 * narrow * ball.radius));
    this.controls.target.copy(ball.center);
    this.camera.position.copy(ball.center).add(way);
    if (this.camera === this.cameras[1]) this.camera.zoom = FLAT_HEIGHT / Math.max(1, 2.4 * narrow * ball.radius);
    this.controls.update();
    this.resize();
    return true;
  }

  // Whether the camera is fixed to a frame.
  get isInFrame() {
    return Boolean(VIEWS[this.name].isInFrame);
  }

  // Move with a frame.
  follow([x, y, z, ...turn]) {
    if (this.isInFrame) {
      this.frameView.update([x, y, z, ...turn]);
      return;
    }
    if (this.name === "third") this._followRotation(turn);
    const step = new THREE.Vector3(x, y, z);
    const before = this.followed;
    this.followed = step.clone();
    if (before) step.sub(before);
    else step.sub(this.controls.target); // start by looking at the frame
    if (step.lengthSq() < 1e-12) return;
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
  }

  // Stay behind a frame that turns.
  _followRotation(/** @type {number[]} */ [x, y, z, w]) {
    const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
    const way = this.camera.position.clone().sub(this.controls.target).applyAxisAngle(new THREE.Vector3(0, 0, 1), yaw - (this.followedYaw ?? yaw));
    this.followedYaw = yaw;
    this.camera.position.copy(this.controls.target).add(way);
    this.controls.update();
  }

  // Use the page's colours, except for a background set by the user.
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

  // Schedule a frame.
  draw() {
    if (this.due || this.closed) return;
    this.due = requestAnimationFrame(() => {
      this.due = 0;
      if (this.closed) return;
      this.render();
      this.frames += 1;
      const start = performance.now();
      requestAnimationFrame((now) => { this.lag = now - start; }); // called when the card has finished
    });
  }

  // Draw a frame now.
  render() {
    for (const each of this.before) each();
    this.renderer.render(this.scene, this.camera);
    for (const each of this.after) each();
  }

  // Return the point of the ground (z = 0) under a position of the canvas in pixels; null if there is none.
  ground(x, y) {
    return this.ray(x, y).ray.intersectPlane(new THREE.Plane(new THREE.Vector3(0, 0, 1), 0), new THREE.Vector3());
  }

  // Return the ray from the camera through a position of the canvas.
  ray(x, y) {
    const ray = new THREE.Raycaster();
    const box = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld(); // it may have moved since the last frame
    ray.setFromCamera(new THREE.Vector2(2 * x / box.width - 1, 1 - 2 * y / box.height), this.camera);
    return ray;
  }

  // Return the nearest point of a solid object under a position of the canvas, or of the ground; null if there is none.
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

// Return the bounding box of an object without its children; null if it has none, or its numbers are invalid or too large:
// such a mesh must not affect the view of other objects.
function boundsOf(object) {
  if (!object.geometry) return null;
  object.updateWorldMatrix(true, false);
  if (object.isInstancedMesh) object.computeBoundingBox();
  else if (!object.geometry.boundingBox) object.geometry.computeBoundingBox();
  const own = (object.isInstancedMesh ? object : object.geometry).boundingBox.clone().applyMatrix4(object.matrixWorld);
  return [...own.min.toArray(), ...own.max.toArray()].every((value) => Math.abs(value) < MAX_COORDINATE) ? own : null;
}

// Return whether a graphics card draws the scene; the renderer's name, which browsers tell, reveals software renderers.
function hasGraphicsCard() {
  const probe = document.createElement("canvas").getContext("webgl2");
  const names = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = probe && names ? probe.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return !/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

// Free an object's memory on the graphics card.
export function dispose(object) {
  object.traverse((each) => {
    each.geometry?.dispose();
    for (const material of [each.material].flat()) {
      material?.map?.dispose();
      material?.dispose();
    }
  });
}

// Set the pose of an object: [x, y, z, qx, qy, qz, qw].
export function setPose(object, pose) {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[3], pose[4], pose[5], pose[6]).normalize(); // 0, 0, 0, 0 becomes the identity
}
