// Points of curves, what of them a chart shows, and how they are written. Run by tests/web/test_page_modules.py, or with:
// node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { Points, grid, isolated, sample } from "../../../src/pyros1/web/page/lib/curves.js";
import { moment, number, reading } from "../../../src/pyros1/web/page/lib/format.js";
import { written } from "../../../src/pyros1/web/page/parts/tree.js";

function sampled(times, values, places) {
  const points = new Points();
  points.add(times, values);
  return sample(points, places);
}

test("keeps a spike just before the edge of a column", () => {
  assert.equal(Math.floor(8.6 / 0.2), 42); // although 43 * 0.2 is 8.6
  const shown = sampled([8.5, 8.599, 8.6, 8.7], [0, 7, 0, 0], { step: 0.2, first: 40, columns: 4 });
  const none = undefined;
  assert.deepEqual(shown, [none, none, none, none, 0, 7, 0, none, none, none]);
});

test("shows the minimum and maximum of each column, wherever its edges are", () => {
  for (let number = 1; number < 400; number += 1) {
    const step = number / 1000;
    const columns = 9;
    const first = number * 7;
    const places = [...Array(8).keys()].flatMap((column) => [0.1, 0.5, 0.9].map((part) => (first + column + 1 + part) * step).concat((first + column + 2) * step));
    const shown = sampled(places, places.map((_, index) => (index % 4 === 2 ? 5 : index % 4 === 1 ? -5 : 0)), { step, first, columns });
    assert.equal(shown.length, 2 * (columns + 1));
    for (let column = 1; column < 9; column += 1) assert.deepEqual(shown.slice(2 * column, 2 * column + 2).sort(), [-5, 5]);
  }
});

function curve(values) {
  const points = new Points();
  points.add(Float64Array.from(values.keys()), Float64Array.from(values));
  return points;
}

test("a line continues across columns without points, and breaks at values that are not finite", () => {
  const shown = (...values) => sample(curve(values), grid(0, 8, 8)).slice(0, 10); // a column a second, of two values
  const none = undefined;
  assert.deepEqual(shown(1, 2, NaN, 3, 4), [1, none, 2, null, null, null, 3, none, 4, none]);
  assert.deepEqual(shown(NaN, 2, NaN, Infinity, 4), [null, null, 2, null, null, null, null, null, 4, none]);
  assert.deepEqual(sample(curve([NaN, 2, 7, 4]), grid(0, 8, 2)).slice(0, 4), [2, 7, undefined, undefined]);
});

test("isolated values are drawn as dots", () => {
  const none = undefined;
  assert.deepEqual(isolated([none, 5, none]), [1]);
  assert.deepEqual(isolated([1, none, 2, null, none, 3, null, 4, 5, null, 6]), [5, 10]);
  assert.equal(isolated([1, 2, null]), null);
  assert.equal(isolated([]), null);
});

test("the values in a legend are as precise as its axis", () => {
  for (const [value, span, text] of [
    [42.123456789, 1e-5, "42.12345679"], [1795706846.123456, 20, "1795706846.12"], [0.850437123, 2, "0.850437"],
    [1.845e19, 1e18, "1.845e+19"], [5e-9, 1e-8, "5e-9"], [100.25, 0, "100.25"], [NaN, 1, "NaN"],
  ]) assert.equal(reading(value, span), text);
});

test("numbers are written with the precision of their types", () => {
  assert.equal(written(42.123456789012, "float64"), "42.123456789012");
  assert.equal(written(0.1 + 0.2, "float64"), "0.3");
  assert.equal(written(1795706846.123456, "float64"), "1795706846.12346");
  assert.equal(written(0.10000000149, "float32"), "0.1");
  assert.equal(number(5e-9, 7), "5e-9");
});

test("simulated times are written without a date", () => {
  assert.equal(moment(47.58), "47.58 s");
  assert.match(moment(1400000000), /2014/);
});
