// Points of curves over time, and what of them a chart of some width shows.

const ROOM = 1024;
const BACK = 0.1; // seconds: by more, a time goes back only when a bag or a simulation begins again

export class Points {
  constructor() {
    this.times = new Float64Array(ROOM);
    this.values = new Float64Array(ROOM);
    this.start = 0;
    this.end = 0;
    this.forgotten = 0; // points, so that those that are left have lasting numbers
  }

  get length() {
    return this.end - this.start;
  }

  // Add points, whose times grow; a time that goes back, wherever it is among them, starts anew.
  add(times, values) {
    let newest = this.length ? this.times[this.end - 1] : -Infinity;
    let first = 0;
    times.forEach((time, index) => {
      if (time < newest - BACK) {
        this.start = this.end = 0;
        first = index;
        newest = time;
      }
      newest = Math.max(newest, time);
    });
    this._makeRoom(times.length - first);
    for (let index = first; index < times.length; index += 1, this.end += 1) {
      this.times[this.end] = Math.max(times[index], this.length ? this.times[this.end - 1] : -Infinity); // a clock was set right
      this.values[this.end] = values[index];
    }
  }

  // Forget what is older than a time, and the oldest of too many.
  trim(oldest, most) {
    const start = Math.max(this.indexOf(oldest), this.end - most);
    this.forgotten += start - this.start;
    this.start = start;
  }

  // The index of the first point at a time or later.
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

  // The value of the point nearest to a time.
  near(time) {
    const after = this.indexOf(time);
    const nearer = after > this.start && (after === this.end || time - this.times[after - 1] < this.times[after] - time);
    return this.length ? this.values[nearer ? after - 1 : after] : undefined;
  }

  last() {
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

// The times of a chart: two for each column, since a column may have a least and a greatest value.
// Columns keep their places while the chart moves, so curves do not flicker.
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

// What a curve has in the columns of a grid: its least and its greatest value in each, in the order in which they came.
// undefined: no point is there, and the line goes on; null: what is there is no number, and the line ends.
export function sample(points, { step, first, columns }) {
  const out = new Array(2 * (columns + 1)).fill(undefined);
  let index = Math.max(points.start, points.indexOf(first * step) - 1); // the line begins outside
  const { times, values, end } = points;
  const last = (first + columns + 1) * step;
  let next = 0; // column; by rounding, a time at an edge may seem to be in the column before
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
    out[2 * column] = finite(values[Math.min(least, most)]);
    if (least !== most) out[2 * column + 1] = finite(values[Math.max(least, most)]);
  }
  return apart(out);
}

// Between two numbers there is no line if something else came: then all is null there, as uPlot wants it.
function apart(values) {
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

// The indices of numbers of such a row to which no line leads: they are drawn as dots. null for none.
export function lone(values) {
  const found = [];
  let before = null;
  let last = -1; // index of a number that may be lone
  values.forEach((value, index) => {
    if (value === undefined) return;
    if (value === null && last >= 0) found.push(last);
    last = value !== null && before === null ? index : -1;
    before = value;
  });
  if (last >= 0) found.push(last);
  return found.length ? found : null;
}

function finite(value) {
  return Number.isFinite(value) ? value : null;
}
