// The rows of a bag: messages over time, with zoom, pan and a cursor.

import { fill, h } from "../../lib/dom.js";
import { plural, rate } from "../../lib/format.js";
import { Thumbnails } from "./thumbnails.js";
import { formatElapsed, ticks } from "./times.js";

const ROW_HEIGHT = 30; // pixels
const IMAGE_ROW_HEIGHT = 74;
const EXTRA_ROWS = 4; // rows above and below the visible ones
const MAX_IMAGE_ROWS = 6; // maximum number of rows with thumbnails
const MIN_SPAN = 1e-4; // seconds; minimum width of the view
export const RIGHT_MARGIN = 12; // pixels to the right of the lanes

// on: {seek(time), view(begin, end), room(): the lanes have moved, select(topic, several)}
export class Timeline {
  constructor(robot, on) {
    this.robot = robot;
    this.on = on;
    this.facts = null;
    this.time = 0;
    this.view = [0, 1];
    this.fullView = [0, 1]; // the time range of the whole bag
    this.selected = new Set();
    this.rows = [];
    this.thumbnails = new Map(); // topic -> Thumbnails
    this.rowTops = [];
    this.gutter = 0; // pixels beside the lanes; 0 until it is measured
    this.width = 0; // pixels of the lanes
    this._build();
    this.observer = new ResizeObserver(() => { this._measure(); this.draw(); });
    this.observer.observe(this.element);
  }

  _build() {
    this.axis = h("canvas");
    this.window = h("i.window");
    this.ruler = h("div.ruler", { title: "drag to pan, wheel to zoom" }, h("div.lane", {}, this.axis, this.window));
    this.content = h("div.tall");
    this.line = h("i.cursor", { hidden: true });
    this.scroller = h("div.scroller", { onscroll: () => this.draw() }, this.content);
    this.element = h("div.timeline", {
      tabIndex: 0, role: "slider", "aria-label": "time in the bag", "aria-orientation": "horizontal",
    }, this.ruler, this.scroller, this.line);
    this.ruler.querySelector(".lane").addEventListener("pointerdown", (event) => this._pan(event));
    this.content.addEventListener("pointerdown", (event) => this._scrub(event));
    this.element.addEventListener("wheel", (event) => this._wheel(event), { passive: false });
  }

  close() {
    this.observer.disconnect();
    this.closeStream();
  }

  closeStream() {
    this.stream?.close();
    this.stream = null;
    for (const pictures of this.thumbnails.values()) pictures.close();
    this.thumbnails.clear();
  }

  show(path, facts, view) {
    this.closeStream();
    this.path = path;
    this.facts = facts;
    this.fullView = fullViewOf(facts);
    this.view = view || this.fullView;
    this.data = null;
    this.problem = "";
    this._layOut();
    this.stream = this.robot.stream("bag_timeline", this._args([]), {
      opened: () => { this.lastRequest = ""; this.draw(); },
      data: (data, blob) => this._receive(data, blob),
      problem: (text) => this.on.problem(text),
    });
  }

  _layOut() {
    let top = 0;
    this.rows = this.facts.topics;
    this.rowTops = this.rows.map((topic) => {
      const at = top;
      top += this._height(topic);
      return at;
    });
    this.content.style.height = `${top}px`;
    this.shown = "";
    this._measure();
  }

  _height(topic) {
    return (topic.image ? IMAGE_ROW_HEIGHT : ROW_HEIGHT) + (this.narrow ? 16 : 0);
  }

  _measure() {
    const style = getComputedStyle(this.element);
    const gutter = parseFloat(style.getPropertyValue("--gutter")) || 240;
    const narrow = style.getPropertyValue("--narrow").trim() === "1";
    const moved = this.gutter > 0 && this.gutter !== gutter;
    this.gutter = gutter;
    this.width = Math.max(50, this.element.clientWidth - gutter - RIGHT_MARGIN);
    if (narrow !== this.narrow) {
      this.narrow = narrow;
      if (this.facts) this._layOut();
    }
    if (moved) this.on.room();
  }

  // Return the position of a time, in pixels from the left of the lanes.
  x(time) {
    return ((time - this.view[0]) / (this.view[1] - this.view[0])) * this.width;
  }

  _timeAt(event) {
    const left = this.element.getBoundingClientRect().left + this.gutter;
    return this.view[0] + ((event.clientX - left) / this.width) * (this.view[1] - this.view[0]);
  }

  setTime(time) {
    this.time = time;
    this.element.setAttribute("aria-valuenow", time.toFixed(3));
    this.element.setAttribute("aria-valuemax", this.facts.length.toFixed(3));
    this._drawCursor();
  }

