// Numeric fields of any topic over time, like rqt_plot.

import { Points, grid, sample } from "../lib/curves.js";
import { command, empty, fill, h, save } from "../lib/dom.js";
import { clock, reading } from "../lib/format.js";
import { styleOf, showLegendText, swatch } from "../parts/plot/curve_styles.js";
import { Pairs } from "../parts/plot/pairs.js";
import { exportImage } from "../parts/plot/export_image.js";
import { timeChart } from "../parts/plot/timechart.js";
import { splitCurves } from "../parts/plot/plot_text.js";
import { XYChart } from "../parts/plot/xychart.js";

const PERIODS = [2, 5, 10, 20, 60, 300];
const MAX_AGE = 600; // seconds
const MAX_POINTS = 6e5; // points per line
const MIN_HEIGHT = 90;
const REDRAW_DELAY = 250; // milliseconds until trails are redrawn without new data: they continue to fade

export default {
  title: "Plot",
  description: "numbers of any topic over time",
  order: 30,
  mount: (place) => new Plot(place),
};

class Plot {
  constructor(place) {
    this.place = place;
    this.curves = []; // {id, text, hidden, points: Map(part -> Points), problem, waits: what the curve waits for}
    this.period = Number(place.settings.period) || 20;
    this.stacked = Boolean(place.settings.stacked);
    this.xy = Boolean(place.settings.xy); // plot curves against each other instead of over time
    this.equal = place.settings.equal !== false; // whether both axes then have the same scale
    this.pairs = new Pairs({
      curves: () => this.curves,
      add: (text) => this._add(text, false),
      remove: (texts) => { this.curves = this.curves.filter(({ text }) => !texts.includes(text)); },
      changed: () => this._curvesChanged(),
      redraw: () => this._layOut(),
    });
    this.range = null; // the zoomed range; null follows the newest data
    this.now = null; // the robot's time
    this.nowAt = 0; // when `now` was received
    this.charts = [];
    this.lines = [];
    this.drawnAt = 0;
    this.ids = 0;
    this._build();
    for (const text of place.settings.curves || []) this._add(String(text), false);
    const { pairs } = place.settings;
    for (const pair of Array.isArray(pairs) ? pairs : []) if (Array.isArray(pair)) this.pairs.pair(String(pair[0]), String(pair[1] || ""));
    if (this.xy && !this.pairs.list.length) this.pairs.pairAll();
    this.startPaused = Boolean(place.settings.paused);
    this.stream = place.robot.stream("plot", this._streamArgs(), {
      data: (data, blob) => this._receive(data, blob),
      problem: (text) => place.problem(text),
    });
    this._layOut();
    this.observer = new ResizeObserver(() => this._resize());
    this.observer.observe(this.area);
    this.onTheme = () => this._layOut();
    addEventListener("themechange", this.onTheme);
    this.timer = requestAnimationFrame(() => this._frame());
  }

  // Called when another panel asks for something to be plotted.
  accept(settings) {
    if (this.xy) this.pairs.add(settings.curves || []);
    else for (const text of settings.curves || []) this._add(text);
  }

  unmount() {
    this.stream.close();
    this.observer.disconnect();
    removeEventListener("themechange", this.onTheme);
    cancelAnimationFrame(this.timer);
    for (const chart of this.charts) chart.destroy();
  }

