// Pictures as pixels. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { pixelsOf } from "../../../src/pyros1/web/page/lib/images.js";

globalThis.ImageData = class {
  constructor(width, height) {
    Object.assign(this, { width, height, data: new Uint8ClampedArray(4 * width * height) });
  }
};

const facts = { encoding: "mono8", width: 2, height: 1, step: 2, bigendian: false };

test("a picture of one channel", () => {
  assert.deepEqual([...pixelsOf(facts, Uint8Array.of(0, 255)).pixels.data], [0, 0, 0, 255, 255, 255, 255, 255]);
});

test("encodings that a robot calls as parts of JavaScript are not known", () => {
  for (const encoding of ["constructor", "__proto__", "toString", "hasOwnProperty", "", "rgb9"]) {
    assert.throws(() => pixelsOf({ ...facts, encoding }, Uint8Array.of(0, 255)), { message: `the encoding ${encoding} is not supported` });
  }
});
