// The number of points of a cloud to draw: fewer when frames take too long, more when they do not.
// Pure.

const SLOW_FRAME = 150; // milliseconds that a frame may take
const SLOW_FRAMES = 3; // consecutive frames that take longer before fewer points are requested
const FAST_FRAMES = 5; // consecutive frames that are fast enough before more points are requested
const MAX_FAST_FRAMES = 160;
const MIN_INCREASE = 1.5; // more points are requested if this factor more could be drawn
const MIN_POINTS = 20000;

export class PointBudget {
  constructor() {
    this.maxPoints = Infinity; // maximum number of points
    this._patience = FAST_FRAMES;
    this._slow = 0;
    this._fast = 0;
    this._more = false; // whether the last change was an increase
  }

  // Start again: the user has chosen another number.
  reset() {
    Object.assign(this, new PointBudget());
  }

  // Report how many milliseconds the last frame took. Returns whether `maxPoints` has changed.
  // count: points drawn; all: whether there are no more points; fresh: whether they have just arrived, which takes longer
  // than drawing them again from another viewpoint.
  reportFrame(lag, { count, all, fresh }) {
    const room = Math.min(4 * count, Math.round(count * 0.7 * SLOW_FRAME / Math.max(lag, 1)));
    if (fresh) this._slow = lag > SLOW_FRAME ? this._slow + 1 : 0;
    this._fast = !all && room > MIN_INCREASE * Math.max(count, this.maxPoints) ? this._fast + 1 : 0;
    if (this._slow >= SLOW_FRAMES && count > MIN_POINTS) {
      if (this._more) this._patience = Math.min(MAX_FAST_FRAMES, 2 * this._patience); // the increase was too much: wait longer before the next one
      return this._change(Math.max(MIN_POINTS, Math.round(count / 10), room), false);
    }
    return this._fast >= this._patience && this._change(room, true);
  }

  _change(maxPoints, more) {
    Object.assign(this, { maxPoints, _more: more, _slow: 0, _fast: 0 });
    return true;
  }
}

// The rate of the last few events.
export class RateMeter {
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