  _build() {
    const { body, tools } = this.place;
    const list = h("datalist", { id: `fields${Math.random()}` });
    this.input = h("input.mono", {
      placeholder: "/topic/field", size: 26, "aria-label": "add a curve", spellcheck: false,
      title: "/topic/field, /topic/array[0:3], or /topic: an expression with m, the message",
      onfocus: () => this._suggest(list),
      oninput: () => this._suggest(list),
    });
    this.input.setAttribute("list", list.id);
    const form = h("form", { onsubmit: (event) => this._submit(event) }, this.input, list, " ", h("button.primary", {}, "Add"));
    const periods = h("select", {
      "aria-label": "period", title: "time range shown",
      onchange: (event) => {
        this.period = Number(event.target.value);
        if (this.range) this._showRange([this.range[1] - this.period, this.range[1]]); // the plot remains paused
        this._save();
      },
    }, [...new Set([...PERIODS, this.period])].sort((one, other) => one - other).map((seconds) => h("option", { value: seconds, selected: seconds === this.period }, seconds < 60 ? `${seconds} s` : `${seconds / 60} min`)));
    this.pause = h("button", { "aria-pressed": "false", title: "pause the plot; drag: zoom; Shift and drag: move; double-click: show all; wheel: zoom, with Ctrl vertically", onclick: () => this._pause() }, "Pause");
    const toggle = (label, title, key, more = () => {}) => h("button", { "aria-pressed": String(this[key]), title, onclick: (event) => {
      this[key] = !this[key];
      event.currentTarget.setAttribute("aria-pressed", String(this[key]));
      more();
      this._save();
      this._layOut();
    } }, label);
    const stack = toggle("Stack", "a chart for each curve", "stacked");
    const same = toggle("1:1", "same scale on both axes", "equal");
    const choose = () => {
      stack.hidden = this.xy;
      same.hidden = !this.xy;
      this.input.placeholder = this.xy ? "/topic/x:y" : "/topic/field";
    };
    const against = toggle("XY", "one field against another: type both, as /pose/x:y or /a,/b", "xy", () => {
      if (this.xy && !this.pairs.list.length) this.pairs.pairAll();
      choose();
    });
    choose();
    tools.append(form, periods, this.pause, stack, same, against,
      h("button.quiet", { title: "save all points as CSV", onclick: () => this._csv() }, "CSV"),
      h("button.quiet", { title: "save the image", onclick: () => this._png() }, "PNG"));
    this.legend = h("div.legend");
    this.area = h("div.charts");
    this.timeText = h("span.when.mono", { hidden: true });
    body.classList.add("plot");
    body.plot = this; // for tests and debugging
    body.append(this.legend, this.area, this.timeText);
  }

  _streamArgs() {
    return { curves: this.curves.map(({ id, text }) => ({ id, text })) };
  }

  _save() {
    this.place.save({
      curves: this.curves.map(({ text }) => text), period: this.period, stacked: this.stacked,
      ...(this.xy || this.pairs.list.length ? { xy: this.xy, equal: this.equal, pairs: this.pairs.list.map(({ x, y }) => [x, y]) } : {}),
    });
  }

  _submit(event) {
    event.preventDefault();
    // like rqt_plot: several curves separated by commas, and /topic/x:y:z for three fields of one message
    const texts = splitCurves(this.input.value).map((text) => (/^\s*[A-Za-z]/.test(text) ? `/${text.trim()}` : text));
    if (this.xy) this.pairs.add(texts);
    else for (const text of texts) this._add(text);
    this.input.value = "";
  }

  _add(text, change = true) {
    text = text.trim();
    if (!text || this.curves.some((curve) => curve.text === text)) return;
    this.curves.push({ id: ++this.ids, text, hidden: false, points: new Map(), problem: "", waits: "" });
    if (change) this._curvesChanged();
  }

  _remove(curve) {
    this.curves = this.curves.filter((each) => each !== curve);
    this.pairs.list = this.pairs.list.filter(({ x, y }) => x !== curve.text && y !== curve.text);
    this._curvesChanged();
  }

  _curvesChanged() {
    this.stream.change(this._streamArgs());
    this._save();
    this._layOut();
  }

  async _suggest(list) {
    const { robot } = this.place;
    const typed = this.input.value;
    try {
      const fields = await robot.call("topics.fields", { begin: typed.split(",").at(-1).trim() });
      fill(list, fields.map((value) => h("option", { value })));
    } catch {
      // the master is unreachable; what was typed can still be added
    }
  }

