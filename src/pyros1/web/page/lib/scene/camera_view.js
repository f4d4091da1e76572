// A camera's image in a corner of the scene, with the scene drawn over it from the camera's point of view.

import * as THREE from "../../vendor/three/three.module.min.js";
import { h } from "../dom.js";
import { drawPicture } from "../images.js";
import { setPose } from "./stage.js";

const NEAR = 0.01; // metres
const MAX_TEXTURE = 1024; // pixels of an image's longer side on the graphics card
const CAMERA_ROTATION = new THREE.Quaternion(1, 0, 0, 0); // cameras look along z with y down in ROS, and along -z with y up in three.js
const SCREEN_CAMERA = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);

// Return the left, right, top and bottom of a camera's field of view at a distance of 1; see pyros1/web/scene/camera.py.
export function fieldOfView({ fx, fy, cx, cy, width, height }, zoom = 1) {
  const [across, down] = [width / 2 / fx / zoom, height / 2 / fy / zoom];
  const [right, low] = [(width / 2 - 0.5 - cx) / fx, (height / 2 - 0.5 - cy) / fy];
  return [right - across, right + across, down - low, -down - low];
}

export class CameraView {
  // place: the element to overlay; stage: the scene that is drawn; frames: FrameSet; changed(): see Overlay.
  constructor(place, title, { stage, frames, changed }) {
    this.stage = stage;
    this.frames = frames;
    this.changed = changed;
    this.hole = h("div.hole", { role: "img", "aria-label": `what the camera of ${title} sees` }); // the stage's canvas is visible through it
    this.figure = h("figure.overlay.camera", { title, onclick: () => { this.figure.classList.toggle("large"); stage.draw(); } }, this.hole, h("figcaption.mono", {}, title));
    place.append(this.figure);
    this.canvas = h("canvas"); // the image
    this.scaledCanvas = h("canvas"); // the same, reduced to what is needed
    this.material = new THREE.MeshBasicMaterial({ depthTest: false, depthWrite: false, toneMapped: false, transparent: true });
    this.picture = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), this.material);
    this.imageScene = new THREE.Scene().add(this.picture);
    this.camera = new THREE.PerspectiveCamera();
    this.object = null; // no object in the scene
    this.status = "no image yet";
    this.problem = "";
    this.controls = {
      alpha: { text: "overlay alpha", kind: "number", defaultValue: 0.2, least: 0, most: 1, step: 0.05 },
      behind: { text: "image in background", kind: "check", defaultValue: true },
      zoom: { text: "zoom", kind: "number", defaultValue: 1, least: 0.1, most: 20, step: 0.1 },
      info: { text: "CameraInfo", kind: "text", defaultValue: "", none: "next to the image" },
    };
    this.options = { alpha: 0.2, behind: true, zoom: 1, info: "" };
    this.draw = () => this._draw();
    stage.after.push(this.draw);
  }

  // The arguments of its stream, in addition to topic and fixed frame.
  get args() {
    return { info: this.options.info };
  }

  set(options) {
    Object.assign(this.options, options);
    this.options.zoom = Math.min(20, Math.max(0.1, this.options.zoom)); // links are untrusted input
  }

  // Apply data of the view scene_camera. Returns a promise that resolves when it is drawn.
  async update(facts, blob) {
    try {
      if (!await drawPicture(this.canvas, facts, new Uint8Array(blob.buffer, blob.offset)) || this.closed) return;
      this._shrink();
      const { width, height } = this.canvas;
      this.hole.style.aspectRatio = `${width} / ${height}`;
      this.cameraInfo = facts.camera && facts.pose ? { ...facts.camera, width: facts.camera.width || width, height: facts.camera.height || height } : null;
      if (this.cameraInfo) this._placeCamera(facts.pose, this.cameraInfo);
      this.status = `${width} × ${height}, from ${facts.frame}`;
      this.problem = facts.why || (facts.pose ? "" : `no transform to the frame ${facts.frame || "“”"}`);
    } catch (error) {
      this.problem = error.message;
    }
    this.changed();
  }

  show(visible) {
    this.figure.hidden = !visible;
  }

  close() {
    this.closed = true;
    this.stage.after.splice(this.stage.after.indexOf(this.draw), 1);
    this.figure.remove();
    this.picture.geometry.dispose();
    this.material.map?.dispose();
    this.material.dispose();
  }

  _shrink() {
    const scale = Math.min(1, MAX_TEXTURE / Math.max(this.canvas.width, this.canvas.height));
    const [width, height] = [this.canvas.width, this.canvas.height].map((size) => Math.max(1, Math.round(size * scale)));
    if (this.scaledCanvas.width !== width || this.scaledCanvas.height !== height || !this.material.map) {
      Object.assign(this.scaledCanvas, { width, height });
      this.material.map?.dispose();
      this.material.map = new THREE.CanvasTexture(this.scaledCanvas);
      this.material.map.colorSpace = THREE.SRGBColorSpace;
      this.material.needsUpdate = true;
    }
    this.scaledCanvas.getContext("2d").drawImage(this.canvas, 0, 0, width, height);
    this.material.map.needsUpdate = true;
  }

  _placeCamera(pose, { tx, ty }) {
    setPose(this.camera, pose);
    this.camera.position.add(new THREE.Vector3(tx, ty, 0).applyQuaternion(this.camera.quaternion));
    this.camera.quaternion.multiply(CAMERA_ROTATION);
  }

  // Draw into the part of the stage's canvas that is visible through the hole.
  _draw() {
    if (!this.material.map || this.figure.hidden) return;
    const { renderer, scene, canvas } = this.stage;
    const [all, hole] = [canvas, this.hole].map((each) => each.getBoundingClientRect());
    const scale = Math.min(hole.width / this.scaledCanvas.width, hole.height / this.scaledCanvas.height);
    const [width, height] = [this.scaledCanvas.width * scale, this.scaledCanvas.height * scale];
    if (width < 1 || height < 1) return;
    const place = [hole.left - all.left + (hole.width - width) / 2, all.bottom - hole.bottom + (hole.height - height) / 2, width, height];
    renderer.setViewport(...place);
    renderer.setScissor(...place);
    renderer.setScissorTest(true);
    renderer.autoClear = false;
    renderer.clear();
    const { alpha, behind, zoom } = this.options;
    this.picture.scale.setScalar(zoom);
    if (behind || !this.cameraInfo) this._drawImage(renderer, 1);
    if (this.cameraInfo) {
      const [left, right, top, bottom] = fieldOfView(this.cameraInfo, zoom);
      this.camera.projectionMatrix.makePerspective(NEAR * left, NEAR * right, NEAR * top, NEAR * bottom, NEAR, 5000);
      this.camera.projectionMatrixInverse.copy(this.camera.projectionMatrix).invert();
      this.frames.faceCamera({ camera: this.camera, size: [width, height], pixel: (point) => point.distanceTo(this.camera.position) * (right - left) / width });
      renderer.render(scene, this.camera);
      if (alpha > 0) this._drawImage(renderer, alpha);
    }
    renderer.autoClear = true;
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, all.width, all.height);
  }

  _drawImage(renderer, opacity) {
    this.material.opacity = opacity;
    renderer.render(this.imageScene, SCREEN_CAMERA);
    renderer.clearDepth();
  }
}
