// Clouds and scans as points.

import * as THREE from "../../vendor/three/three.module.min.js";
import { bounds, rainbow } from "./colours.js";

const READ = { 1: "getInt8", 2: "getUint8", 3: "getInt16", 4: "getUint16", 5: "getInt32", 6: "getUint32", 7: "getFloat32", 8: "getFloat64" };

// Return the positions of a scan, and what to colour them by: [Float32Array of x, y, z, Float32Array of values].
export function scanPoints(facts, numbers) {
  const { start, step, least, most, count, intensities } = facts;
  const positions = new Float32Array(3 * count);
  const values = new Float32Array(count);
  let kept = 0;
  for (let index = 0; index < count; index += 1) {
    const range = numbers[index];
    if (!(range >= least && range <= most)) continue;
    const angle = start + index * step;
    positions[3 * kept] = range * Math.cos(angle);
    positions[3 * kept + 1] = range * Math.sin(angle);
    values[kept] = intensities ? numbers[count + index] : range;
    kept += 1;
  }
  return [positions.subarray(0, 3 * kept), values.subarray(0, kept)];
}

// Return the positions of a cloud and a function that colours them.
export function cloudPoints(facts, view) {
  const { count, step, fields, bigendian } = facts;
  const reader = (name) => {
    const [offset, kind] = fields[name];
    const read = READ[kind];
    return read ? (index) => view[read](index * step + offset, !bigendian) : () => NaN;
  };
  const [x, y, z] = ["x", "y", "z"].map(reader);
  const positions = new Float32Array(3 * count);
  for (let index = 0; index < count; index += 1) {
    positions[3 * index] = x(index);
    positions[3 * index + 1] = y(index);
    positions[3 * index + 2] = z(index);
  }
  return { positions, reader };
}

// Colours of a cloud: by "rgb" if it has it, else by a field, else by height.
export function cloudColours(facts, { positions, reader }, by, view) {
  const { count, step, fields, bigendian } = facts;
  const colours = new Float32Array(3 * count);
  const packed = ["rgb", "rgba"].find((name) => fields[name]);
  if (packed && (by === "rgb" || !by)) {
    const [offset] = fields[packed];
    for (let index = 0; index < count; index += 1) {
      const value = view.getUint32(index * step + offset, !bigendian);
      colours[3 * index] = ((value >> 16) & 255) / 255;
      colours[3 * index + 1] = ((value >> 8) & 255) / 255;
      colours[3 * index + 2] = (value & 255) / 255;
    }
    return colours;
  }
  const name = fields[by] ? by : fields.intensity && by !== "z" ? "intensity" : "z";
  const values = new Float32Array(count);
  if (name === "z") for (let index = 0; index < count; index += 1) values[index] = positions[3 * index + 2];
  else for (let index = 0, read = reader(name); index < count; index += 1) values[index] = read(index);
  paint(colours, values);
  return colours;
}

export function paint(colours, values) {
  const [least, most] = bounds(values);
  const scale = most > least ? 1 / (most - least) : 0;
  for (let index = 0; index < values.length; index += 1) rainbow((values[index] - least) * scale, colours, 3 * index);
}

// Points that keep their room on the graphics card while their number changes.
export class PointSet {
  constructor(size = 3) {
    this.material = new THREE.PointsMaterial({ size, sizeAttenuation: false, vertexColors: true });
    this.object = new THREE.Points(new THREE.BufferGeometry(), this.material);
    this.object.frustumCulled = false;
    this.room = 0;
  }

  set(positions, colours) {
    const count = positions.length / 3;
    const { geometry } = this.object;
    if (count > this.room) {
      this.room = Math.ceil(count * 1.2);
      for (const name of ["position", "color"]) {
        const attribute = new THREE.BufferAttribute(new Float32Array(3 * this.room), 3);
        attribute.setUsage(THREE.DynamicDrawUsage);
        geometry.setAttribute(name, attribute);
      }
    }
    if (this.room) {
      for (const [name, numbers] of [["position", positions], ["color", colours]]) {
        const attribute = geometry.getAttribute(name);
        attribute.array.set(numbers);
        attribute.clearUpdateRanges();
        attribute.addUpdateRange(0, numbers.length);
        attribute.needsUpdate = true;
      }
    }
    geometry.setDrawRange(0, count);
  }
}
