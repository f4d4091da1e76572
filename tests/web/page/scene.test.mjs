// The 3D scene's parts that need no browser: names of files beside others, points, levels, kinds of displays, what a camera
// sees, what is under the mouse.

import assert from "node:assert/strict";
import { test } from "node:test";

import * as THREE from "../../../src/pyros1/web/page/vendor/three/three.module.min.js";
import { fieldOfView } from "../../../src/pyros1/web/page/lib/scene/camera_view.js";
import { Display } from "../../../src/pyros1/web/page/lib/scene/displays.js";
import { visibleLabels } from "../../../src/pyros1/web/page/lib/scene/label_overlap.js";
import { PointBudget, RateMeter } from "../../../src/pyros1/web/page/lib/scene/point_budget.js";
import { MapPlane } from "../../../src/pyros1/web/page/lib/scene/map.js";
import { infoTopic, addableDisplays, parseKey } from "../../../src/pyros1/web/page/lib/scene/display_kinds.js";
import { resolveUri } from "../../../src/pyros1/web/page/lib/scene/meshes.js";
import { pointsIn, overlaps } from "../../../src/pyros1/web/page/lib/scene/picking.js";
import { PointSet, levels, scanPoints } from "../../../src/pyros1/web/page/lib/scene/points.js";

test("files that a mesh refers to are relative to it, and stay in its package", () => {
  const mesh = "package://arm/meshes/visual/a.dae";
  assert.equal(resolveUri(mesh, "b.png"), "package://arm/meshes/visual/b.png");
  assert.equal(resolveUri(mesh, "./b.png"), "package://arm/meshes/visual/b.png");
  assert.equal(resolveUri(mesh, "..\\..\\textures\\b.png"), "package://arm/textures/b.png");
  assert.equal(resolveUri(mesh, "../../../../../etc/passwd"), "package://arm/etc/passwd");
  assert.equal(resolveUri(mesh, "package://other/b.png"), "package://other/b.png");
  assert.equal(resolveUri("file:///opt/arm/a.dae", "../b.png"), "file:///opt/b.png");
});

test("the mouse can pick the points of a marker", () => {
  const dots = new PointSet();
  dots.set(Float32Array.of(0, 0, 0, 5, 5, 0), "rgba", new Uint8Array(8));
  dots.enablePicking();
  const caster = new THREE.Raycaster(new THREE.Vector3(5, 5, 9), new THREE.Vector3(0, 0, -1));
  const [hit, ...others] = caster.intersectObject(dots.object, true);
  assert.deepEqual([hit.index, hit.point.toArray(), others.length], [1, [5, 5, 0], 0]);
  dots.set(Float32Array.of(0, 0, 0), "rgba", new Uint8Array(4)); // fewer points in the same buffers
  assert.equal(caster.intersectObject(dots.object, true).length, 0);
});

test("valid ranges become points", () => {
  const facts = { start: 0, step: Math.PI / 2, least: 0.5, most: 5, count: 4, intensities: true };
  const [positions, values, indices] = scanPoints(facts, Float32Array.of(1, 0.1, NaN, 2, 10, 20, 30, 40));
  assert.deepEqual([...positions].map((value) => Math.round(value * 1000) / 1000 + 0), [1, 0, 0, 0, -2, 0]);
  assert.deepEqual([...values], [10, 40]);
  assert.deepEqual([...indices], [0, 3]);
});

test("a reading at the maximum range is not a point", () => {
  const facts = { start: 0, step: 1, least: 1, most: 2, count: 3, intensities: false };
  assert.deepEqual([...scanPoints(facts, Float32Array.of(1, 1.5, 2))[2]], [0, 1]);
});

test("a scan without a maximum range keeps all finite points", () => {
  const facts = { start: 0, step: Math.PI, least: null, most: null, count: 4, intensities: false };
  const [positions, , indices] = scanPoints(facts, Float32Array.of(1, Infinity, 2, NaN));
  assert.deepEqual([[...indices], positions[3]], [[0, 2], 2]);
});

test("a selected point is still described after its points are gone", () => {
  const display = new Display("#1c7ed6", "PointCloud2");
  const pose = [0, 0, 0, 0, 0, 0, 1];
  const points = { buffer: Float32Array.of(1, 2, 3).buffer, offset: 0 };
  display.update({ kind: "cloud", frame: "base", pose, count: 1, every: 1, fields: ["x"], by: "x", colour: "x", numbers: false }, points);
  const [part] = display.parts();
  display.set({ decay: 1 });
  assert.deepEqual(part.points.about(0)[1], ["x, y, z", "1, 2, 3"]);
});

