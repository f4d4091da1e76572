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

test("decodes an image with one channel", () => {
  assert.deepEqual([...pixelsOf(facts, Uint8Array.of(0, 255)).pixels.data], [0, 0, 0, 255, 255, 255, 255, 255]);
});

test("encodings named like JavaScript's built-in properties are unknown", () => {
  for (const encoding of ["constructor", "__proto__", "toString", "hasOwnProperty", "", "rgb9"]) {
    assert.throws(() => pixelsOf({ ...facts, encoding }, Uint8Array.of(0, 255)), { message: `the encoding ${encoding} is not supported` });
  }
});

test("a 16-bit Bayer image has the colours of its upper bytes", () => {
  const rows = { rggb: [9, 5, 7, 3], bggr: [3, 5, 7, 9], gbrg: [5, 3, 9, 7], grbg: [5, 9, 3, 7] }; // red 9, green 5 and 7, blue 3
  for (const [order, values] of Object.entries(rows)) {
    const eight = pixelsOf({ ...facts, encoding: `bayer_${order}8`, height: 2 }, Uint8Array.from(values)).pixels.data;
    for (const bigendian of [false, true]) {
      const wide = Uint8Array.from(values.flatMap((value) => (bigendian ? [value, 200] : [200, value])));
      const { pixels } = pixelsOf({ ...facts, encoding: `bayer_${order}16`, height: 2, step: 4, bigendian }, wide);
      assert.deepEqual([...pixels.data], [...eight]);
    }
    assert.deepEqual([...eight.slice(0, 4)], [9, 6, 3, 255]);
  }
  assert.throws(() => pixelsOf({ ...facts, encoding: "bayer_rggb16" }, Uint8Array.of(1, 2)), /step is 2/);
});

test("channels of numbers become blue, green and red, scaled from the minimum to the maximum", () => {
  const two = pixelsOf({ ...facts, encoding: "8UC2", step: 4 }, Uint8Array.of(10, 20, 30, 40));
  assert.deepEqual([...two.pixels.data], [0, 20, 10, 255, 0, 40, 30, 255]);
  const floats = new Uint8Array(Float32Array.of(0, 0.5, 1, NaN, 0, 2).buffer);
  const three = pixelsOf({ ...facts, encoding: "32FC3", step: 24 }, floats);
  assert.deepEqual([three.least, three.most], [0, 2]);
  assert.deepEqual([...three.pixels.data], [128, 64, 0, 255, 255, 0, 0, 255]);
  assert.deepEqual([...pixelsOf({ ...facts, encoding: "32FC3", step: 24 }, floats, [0, 1]).pixels.data], [255, 128, 0, 255, 255, 0, 0, 255]);
  const four = pixelsOf({ ...facts, encoding: "16SC4", width: 1, step: 8, bigendian: true }, Uint8Array.of(255, 255, 0, 0, 0, 1, 99, 99));
  assert.deepEqual([...four.pixels.data], [255, 128, 0, 255]);
  assert.throws(() => pixelsOf({ ...facts, encoding: "8FC2" }, Uint8Array.of(1, 2)), /not supported/);
});
