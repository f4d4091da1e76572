// A graph on a canvas: laid out by a worker, drawn when something has changed, moved with pointer and keys.

import { Camera } from "./camera.js";
import { CanvasPen, SvgPen } from "./pens.js";
import { Scene, plan } from "./scene.js";
import { s } from "../dom.js";

const MAX_FIT_SCALE = 1.25; // pixels per unit when everything is shown
const KEY_STEP = 60; // pixels per press of an arrow key
const HIT_DISTANCE = 7; // pixels from an edge that still count as a hit
const ARROW_KEYS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] };

export class GraphView {
  // room: the element whose shape the layout should have; the canvas may show only a part of it.
  // on: {choose(found), fold(group), arranged(), moved(), coveredHeight()}; coveredHeight: pixels covered at the bottom; found is {box}, {edge} or null; moved: the user has moved boxes, or moved them back
  constructor(canvas, room, on) {
    this.canvas = canvas;
    this.room = room;
    this.on = on;
    this.scene = new Scene();
    this.fitted = true; // fit everything until the user moves the view
    this.hovered = null;
    this.chosen = null;
    this.highlighted = null;
    this.number = 0;
    this.frame = 0; // id from requestAnimationFrame; 0 for none
    this.widths = new Map(); // text widths in pixels
    /** @type {{layout: number, shown?: number, frames: number[][]}} */
    this.times = { layout: 0, frames: [] };
    this.context = canvas.getContext("2d");
    this.family = getComputedStyle(document.body).fontFamily;
    this.pen = new CanvasPen(this.context, this.family);
    this.camera = new Camera(canvas, {
      changed: () => this.draw(),
      userMoved: () => { this.fitted = false; },
      hover: (x, y) => this._hover(x, y),
      click: (x, y) => this._click(x, y),
      double: (x, y) => this._double(x, y),
      grab: (x, y, touch) => this._grab(x, y, touch),
      drag: (right, down) => this._drag(right, down),
      drop: () => this._drop(),
      coveredHeight: on.coveredHeight,
    });
    canvas.addEventListener("keydown", (event) => this._key(event));
    this.worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    this.worker.onmessage = ({ data }) => this._applyLayout(data);
    this.observer = new ResizeObserver(() => this._resized());
    this.observer.observe(canvas);
    this.onTheme = () => {
      this.colours = null;
      this.draw();
    };
    addEventListener("themechange", this.onTheme);
    this.dark = matchMedia("(prefers-color-scheme: dark)");
    this.dark.addEventListener("change", this.onTheme);
  }

  close() {
    this.worker.terminate();
    this.observer.disconnect();
    removeEventListener("themechange", this.onTheme);
    this.dark.removeEventListener("change", this.onTheme);
    cancelAnimationFrame(this.frame);
  }

  // Show a model. A layout is computed only if its structure has changed.
  show(model, rates) {
    this.rates = rates;
    const [width, height] = [this.room.clientWidth || 1, this.room.clientHeight || 1];
    const isTall = height > width * 1.15;
    if (isTall !== this.isTall) this.isTall = this.down = isTall;
    const what = plan(model, { rates, down: this.down, room: [width, height], measure: (...args) => this._measure(...args) });
    const shape = JSON.stringify([what.boxes, what.edges, what.groups, isTall]);
    this.model = model;
    if (shape !== this.shape) {
      this.shape = shape;
      this.number += 1;
      this.nextRequest = { number: this.number, what };
      this._requestLayout();
    } else if (!this.request) {
      this.scene.refresh(model);
      this.draw();
    }
  }

  // Compute one layout at a time; of the pending ones, only the latest counts.
  _requestLayout() {
    if (this.request || !this.nextRequest) return;
    this.request = { ...this.nextRequest, model: this.model, at: performance.now() };
    this.nextRequest = null;
    this.worker.postMessage({ number: this.request.number, what: this.request.what });
    clearTimeout(this.busyTimer);
    this.busyTimer = setTimeout(() => this.request && this.canvas.parentElement?.classList.add("busy"), 300);
  }