test("a marker's mesh may finish loading after the topic's type has changed", () => {
  const display = new Display("#1c7ed6", "Marker");
  display.update({ kind: "markers", new: [], gone: [], poses: {} });
  const { markers } = display;
  display.update({ kind: "path", frame: "base", pose: null });
  markers.host.changed();
  assert.equal(display.problem, "no transform to the frame base");
});

test("levels run from the minimum to the maximum", () => {
  assert.deepEqual([...levels(Float32Array.of(1, 2, 3))], [0, 127, 255]);
  assert.deepEqual([...levels(Float32Array.of(5, 5))], [0, 0]);
  assert.deepEqual([...levels(Float32Array.of(NaN, 0, Infinity, 10))], [0, 0, 255, 255]);
  assert.deepEqual([...levels(new Float32Array())], []);
  assert.deepEqual([...levels(Float32Array.of(0, 1, 2, 3), [2, 0])], [255, 127, 0, 0]); // as in rviz
  assert.deepEqual([...levels(Float32Array.of(0, 1), [2, 2])], [0, 0]);
});

const TYPES = {
  "/cam/depth": "sensor_msgs/Image", "/cam/rgb/compressed": "sensor_msgs/CompressedImage", "/alone": "sensor_msgs/Image",
  "/cam/camera_info": "sensor_msgs/CameraInfo", "/map": "nav_msgs/OccupancyGrid", "/words": "std_msgs/String",
};

test("a key identifies a topic and its kind of display", () => {
  assert.deepEqual(parseKey("/map", TYPES), { topic: "/map", kind: "Map", view: "scene_topic" });
  assert.deepEqual(parseKey("/alone", TYPES), { topic: "/alone", kind: "Image", view: "image" });
  assert.deepEqual(parseKey("camera:/alone", TYPES), { topic: "/alone", kind: "Camera", view: "scene_camera" });
  assert.deepEqual(parseKey("depth:/cam/depth", TYPES), { topic: "/cam/depth", kind: "DepthCloud", view: "scene_depth" });
  for (const key of ["camera:/map", "depth:/nothing", "/words", "constructor:/map", ""]) assert.equal(parseKey(key, TYPES).kind, "");
});

test("offers a camera if there is a CameraInfo, and a depth cloud if the name suggests depth", () => {
  const keys = (shown) => addableDisplays(TYPES, shown, ["/robot_description"]).map(({ key }) => key);
  const all = ["/alone", "/cam/depth", "camera:/cam/depth", "depth:/cam/depth", "/cam/rgb/compressed", "camera:/cam/rgb/compressed", "/map", "depth:", "robot:"];
  assert.deepEqual(keys([]), all);
  assert.deepEqual(keys(all.slice(0, 3)), all.slice(3));
  const others = addableDisplays({ ...TYPES, "/cam/camera_info": "std_msgs/String" }, [], []).map(({ kind }) => kind);
  assert.deepEqual(others, ["RobotModel", "Image", "Image", "Image", "Map", "RobotModel"]);
});

test("a camera's view extends to the outer edges of its outermost pixels", () => {
  const camera = { fx: 2, fy: 4, cx: 1.5, cy: 0.5, width: 4, height: 4 };
  assert.deepEqual(fieldOfView(camera), [-1, 1, 0.25, -0.75]);
  assert.deepEqual(fieldOfView(camera, 2), [-0.5, 0.5, 0, -0.5]);
});

const EYE = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -1, 0, 0, -0.2, 0]; // looks along -z, from 0.1 m to far away

test("finds the frontmost point in a rectangle of the picture", () => {
  const positions = Float32Array.of(0, 0, -2, 0, 0, -1, 0, 0, 1, 0.5, 0, -1, 0, NaN, -1, 0, 0, -0.01);
  const found = pointsIn(positions, 6, EYE, [-0.1, -0.1, 0.1, 0.1], 10);
  assert.deepEqual([found.total, found.nearest, found.indices], [2, 1, [0, 1]]); // the others are beside, behind, nowhere, too near
  assert.deepEqual(pointsIn(positions, 6, EYE, [-1, -1, 1, 1], 2).indices, [0, 1]);
  assert.equal(pointsIn(positions, 6, EYE, [-1, -1, 1, 1], 2).total, 3);
  assert.equal(pointsIn(positions, 6, EYE, [0.9, 0.9, 1, 1], 2).nearest, -1);
});

test("finds what overlaps a rectangle of the picture", () => {
  const corners = [[-1, -1, -2], [1, 1, -2]];
  assert.ok(overlaps(corners, EYE, [0.4, 0.4, 0.9, 0.9]));
  assert.ok(!overlaps(corners, EYE, [0.6, 0.4, 0.9, 0.9]));
  assert.ok(!overlaps([[0, 0, 5]], EYE, [-1, -1, 1, 1])); // behind the eye
  assert.ok(!overlaps([], EYE, [-1, -1, 1, 1]));
});