  _receive(data, blob) {
    this.now = data.now;
    this.nowAt = performance.now();
    if (this.startPaused) {
      this.startPaused = false;
      this._pause();
    }
    const numbers = new Float64Array(blob.buffer, blob.offset);
    let at = 0;
    let changed = false;
    for (const { id, part, count } of data.curves) {
      const curve = this.curves.find((each) => each.id === id);
      const [times, values] = [numbers.subarray(at, at + count), numbers.subarray(at + count, at + 2 * count)];
      at += 2 * count;
      if (!curve) continue;
      if (!curve.points.has(part)) {
        curve.points.set(part, new Points());
        changed = true;
      }
      curve.points.get(part).add(times, values);
    }
    for (const curve of this.curves) Object.assign(curve, { problem: data.problems[curve.id] || "", waits: data.waiting[curve.id] || "" });
    if (changed) this._layOut();
    this.hasNewPoints = true;
  }

  // Each curve, or each element of an array, is a line.
  _lines() {
    const lines = [];
    for (const curve of this.curves) {
      for (const [part, points] of [...curve.points].sort((one, other) => one[0] - other[0])) {
        lines.push({ curve, points, label: part < 0 ? curve.text : `${curve.text}[${part}]`, ...styleOf(lines.length), at: undefined });
      }
    }
    return lines;
  }

  _layOut() {
    for (const chart of this.charts) chart.destroy();
    this.charts = [];
    this.axis = 0;
    this.lines = this._lines();
    this._drawLegend();
    if (this.xy && !this.pairs.list.some(({ y }) => y)) {
      fill(this.area, empty("No curves yet", "Type two fields above, to plot the second against the first, for example:",
        command("/odom/pose/pose/position/x:y")));
      return;
    }
    if (!this.curves.length) {
      fill(this.area, empty("No curves yet", "Type a topic and a field above, for example:",
        command("/velocity/data"), "or click a number in the Topics tab."));
      return;
    }
    fill(this.area);
    const shown = this.lines.filter((line) => !line.curve.hidden);
    const groups = this.stacked && shown.length ? shown.map((line) => [line]) : [shown];
    this._drawValues(); // the legend must have its height before the charts are measured
    if (this.xy) {
      const pairs = this.pairs.trails().filter(({ pair }) => !pair.hidden);
      this.charts.push(new XYChart(this.area, this._size(1), pairs, this.equal, {
        cursor: (found) => {
          this.pairs.pointAt(pairs, found);
          this._drawValues();
          this._showTime(found?.time);
        },
      }));
      this.hasNewPoints = true;
      return;
    }
    const on = {
      origin: () => this.origin, shown: () => this._shown(),
      show: (range) => this._showRange(range),
      all: () => this._followNewest(), cursor: (chart) => this._cursor(chart),
      room: (width) => { this.axis = Math.max(this.axis, width); return this.axis; }, // the same for all charts, so that their time axes are aligned
    };
    for (const lines of groups) this.charts.push(timeChart(this.area, lines, this._size(groups.length), on));
    this.hasNewPoints = true;
  }

  _size(count) {
    const { width, height } = this.area.getBoundingClientRect();
    return { width: Math.max(120, Math.floor(width) - 8), height: Math.max(MIN_HEIGHT, Math.floor((height - 10) / count)) };
  }

  _resize() {
    for (const chart of this.charts) chart.setSize(this._size(this.charts.length));
    this.hasNewPoints = true;
  }

  _pause() {
    this.range = this.range ? null : this._shown();
    this._showPause();
  }

  _showRange(range) {
    this.range = range;
    this._showPause();
  }

  _followNewest() {
    this.range = null;
    for (const chart of this.charts) chart.high = null;
    this._showPause();
  }

  _showPause() {
    this.pause.setAttribute("aria-pressed", String(Boolean(this.range)));
    fill(this.pause, this.range ? "Resume" : "Pause");
    this.hasNewPoints = true;
  }

  _shown() {
    if (this.range) return this.range;
    const end = this._time();
    return [end - this.period, end];
  }

  // The robot's current time: between two updates it continues, so that curves move smoothly.
  _time() {
    if (this.now === null) return 0;
    return this.now + Math.min(0.25, (performance.now() - this.nowAt) / 1000);
  }