  _applyLayout({ found, problem, seconds }) {
    if (!this.request) return;
    const { what, model, at } = this.request;
    this.request = null;
    this.canvas.parentElement?.classList.remove("busy");
    if (problem) console.error(`layout: ${problem}`);
    else {
      this.down = found.down; // keep the direction as long as it fits
      this.times.layout = seconds;
      this.times.shown = (performance.now() - at) / 1000;
      const first = !this.scene.items.size;
      this.scene.arrange(model, what, found, this.chosen, first ? -Infinity : performance.now());
      if (!this.nextRequest) this.scene.refresh(this.model);
      if (this.fitted) this.fit(!first);
      this.on.arranged?.();
      this.draw();
    }
    this._requestLayout();
  }

  highlight(chosen, highlighted) {
    this.chosen = chosen;
    this.highlighted = highlighted;
    this.draw();
  }

  fit(glide = true) {
    this.fitted = true;
    this.camera.show(this.scene.bounds, MAX_FIT_SCALE, glide);
  }

  // Centre the view on boxes.
  centre(ids) {
    const bounds = this.scene.boundsOf(ids);
    if (!Number.isFinite(bounds[0])) return;
    this.fitted = false;
    this.camera.show(bounds, Math.max(this.camera.scale, 1));
  }

  // Pan just enough to make a box visible.
  reveal(id) {
    const item = this.scene.items.get(id);
    if (!item || this.fitted) return;
    const [left, top] = this.camera.toScreen(...item.to);
    const [width, height] = this.camera.size;
    if (left > 60 && left < width - 60 && top > 30 && top < height - 30) return;
    this.fitted = false;
    this.camera.go(item.to[0], item.to[1], Math.max(this.camera.scale, 0.6));
  }

  draw() {
    this.frame ||= requestAnimationFrame((now) => this._draw(now));
  }

  _draw(now) {
    const begin = performance.now();
    this.frame = 0;
    const gliding = this.camera.step(performance.now());
    const moving = this.scene.step(performance.now()) || gliding;
    const { context, camera } = this;
    const ratio = devicePixelRatio || 1;
    const [width, height] = camera.size;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    context.setTransform(camera.scale * ratio, 0, 0, camera.scale * ratio, (width / 2 - camera.x * camera.scale) * ratio, (height / 2 - camera.y * camera.scale) * ratio);
    this.scene.draw(this.pen, this._drawOptions(camera.scale, camera.visibleArea()));
    context.globalAlpha = 1;
    this.times.frames.push([now, performance.now() - begin]);
    if (this.times.frames.length > 240) this.times.frames.shift();
    if (moving) this.draw();
  }

  _drawOptions(scale, visibleArea) {
    this.colours ||= palette();
    return { colours: this.colours, scale, visibleArea, highlighted: this.highlighted, chosen: this.chosen, hovered: this.hovered };
  }

  // Return the whole graph as an SVG file.
  svg() {
    const [left, top, right, bottom] = this.scene.bounds;
    const [x, y, width, height] = [left - 20, top - 20, right - left + 40, bottom - top + 40].map(Math.round);
    const root = s("svg", { xmlns: "http://www.w3.org/2000/svg", viewBox: `${x} ${y} ${width} ${height}`, width, height });
    const pen = new SvgPen(root, this.family.replaceAll('"', "'"));
    this.scene.step(Infinity);
    pen.box(x + width / 2, y + height / 2, width, height, { fill: palette().surface });
    this.scene.draw(pen, { ...this._drawOptions(1, [-Infinity, -Infinity, Infinity, Infinity]), highlighted: null, chosen: null, hovered: null });
    return new XMLSerializer().serializeToString(root);
  }

  _resized() {
    const ratio = devicePixelRatio || 1;
    const [width, height] = this.camera.size;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    if (this.model) this.show(this.model, this.rates);
    if (this.fitted && this.scene.items.size) this.fit(false);
    this._draw(performance.now()); // at once: resizing clears a canvas
  }

