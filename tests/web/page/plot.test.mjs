// Words of the plot. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { axisWidth, expand, marks } from "../../../src/pyros1/web/page/parts/plot/words.js";

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

test("words of rqt_plot, slices and expressions are curves", () => {
  for (const [text, curves] of [
    ["/a/x:y:z", ["/a/x", "/a/y", "/a/z"]],
    ["/a/x,/b[0:2]/y", ["/a/x", "/b[0:2]/y"]],
    ["/a/m:n", ["/a/m", "/a/n"]],
    ["/a: hypot(m.x, m.y)", ["/a: hypot(m.x, m.y)"]],
    ["/a:m.x*2", ["/a:m.x*2"]],
    ["/a/x,/b: m.y * 2", ["/a/x", "/b: m.y * 2"]],
    ["/a: 5", ["/a: 5"]],
  ]) assert.deepEqual(expand(text), curves);
});