test("a slow browser gets fewer points, and more again once it has recovered", () => {
  const density = new PointBudget();
  const told = (lag, count, more = {}) => density.reportFrame(lag, { count, all: false, fresh: true, ...more });
  assert.deepEqual([1, 2, 3].map(() => told(500, 1e6)), [false, false, true]);
  assert.equal(density.maxPoints, 210000);
  for (let time = 0; time < 50; time += 1) assert.ok(!told(110, 200000)); // that is as many as it can
  for (let time = 0; time < 4; time += 1) assert.ok(!told(20, 200000));
  assert.ok(told(20, 200000));
  assert.equal(density.maxPoints, 800000);
  for (let time = 0; time < 50; time += 1) assert.ok(!told(20, 700000, { all: true })); // there are no more
  for (let time = 0; time < 3; time += 1) told(600, 700000);
  assert.equal(density.maxPoints, 122500);
  for (let time = 0; time < 9; time += 1) assert.ok(!told(20, 100000), String(time)); // it was too much: it waits longer
  assert.ok(told(20, 100000));
});

test("turning the view never reduces the number of points, but may increase it", () => {
  const density = new PointBudget();
  const turned = (lag) => density.reportFrame(lag, { count: 1e6, all: false, fresh: false });
  for (let time = 0; time < 20; time += 1) assert.ok(!turned(500));
  for (let time = 0; time < 3; time += 1) density.reportFrame(1000, { count: 1e6, all: false, fresh: true });
  assert.equal(density.maxPoints, 105000);
  for (let time = 0; time < 5; time += 1) density.reportFrame(10, { count: 1e5, all: false, fresh: false });
  assert.equal(density.maxPoints, 400000);
  density.reset();
  assert.equal(density.maxPoints, Infinity);
});

test("of overlapping labels, only the first is visible", () => {
  const box = (left, top) => ({ left, top, wide: 10, high: 5 });
  assert.deepEqual(visibleLabels([box(0, 0), box(5, 2), box(10, 0), box(0, 5)]), [true, false, true, true]);
  assert.deepEqual(visibleLabels([]), []);
});

test("measures how often clouds arrive", () => {
  const pace = new RateMeter();
  pace.tick(1000);
  assert.equal(`${pace}`, "the first");
  for (let step = 1; step <= 20; step += 1) pace.tick(1000 + 250 * step);
  assert.equal(`${pace}`, "4.0 a second");
});

test("a map that is too large for the graphics card is shown at a lower resolution", () => {
  const plane = new MapPlane();
  const facts = { resolution: 0.05, origin: [0, 0, 0, 0, 0, 0, 1] };
  plane.set({ ...facts, width: 3, height: 2 }, Int8Array.of(0, 100, 0, 0, 0, 100));
  assert.deepEqual([plane.texture.image.width, plane.texture.image.height, plane.every], [3, 2, 1]);
  const pixels = () => [...new Uint32Array(plane.texture.image.data.buffer)];
  const [white, black] = pixels();
  assert.deepEqual(pixels(), [white, black, white, white, white, black]);
  plane.patch({ x: 0, y: 1, width: 2, height: 1 }, Int8Array.of(100, 100));
  assert.deepEqual(pixels(), [white, black, white, black, black, black]);
  const cells = new Int8Array(30000 * 6);
  cells[4 * 30000 + 29996] = 100;
  plane.set({ ...facts, width: 30000, height: 6 }, cells);
  assert.deepEqual([plane.texture.image.width, plane.texture.image.height, plane.every], [7500, 2, 4]);
  assert.deepEqual(pixels().map((pixel, index) => (pixel === white ? -1 : index)).filter((index) => index >= 0), [7500 + 7499]);
  plane.patch({ x: 0, y: 4, width: 1, height: 1 }, Int8Array.of(100));
  assert.equal(pixels()[7500], black);
});

test("types named like JavaScript's built-in properties are unknown", () => {
  const types = { "/a": "constructor", "/b": "__proto__", "/c": "toString" };
  for (const topic of Object.keys(types)) assert.equal(parseKey(topic, types).kind, "");
  assert.deepEqual(addableDisplays(types, [], ["/robot_description"]).map(({ key }) => key), ["robot:"]);
});

test("the CameraInfo is next to the image topic, whatever its namespace", () => {
  for (const [topic, type, info] of [
    ["/camera/image", "sensor_msgs/Image", "/camera/camera_info"],
    ["/camera/image/compressed", "sensor_msgs/CompressedImage", "/camera/camera_info"],
    ["/image", "sensor_msgs/Image", "/camera_info"],
    ["/compressed", "sensor_msgs/CompressedImage", "/camera_info"],
  ]) assert.equal(infoTopic(topic, type), info);
});
