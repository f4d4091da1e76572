// Grey PNG pictures with 16 bits. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";
import { deflateSync } from "node:zlib";

import { decodeGrey16, depthsInMetres } from "../../../src/pyros1/web/page/lib/deep_png.js";

const PASSES = [[0, 0, 8, 8], [4, 0, 8, 8], [0, 4, 4, 8], [2, 0, 4, 4], [0, 2, 2, 4], [1, 0, 2, 2], [0, 1, 1, 2]];
let seed = 7;
const random = (below) => {
  seed = (seed * 1103515245 + 12345) % 2 ** 31;
  return Math.floor((seed / 2 ** 31) * below);
};

// Its checksum is 0: the page does not look at it.
function chunk(kind, body) {
  const found = Buffer.alloc(12 + body.length);
  found.writeUInt32BE(body.length, 0);
  found.write(kind, 4, "latin1");
  body.copy(found, 8);
  return found;
}

const predicted = [
  () => 0, (left) => left, (left, up) => up, (left, up) => (left + up) >> 1,
  (left, up, corner) => [left, up, corner].sort((one, other) => Math.abs(up - corner + left - one) - Math.abs(up - corner + left - other))[0],
];

// Return a file of pixels, with a random filter in each row.
function png(pixels, width, height, { interlaced = 0, bits = 16, colours = 0, cut = 0 } = {}) {
  const raw = [];
  for (const [x, y, across, down] of interlaced ? PASSES : [[0, 0, 1, 1]]) {
    if (x >= width) continue;
    let before = null;
    for (let row = y; row < height; row += down) {
      const bytes = [];
      for (let column = x; column < width; column += across) bytes.push(pixels[row * width + column] >> 8, pixels[row * width + column] & 255);
      const kind = random(5);
      raw.push(kind, ...bytes.map((byte, at) => (byte - predicted[kind](bytes[at - 2] ?? 0, before?.[at] ?? 0, before?.[at - 2] ?? 0)) & 255));
      before = bytes;
    }
  }
  const head = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, bits, colours, 0, 0, interlaced]);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  const data = deflateSync(Buffer.from(raw.slice(0, raw.length - cut)));
  const parts = [data.subarray(0, 5), data.subarray(5)].map((part) => chunk("IDAT", part));
  return new Uint8Array(Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", head), ...parts, chunk("IEND", Buffer.alloc(0))]));
}

test("decodes all pixels of random images, with every filter", async () => {
  for (const [width, height] of [[1, 1], [1, 6], [6, 1], [3, 2], [13, 11]]) {
    for (const interlaced of [0, 1]) {
      const pixels = Array.from({ length: width * height }, () => random(65536));
      const found = await decodeGrey16(png(pixels, width, height, { interlaced }), 1000);
      assert.deepEqual([found.width, found.height, found.step, found.encoding], [width, height, 2 * width, "16UC1"]);
      assert.deepEqual(pixels.map((_, at) => found.data[2 * at] * 256 + found.data[2 * at + 1]), pixels);
    }
  }
});

test("leaves other files to the browser", async () => {
  assert.equal(await decodeGrey16(png([1], 1, 1, { bits: 8 }), 9), null);
  assert.equal(await decodeGrey16(png([1], 1, 1, { colours: 2 }), 9), null);
  assert.equal(await decodeGrey16(new Uint8Array(5), 9), null);
  assert.equal(await decodeGrey16(new Uint8Array(50), 9), null);
});

test("rejects damaged and huge files", async () => {
  const pixels = Array.from({ length: 9 }, () => 300);
  await assert.rejects(decodeGrey16(png(pixels, 3, 3, { cut: 4 }), 100), { message: "the picture is cut off" });
  await assert.rejects(decodeGrey16(png(pixels, 3, 3).subarray(0, 50), 100));
  await assert.rejects(decodeGrey16(png(pixels, 3, 3), 8), /3 by 3 pixels is too large/);
});

test("converts depths to metres", async () => {
  const message = Buffer.alloc(12);
  message.writeFloatLE(100, 4);
  message.writeFloatLE(50, 8);
  const found = depthsInMetres(message, await decodeGrey16(png([300, 0], 2, 1), 9));
  const values = new Float32Array(found.data.buffer);
  assert.ok(Math.abs(values[0] - 0.4) < 1e-6);
  assert.ok(Number.isNaN(values[1]));
});