  _frame() {
    this.timer = requestAnimationFrame(() => this._frame());
    if (this.now === null || (!this.hasNewPoints && this.range)) return;
    const changed = this.hasNewPoints; // otherwise only time has passed
    this.hasNewPoints = false;
    const [begin, end] = this._shown();
    if (!this.range) this.origin = end; // zero of the time axis; it is kept while the user looks at the past
    for (const chart of this.charts) {
      if (this.xy) {
        if (changed || performance.now() - this.drawnAt > REDRAW_DELAY) {
          chart.draw(begin, end);
          this.drawnAt = performance.now();
        }
        continue;
      }
      const columns = Math.max(50, Math.floor(chart.over.clientWidth));
      const places = grid(begin, end, columns);
      chart.batch(() => {
        chart.setData([places.times, ...chart.lines.map((line) => sample(line.points, places))], false);
        chart.setScale("x", { min: begin, max: end });
      });
    }
    for (const line of this.lines) line.points.trim(Math.min(begin, this.now) - MAX_AGE, MAX_POINTS);
    this._drawValues();
  }

  _drawLegend() {
    if (this.xy) {
      this.pairs.drawLegend(this.legend);
      return;
    }
    fill(this.legend, this.curves.map((curve) => {
      const lines = this.lines.filter((line) => line.curve === curve);
      curve.mark = h("span.value.mono");
      return h("span.chip", { title: curve.problem || "click to hide or show" },
        h("button.name.mono", { "aria-pressed": null, className: `name mono${curve.hidden ? " hidden-curve" : ""}`, onclick: () => {
          curve.hidden = !curve.hidden;
          this._layOut();
        } }, (lines.length ? lines : [{}]).map((line) => h("i.swatch", { style: { background: swatch(line) } })), curve.text),
        curve.mark,
        h("button.quiet", { title: "remove", "aria-label": `remove ${curve.text}`, onclick: () => this._remove(curve) }, "✕"));
    }));
  }

  _drawValues() {
    if (this.xy) {
      this.pairs.drawValues(this.now);
      return;
    }
    for (const curve of this.curves) {
      if (!curve.mark) continue;
      const texts = this.lines.filter((line) => line.curve === curve).map((line) => {
        const { min, max } = this.charts.find((chart) => chart.lines.includes(line))?.scales.y || {};
        return reading(line.at ?? line.points.lastValue(), max - min);
      });
      showLegendText(curve.mark, [curve], texts.join("  "));
    }
  }

  // Show the values under the cursor in the legend.
  _cursor(chart) {
    const inside = chart.cursor.left >= 0;
    const time = inside ? chart.posToVal(chart.cursor.left, "x") : null;
    for (const line of this.lines) line.at = time === null ? undefined : line.points.valueNear(time);
    this._drawValues(); // also while paused
    this._showTime(time);
  }

  // Show the time under the cursor: relative to the axis's zero, and by the robot's clock.
  _showTime(time) {
    this.timeText.hidden = time === null || time === undefined || this.now === null;
    if (!this.timeText.hidden) fill(this.timeText, `${(time - (this.origin ?? this.now)).toFixed(3)} s · ${clock(time)}`);
  }

  _csv() {
    const rows = ["curve,time,value"];
    for (const { label, points } of this.lines) {
      const name = /[",\n]/.test(label) ? `"${label.replaceAll('"', '""')}"` : label;
      for (let index = points.start; index < points.end; index += 1) rows.push(`${name},${points.times[index]},${points.values[index]}`);
    }
    save("plot.csv", rows.join("\n"), "text/csv");
  }

  _png() {
    const canvases = this.charts.map((chart) => chart.ctx.canvas);
    if (!canvases.length) return;
    const entries = this.xy ? this.pairs.entries() : this.lines.filter(({ curve }) => !curve.hidden);
    exportImage(canvases, entries).toBlob((blob) => save("plot.png", blob, "image/png"));
  }
}
