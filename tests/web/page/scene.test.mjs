// The 3D scene's parts that need no browser: names of files beside others, points, levels.

import assert from "node:assert/strict";
import { test } from "node:test";

import { beside } from "../../../src/pyros1/web/page/lib/scene/meshes.js";
import { levels, scanPoints } from "../../../src/pyros1/web/page/lib/scene/points.js";

test("files that a mesh names are beside it, in its package", () => {
  const mesh = "package://arm/meshes/visual/a.dae";
  assert.equal(beside(mesh, "b.png"), "package://arm/meshes/visual/b.png");
  assert.equal(beside(mesh, "./b.png"), "package://arm/meshes/visual/b.png");
  assert.equal(beside(mesh, "..\\..\\textures\\b.png"), "package://arm/textures/b.png");
  assert.equal(beside(mesh, "../../../../../etc/passwd"), "package://arm/etc/passwd");
  assert.equal(beside(mesh, "package://other/b.png"), "package://other/b.png");
  assert.equal(beside("file:///opt/arm/a.dae", "../b.png"), "file:///opt/b.png");
});

test("ranges become points, but not those that are none", () => {
  const facts = { start: 0, step: Math.PI / 2, least: 0.5, most: 5, count: 4, intensities: true };
  const [positions, values] = scanPoints(facts, Float32Array.of(1, 0.1, NaN, 2, 10, 20, 30, 40));
  assert.deepEqual([...positions].map((value) => Math.round(value * 1000) / 1000 + 0), [1, 0, 0, 0, -2, 0]);
  assert.deepEqual([...values], [10, 40]);
});

test("levels go from the least to the greatest number", () => {
  assert.deepEqual([...levels(Float32Array.of(1, 2, 3))], [0, 127, 255]);
  assert.deepEqual([...levels(Float32Array.of(5, 5))], [0, 0]);
  assert.deepEqual([...levels(Float32Array.of(NaN, 0, Infinity, 10))], [0, 0, 255, 255]);
  assert.deepEqual([...levels(new Float32Array())], []);
});
