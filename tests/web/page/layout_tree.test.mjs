// Trees of panels that the user arranges.

import assert from "node:assert/strict";
import { test } from "node:test";

import { moved, panelsOf, sideOf, swapped, without } from "../../../src/pyros1/web/page/lib/layout_tree.js";

const [one, two, three] = ["one", "two", "three"].map((panel) => ({ panel }));
const tree = { split: "row", sizes: [2, 1, 1], parts: [one, two, three] };
const names = (each) => panelsOf(each).map(({ panel }) => panel).join();

test("swaps two panels, even of different splits", () => {
  assert.equal(names(swapped(tree, one, three)), "three,two,one");
  const deep = { split: "column", sizes: [1, 1], parts: [one, { split: "row", sizes: [1, 1], parts: [two, three] }] };
  assert.equal(names(swapped(deep, one, three)), "three,two,one");
});

test("moves a panel to a side of another one", () => {
  const below = moved(tree, one, three, "bottom");
  assert.deepEqual(below, { split: "row", sizes: [1, 1], parts: [two, { split: "column", sizes: [1, 1], parts: [three, one] }] });
  assert.deepEqual(moved(tree, three, one, "left"), { split: "row", sizes: [1, 1, 1], parts: [three, one, two] });
  assert.deepEqual(moved({ split: "row", sizes: [1, 1], parts: [one, two] }, one, two, "top"), { split: "column", sizes: [1, 1], parts: [one, two] });
});

test("a full split takes no more panels", () => {
  const parts = Array.from("abcdefgh", (panel) => ({ panel }));
  const full = { split: "column", sizes: [1, 1], parts: [one, { split: "row", sizes: parts.map(() => 1), parts }] };
  assert.equal(names(moved(full, one, parts[7], "right")), "a,b,c,d,e,f,g,h,one");
  assert.equal(moved(full, one, parts[7], "right").parts.length, 8);
});

test("removing a panel gives its space to the others", () => {
  assert.equal(without(one, one), null);
  assert.deepEqual(without(tree, one), { split: "row", sizes: [1, 1], parts: [two, three] });
});

test("finds the side of a box that a point is near", () => {
  const box = { left: 100, top: 0, width: 200, height: 100 };
  assert.deepEqual([[105, 50], [295, 50], [200, 5], [200, 95], [200, 50]].map(([x, y]) => sideOf(box, x, y)), ["left", "right", "top", "bottom", "middle"]);
});