  // Show another time range; it is never wider than the bag, nor outside it.
  setView(begin, end) {
    const [least, most] = this.fullView;
    const size = Math.min(most - least, Math.max(MIN_SPAN, end - begin));
    const middle = (begin + end) / 2;
    begin = Math.min(Math.max(least, middle - size / 2), most - size);
    this.view = [begin, begin + size];
    this.on.view(...this.view);
    this.draw();
  }

  zoom(factor, at = (this.view[0] + this.view[1]) / 2) {
    const [begin, end] = this.view;
    this.setView(at - (at - begin) * factor, at + (end - at) * factor);
  }

  all() {
    this.setView(...this.fullView);
  }

  // Keep the cursor visible while it moves by itself.
  follow() {
    const [begin, end] = this.view;
    if (this.time >= begin && this.time <= end) return;
    this.setView(this.time - (end - begin) * 0.1, this.time + (end - begin) * 0.9);
  }

  _wheel(event) {
    if (!this.facts) return;
    const inLane = event.clientX > this.element.getBoundingClientRect().left + this.gutter;
    const sideways = Math.abs(event.deltaX) > Math.abs(event.deltaY) || event.shiftKey;
    if (!inLane || (event.altKey && !sideways)) return; // over the names, the wheel scrolls
    event.preventDefault();
    const [begin, end] = this.view;
    if (sideways) {
      const by = ((event.deltaX || event.deltaY) / this.width) * (end - begin);
      this.setView(begin + by, end + by);
    } else this.zoom(Math.exp(Math.max(-100, Math.min(100, event.deltaY)) * 0.002), this._timeAt(event));
  }

  _pan(event) {
    if (!this.facts) return;
    event.preventDefault();
    const [begin, end] = this.view;
    const from = event.clientX;
    const place = event.currentTarget;
    let moved = false;
    trackPointer(place, event, (move) => {
      moved = moved || Math.abs(move.clientX - from) > 3;
      const by = ((from - move.clientX) / this.width) * (end - begin);
      if (moved) this.setView(begin + by, end + by);
    }, (up) => { if (!moved) this._seek(up); });
  }

  _scrub(event) {
    if (!this.facts || event.button) return;
    const lane = event.target.closest(".lane");
    if (!lane) return;
    event.preventDefault();
    this.element.focus({ preventScroll: true });
    if (event.shiftKey) {
      this._pan(event);
      return;
    }
    const topic = lane.parentElement.topic;
    if (topic && !this.selected.size) this.on.select(topic, false);
    this._seek(event);
    trackPointer(this.content, event, (move) => this._seek(move), () => {});
  }

  _seek(event) {
    this.on.seek(Math.max(0, Math.min(this.facts.length, this._timeAt(event))));
  }

  _args(topics) {
    return { path: this.path, begin: this.view[0], end: this.view[1], columns: Math.max(1, Math.min(4000, Math.round(this.width / 2))), topics };
  }

  _receive(data, blob) {
    const counts = new Float32Array(blob.buffer, blob.offset, data.columns * data.topics.length);
    const rows = new Map(data.topics.map((topic, index) => [topic, counts.subarray(index * data.columns, (index + 1) * data.columns)]));
    this.data = { ...data, rows };
    this.element.dataset.exact = String(data.exact);
    this.draw();
  }

  draw() {
    if (this.drawing || !this.facts) return;
    this.drawing = requestAnimationFrame(() => {
      this.drawing = 0;
      if (this.facts) this._drawNow();
    });
  }

  _drawNow() {
    const { scrollTop, clientHeight } = this.scroller;
    const visibleRows = this.rows.map((_, index) => index).filter((index) => this.rowTops[index] + IMAGE_ROW_HEIGHT + 16 > scrollTop - EXTRA_ROWS * ROW_HEIGHT && this.rowTops[index] < scrollTop + clientHeight + EXTRA_ROWS * ROW_HEIGHT);
    const topics = visibleRows.map((index) => this.rows[index].name).slice(0, 200);
    const args = this._args(topics);
    const request = JSON.stringify(args);
    if (request !== this.lastRequest && this.stream) {
      this.lastRequest = request;
      this.stream.change(args);
    }
    const shown = `${visibleRows[0]} ${visibleRows.length} ${this.narrow}`;
    if (shown !== this.shown) {
      this.shown = shown;
      fill(this.content, visibleRows.map((index) => this._row(index)));
    }
    for (const row of this.content.children) this._drawRow(row);
    this._drawRuler();
    this._drawCursor();
    this._requestThumbnails(visibleRows);
  }

