// A chart of curves against each other: fading trails, the newest point, and the point under the cursor.

import uPlot from "../../vendor/uplot.js";
import { gestures } from "./gestures.js";
import { axisWidth, safeRange, tickLabels } from "./plot_text.js";
import { boxAround, equal, join, nearest } from "../../lib/curve_pairs.js";

const MAX_POINTS = 12000; // points per trail
const MAX_TITLE_LENGTH = 60; // characters of an axis title
const HIT_DISTANCE = 30; // maximum pixels from the cursor to a point
const TRAIL_OPACITIES = [0.3, 0.5, 0.75, 1]; // opacity of the quarters of a trail, the oldest first

export class XYChart {
  // pairs: [{pair: {x, y} (names), x: Points, y: Points, colour, dash}]; on: {cursor(found or null)}, with {trail, x, y, time} of a point.
  constructor(area, size, pairs, isEqual, on) {
    this.pairs = pairs;
    this.equal = isEqual;
    this.on = on;
    this.trails = [];
    this.box = null; // the zoomed range; null: everything
    this.shown = { x: [0, 1], y: [0, 1] };
    this.found = null;
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const axis = { stroke: colour("--muted"), grid: { stroke: colour("--border"), width: 1 }, ticks: { stroke: colour("--border"), width: 1 }, values: (_, ticks) => tickLabels(ticks) };
    this.ink = colour("--text");
    const named = (key) => {
      const names = [...new Set(pairs.map(({ pair }) => pair[key]))].join(", ");
      return { label: names.length > MAX_TITLE_LENGTH ? `${names.slice(0, MAX_TITLE_LENGTH)} …` : names, labelSize: 22, labelFont: "12px sans-serif" };
    };
    this.plot = new uPlot({
      ...size,
      padding: [10, 14, 0, 0],
      legend: { show: false },
      cursor: { drag: { x: true, y: true, setScale: false }, points: { show: false } },
      scales: { x: { time: false, auto: false, range: () => this.shown.x }, y: { auto: false, range: () => this.shown.y } },
      axes: [{ ...axis, size: 30, space: 90, ...named("x") }, { ...axis, size: axisWidth, ...named("y") }],
      series: [{}, { points: { show: false } }],
      hooks: {
        draw: [() => this._drawTrails()],
        setSelect: [() => this._zoom()],
        setCursor: [() => this._cursor()],
      },
    }, [[0, 1], [null, null]], area);
    const { over } = this.plot;
    over.addEventListener("dblclick", () => { this.box = null; this.draw(); });
    gestures(over, {
      pan: (right, down) => this._pan(right, down),
      pinch: (x, y, ...factors) => {
        const factor = Math.abs(factors[0] - 1) > Math.abs(factors[1] - 1) ? factors[0] : factors[1];
        this._scale(x, y, factor, factor);
      },
    });
    over.addEventListener("wheel", (event) => this._wheel(event), { passive: false });
  }

  get ctx() {
    return this.plot.ctx;
  }

  setSize(size) {
    this.plot.setSize(size);
    this.draw();
  }

  destroy() {
    this.plot.destroy();
  }

  // Draw the points in a time range; without arguments, in the same range as before.
  draw(begin, end) {
    if (begin !== undefined) this.trails = this.pairs.map(({ x, y }) => join(x, y, begin, end, MAX_POINTS));
    const { clientWidth: width, clientHeight: height } = this.plot.over;
    const box = this.box || boxAround(this.trails);
    const { x, y } = this.equal ? equal(box, width, height) : box;
    this.shown = { x: safeRange(x), y: safeRange(y) };
    this.plot.batch(() => {
      this.plot.setScale("x", { min: this.shown.x[0], max: this.shown.x[1] });
      this.plot.setScale("y", { min: this.shown.y[0], max: this.shown.y[1] });
    });
    this._cursor();
    this.plot.redraw(false);
  }

