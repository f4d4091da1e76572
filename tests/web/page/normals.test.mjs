// Normals of meshes. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { repairNormals } from "../../../src/pyros1/web/page/lib/scene/normals.js";

const PLACES = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0); // seen from +z
const UP = [0, 0, 1, 0, 0, 1, 0, 0, 1];
const near = (found, wanted) => assert.ok([...found].every((each, at) => Math.abs(each - wanted[at]) < 1e-6), `${[...found]}`);

test("leaves usable normals alone", () => {
  assert.equal(repairNormals(PLACES, Float32Array.from(UP)), null);
  assert.equal(repairNormals(PLACES, Float32Array.from([0, 0, 1, 0, 0.6, 0.8, 0, 0, -1])), null);
});

test("computes normals that are missing, too few, zero or not finite", () => {
  near(repairNormals(PLACES, null), UP);
  near(repairNormals(PLACES, Float32Array.of(0, 0, 1)), UP);
  for (const wrong of [0, NaN, Infinity, 1e-9, 3e38 * 10]) near(repairNormals(PLACES, new Float32Array(9).fill(wrong)), UP);
});

test("computes only the unusable normals, and normalises the others", () => {
  near(repairNormals(PLACES, Float32Array.of(0, 0, 0, 0, 3, 4, 0, -0.5, 0)), [0, 0, 1, 0, 0.6, 0.8, 0, -1, 0]);
});

test("a shared vertex gets the area-weighted mean of its triangles' normals", () => {
  const places = Float32Array.of(0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2); // one triangle looks to z, one to x
  const found = repairNormals(places, null, Uint16Array.of(0, 1, 2, 0, 2, 3));
  near(found.subarray(0, 3), [Math.SQRT1_2, 0, Math.SQRT1_2]);
  near(found.subarray(3, 6), [0, 0, 1]);
  near(found.subarray(9, 12), [1, 0, 0]);
});

test("handles triangles without an area, and vertices without a triangle", () => {
  near(repairNormals(new Float32Array(9), null), UP);
  near(repairNormals(PLACES, null, Uint16Array.of(0, 1)), UP);
});
