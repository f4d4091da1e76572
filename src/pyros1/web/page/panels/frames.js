// The tree of coordinate frames, like rqt_tf_tree and tf_monitor.

import { command, empty, fill, h, save } from "../lib/dom.js";
import { number, plural, rate } from "../lib/format.js";

const MAX_AGE = 1; // seconds
const RECORDED_AGE = 86400; // seconds: transforms this old come from a bag, not from a running robot

export default {
  title: "Frames",
  description: "the tree of coordinate frames (tf)",
  order: 45,
  mount: (place) => new Frames(place),
};

class Frames {
  constructor(place) {
    this.place = place;
    this.closed = new Set(place.settings.closed || []);
    this.selected = place.settings.selected || "";
    this.search = "";
    this.drawn = null; // {shape, rows} of the current table
    this.drawnFrames = new Set(); // names of the frames in the table
    this.paused = false;
    place.tools.append(
      h("input", { placeholder: "find frames", "aria-label": "find frames", size: 14, oninput: (event) => { this.search = event.target.value.toLowerCase(); this._draw(); } }),
      this.pause = h("button", { "aria-pressed": "false", onclick: () => {
        this.paused = !this.paused;
        this.pause.setAttribute("aria-pressed", String(this.paused));
        fill(this.pause, this.paused ? "Resume" : "Pause");
      } }, "Pause"),
      h("button.quiet", { title: "save the tree for Graphviz", onclick: () => save("frames.dot", this._drawStatus(), "text/vnd.graphviz") }, "DOT"),
      this.count = h("span.muted"));
    this.table = h("div.frames");
    this.detail = h("div.detail", { hidden: true });
    place.body.classList.add("frames-panel");
    place.body.append(this.table, this.detail);
    this.stream = place.robot.stream("frames", {}, {
      data: (data) => { if (!this.paused) { this.data = data; this._draw(); } },
      problem: (text) => place.problem(text),
    });
  }

  unmount() {
    this.stream.close();
  }

  _draw() {
    const { data } = this;
    if (!data) return;
    const recorded = data.frames.some((frame) => !frame.static && frame.age > RECORDED_AGE);
    this.place.problem(data.problem || (data.ignored ? "there are too many frames to show them all" : "")
      || (recorded ? "these transforms are from a recording, but nodes use the current time: type `pyros1 param set /use_sim_time true`, and play the bag with `pyros1 bag play --clock`" : ""));
    fill(this.count, plural(data.frames.length + data.roots.length, "frame"));
    if (!data.frames.length) {
      this.drawn = null;
      fill(this.table, empty("No frames yet", "No node publishes /tf or /tf_static. Try, in a terminal:",
        command("pyros1 run tf2_ros static_transform_publisher 1 0 0 0 0 0 map base_link")));
      return;
    }
    const children = new Map();
    for (const frame of data.frames) {
      if (!children.has(frame.parent)) children.set(frame.parent, []);
      children.get(frame.parent).push(frame);
    }
    this.drawnFrames.clear();
    const rows = data.roots.flatMap((name) => this._rows({ name, root: true }, children, 0));
    const left = data.frames.filter((frame) => !this.drawnFrames.has(frame.name)); // frames in a loop, which no root contains
    this._drawRows([...rows, ...left.map((frame) => ({ frame, depth: 0, parent: false }))]);
    this._drawDetail();
  }

  // Rows are kept while their numbers change, so that a click always hits.
  _drawRows(items) {
    const shape = JSON.stringify(items.map(({ frame, depth, parent }) => [frame.name, depth, parent]));
    if (shape !== this.drawn?.shape) {
      const rows = items.map((item) => this._row(item));
      this.drawn = { shape, rows };
      fill(this.table, h("table.rows", {},
        h("thead", {}, h("tr", {}, h("th", {}, "frame"), h("th.number", {}, "rate"), h("th.number", {}, "age"), h("th.who", {}, "published by"))),
        h("tbody", {}, rows.map(({ element }) => element))));
    }
    items.forEach(({ frame }, index) => this.drawn.rows[index].update(frame));
  }

