// Layouts: everything gets a place, and nothing lies on anything else.

import assert from "node:assert/strict";
import test from "node:test";

const page = new URL("../../../src/pyros1/web/page/", import.meta.url);
const { MAX_FOR_DAGRE, POINTS, routeBackwards, layout, resample } = await import(new URL("lib/graph/layout.js", page));

const room = [1200, 700];

// Nodes with topics to the next nodes; groups: number of namespaces, 0 for none.
function system(nodes, topics, groups) {
  const group = (index) => (groups ? `/robot${index % groups}` : "");
  const boxes = Array.from({ length: nodes }, (_, index) => ({ id: `n:${index}`, width: 120, height: 32, group: group(index) }));
  const edges = [];
  for (let index = 0; index < topics; index += 1) {
    boxes.push({ id: `t:${index}`, width: 150, height: 26, group: group(index % nodes) });
    edges.push({ id: `a${index}`, from: `n:${index % nodes}`, to: `t:${index}`, width: 100, height: 14 });
    edges.push({ id: `b${index}`, from: `t:${index}`, to: `n:${(index * 7 + (groups || 1)) % nodes}`, width: 100, height: 14 });
  }
  const frames = [...new Set(boxes.map((box) => box.group).filter(Boolean))];
  return { boxes, edges, groups: frames.map((name) => ({ name, parent: "" })), down: false, room };
}

function check(what) {
  const found = layout(what);
  assert.equal(Object.keys(found.boxes).length, what.boxes.length);
  for (const { id } of what.edges) {
    assert.equal(found.edges[id].points.length, POINTS * 2);
    assert.ok(found.edges[id].points.every(Number.isFinite), id);
  }
  const places = what.boxes.map(({ id, width, height }) => [...found.boxes[id], width, height]);
  places.forEach(([x, y, width, height], one) => {
    assert.ok(x - width / 2 >= -1 && y - height / 2 >= -1 && x + width / 2 <= found.width + 1 && y + height / 2 <= found.height + 1);
    for (const [a, b, c, d] of places.slice(one + 1)) {
      assert.ok(Math.abs(x - a) * 2 >= width + c - 1 || Math.abs(y - b) * 2 >= height + d - 1, "boxes overlap");
    }
  });
  return found;
}

test("lays out small graphs, with and without groups", () => {
  check(system(5, 8, 0));
  const { frames } = check(system(8, 12, 2));
  assert.deepEqual(Object.keys(frames).sort(), ["/robot0", "/robot1"]);
});

test("the boxes of a group are inside its frame, and frames do not overlap", () => {
  for (const what of [system(8, 12, 2), system(60, 300, 6)]) {
    const { boxes, frames } = check(what);
    for (const { id, width, group } of what.boxes) {
      const [x, , wide] = frames[group];
      assert.ok(Math.abs(boxes[id][0] - x) + width / 2 <= wide / 2 + 1);
    }
  }
});

test("200 nodes and 1,000 topics fill roughly the shape of the available space", () => {
  for (const groups of [0, 20]) {
    const what = system(200, 1000, groups);
    assert.ok(what.boxes.length + what.edges.length > MAX_FOR_DAGRE);
    const { width, height } = check(what);
    assert.ok(width / height < 5 && height / width < 2, `${width} x ${height}`);
  }
});

