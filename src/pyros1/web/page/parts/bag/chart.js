// Recorded numeric fields below the timeline, on the same time axis.

import uPlot from "../../vendor/uplot.js";
import { Points, grid, sample } from "../../lib/curves.js";
import { fill, h } from "../../lib/dom.js";
import { reading } from "../../lib/format.js";
import { dots, styleOf, showLegendText, swatch } from "../plot/curve_styles.js";
import { tickLabels, paddedRange } from "../plot/plot_text.js";
import { RIGHT_MARGIN } from "./timeline.js";

const MAX_CURVES = 16;
const ZOOM_DELAY = 250; // ms after the last zoom

// on: {gutter() -> the pixels beside the lanes, seek(time), changed(curves), problem(text)}
export class Chart {
  constructor(robot, on) {
    this.robot = robot;
    this.on = on;
    this.curves = []; // {id, text, lines: Map(part -> Points), problem, done}
    this.lines = []; // {curve, points, label, and how it looks}
    this.ids = 0;
    this.legend = h("div.legend");
    this.bar = h("progress", { max: 1, value: 0, "aria-label": "reading" });
    this.reading = h("div.reading", { hidden: true }, this.bar, h("button.quiet", { onclick: () => this._cancel() }, "Cancel"));
    this.area = h("div.area");
    this.element = h("div.chart", { hidden: true }, this.legend, this.reading, this.area);
    this.observer = new ResizeObserver(() => this._layOut());
    this.observer.observe(this.area);
  }

  close() {
    this.closeStream();
    this.observer.disconnect();
    this.plot?.destroy();
    clearTimeout(this.timer);
  }

  closeStream() {
    this.stream?.close();
    this.stream = null;
  }

  show(path, view) {
    this.closeStream();
    this.path = path;
    this.view = view;
    for (const curve of this.curves) Object.assign(curve, { lines: new Map(), problem: "", done: false });
    this._requestPoints();
  }

  add(text) {
    if (!text || this.curves.some((curve) => curve.text === text)) return;
    if (this.curves.length >= MAX_CURVES) {
      this.on.problem(`a plot has at most ${MAX_CURVES} curves: remove one first`);
      return;
    }
    this.curves.push({ id: ++this.ids, text, lines: new Map(), problem: "", done: false });
    this._changed();
  }

  _remove(curve) {
    this.curves = this.curves.filter((each) => each !== curve);
    this._changed();
  }

  _changed() {
    this.on.problem("");
    this.on.changed(this.curves.map(({ text }) => text));
    this._requestPoints();
  }

  // After zooming, the visible range is read again at a higher resolution; meanwhile the known points are shown.
  setView(view) {
    this.view = view;
    this._draw();
    clearTimeout(this.timer);
    if (this.curves.length) this.timer = setTimeout(() => this._requestPoints(), ZOOM_DELAY);
  }

  setTime(time) {
    this.time = time;
    this._mark();
  }

  // Called when the lanes have moved.
  resize() {
    this._layOut();
  }

  _requestPoints() {
    this.element.hidden = !this.curves.length;
    this._layOut();
    if (!this.path) return;
    if (!this.curves.length) {
      this.closeStream();
      return;
    }
    const args = { path: this.path, begin: this.view[0], end: this.view[1], curves: this.curves.map(({ id, text }) => ({ id, text })) };
    for (const curve of this.curves) curve.done = false;
    if (this.stream) this.stream.change(args);
    else {
      this.stream = this.robot.stream("bag_plot", args, {
        data: (data, blob) => this._receive(data, blob),
        problem: (text) => this.on.problem(text),
      });
    }
  }

  _cancel() {
    this.closeStream();
    this.reading.hidden = true;
  }

  _receive(data, blob) {
    const whole = data.progress >= 1;
    this.reading.hidden = whole;
    this.bar.value = data.progress;
    const numbers = new Float64Array(blob.buffer, blob.offset);
    const found = new Map();
    let at = 0;
    for (const { id, part, count } of data.curves) {
      const points = new Points();
      points.add(numbers.subarray(at, at + count), numbers.subarray(at + count, at + 2 * count));
      at += 2 * count;
      if (!found.has(id)) found.set(id, new Map());
      found.get(id).set(part, points);
    }
    let changed = false;
    for (const curve of this.curves) {
      curve.problem = data.problems[curve.id] || "";
      const lines = found.get(curve.id) || new Map();
      if (!whole && curve.whole) continue; // complete old data is better than incomplete new data
      changed = changed || [...lines.keys()].join() !== [...curve.lines.keys()].join();
      curve.lines = lines;
      curve.whole = whole;
    }
    if (changed || !this.plot) this._layOut();
    else {
      this.lines = this._lines();
      this._draw();
    }
    this._values();
  }

