// Points of curves, and what of them a chart shows. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { Points, sample } from "../../../src/pyros1/web/page/lib/curves.js";

function sampled(times, values, places) {
  const points = new Points();
  points.add(times, values);
  return sample(points, places);
}

test("a spike just before the edge of a column stays", () => {
  assert.equal(Math.floor(8.6 / 0.2), 42); // although 43 * 0.2 is 8.6
  const shown = sampled([8.5, 8.599, 8.6, 8.7], [0, 7, 0, 0], { step: 0.2, first: 40, columns: 4 });
  assert.deepEqual(shown, [null, null, null, null, 0, 7, 0, null, null, null]);
});

test("the least and the greatest of each column are shown, whatever its edges", () => {
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
