// Boxes of the graph that the user drags, and what is seen of it. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

const page = new URL("../../../src/pyros1/web/page/", import.meta.url);
const { Scene, flowTexts, plan } = await import(new URL("lib/graph/scene.js", page));
const { Camera } = await import(new URL("lib/graph/camera.js", page));
globalThis.matchMedia = () => ({ matches: false });

const box = (id, group = "") => ({ id, kind: "node", name: id.slice(2), label: id, group });
const MODEL = {
  boxes: [box("n:/g/a", "/g"), box("n:/b"), box("n:/c")],
  edges: [{ id: "e", from: "n:/g/a", to: "n:/b", lines: [], links: [] }, { id: "f", from: "n:/b", to: "n:/c", lines: [], links: [] }],
  groups: [{ id: "f:/g", name: "/g", parent: "" }],
};
const WHAT = { boxes: MODEL.boxes.map(({ id }) => ({ id, width: 20, height: 10 })) };
const FOUND = {
  boxes: { "n:/g/a": [0, 0], "n:/b": [100, 0], "n:/c": [200, 0] },
  edges: { e: { points: [0, 0, 50, 0, 100, 0], label: [50, 0] }, f: { points: [100, 0, 150, 0, 200, 0], label: [150, 0] } },
  frames: { "/g": [0, 0, 50, 50] }, width: 220, height: 50,
};

function arranged(scene = new Scene(), found = FOUND) {
  scene.arrange(MODEL, WHAT, found, null, 0);
  scene.step(1e9);
  return scene;
}

test("a dragged box takes its lines along immediately", () => {
  const scene = arranged();
  scene.move("n:/b", 10, 20);
  assert.deepEqual(scene.items.get("n:/b").at, [110, 20]);
  assert.deepEqual(scene.items.get("n:/c").at, [200, 0]);
  assert.deepEqual(scene.lines.get("e").at, [0, 0, 55, 10, 110, 20, 55, 10]); // from end to end more and more, the label by the half
  assert.deepEqual(scene.lines.get("f").at, [110, 20, 155, 10, 200, 0, 155, 10]);
  assert.equal(scene.find(112, 22, 1).box.id, "n:/b");
  scene.move("n:/nothing", 1, 1);
});

test("dragging a box enlarges its namespace's frame and the scene's bounds", () => {
  const scene = arranged();
  scene.move("n:/g/a", -300, 0);
  const [x, , width, height] = scene.frames.get("/g").at;
  assert.ok(x - width / 2 < -310 && x + width / 2 === 25 && height === 64);
  assert.ok(scene.bounds[0] < -310);
});

test("a moved box stays where it was put after a new layout", () => {
  const scene = arranged();
  scene.move("n:/b", 10, 20);
  arranged(scene, { ...FOUND, boxes: { ...FOUND.boxes, "n:/c": [200, 80] } });
  assert.deepEqual(scene.items.get("n:/b").at, [110, 20]);
  assert.deepEqual(scene.items.get("n:/c").at, [200, 80]);
});

test("putting boxes back does nothing before there is a layout", () => {
  const scene = new Scene();
  scene.release(0);
  assert.deepEqual(scene.bounds, [0, 0, 1, 1]);
});

test("a released box glides back", () => {
  const scene = arranged();
  scene.move("n:/b", 10, 20);
  scene.release(1000);
  assert.equal(scene.step(1001), true);
  scene.step(1e9);
  assert.deepEqual(scene.items.get("n:/b").at, [100, 0]);
  assert.deepEqual(scene.lines.get("e").at, [0, 0, 50, 0, 100, 0, 50, 0]);
  assert.deepEqual(scene.bounds, [0, 0, 220, 50]);
});

test("the number of remembered positions is limited", () => {
  const scene = arranged();
  for (let index = 0; index < 500; index += 1) scene.movedBoxes.set(`n:/${index}`, [0, 0]);
  scene.move("n:/b", 1, 1);
  assert.equal(scene.movedBoxes.size, 500);
});