  _measure(text, size, weight) {
    const key = `${weight} ${size} ${text}`;
    if (!this.widths.has(key)) {
      if (this.widths.size > 50000) this.widths.clear();
      this.context.font = `${weight} ${size}px ${this.family}`;
      this.widths.set(key, this.context.measureText(text).width);
    }
    return this.widths.get(key);
  }

  _find(x, y) {
    return this.scene.find(x, y, HIT_DISTANCE / this.camera.scale);
  }

  _hover(x, y) {
    const found = Number.isNaN(x) ? null : this._find(x, y);
    const of = found?.box || found?.group || found?.edge;
    if ((of?.id || null) === this.hovered) return;
    this.hovered = of?.id || null;
    this.canvas.style.cursor = of ? "pointer" : "";
    this.canvas.title = found?.box ? `${of.name}${of.type ? `\n${of.type}` : ""}${of.silent ? "\ndoes not answer" : ""}` : found?.group ? `fold ${of.name}` : "";
    this.draw();
  }

  // A finger pans the plane, unless it touches the chosen box: there may be little free space between boxes.
  _grab(x, y, touch) {
    const { box } = this._find(x, y) || {};
    this.draggedBox = box && (!touch || box.id === this.chosen) ? box.id : null;
    return Boolean(this.draggedBox);
  }

  _drag(right, down) {
    this.fitted = false;
    this.canvas.style.cursor = "grabbing";
    this.scene.move(this.draggedBox, right, down);
    this.draw();
  }

  _drop() {
    this.canvas.style.cursor = "pointer";
    this.draggedBox = null;
    this.on.moved?.();
  }

  // Move all boxes back to the positions of the layout.
  release() {
    this.scene.release(performance.now());
    this.fit();
    this.on.moved?.();
    this.draw();
  }

  _click(x, y) {
    const found = this._find(x, y);
    if (found?.group) this.on.fold(found.group.name);
    else this.on.choose(found);
  }

  _double(x, y) {
    const found = this._find(x, y);
    if (found?.box?.kind === "group") this.on.fold(found.box.name);
    else if (!found) this.fit();
  }

  _key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const way = ARROW_KEYS[event.key];
    if (way) {
      const next = this.chosen && !event.shiftKey && this.scene.items.has(this.chosen) ? this.scene.neighbour(this.chosen, way) : null;
      if (next) this.on.choose({ box: this.scene.items.get(next).box });
      else this.camera.move(way[0] * KEY_STEP, way[1] * KEY_STEP);
    } else if (event.key === "r") this.release();
    else if (event.key === "+" || event.key === "=") this.camera.zoom(1.25);
    else if (event.key === "-") this.camera.zoom(0.8);
    else if (event.key === "f" || event.key === "0") this.fit();
    else if (event.key === "Enter") this._enter();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // If nothing is chosen, start with the box nearest to the middle.
  _enter() {
    const { camera, scene } = this;
    const chosen = scene.items.get(this.chosen);
    if (chosen?.box.kind === "group") {
      this.on.fold(chosen.box.name);
      return;
    }
    const away = ({ at }) => Math.hypot(at[0] - camera.x, at[1] - camera.y);
    const [first] = [...scene.items.values()].sort((one, other) => away(one) - away(other));
    if (first) this.on.choose({ box: first.box });
  }
}

function palette() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => style.getPropertyValue(name).trim();
  const dark = style.colorScheme === "dark";
  return {
    dark, surface: of("--surface"), raised: of("--raised"), border: of("--border"), text: of("--text"), muted: of("--muted"), accent: of("--accent"),
    error: of("--error"), node: of("--node"), nodeSoft: of("--node-soft"), topic: of("--topic"), topicSoft: of("--topic-soft"),
    edge: dark ? "#8593a3" : "#7c8896", border2: dark ? "#566270" : "#b3bcc7", group: dark ? "#20252c" : "#f8f9fb",
  };
}
