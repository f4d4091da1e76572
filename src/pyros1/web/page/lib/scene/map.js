// An occupancy grid as a textured plane that can be updated in part.

import * as THREE from "../../vendor/three/three.module.min.js";
import { dispose } from "./stage.js";

const MAX_TEXTURE = 8192; // maximum texture size of graphics cards; of larger grids only every n-th cell is shown

export const COLOUR_SCHEMES = ["map", "costmap", "raw"];

// rviz's colours of the 256 values of a cell, as pixels.
function colourTable(scheme) {
  const pixels = new Uint32Array(256);
  const put = (cell, red, green, blue, alpha) => { pixels[cell & 255] = ((alpha << 24) | (blue << 16) | (green << 8) | red) >>> 0; };
  for (let cell = -128; cell < 128; cell += 1) {
    if (scheme === "raw") put(cell, cell & 255, cell & 255, cell & 255, 255);
    else if (cell > 100) put(cell, 0, 255, 0, 255); // invalid value
    else if (cell < -1) put(cell, 255, Math.round(255 * (cell + 128) / 126), 0, 255); // invalid value
    else if (scheme === "costmap") {
      if (cell === -1) put(cell, 112, 137, 134, 255);
      else if (cell === 0) put(cell, 0, 0, 0, 0);
      else if (cell === 99) put(cell, 0, 255, 255, 255);
      else if (cell === 100) put(cell, 255, 0, 255, 255);
      else put(cell, Math.round(255 * cell / 100), 0, 255 - Math.round(255 * cell / 100), 255);
    } else if (cell === -1) put(cell, 112, 137, 134, 255);
    else {
      const grey = 255 - Math.round(2.55 * cell);
      put(cell, grey, grey, grey, 255);
    }
  }
  return pixels;
}

export class MapPlane {
  constructor() {
    this.object = new THREE.Group();
    this.plane = null;
    /** @type {THREE.DataTexture | null} */
    this.texture = null;
    this.cells = new Int8Array(0);
    this.width = 0; // cells in a row
    this.resolution = 1; // metres per cell
    this.every = 1; // of this many cells across and down, one is shown
    this.scheme = "map";
    this.alpha = 0.7;
    this.behind = false;
  }

  // Set a complete grid.
  set({ width, height, resolution, origin }, cells) {
    this._clear();
    const every = Math.max(1, Math.ceil(Math.max(width, height) / MAX_TEXTURE));
    this.width = width;
    this.resolution = resolution;
    this.every = every;
    this.cells = new Int8Array(cells.subarray(0, width * height));
    if (!width || !height) return;
    const [columns, rows] = [width, height].map((count) => Math.ceil(count / every));
    this.texture = new THREE.DataTexture(new Uint8Array(4 * columns * rows), columns, rows);
    this.texture.colorSpace = THREE.SRGBColorSpace;
    this._colour();
    const [across, up] = [width * resolution, height * resolution];
    const plane = new THREE.Mesh(
      new THREE.PlaneGeometry(across, up).translate(across / 2, up / 2, 0),
      new THREE.MeshBasicMaterial({ map: this.texture, opacity: this.alpha, side: THREE.DoubleSide, depthWrite: false, polygonOffset: true, polygonOffsetFactor: 1 }));
    setLayer(plane, this.behind);
    plane.position.set(origin[0] ?? 0, origin[1] ?? 0, origin[2] ?? 0);
    plane.quaternion.fromArray(origin.slice(3).map((value) => value ?? 0));
    plane.quaternion.normalize(); // 0, 0, 0, 0 becomes the identity
    this.object.add(plane);
    this.plane = plane;
  }

  // Update a part of it.
  patch({ x, y, width, height }, cells) {
    if (!this.texture || x + width > this.width) return;
    for (let row = 0; row < height; row += 1) {
      this.cells.set(cells.subarray(row * width, (row + 1) * width), (y + row) * this.width + x);
    }
    this._colour(y, y + height);
  }

  // Return the cell at a point of the scene, for select_tool.js.
  about(place) {
    if (!place || !this.plane) return [];
    const { x, y } = this.plane.worldToLocal(place.clone());
    const [column, row] = [x, y].map((value) => Math.floor(value / this.resolution));
    return [["cell", `${column}, ${row}`], ["value", this.cells[row * this.width + column] ?? "none"]];
  }

  style({ scheme, alpha, behind }) {
    this.scheme = scheme;
    this.alpha = alpha;
    this.behind = behind;
    if (!this.plane) return;
    this.plane.material.opacity = alpha;
    setLayer(this.plane, behind);
    this._colour();
  }

  _colour(low = 0, high = Infinity) {
    const colours = colourTable(this.scheme);
    const { every, width, cells, texture } = this;
    if (!texture) return;
    const { width: columns, height: rows, data } = texture.image;
    const pixels = new Uint32Array(data.buffer);
    for (let row = Math.floor(low / every); row < rows && row * every < high; row += 1) {
      for (let column = 0, from = row * every * width; column < columns; column += 1, from += every) pixels[row * columns + column] = colours[cells[from] & 255];
    }
    texture.needsUpdate = true;
  }

  _clear() {
    for (const child of [...this.object.children]) {
      this.object.remove(child);
      dispose(child);
    }
    this.plane = this.texture = null;
  }
}

// Set whether a plane is behind everything: it is then drawn first, before opaque objects, and hides none of them.
function setLayer(plane, behind) {
  const { material } = plane;
  plane.renderOrder = behind ? -2 : -1;
  Object.assign(material, { transparent: !behind, blending: behind ? THREE.CustomBlending : THREE.NormalBlending });
  Object.assign(material, { blendSrc: THREE.SrcAlphaFactor, blendDst: THREE.OneMinusSrcAlphaFactor });
  material.needsUpdate = true;
}