  _lines() {
    const lines = this.curves.flatMap((curve) => [...curve.lines].sort((one, other) => one[0] - other[0]).map(([part, points]) => ({ curve, points, label: part < 0 ? curve.text : `${curve.text}[${part}]` })));
    return lines.map((line, index) => ({ ...line, ...styleOf(index) }));
  }

  _layOut() {
    if (this.element.hidden) return;
    this.plot?.destroy();
    this.plot = null;
    this.lines = this._lines();
    this._drawLegend();
    const { width, height } = this.area.getBoundingClientRect();
    if (width < 80 || height < 60) return;
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const axis = { stroke: colour("--muted"), grid: { stroke: colour("--border"), width: 1 }, ticks: { show: false } };
    const plot = new uPlot({
      width: Math.floor(width), height: Math.floor(height),
      padding: [8, RIGHT_MARGIN, 4, 0],
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, y: false },
      scales: { x: { time: false, auto: false }, y: { range: (_, least, most) => paddedRange(least, most) } },
      axes: [{ ...axis, show: false }, { ...axis, size: this.on.gutter(), values: (_, ticks) => tickLabels(ticks) }],
      series: [{}, ...this.lines.map((line) => ({ label: line.label, stroke: line.colour, dash: line.dash, width: 1.5, points: dots(line.colour) }))],
    }, [new Float64Array(0), ...this.lines.map(() => [])], this.area);
    this.plot = plot;
    this.mark = h("i.cursor");
    const { over } = plot;
    over.append(this.mark);
    const seek = (event) => this.on.seek(plot.posToVal(event.clientX - over.getBoundingClientRect().left, "x"));
    over.addEventListener("pointerdown", (event) => {
      seek(event);
      over.setPointerCapture(event.pointerId);
      over.onpointermove = seek;
      over.onpointerup = () => { over.onpointermove = null; };
    });
    this._draw();
  }

  _draw() {
    const { plot, lines } = this;
    if (!plot) return;
    const [begin, end] = this.view;
    const places = grid(begin, end, Math.max(50, plot.width - this.on.gutter() - RIGHT_MARGIN)); // the plot is measured later
    plot.batch(() => {
      plot.setData([places.times, ...lines.map((line) => sample(line.points, places))], false);
      plot.setScale("x", { min: begin, max: end });
    });
    this._mark();
  }

  _mark() {
    if (this.plot && this.time !== undefined) {
      const x = this.plot.valToPos(this.time, "x");
      this.mark.hidden = !(x >= 0 && x <= this.plot.width - this.on.gutter() - RIGHT_MARGIN);
      this.mark.style.transform = `translateX(${x}px)`;
    }
    this._values();
  }

  _drawLegend() {
    fill(this.legend, this.curves.map((curve) => {
      const lines = this.lines.filter((line) => line.curve === curve);
      curve.mark = h("span.value.mono");
      return h("span.chip", {}, h("span.name.mono", {}, (lines.length ? lines : [{}]).map((line) => h("i.swatch", { style: { background: swatch(line) } })), curve.text), curve.mark,
        h("button.quiet", { title: "remove", "aria-label": `remove ${curve.text}`, onclick: () => this._remove(curve) }, "✕"));
    }));
    this._values();
  }

  // Show the curves' values at the cursor in the legend, from the last points at or before it.
  _values() {
    const { min = NaN, max = NaN } = this.plot?.scales.y || {};
    for (const curve of this.curves) {
      if (!curve.mark) continue;
      const values = [...curve.lines.values()].map((points) => points.values[points.indexOf((this.time ?? 0) + 1e-9) - 1]);
      showLegendText(curve.mark, [curve], values.slice(0, 6).map((value) => (value === undefined ? "–" : reading(value, max - min))).join("  "));
    }
  }
}
