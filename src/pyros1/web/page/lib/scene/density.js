// How many points of a cloud a browser draws without halting: fewer when pictures take too long, and more again when they
// do not. Nothing is drawn here.

const SLOW = 150; // milliseconds that a picture may take
const SLOW_TIMES = 3; // pictures in a row that take longer
const WELL_TIMES = 5; // pictures in a row after which there may be more points
const MOST_TIMES = 160;
const ROOM = 1.5; // more is asked for if there is room for so many times as many
const FEWEST = 20000;

export class Density {
  constructor() {
    this.enough = Infinity; // points
    this._patience = WELL_TIMES;
    this._slow = 0;
    this._well = 0;
    this._more = false; // whether the last change was to more points
  }

  // The user wants another number: that counts.
  forget() {
    Object.assign(this, new Density());
  }

  // Told how many milliseconds the last picture took. Returns whether `enough` is another number now.
  // count: points that are drawn; all: whether these are all that there are; fresh: whether they have just come, which takes
  // longer than to draw them again from elsewhere.
  told(lag, { count, all, fresh }) {
    const room = Math.min(4 * count, Math.round(count * 0.7 * SLOW / Math.max(lag, 1)));
    if (fresh) this._slow = lag > SLOW ? this._slow + 1 : 0;
    this._well = !all && room > ROOM * Math.max(count, this.enough) ? this._well + 1 : 0;
    if (this._slow >= SLOW_TIMES && count > FEWEST) {
      if (this._more) this._patience = Math.min(MOST_TIMES, 2 * this._patience); // it was too much: next time later
      return this._change(Math.max(FEWEST, Math.round(count / 10), room), false);
    }
    return this._well >= this._patience && this._change(room, true);
  }

  _change(enough, more) {
    Object.assign(this, { enough, _more: more, _slow: 0, _well: 0 });
    return true;
  }
}

// How often something comes, of the last few times.
export class Pace {
  constructor() {
    this.times = []; // milliseconds
  }

  tick(now) {
    this.times = [...this.times.slice(-9), now];
  }

  toString() {
    const { times } = this;
    const took = times.at(-1) - times[0];
    return took > 0 ? `${((times.length - 1) * 1000 / took).toFixed(1)} a second` : "the first";
  }
}
