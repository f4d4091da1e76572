// Greyscale PNG images with 16 bits, as sent by depth cameras: browsers decode only the upper byte. See
// https://www.w3.org/TR/png and https://wiki.ros.org/compressed_depth_image_transport

const INTERLACED = [[0, 0, 8, 8], [4, 0, 8, 8], [0, 4, 4, 8], [2, 0, 4, 4], [0, 2, 2, 4], [1, 0, 2, 2], [0, 1, 1, 2]];
const HEADER_BYTES = 12; // bytes of the compressedDepth header before the file

// Return the image as a sensor_msgs/Image: {encoding, width, height, step, bigendian, data}; null if the file is not a
// 16-bit greyscale PNG. Throws an Error if it is damaged, or has more than the maximum number of pixels.
export async function decodeGrey16(file, most) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  if (file.length < 33 || view.getUint32(0) !== 0x89504e47 || view.getUint32(12) !== 0x49484452) return null;
  if (file[24] !== 16 || file[25] !== 0) return null; // bit depth and colour type
  const [width, height] = [view.getUint32(16), view.getUint32(20)];
  if (!width || !height || width * height > most) throw new Error(`a picture of ${width} by ${height} pixels is too large to be shown`);
  const passes = (file[28] ? INTERLACED : [[0, 0, 1, 1]]).map(([x, y, across, down]) => ({
    x, y, across, down, columns: Math.ceil(Math.max(0, width - x) / across), rows: Math.ceil(Math.max(0, height - y) / down),
  })).filter(({ columns, rows }) => columns && rows);
  const size = passes.reduce((sum, { columns, rows }) => sum + (1 + 2 * columns) * rows, 0);
  const raw = await inflate(dataChunks(file, view), size);
  const data = new Uint8Array(2 * width * height);
  let at = 0;
  for (const { x, y, across, down, columns, rows } of passes) {
    const step = 1 + 2 * columns;
    for (let row = 0; row < rows; row += 1, at += step) {
      unfilter(raw, at, step, row > 0);
      let to = 2 * ((y + row * down) * width + x);
      for (let from = at + 1; from < at + step; from += 2, to += 2 * across) {
        data[to] = raw[from];
        data[to + 1] = raw[from + 1];
      }
    }
  }
  return { encoding: "16UC1", width, height, step: 2 * width, bigendian: true, data };
}

// Return the depths in metres of a compressedDepth image with the format 32FC1; NaN where there is none.
export function depthsInMetres(message, { width, height, data }) {
  const head = new DataView(message.buffer, message.byteOffset, HEADER_BYTES);
  const [one, other] = [head.getFloat32(4, true), head.getFloat32(8, true)];
  const found = new DataView(new ArrayBuffer(4 * width * height));
  for (let pixel = 0; pixel < width * height; pixel += 1) {
    const value = data[2 * pixel] * 256 + data[2 * pixel + 1];
    found.setFloat32(4 * pixel, value ? one / (value - other) : NaN, true);
  }
  return { encoding: "32FC1", width, height, step: 4 * width, bigendian: false, data: new Uint8Array(found.buffer) };
}

function dataChunks(file, view) {
  const found = [];
  for (let at = 8; at + 12 <= file.length;) {
    const length = view.getUint32(at);
    if (view.getUint32(at + 4) === 0x49444154) found.push(file.subarray(at + 8, at + 8 + length));
    at += 12 + length;
  }
  return found;
}

// Return the first bytes of the decompressed data, and ignore the rest.
async function inflate(chunks, size) {
  const reader = new Blob(chunks).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  const found = new Uint8Array(size);
  let at = 0;
  while (at < size) {
    const { done, value } = await reader.read();
    if (done) throw new Error("the picture is cut off");
    found.set(value.subarray(0, size - at), at);
    at += value.length;
  }
  reader.cancel().catch(() => {});
  return found;
}

// Undo the filter of a row; its first byte is the type of the filter.
function unfilter(raw, start, step, above) {
  const kind = raw[start];
  if (!kind) return;
  for (let at = start + 1; at < start + step; at += 1) {
    const left = at > start + 2 ? raw[at - 2] : 0;
    const up = above ? raw[at - step] : 0;
    const corner = above && at > start + 2 ? raw[at - step - 2] : 0;
    if (kind === 1) raw[at] += left;
    else if (kind === 2) raw[at] += up;
    else if (kind === 3) raw[at] += (left + up) >> 1;
    else raw[at] += paeth(left, up, corner);
  }
}

function paeth(left, up, corner) {
  const guess = left + up - corner;
  const [toLeft, toUp, toCorner] = [Math.abs(guess - left), Math.abs(guess - up), Math.abs(guess - corner)];
  if (toLeft <= toUp && toLeft <= toCorner) return left;
  return toUp <= toCorner ? up : corner;
}