test("a backward edge goes around the boxes, and enters from the front", () => {
  const size = { width: 100, height: 30 };
  for (const down of [false, true]) {
    const turn = ([x, y]) => (down ? [y, x] : [x, y]);
    const [wide, high] = turn([100, 30]);
    const boxes = [];
    for (let column = 0; column < 4; column += 1) for (let row = 0; row < 5; row += 1) boxes.push([...turn([column * 200, row * 60]), wide, high]);
    const [from, to] = [boxes[17], boxes[1]]; // of the last column, and of the first
    const box = { width: wide, height: high };
    const points = routeBackwards([from, box, to, box], from, to, boxes, down);
    assert.equal(points.length, POINTS * 2);
    assert.ok(points.every(Number.isFinite));
    for (let index = 0; index < points.length - 2; index += 2) {
      const [left, right] = [points[index], points[index + 2]].sort((one, other) => one - other);
      const [top, bottom] = [points[index + 1], points[index + 3]].sort((one, other) => one - other);
      for (const [x, y, w, h] of boxes) {
        const apart = right <= x - w / 2 || left >= x + w / 2 || bottom <= y - h / 2 || top >= y + h / 2;
        assert.ok(apart, `${points} goes through ${[x, y]}`);
      }
    }
    const [before, end] = [turn(points.slice(-4, -2)), turn(points.slice(-2))];
    assert.ok(end[0] > before[0] && end[1] === before[1], "the arrow looks ahead");
    assert.equal(end[0], turn(to)[0] - size.width / 2);
  }
});

test("turns a long strip vertical if it can then be drawn larger", () => {
  const boxes = Array.from({ length: 6 }, (_, index) => ({ id: `n:${index}`, width: 140, height: 32, group: "" }));
  const edges = boxes.slice(1).map(({ id }, index) => ({ id: `e${index}`, from: `n:${index}`, to: id, width: 104, height: 28 }));
  const { down, width, height } = layout({ boxes, edges, groups: [], down: false, room: [1400, 800] });
  assert.ok(down);
  assert.ok(Math.min(1400 / width, 800 / height) > 1);
});

test("lays out an empty graph, and one box with an edge to itself", () => {
  assert.deepEqual(layout({ boxes: [], edges: [], groups: [], down: false, room }).boxes, {});
  const loop = { boxes: [{ id: "n:a", width: 80, height: 30, group: "" }], edges: [{ id: "e", from: "n:a", to: "n:a", width: 0, height: 0 }], groups: [], down: true, room };
  check(loop);
});

test("resamples a line to points at equal distances", () => {
  assert.deepEqual(resample([0, 0, 10, 0, 10, 10], 5), [0, 0, 5, 0, 10, 0, 10, 5, 10, 10]);
  assert.deepEqual(resample([3, 3, 3, 3], 2), [3, 3, 3, 3]);
});

test("sites are placed before their bridge, away from its topics, however many there are", () => {
  for (const number of [1, 2, 12]) {
    const what = system(0, 0, 0);
    what.boxes.push({ id: "n:bridge", width: 120, height: 32, group: "" }, { id: "n:viewer", width: 120, height: 32, group: "" });
    for (let index = 0; index < number; index += 1) {
      what.boxes.push({ id: `s:${index}`, width: 120, height: 50, group: "" });
      what.edges.push({ id: `in${index}`, from: `s:${index}`, to: "n:bridge", width: 100, height: 42 });
      what.edges.push({ id: `out${index}`, from: "n:bridge", to: `s:${index}`, width: 100, height: 42 });
      for (const topic of [`t:${index}/odom`, `t:${index}/scan`]) {
        what.boxes.push({ id: topic, width: 120, height: 26, group: "" });
        what.edges.push({ id: `a${topic}`, from: "n:bridge", to: topic, width: 0, height: 0 });
        what.edges.push({ id: `b${topic}`, from: topic, to: "n:viewer", width: 0, height: 0 });
      }
    }
    const found = check(what);
    const axis = found.down ? 1 : 0;
    const bridge = found.boxes["n:bridge"][axis];
    for (const [id, at] of Object.entries(found.boxes)) {
      if (id.startsWith("s:")) assert.ok(at[axis] < bridge, id);
      if (id.startsWith("t:")) assert.ok(at[axis] > bridge, id);
    }
    for (let index = 0; index < number; index += 1) {
      const [into, out] = [found.edges[`in${index}`].points, found.edges[`out${index}`].points];
      assert.ok(into[axis] < into.at(axis - 2) && out[axis] > out.at(axis - 2), "edges keep their directions");
      assert.ok(into.some((value, at) => Math.abs(value - out.at(at % 2 ? -at : -2 - at)) > 1), "and do not lie on each other");
    }
  }
});
