// Words, points and values of the plot and of messages. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { Points, grid, sample } from "../../../src/pyros1/web/page/lib/curves.js";
import { seconds } from "../../../src/pyros1/web/page/lib/format.js";
import { axisWidth, safeRange, splitCurves, tickLabels, paddedRange } from "../../../src/pyros1/web/page/parts/plot/plot_text.js";
import { written } from "../../../src/pyros1/web/page/parts/tree.js";

test("the tick labels of an axis are distinct, and as short as possible", () => {
  for (const [ticks, texts] of [
    [[0, 0.25, 0.5], ["0.00", "0.25", "0.50"]],
    [[-2.5, 0, 2.5], ["-2.5", "0.0", "2.5"]],
    [[0.1, 0.2, 0.30000000000000004], ["0.1", "0.2", "0.3"]],
    [[0, 200, 400], ["0", "200", "400"]],
    [[0, 2e8, 4e8], ["0", "2e+8", "4e+8"]],
    [[1795706846, 1795706846.5], ["1795706846.0", "1795706846.5"]],
    [[-1e-9, 0, 1e-9], ["-1e-9", "0", "1e-9"]],
    [[1.7957068e15, 1.7957069e15], ["1.7957068e+15", "1.7957069e+15"]],
    [[0], ["0"]], [[7], ["7"]], [[], []],
  ]) assert.deepEqual(tickLabels(ticks), texts);
});

test("an axis has room for its tick labels", () => {
  assert.equal(axisWidth(null, null), axisWidth(null, ["0.5"]));
  assert.ok(axisWidth(null, ["1795706846.5"]) >= 12 * 7 + 20);
});

function points(...parts) {
  const all = new Points();
  for (const times of parts) all.add(Float64Array.from(times), Float64Array.from(times, (time) => 10 * time));
  return all;
}
const kept = ({ times, values, start, end }) => [[...times.slice(start, end)], [...values.slice(start, end)]];

test("a curve starts over when time jumps back, even within a batch", () => {
  const looped = points([8, 9], [9.8, 9.9, 0.1, 0.2], [0.3]);
  assert.deepEqual(kept(looped), [[0.1, 0.2, 0.3], [1, 2, 3]]);
  assert.ok(sample(looped, grid(0, 0.4, 4)).includes(3)); // the newest is seen
  assert.deepEqual(kept(points([5, 6], [1], [2, 0.5, 0.2, 0.4]))[0], [0.2, 0.4]);
  assert.deepEqual(kept(points([0, 0.9], [0.2, 0.3]))[0], [0.2, 0.3]); // a bag that is shorter than a second
});

test("a small clock correction keeps the curve, with its times in order", () => {
  assert.deepEqual(kept(points([1, 2, 1.95, 2.1])), [[1, 2, 2, 2.1], [10, 20, 19.5, 21]]);
  assert.deepEqual(kept(points([1, 2], [1.95], [], [3]))[0], [1, 2, 2, 3]);
});

test("integers and times are written in full", () => {
  assert.equal(written(1795706846123456, "int64"), "1795706846123456"); // microseconds
  assert.equal(written(-1795706846123456, "int64"), "-1795706846123456");
  assert.equal(written("9223372036854775807", "int64"), "9223372036854775807");
  assert.equal(written(0.1, "float64"), "0.1");
  assert.equal(written(true, "bool"), "true");
  for (const [secs, nsecs, text] of [[1, 5, "1.000000005"], [-1, 500000000, "-0.500000000"], [-2, 999999999, "-1.000000001"], [-2, 0, "-2.000000000"], [4294967295, 0, "4294967295.000000000"]]) {
    assert.equal(seconds({ secs, nsecs }), text);
  }
});

test("the ends of an axis are far enough apart to step between them", () => {
  const numbers = [0, 1, -1, 0.1, 0.1 + 2e-17, 1e16, 1e16 + 2, 1e17, 1e17 + 16, 1e308, 1.7e308, -1.7e308, 5e-324, -1e-320, 1e-300];
  for (const one of numbers) for (const other of numbers) {
    const [least, most] = [one, other].sort((first, second) => first - second);
    for (const ends of [paddedRange(least, most), ...(least < most ? [safeRange([least, most])] : [])]) {
      const step = (ends[1] - ends[0]) / 1000;
      assert.ok(Number.isFinite(step) && ends[0] <= Math.max(least, -8e307) && ends[1] >= Math.min(most, 8e307), String(ends));
      for (const end of ends) assert.ok(step < 1e-300 || end + step > end, `${least} to ${most}: ${ends}`);
    }
  }
  assert.deepEqual(safeRange([-Infinity, Infinity]), [-8e307, 8e307]);
  assert.deepEqual(safeRange([0, 2]), [0, 2]);
});

test("accepts rqt_plot's arguments, slices and expressions as curves", () => {
  for (const [text, curves] of [
    ["/a/x:y:z", ["/a/x", "/a/y", "/a/z"]],
    ["/a/x,/b[0:2]/y", ["/a/x", "/b[0:2]/y"]],
    ["/a/m:n", ["/a/m", "/a/n"]],
    ["/a: hypot(m.x, m.y)", ["/a: hypot(m.x, m.y)"]],
    ["/a:m.x*2", ["/a:m.x*2"]],
    ["/a/x,/b: m.y * 2", ["/a/x", "/b: m.y * 2"]],
    ["/a: 5", ["/a: 5"]],
    ["/js/position[0]:velocity[0]", ["/js/position[0]", "/js/velocity[0]"]],
    ["/js/position[-1]:velocity[1]:effort[2]", ["/js/position[-1]", "/js/velocity[1]", "/js/effort[2]"]],
    ["/a/x:y[0]", ["/a/x", "/a/y[0]"]],
    ["/a/p[0]/x:y", ["/a/p[0]/x", "/a/p[0]/y"]],
    ["/a/p[0]:q[1]/x", ["/a/p[0]", "/a/q[1]/x"]],
    ["/a/p[0:2]:q[1:5:2],/b/x:y", ["/a/p[0:2]", "/a/q[1:5:2]", "/b/x", "/b/y"]],
    ["/a/p[0:2]/x", ["/a/p[0:2]/x"]],
    ["/a/x[0],/b: m.y[0] * 2", ["/a/x[0]", "/b: m.y[0] * 2"]],
    ["/b: m.y[0] - m.y[1]", ["/b: m.y[0] - m.y[1]"]],
    ["/a/x:,,/b/y", ["/a/x", "/b/y"]],
  ]) assert.deepEqual(splitCurves(text), curves);
});