  _rows(frame, children, depth) {
    if (this.drawnFrames.has(frame.name) || depth > 200) return [];
    this.drawnFrames.add(frame.name);
    const below = children.get(frame.name) || [];
    const open = !this.closed.has(frame.name) || this.search;
    const inner = below.flatMap((child) => this._rows(child, children, depth + 1));
    const fits = !this.search || frame.name.toLowerCase().includes(this.search);
    return fits || inner.length ? [{ frame, depth, parent: below.length > 0 }, ...(open ? inner : [])] : [];
  }

  _row({ frame: { name }, depth, parent }) {
    const fold = parent && h("button.quiet.fold", { "aria-label": "fold", onclick: (event) => {
      event.stopPropagation();
      if (!this.closed.delete(name)) this.closed.add(name);
      this._save();
      this._draw();
    } });
    const problem = h("div.wrong");
    const [hz, old, who] = [h("td.number"), h("td.number"), h("td.who.mono.muted")];
    const choose = () => { this.selected = this.selected === name ? "" : name; this._save(); this._draw(); };
    const element = h("tr.link", { tabIndex: 0, onclick: choose, onkeydown: (event) => this._key(event, choose) }, h("td.mono", { style: { paddingLeft: `calc(10px + ${depth} * var(--step, 18px))` } }, h("span.label", {}, fold || h("span.fold"), name), problem), hz, old, who);
    return { element, update: (frame) => {
      element.setAttribute("aria-selected", String(name === this.selected));
      if (fold) setText(fold, this.closed.has(name) ? "▸" : "▾");
      setText(problem, frame.problem || "");
      setText(hz, frame.root ? "" : frame.static ? "static" : rate(frame.hz));
      setText(old, frame.root || frame.static ? "" : age(frame.age));
      old.classList.toggle("wrong", frame.age > MAX_AGE && frame.age <= RECORDED_AGE);
      setText(who, (frame.publishers || []).join(" "));
    } };
  }

  // Enter selects a row; arrow keys move to others.
  _key(event, choose) {
    if (event.target !== event.currentTarget) return;
    const other = { ArrowDown: "nextElementSibling", ArrowUp: "previousElementSibling" }[event.key];
    if (event.key === "Enter" || event.key === " ") choose();
    else if (other) event.target[other]?.focus();
    else return;
    event.preventDefault();
  }

  _drawDetail() {
    const frame = this.data.frames.find((each) => each.name === this.selected);
    this.detail.hidden = !frame;
    if (!frame) return;
    const [x, y, z, ...turn] = frame.transform;
    const [roll, pitch, yaw] = angles(turn);
    const row = (label, value) => [h("dt", {}, label), h("dd.mono", {}, value)];
    fill(this.detail, h("strong", {}, `${frame.parent} → ${frame.name}`), h("dl", {},
      row("translation", [x, y, z].map((value) => number(value)).join("  ") + "  m"),
      row("rotation", turn.map((value) => number(value)).join("  ")),
      row("roll pitch yaw", [roll, pitch, yaw].map((value) => `${number(value * 180 / Math.PI, 3)}°`).join("  "))));
  }

  _save() {
    this.place.save({ closed: [...this.closed], selected: this.selected });
  }

  _drawStatus() {
    const quote = (text) => JSON.stringify(text);
    const edges = (this.data?.frames || []).map((frame) =>
      `  ${quote(frame.parent)} -> ${quote(frame.name)} [label=${quote(`${frame.publishers.join(" ")}\n${frame.static ? "static" : rate(frame.hz)}`)}];`);
    return ["digraph frames {", ...edges, "}", ""].join("\n");
  }
}

function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

function age(seconds) {
  if (seconds < 1) return `${(seconds * 1000).toFixed(0)} ms`;
  if (seconds < 120) return `${seconds.toFixed(1)} s`;
  if (seconds < 7200) return `${(seconds / 60).toFixed(0)} min`;
  if (seconds < 172800) return `${(seconds / 3600).toFixed(0)} h`;
  return seconds < 6e7 ? `${(seconds / 86400).toFixed(0)} days` : `${(seconds / 3.156e7).toFixed(0)} years`;
}

// Convert a quaternion to roll, pitch and yaw (fixed axes x, y, z) in radians.
function angles([x, y, z, w]) {
  return [
    Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))),
    Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  ];
}