test("a link keeps the positions of moved boxes, including those that appear later", () => {
  const scene = arranged();
  scene.move("n:/b", 10, 20);
  assert.deepEqual(scene.offsets, [["n:/b", 10, 20]]);
  const other = new Scene();
  other.offsets = [["n:/b", 10, 20], ["n:/later", 1, 2], ["n:/c", "x", 0], null, ["n:/c", Infinity, 0], 7];
  const shifted = Object.fromEntries(Object.entries(FOUND.boxes).map(([id, [x, y]]) => [id, [x + 5, y]]));
  arranged(other, { ...FOUND, boxes: shifted });
  assert.deepEqual(other.items.get("n:/b").at, [115, 20]);
  assert.deepEqual(other.items.get("n:/c").at, [205, 0]);
  assert.deepEqual(other.offsets, [["n:/later", 1, 2], ["n:/b", 10, 20]]);
  other.release(0);
  assert.deepEqual(other.offsets, []);
});

test("an edge's text gives the rate, the message size and the bandwidth", () => {
  const edge = (hz, bytes) => ({ from: "n:/a", to: "n:/b", links: [{ topic: "/t", publisher: "/a", subscriber: "/b", state: "ok", hz, bytes }] });
  assert.deepEqual(flowTexts(edge(10, 2600)), ["10.0 Hz · 260 B", "2.6 kB/s"]);
  assert.deepEqual(flowTexts(edge(0, 0)), ["0 Hz"]);
  assert.deepEqual(flowTexts(edge(null, null)), []);
});

test("a dimmed edge has no label", () => {
  const scene = arranged();
  scene.model.edges[0].lines = ["/topic"];
  const look = { colours: {}, scale: 1, visibleArea: [-1e6, -1e6, 1e6, 1e6], chosen: null, hovered: null };
  const texts = (lit) => {
    const found = [];
    scene.draw({ box() {}, lines() {}, arrowHead() {}, text: (x, y, text) => found.push(text) }, { ...look, highlighted: lit });
    scene.model.edges[0].lines = ["/topic"];
    return found.filter((text) => text === "/topic").length;
  };
  scene.lines.get("e").at = [0, 200, 50, 200, 100, 200, 50, 200]; // beside the boxes
  assert.deepEqual([texts(null), texts({ boxes: new Set(), edges: new Set(["e"]) }), texts({ boxes: new Set(), edges: new Set(["f"]) })], [1, 1, 0]);
});

test("fitting the whole graph leaves room for the footer, whatever its height", () => {
  const element = { clientWidth: 390, clientHeight: 700, addEventListener() {} };
  for (const foot of [24, 60]) {
    const camera = new Camera(element, { coveredHeight: () => foot, changed() {} });
    camera.show([0, 0, 100, 4000], 1, false);
    const [, top] = camera.toScreen(0, 0);
    const [, bottom] = camera.toScreen(0, 4000);
    assert.ok(Math.abs(top - 20) < 1e-6 && Math.abs(bottom - (700 - 20 - foot)) < 1e-6);
  }
});

test("a site's box has room for its state, and its edges report dropped messages", () => {
  const link = (topic, dropped) => ({ topic, publisher: "red", subscriber: "/bridge", state: "ok", hz: 1, bytes: 1, dropped });
  const edge = (links) => ({ id: "s:red n:/bridge", from: "s:red", to: "n:/bridge", links });
  const model = { boxes: [{ ...box("s:red"), kind: "site", text: "site lost" }, box("n:/bridge")], edges: [edge([link("/a", {}), link("/b", { "too old": 2 })])], groups: [] };
  const what = plan(model, { rates: true, down: false, room: [1, 1], measure: (text) => 7 * text.length });
  assert.deepEqual([what.boxes[0].height, what.boxes[1].height], [48, 32]);
  assert.deepEqual(model.edges[0].lines, ["/a", "/b", "messages dropped"]);
  model.edges = [edge([link("/a", {})])];
  plan(model, { rates: true, down: false, room: [1, 1], measure: () => 7 });
  assert.deepEqual(model.edges[0].lines, ["/a"]);
});
