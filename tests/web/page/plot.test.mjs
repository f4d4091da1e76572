// Words of the plot. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { axisWidth, countable, marks, spread } from "../../../src/pyros1/web/page/parts/plot/words.js";

test("marks of an axis differ, and are as short as that allows", () => {
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
  ]) assert.deepEqual(marks(ticks), texts);
});

test("an axis has room for its marks", () => {
  assert.equal(axisWidth(null, null), axisWidth(null, ["0.5"]));
  assert.ok(axisWidth(null, ["1795706846.5"]) >= 12 * 7 + 20);
});

test("between the ends of an axis one can count", () => {
  const numbers = [0, 1, -1, 0.1, 0.1 + 2e-17, 1e16, 1e16 + 2, 1e17, 1e17 + 16, 1e308, 1.7e308, -1.7e308, 5e-324, -1e-320, 1e-300];
  for (const one of numbers) for (const other of numbers) {
    const [least, most] = [one, other].sort((first, second) => first - second);
    for (const ends of [spread(least, most), ...(least < most ? [countable([least, most])] : [])]) {
      const step = (ends[1] - ends[0]) / 1000;
      assert.ok(Number.isFinite(step) && ends[0] <= Math.max(least, -8e307) && ends[1] >= Math.min(most, 8e307), String(ends));
      for (const end of ends) assert.ok(step < 1e-300 || end + step > end, `${least} to ${most}: ${ends}`);
    }
  }
  assert.deepEqual(countable([-Infinity, Infinity]), [-8e307, 8e307]);
  assert.deepEqual(countable([0, 2]), [0, 2]);
});