  _drawTrails() {
    const { ctx, bbox } = this.plot;
    const ratio = devicePixelRatio || 1;
    const [scaleX, scaleY] = [bbox.width / (this.shown.x[1] - this.shown.x[0]), bbox.height / (this.shown.y[1] - this.shown.y[0])];
    const across = (x) => bbox.left + (x - this.shown.x[0]) * scaleX;
    const down = (y) => bbox.top + bbox.height - (y - this.shown.y[0]) * scaleY;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineWidth = 1.75 * ratio;
    ctx.lineJoin = "round";
    const dot = (x, y, size, ...colours) => {
      ctx.beginPath();
      ctx.arc(across(x), down(y), size * ratio, 0, 7);
      [ctx.fillStyle] = colours;
      ctx.fill();
      if (!colours[1]) return;
      [, ctx.strokeStyle] = colours;
      ctx.stroke();
    };
    this.trails.forEach(({ xs, ys }, number_) => {
      const { colour, dash = [] } = this.pairs[number_];
      ctx.strokeStyle = colour;
      ctx.setLineDash(dash.map((length) => length * ratio));
      TRAIL_OPACITIES.forEach((alpha, quarter) => {
        const from = Math.floor((xs.length * quarter) / TRAIL_OPACITIES.length);
        const to = Math.min(xs.length - 1, Math.floor((xs.length * (quarter + 1)) / TRAIL_OPACITIES.length));
        ctx.globalAlpha = alpha;
        ctx.beginPath();
        for (let index = from; index <= to; index += 1) {
          if (index === from || Number.isNaN(xs[index - 1])) ctx.moveTo(across(xs[index]), down(ys[index]));
          else ctx.lineTo(across(xs[index]), down(ys[index]));
        }
        ctx.stroke();
      });
      ctx.globalAlpha = 1;
      ctx.setLineDash([]);
      if (xs.length) dot(xs[xs.length - 1], ys[ys.length - 1], 4.5, colour);
    });
    if (this.found) dot(this.found.x, this.found.y, 5, "transparent", this.ink);
    ctx.restore();
  }

  _zoom() {
    const { plot } = this;
    const { left, top, width, height } = plot.select;
    if (width < 4 || height < 4) return;
    this.box = {
      x: [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")],
      y: [plot.posToVal(top + height, "y"), plot.posToVal(top, "y")],
    };
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.draw();
  }

  _wheel(event) {
    event.preventDefault();
    const factor = event.deltaY > 0 ? 1 / 1.2 : 1.2;
    this._scale(event.offsetX, event.offsetY, factor, factor);
  }

  _scale(left, top, across, along) {
    const { plot } = this;
    const about = (/** @type {number[]} */ [least, most], here, factor) => [here - (here - least) / factor, here + (most - here) / factor];
    this.box = {
      x: about(this.shown.x, plot.posToVal(left, "x"), across),
      y: about(this.shown.y, plot.posToVal(top, "y"), along),
    };
    this.draw();
  }

  _pan(right, down) {
    const { clientWidth: width, clientHeight: height } = this.plot.over;
    const moved = (/** @type {number[]} */ [least, most], part) => [least - part * (most - least), most - part * (most - least)];
    this.box = { x: moved(this.shown.x, right / width), y: moved(this.shown.y, -down / height) };
    this.draw();
  }

  _cursor() {
    const { left = -1, top = -1 } = this.plot.cursor;
    const before = this.found;
    this.found = null;
    if (left >= 0 && top >= 0) {
      const { clientWidth: width, clientHeight: height } = this.plot.over;
      const place = { x: this.plot.posToVal(left, "x"), y: this.plot.posToVal(top, "y") };
      const found = nearest(this.trails, place, this.shown, width, height, HIT_DISTANCE);
      if (found) {
        const { xs, ys, times } = this.trails[found.trail];
        this.found = { trail: found.trail, x: xs[found.index], y: ys[found.index], time: times[found.index] };
      }
    }
    this.on.cursor(this.found);
    if (before !== this.found) this.plot.redraw(false);
  }
}
