// Decodes sensor_msgs/Image to the pixels of a canvas; see https://wiki.ros.org/sensor_msgs and image_encodings.h.

import { decodeGrey16, depthsInMetres } from "./deep_png.js";

// Encodings come from a robot and may have any name: __proto__: null keeps "constructor" from being found.
const PACKED_8 = { // bytes per pixel, then the offsets of red, green, blue and alpha; -1 for none
  __proto__: null,
  rgb8: [3, 0, 1, 2, -1], bgr8: [3, 2, 1, 0, -1], rgba8: [4, 0, 1, 2, 3], bgra8: [4, 2, 1, 0, 3],
  "8uc3": [3, 2, 1, 0, -1], "8uc4": [4, 2, 1, 0, 3],
};
const PACKED_16 = { __proto__: null, rgb16: [3, 0, 1, 2], bgr16: [3, 2, 1, 0], rgba16: [4, 0, 1, 2, 3], bgra16: [4, 2, 1, 0, 3] };
const SINGLE_CHANNEL = { // one channel: bytes per value, and how to read it
  __proto__: null,
  mono8: [1, "getUint8"], "8uc1": [1, "getUint8"], "8sc1": [1, "getInt8"],
  mono16: [2, "getUint16"], "16uc1": [2, "getUint16"], "16sc1": [2, "getInt16"],
  "32sc1": [4, "getInt32"], "32fc1": [4, "getFloat32"], "64fc1": [8, "getFloat64"],
};
const GETTERS = { __proto__: null, "8u": "getUint8", "8s": "getInt8", "16u": "getUint16", "16s": "getInt16", "32s": "getInt32", "32f": "getFloat32", "64f": "getFloat64" };
const MULTI_CHANNEL = /^((?:8|16|32|64)[usf])c([2-4])$/; // OpenCV's channel order: blue, green, red and another
const BAYER = /^bayer_(rggb|bggr|gbrg|grbg)(8|16)$/; // colours at (even row, even column), (even, odd), (odd, even), (odd, odd)
const MAX_PIXELS = 40e6;

// Return {pixels: ImageData, least, most} of an image, or throw an Error that explains what is wrong.
// range: [least, most], the values drawn as black and white; null to use the image's.
export function pixelsOf({ encoding, width, height, step, bigendian }, data, range) {
  const kind = encoding.trim().toLowerCase();
  if (!width || !height) throw new Error(`an image of ${width} x ${height} pixels`);
  if (width * height > MAX_PIXELS) throw new Error(`an image of ${width} x ${height} pixels is too large to be shown`);
  const pixels = new ImageData(width, height);
  const out = pixels.data;
  const requireBytes = (bytes) => {
    if (step < width * bytes) throw new Error(`a row of ${width} pixels of ${encoding} has ${width * bytes} bytes, but step is ${step}`);
    if (data.length < step * (height - 1) + width * bytes) throw new Error(`data has ${data.length} bytes, which is too few for ${height} rows of ${step}`);
  };
  const bayer = BAYER.exec(kind);
  const multiple = MULTI_CHANNEL.exec(kind);
  if (PACKED_8[kind]) {
    requireBytes(PACKED_8[kind][0]);
    decodePacked8(out, data, width, height, step, PACKED_8[kind]);
  } else if (PACKED_16[kind]) {
    requireBytes(2 * PACKED_16[kind][0]);
    decodePacked16(out, data, width, height, step, PACKED_16[kind], bigendian);
  } else if (bayer) {
    const [, order, bits] = bayer;
    const size = Number(bits) / 8;
    requireBytes(size);
    decodeBayer(out, data, width, height, step, order.toUpperCase(), size, bigendian);
  } else if (kind === "yuv422" || kind === "yuv422_yuy2" || kind === "uyvy" || kind === "yuyv") {
    requireBytes(2);
    decodeYuv(out, data, width, height, step, kind === "yuv422" || kind === "uyvy");
  } else if (SINGLE_CHANNEL[kind]) {
    requireBytes(SINGLE_CHANNEL[kind][0]);
    return { pixels, ...decodeSingleChannel(out, data, width, height, step, SINGLE_CHANNEL[kind], bigendian, range) };
  } else if (multiple && GETTERS[multiple[1]]) {
    const [, value, digit] = multiple;
    const [size, count] = [Number.parseInt(value, 10) / 8, Number(digit)];
    requireBytes(size * count);
    return { pixels, ...decodeMultiChannel(out, data, width, height, step, [size, GETTERS[value], count], bigendian, range) };
  } else {
    throw new Error(`the encoding ${encoding} is not supported`);
  }
  return { pixels, least: null, most: null };
}

function decodePacked8(out, data, width, height, step, [size, red, green, blue, alpha]) {
  for (let row = 0, to = 0; row < height; row += 1) {
    for (let column = 0, from = row * step; column < width; column += 1, from += size, to += 4) {
      out[to] = data[from + red];
      out[to + 1] = data[from + green];
      out[to + 2] = data[from + blue];
      out[to + 3] = alpha < 0 ? 255 : data[from + alpha];
    }
  }
}

function decodePacked16(out, data, width, height, step, [size, ...places], bigendian) {
  const high = bigendian ? 0 : 1; // the upper byte is enough for a display
  for (let row = 0, to = 0; row < height; row += 1) {
    for (let column = 0, from = row * step; column < width; column += 1, from += 2 * size, to += 4) {
      out[to + 3] = 255;
      for (let colour = 0; colour < places.length; colour += 1) out[to + colour] = data[from + 2 * places[colour] + high];
    }
  }
}

