// Normals of meshes, which may be missing, zero, not finite or of any length. Pure.

const MIN_LENGTH = 0.03; // rviz recomputes shorter ones, too

// Return unit normals for all corners of triangles, or null if the given ones can be used.
// places, normals: three numbers per corner; normals may be null. index: the corners of the triangles, three by three;
// null if they are in order. An unusable normal is replaced by the normal of the corner's triangles, averaged by area.
export function repairNormals(places, normals, index = null) {
  const usable = normals?.length === places.length ? normals : null;
  const found = new Float32Array(places.length);
  const missing = new Uint8Array(places.length / 3);
  let same = Boolean(usable);
  if (!usable) missing.fill(1);
  else for (let corner = 0; corner < missing.length; corner += 1) {
    const length = normaliseInto(usable, found, 3 * corner, MIN_LENGTH);
    if (!length) missing[corner] = 1;
    same &&= Math.abs(length - 1) < 0.01;
  }
  if (same) return null;
  if (missing.includes(1)) computeMissing(places, index, found, missing);
  return found;
}

// Write a vector scaled to length 1, and return its original length; 0 if that is not finite, or below the minimum.
function normaliseInto(from, to, at, least) {
  const length = Math.hypot(from[at], from[at + 1], from[at + 2]);
  if (!Number.isFinite(length) || length < least) return 0;
  for (let axis = 0; axis < 3; axis += 1) to[at + axis] = from[at + axis] / length;
  return length;
}

function computeMissing(places, index, found, missing) {
  const sums = new Float64Array(found.length);
  const corners = index ? index.length : missing.length;
  const at = (place) => 3 * (index ? index[place] : place);
  for (let first = 0; first + 2 < corners; first += 3) {
    const [a, b, c] = [at(first), at(first + 1), at(first + 2)];
    const [ux, uy, uz] = [places[b] - places[a], places[b + 1] - places[a + 1], places[b + 2] - places[a + 2]];
    const [vx, vy, vz] = [places[c] - places[a], places[c + 1] - places[a + 1], places[c + 2] - places[a + 2]];
    for (const corner of [a, b, c]) {
      sums[corner] += uy * vz - uz * vy;
      sums[corner + 1] += uz * vx - ux * vz;
      sums[corner + 2] += ux * vy - uy * vx;
    }
  }
  for (let corner = 0; corner < missing.length; corner += 1) {
    if (missing[corner] && !normaliseInto(sums, found, 3 * corner, Number.MIN_VALUE)) found[3 * corner + 2] = 1; // a triangle without an area is invisible
  }
}
