// Hit testing of points. Pure.

// Return the points within a part of the screen: {total, nearest: the index of the nearest one, or -1, indices: the first
// of them, deep: the depth of the nearest one, from -1 (near) to 1 (far)}.
// positions: x, y, z of each; matrix: 16 numbers in column order that project them to the screen, with x and y from -1 to 1;
// box: [left, low, right, high] on the screen; most: maximum number of indices.
export function pointsIn(positions, count, matrix, /** @type {number[]} */ [left, low, right, high], most) {
  const [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = matrix;
  const indices = [];
  let [total, nearest, deep] = [0, -1, 1];
  for (let index = 0; index < count; index += 1) {
    const [x, y, z] = [positions[3 * index], positions[3 * index + 1], positions[3 * index + 2]];
    const far = d * x + h * y + l * z + p;
    if (!(far > 0)) continue; // behind the camera
    const across = (a * x + e * y + i * z + m) / far;
    const up = (b * x + f * y + j * z + n) / far;
    if (!(across >= left && across <= right && up >= low && up <= high)) continue;
    const depth = (c * x + g * y + k * z + o) / far;
    if (!(depth >= -1 && depth <= 1)) continue;
    total += 1;
    if (indices.length < most) indices.push(index);
    if (nearest < 0 || depth < deep) [nearest, deep] = [index, depth];
  }
  return { total, nearest, deep, indices };
}

// Return whether an object with these corners ([x, y, z]) overlaps a part of the screen.
export function overlaps(corners, [a, b, , d, e, f, , h, i, j, , l, m, n, , p], /** @type {number[]} */ [left, low, right, high]) {
  const screenBox = [Infinity, Infinity, -Infinity, -Infinity];
  for (const [x, y, z] of corners) {
    const far = d * x + h * y + l * z + p;
    if (!(far > 0)) continue;
    const across = (a * x + e * y + i * z + m) / far;
    const up = (b * x + f * y + j * z + n) / far;
    screenBox[0] = Math.min(screenBox[0], across);
    screenBox[1] = Math.min(screenBox[1], up);
    screenBox[2] = Math.max(screenBox[2], across);
    screenBox[3] = Math.max(screenBox[3], up);
  }
  return screenBox[0] <= right && screenBox[2] >= left && screenBox[1] <= high && screenBox[3] >= low;
}
