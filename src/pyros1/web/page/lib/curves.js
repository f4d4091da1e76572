// Points of curves over time, and how to sample them for a chart of a given width.

const INITIAL_CAPACITY = 1024;
const MAX_CLOCK_STEP = 0.1; // seconds; a time that goes back by more means that a bag or simulation has restarted

export class Points {
  constructor() {
    this.times = new Float64Array(INITIAL_CAPACITY);
    this.values = new Float64Array(INITIAL_CAPACITY);
    this.start = 0;
    this.end = 0;
    this.forgotten = 0; // number of points dropped so far, so that point numbers stay valid
  }

  get length() {
    return this.end - this.start;
  }

  // Append points in order of time. Where a time goes back, all earlier points are dropped.
  add(times, values) {
    let newest = this.length ? this.times[this.end - 1] : -Infinity;
    let first = 0;
    times.forEach((time, index) => {
      if (time < newest - MAX_CLOCK_STEP) {
        this.start = this.end = 0;
        first = index;
        newest = time;
      }
      newest = Math.max(newest, time);
    });
    this._makeRoom(times.length - first);
    for (let index = first; index < times.length; index += 1, this.end += 1) {
      this.times[this.end] = Math.max(times[index], this.length ? this.times[this.end - 1] : -Infinity); // small steps back: the clock was adjusted
      this.values[this.end] = values[index];
    }
  }

  // Drop points older than a time, and the oldest ones above a maximum.
  trim(oldest, most) {
    const start = Math.max(this.indexOf(oldest), this.end - most);
    this.forgotten += start - this.start;
    this.start = start;
  }

  // Return the index of the first point at a time or later.
  indexOf(time) {
    let low = this.start;
    let high = this.end;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // Return the value of the point nearest to a time.
  valueNear(time) {
    const after = this.indexOf(time);
    const nearer = after > this.start && (after === this.end || time - this.times[after - 1] < this.times[after] - time);
    return this.length ? this.values[nearer ? after - 1 : after] : undefined;
  }

  lastValue() {
    return this.length ? this.values[this.end - 1] : undefined;
  }

  _makeRoom(count) {
    if (this.end + count <= this.times.length) return;
    const size = this.length + count > this.times.length / 2 ? 2 * (this.times.length + count) : this.times.length;
    const [times, values] = [new Float64Array(size), new Float64Array(size)];
    times.set(this.times.subarray(this.start, this.end));
    values.set(this.values.subarray(this.start, this.end));
    this.end -= this.start;
    this.start = 0;
    this.times = times;
    this.values = values;
  }
}

// Return the sample times of a chart: two per column, for a minimum and a maximum.
// Columns are aligned to multiples of their width, so that curves do not flicker while the chart scrolls.
export function grid(begin, end, columns) {
  const step = (end - begin) / columns;
  const first = Math.floor(begin / step);
  const times = new Float64Array(2 * (columns + 1));
  for (let column = 0; column <= columns; column += 1) {
    times[2 * column] = (first + column) * step;
    times[2 * column + 1] = (first + column + 0.5) * step;
  }
  return { times, step, first, columns };
}

// Return the minimum and maximum of a curve in each column of a grid, in the order of their times.
// undefined: no point there, the line continues; null: a value that is not finite, the line is interrupted.
export function sample(points, { step, first, columns }) {
  const out = new Array(2 * (columns + 1)).fill(undefined);
  let index = Math.max(points.start, points.indexOf(first * step) - 1); // start with the point before the first column
  const { times, values, end } = points;
  const last = (first + columns + 1) * step;
  let next = 0; // column; because of rounding, a time at an edge may seem to belong to the column before
  while (index < end && times[index] < last) {
    const column = Math.max(next, Math.floor(times[index] / step) - first);
    if (column > columns) break;
    next = column + 1;
    const limit = (first + column + 1) * step;
    let least = index;
    let most = index;
    while (index < end && (times[index] < limit || index === least)) {
      if (!(values[index] >= values[least])) least = Number.isNaN(values[index]) ? least : index;
      if (!(values[index] <= values[most])) most = Number.isNaN(values[index]) ? most : index;
      index += 1;
    }
    out[2 * column] = finiteOrNull(values[Math.min(least, most)]);
    if (least !== most) out[2 * column + 1] = finiteOrNull(values[Math.max(least, most)]);
  }
  return interruptLines(out);
}

// Interrupt the line between two numbers with a non-finite value between them: uPlot needs null in all columns there.
function interruptLines(values) {
  let from = 0;
  for (let at = values.indexOf(null); at >= 0; at = values.indexOf(null, from)) {
    let begin = at;
    while (begin > from && values[begin - 1] === undefined) begin -= 1;
    from = at;
    while (from < values.length && (values[from] === undefined || values[from] === null)) from += 1;
    values.fill(null, begin, from);
  }
  return values;
}

// Return the indices of isolated numbers, which no line reaches and which are drawn as dots; null for none.
export function isolated(values) {
  const found = [];
  let before = null;
  let last = -1; // index of a number that may be isolated
  values.forEach((value, index) => {
    if (value === undefined) return;
    if (value === null && last >= 0) found.push(last);
    last = value !== null && before === null ? index : -1;
    before = value;
  });
  if (last >= 0) found.push(last);
  return found.length ? found : null;
}

function finiteOrNull(value) {
  return Number.isFinite(value) ? value : null;
}
