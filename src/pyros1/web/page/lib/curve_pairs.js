// Plot two curves over time against each other: points of both at the same times, and the range of a chart.

const MAX_GAP = 1; // seconds; x is interpolated between two values that are at most this far apart

// Return the points of a pair of curves in a time range: {xs, ys, times}, at the times of y, up to a maximum; NaN interrupts the line.
// If there are too many, only every n-th is used, always the same ones, so that the chart does not flicker.
export function join(x, y, begin, end, most) {
  const first = y.indexOf(begin);
  const last = Math.min(y.end, y.indexOf(end + 1e-9));
  const step = Math.max(1, 2 ** Math.ceil(Math.log2(Math.max(1, last - first) / most)));
  const count = Math.max(0, Math.ceil((last - first) / step));
  const [xs, ys, times] = [0, 1, 2].map(() => new Float64Array(2 * count));
  let kept = 0;
  let near = x.indexOf(begin);
  let ended = false; // a value was not finite: the line is interrupted
  const addPoint = (...numbers) => {
    [xs[kept], ys[kept], times[kept]] = numbers;
    kept += 1;
  };
  const keep = (index) => {
    const time = y.times[index];
    while (near < x.end && x.times[near] < time) near += 1;
    const value = at(x, near, time);
    if (!Number.isFinite(value) || !Number.isFinite(y.values[index])) {
      ended = kept > 0;
      return;
    }
    if (ended) addPoint(NaN, NaN, time);
    ended = false;
    addPoint(value, y.values[index], time);
  };
  for (let index = first + ((step - ((first - y.start + y.forgotten) % step)) % step); index < last; index += step) keep(index);
  return { xs: xs.subarray(0, kept), ys: ys.subarray(0, kept), times: times.subarray(0, kept) };
}

// Interpolate a curve at a time; near is the index of its first point at that time or later.
function at({ times, values, start, end }, near, time) {
  if (near < end && times[near] === time) return values[near];
  if (near <= start || near >= end) return near > start && near >= end && time - times[end - 1] < MAX_GAP ? values[end - 1] : NaN;
  const [before, after] = [times[near - 1], times[near]];
  if (after - before > MAX_GAP) return time - before < MAX_GAP ? values[near - 1] : NaN;
  return values[near - 1] + ((values[near] - values[near - 1]) * (time - before)) / (after - before);
}

// Return the bounding box of points, with a margin: {x: [least, most], y: [least, most]}.
export function boxAround(trails) {
  const box = { x: [Infinity, -Infinity], y: [Infinity, -Infinity] };
  for (const { xs, ys } of trails) {
    for (const [range, values] of [[box.x, xs], [box.y, ys]]) {
      for (const value of values) {
        if (value < range[0]) range[0] = value;
        if (value > range[1]) range[1] = value;
      }
    }
  }
  return { x: paddedRange(box.x), y: paddedRange(box.y) };
}

function paddedRange(/** @type {number[]} */ [least, most]) {
  if (!(least <= most)) return [0, 1];
  const room = least === most ? Math.abs(least) * 0.1 || 0.5 : (most - least) * 0.06;
  return [least - room, most + room];
}

// Widen a box so that a unit has the same length on both axes.
export function equal({ x, y }, width, height) {
  const unit = Math.max((x[1] - x[0]) / Math.max(1, width), (y[1] - y[0]) / Math.max(1, height));
  const about = (/** @type {number[]} */ [least, most], size) => [(least + most - unit * size) / 2, (least + most + unit * size) / 2];
  return { x: about(x, width), y: about(y, height) };
}

// Return the point nearest to a position, in pixels: {trail, index} with numbers, or null if none is near enough.
/** @returns {{trail: number, index: number} | null} */
export function nearest(trails, place, box, width, height, reach) {
  const [scaleX, scaleY] = [width / (box.x[1] - box.x[0]), height / (box.y[1] - box.y[0])];
  let found = null;
  let least = reach * reach;
  trails.forEach(({ xs, ys }, trail) => {
    for (let index = 0; index < xs.length; index += 1) {
      const across = (xs[index] - place.x) * scaleX;
      const up = (ys[index] - place.y) * scaleY;
      const far = across * across + up * up;
      if (far <= least) {
        least = far;
        found = { trail, index };
      }
    }
  });
  return found;
}
