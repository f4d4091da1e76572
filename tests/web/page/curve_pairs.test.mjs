// Curves plotted against each other. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

const page = new URL("../../../src/pyros1/web/page/", import.meta.url);
const { boxAround, equal, join, nearest } = await import(new URL("lib/curve_pairs.js", page));
const { Points } = await import(new URL("lib/curves.js", page));

function curve(times, values) {
  const points = new Points();
  points.add(Float64Array.from(times), Float64Array.from(values));
  return points;
}

const list = ({ xs, ys, times }) => [[...xs], [...ys], [...times]];

test("pairs the values that two fields have at the same time", () => {
  const joined = join(curve([1, 2, 3], [10, 20, 30]), curve([1, 2, 3], [5, 6, 7]), 2, 9, 100);
  assert.deepEqual(list(joined), [[20, 30], [6, 7], [2, 3]]);
});

test("x is interpolated linearly between its points, and undefined before the first", () => {
  const joined = join(curve([1, 1.5], [0, 10]), curve([0.9, 1.1, 1.25, 1.5, 1.6, 9], [1, 2, 3, 4, 5, 6]), 0, 10, 100);
  assert.deepEqual([...joined.ys], [2, 3, 4, 5]); // after its end x is believed for a second
  assert.ok(Math.abs(joined.xs[0] - 2) < 1e-9);
  assert.deepEqual([...joined.xs].slice(1), [5, 10, 10]);
});

test("leaves out leading and trailing values that are not finite", () => {
  const joined = join(curve([1, 2, 3], [NaN, 2, 3]), curve([1, 2, 3], [1, Infinity, 3]), 0, 9, 100);
  assert.deepEqual(list(joined), [[3], [3], [3]]);
});

test("thinning keeps the same points as time advances", () => {
  const times = Array.from({ length: 1000 }, (_, index) => index / 100);
  const [x, y] = [curve(times, times), curve(times, times)];
  const one = [...join(x, y, 1.0, 10, 100).times];
  const later = [...join(x, y, 1.07, 10, 100).times];
  assert.ok(one.length <= 100 && one.length > 40);
  assert.ok(later.every((time) => one.includes(time)));
  for (const points of [x, y]) points.trim(0.555, 1e6); // the oldest are forgotten
  assert.deepEqual([...join(x, y, 1.0, 10, 100).times], one);
});

test("no points give no trail, and a default box", () => {
  const joined = join(new Points(), new Points(), 0, 1, 100);
  assert.equal(joined.xs.length, 0);
  assert.deepEqual(boxAround([joined]), { x: [0, 1], y: [0, 1] });
});

test("a box has a margin, and can have axes of equal scale", () => {
  const box = boxAround([{ xs: [0, 10], ys: [0, 100] }, { xs: [5], ys: [50] }]);
  assert.deepEqual(box, { x: [-0.6, 10.6], y: [-6, 106] });
  const same = equal({ x: [0, 10], y: [0, 10] }, 200, 100);
  assert.deepEqual(same, { x: [-5, 15], y: [0, 10] });
  const point = boxAround([{ xs: [2], ys: [0] }]);
  assert.deepEqual(point, { x: [1.8, 2.2], y: [-0.5, 0.5] });
});

test("finds the nearest point by its distance in pixels", () => {
  const trails = [{ xs: [0, 10], ys: [0, 10] }, { xs: [5], ys: [5] }];
  const box = { x: [0, 10], y: [0, 10] };
  assert.deepEqual(nearest(trails, { x: 5.2, y: 5 }, box, 100, 100, 20), { trail: 1, index: 0 });
  assert.deepEqual(nearest(trails, { x: 9, y: 10 }, box, 100, 100, 20), { trail: 0, index: 1 });
  assert.equal(nearest(trails, { x: 2.5, y: 2.5 }, box, 100, 100, 20), null);
});

test("a trail has a gap where a value is NaN", () => {
  const joined = join(curve([1, 2, 3, 4], [10, NaN, 30, 40]), curve([1, 2, 3, 4], [5, 6, 7, NaN]), 0, 9, 100);
  assert.deepEqual(list(joined), [[10, NaN, 30], [5, NaN, 7], [1, 3, 3]]);
  assert.deepEqual(boxAround([joined]).x.map(Math.round), [9, 31]);
});