  _row(index) {
    const topic = this.rows[index];
    const hz = this.facts.length > 0 && topic.count > 1 ? rate((topic.count - 1) / this.facts.length) : "";
    const row = h("div.row", { style: { top: `${this.rowTops[index]}px`, height: `${this._height(topic)}px` } },
      h("button.name", {
        title: `${topic.name}\n${topic.type}\n${plural(topic.count, "message")} ${hz}${topic.publishers > 1 ? `\n${topic.publishers} publishers` : ""}\nclick to see its messages; with Shift or Ctrl, several topics`,
        "aria-pressed": String(this.selected.has(topic.name)),
        onclick: (event) => this.on.select(topic.name, event.shiftKey || event.ctrlKey || event.metaKey),
      }, h("span.topic.mono", {}, h("bdi", {}, topic.name)), h("span.count", {}, `${topic.count}`), h("span.kind", {}, topic.type), h("span.count", {}, hz)),
      h("div.lane", {}, h("canvas"), topic.image && h("div.pictures")));
    row.topic = topic.name;
    row.image = topic.image;
    return row;
  }

  select(selected) {
    this.selected = selected;
    for (const row of this.content.children) row.firstChild.setAttribute("aria-pressed", String(selected.has(row.topic)));
    this.draw();
  }

  _drawRow(row) {
    const counts = this.data?.rows.get(row.topic);
    const canvas = row.querySelector("canvas");
    const height = 18;
    const context = prepareCanvas(canvas, this.width, height);
    if (counts) {
      const style = getComputedStyle(this.element);
      context.fillStyle = style.getPropertyValue(this.selected.has(row.topic) ? "--accent" : "--info");
      const { begin, end, columns } = this.data;
      const step = (end - begin) / columns;
      const size = Math.max(1.5, (step / (this.view[1] - this.view[0])) * this.width);
      let most = 0;
      for (const count of counts) if (count > most) most = count;
      for (let index = 0; index < columns; index += 1) {
        if (counts[index] <= 0.001) continue;
        const tall = Math.max(4, Math.sqrt(counts[index] / most) * height);
        context.globalAlpha = 0.35 + 0.65 * (counts[index] / most);
        context.fillRect(this.x(begin + index * step), (height - tall) / 2, size, tall);
      }
    }
    const holder = row.querySelector(".pictures");
    if (holder) this.thumbnails.get(row.topic)?.draw(holder, this);
  }

  _drawRuler() {
    const context = prepareCanvas(this.axis, this.width, 24);
    const style = getComputedStyle(this.element);
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = style.getPropertyValue("--muted");
    context.strokeStyle = style.getPropertyValue("--border");
    const { step, times } = ticks(...this.view, Math.max(2, this.width / 90));
    for (const time of times.filter((each) => each > -step / 2)) { // the bag begins at 0
      const x = Math.round(this.x(time)) + 0.5;
      context.beginPath();
      context.moveTo(x, 17);
      context.lineTo(x, 24);
      context.stroke();
      const text = formatElapsed(time, step);
      const half = context.measureText(text).width / 2;
      context.fillText(text, Math.min(Math.max(x, half), this.width - half) - half, 12);
    }
    const [least, most] = this.fullView;
    const [begin, end] = this.view;
    const part = (end - begin) / (most - least);
    this.window.hidden = part > 0.999;
    this.window.style.left = `${((begin - least) / (most - least)) * 100}%`;
    this.window.style.width = `${Math.max(1, part * 100)}%`;
  }

  _drawCursor() {
    const x = this.x(this.time);
    this.line.hidden = !this.facts || x < -1 || x > this.width + 1;
    this.line.style.transform = `translateX(${this.gutter + x}px)`;
  }

  _requestThumbnails(visibleRows) {
    const imageTopics = visibleRows.map((index) => this.rows[index]).filter((topic) => topic.image).slice(0, MAX_IMAGE_ROWS);
    for (const { name } of imageTopics) {
      if (!this.thumbnails.has(name)) this.thumbnails.set(name, new Thumbnails(this.robot, this.path, name, () => this.draw(), this.on.problem));
      this.thumbnails.get(name).ask(this);
    }
    for (const [name, pictures] of this.thumbnails) {
      if (imageTopics.some((topic) => topic.name === name)) continue;
      pictures.close();
      this.thumbnails.delete(name);
    }
  }
}

// Return a bag's time range with a margin, so that the first and last messages are visible.
function fullViewOf(facts) {
  const room = facts.length * 0.01 || 0.5;
  return [-room, facts.length + room];
}

function prepareCanvas(canvas, width, height) {
  const density = devicePixelRatio || 1;
  const [w, t] = [Math.round(width * density), Math.round(height * density)];
  if (canvas.width !== w || canvas.height !== t) {
    canvas.width = w;
    canvas.height = t;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
  }
  const context = canvas.getContext("2d");
  context.setTransform(density, 0, 0, density, 0, 0);
  context.globalAlpha = 1;
  context.clearRect(0, 0, width, height);
  return context;
}

function trackPointer(place, event, move, end) {
  place.setPointerCapture(event.pointerId);
  place.onpointermove = move;
  place.onpointerup = place.onpointercancel = (up) => {
    place.onpointermove = place.onpointerup = place.onpointercancel = null;
    end(up);
  };
}