// Demosaic: each pixel takes the missing colours from its block of two by two.
function decodeBayer(out, data, width, height, step, order, size, bigendian) {
  const high = size === 2 && !bigendian ? 1 : 0; // the upper byte is enough for a display
  const place = (colour) => order.indexOf(colour);
  const [red, blue] = [place("R"), place("B")];
  const greens = [...order].flatMap((colour, index) => (colour === "G" ? [index] : []));
  const lastRow = Math.max(0, height - 2);
  const lastColumn = Math.max(0, width - 2);
  for (let row = 0, to = 0; row < height; row += 1) {
    const top = Math.min(row & ~1, lastRow & ~1);
    for (let column = 0; column < width; column += 1, to += 4) {
      const left = Math.min(column & ~1, lastColumn & ~1);
      const at = (index) => data[(top + (index >> 1)) * step + (left + (index & 1)) * size + high];
      out[to] = at(red);
      out[to + 1] = (at(greens[0]) + at(greens[1])) >> 1;
      out[to + 2] = at(blue);
      out[to + 3] = 255;
    }
  }
}

function decodeYuv(out, data, width, height, step, chromaFirst) {
  for (let row = 0, to = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1, to += 4) {
      const pair = row * step + (column & ~1) * 2;
      const luma = data[pair + 2 * (column & 1) + (chromaFirst ? 1 : 0)];
      const u = data[pair + (chromaFirst ? 0 : 1)] - 128;
      const v = data[pair + (chromaFirst ? 2 : 3)] - 128;
      out[to] = luma + 1.402 * v; // Uint8ClampedArray clamps the result
      out[to + 1] = luma - 0.344136 * u - 0.714136 * v;
      out[to + 2] = luma + 1.772 * u;
      out[to + 3] = 255;
    }
  }
}

function decodeSingleChannel(out, data, width, height, step, [size, read], bigendian, range) {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  let [least, most] = range || [Infinity, -Infinity];
  if (!range && size === 1 && read === "getUint8") [least, most] = [0, 255];
  else if (!range) {
    for (let row = 0; row < height; row += 1) {
      for (let column = 0; column < width; column += 1) {
        const value = view[read](row * step + column * size, !bigendian);
        if (!Number.isFinite(value)) continue;
        if (value < least) least = value;
        if (value > most) most = value;
      }
    }
  }
  const scale = most > least ? 255 / (most - least) : 0;
  for (let row = 0, to = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1, to += 4) {
      const value = view[read](row * step + column * size, !bigendian);
      const known = Number.isFinite(value);
      const grey = known ? (value - least) * scale : 0;
      out[to] = grey;
      out[to + 1] = grey;
      out[to + 2] = known ? grey : 96; // missing values are blue
      out[to + 3] = 255;
    }
  }
  return { least: Number.isFinite(least) ? least : null, most: Number.isFinite(most) ? most : null };
}

// Two channels are blue and green, a third is red; a fourth is ignored. NaN is black.
function decodeMultiChannel(out, data, width, height, step, [size, read, count], bigendian, range) {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  const colourChannels = Math.min(3, count);
  const each = (visit) => {
    for (let row = 0, to = 0; row < height; row += 1) {
      for (let column = 0, from = row * step; column < width; column += 1, from += size * count, to += 4) {
        for (let channel = 0; channel < colourChannels; channel += 1) visit(view[read](from + channel * size, !bigendian), to + 2 - channel);
        out[to + 3] = 255;
      }
    }
  };
  let [least, most] = range || (read === "getUint8" ? [0, 255] : [Infinity, -Infinity]);
  if (least > most) {
    each((value) => {
      if (!Number.isFinite(value)) return;
      if (value < least) least = value;
      if (value > most) most = value;
    });
  }
  const scale = most > least ? 255 / (most - least) : 0;
  each((value, to) => { out[to] = Number.isFinite(value) ? (value - least) * scale : 0; });
  return { least: Number.isFinite(least) ? least : null, most: Number.isFinite(most) ? most : null };
}

const latestImages = new WeakMap(); // canvas -> number of its latest image

// Return a compressed 16-bit greyscale or depth image as an uncompressed one; null for all others.
async function decodeCompressedDepth({ format }, data) {
  const depth = format.includes("compressedDepth");
  const found = await decodeGrey16(depth ? data.subarray(12) : data, MAX_PIXELS);
  return found && depth && format.startsWith("32FC1") ? depthsInMetres(data, found) : found;
}

// Draw an image sent by the view "image" on a canvas. Returns {least, most} of a greyscale image, null if a newer one has
// arrived meanwhile; throws an Error that explains what is wrong.
export async function drawPicture(canvas, facts, data, range = null) {
  const number = (latestImages.get(canvas) || 0) + 1;
  latestImages.set(canvas, number);
  const size = (width, height) => {
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
  };
  if (facts.type !== "sensor_msgs/CompressedImage") {
    const { pixels, least, most } = pixelsOf(facts, data, range);
    size(facts.width, facts.height);
    canvas.getContext("2d").putImageData(pixels, 0, 0);
    return { least, most };
  }
  let picture;
  try {
    const raw = await decodeCompressedDepth(facts, data);
    if (number !== latestImages.get(canvas)) return null;
    if (raw) return drawPicture(canvas, raw, raw.data, range);
    picture = await createImageBitmap(new Blob([facts.format.includes("compressedDepth") ? data.subarray(12) : data]));
  } catch {
    throw new Error(`the browser cannot show images of the format ${facts.format}`);
  }
  if (number === latestImages.get(canvas)) {
    size(picture.width, picture.height);
    canvas.getContext("2d").drawImage(picture, 0, 0);
  }
  picture.close();
  return number === latestImages.get(canvas) ? { least: null, most: null } : null;
}
