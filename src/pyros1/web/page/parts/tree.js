// A live message as a tree: rows are kept and only their values change. See pyros1/web/views/message.py for the value.

import { fill, h } from "../lib/dom.js";
import { clock, number, seconds } from "../lib/format.js";
import { copyable } from "./widgets.js";

const OPEN_DEPTH = 2;
const MAX_OPEN_MESSAGES = 3; // maximum number of messages in an array that is initially open
const PREVIEW_LENGTH = 70; // characters

// on: {plot(path), window(path, start)}, both optional; paths are like "pose.position.x", "ranges[3]".
// prefix: prepended to a path that is copied, like "/topic".
export class Tree {
  constructor(on = {}, prefix = "") {
    this.on = on;
    this.prefix = prefix;
    this.fields = null; // fields of the definition, see pyros1/web/models/forms.py: names of constants are shown beside their values
    this.folds = new Map(); // path -> open, as set by the user
    this.lengths = new Map(); // path of an array -> its length
    this.element = h("div.tree.mono", { role: "tree" });
    this.root = null;
    this.kind = null;
  }

  show(value) {
    this.value = value;
    if (!value) {
      fill(this.element);
      this.root = null;
      return;
    }
    const kind = value.fields.map(([name, type]) => `${name} ${type}`).join();
    if (!this.root || kind !== this.kind) {
      this.kind = kind;
      this.root = this._children(value.fields.map(([name, type]) => [name, name, type]), 0);
      fill(this.element, value.fields.length ? this.root.map((node) => node.element) : h("div.muted.hint", {}, "This message has no fields."));
    }
    value.fields.forEach(([, , inner], index) => this.root[index].update(inner));
  }

  _children(list, depth) {
    return list.map(([label, path, type]) => this._node(label, path, type, depth));
  }

  _node(label, path, type, depth) {
    if (type.endsWith("]")) return this._array(label, path, type, depth);
    return type.includes("/") ? this._message(label, path, type, depth) : this._leaf(label, path, type, depth);
  }

  _line(label, path, type, depth, ...rest) {
    const full = this.prefix ? `${this.prefix}/${path.replaceAll(".", "/")}` : path;
    return h("div.twig", { role: "treeitem", style: { paddingLeft: `${6 + depth * 15}px` } }, ...rest.slice(0, 1), copyable(full, label), h("span.type", {}, type), ...rest.slice(1));
  }

  _leaf(label, path, type, depth) {
    const shown = this._value(type, path);
    const word = h("span.preview");
    const line = this._line(label, path, type, depth, h("i.caret"), shown.element, word);
    return { element: line, update: (value) => {
      shown.update(value);
      const text = this._constantName(path, value);
      if (word.textContent !== text) word.textContent = text;
    } };
  }

  // Return the name of a constant.
  _constantName(path, value) {
    if (!this.fields) return "";
    let fields = this.fields;
    let field = null;
    for (const name of path.replace(/\[\d+\]/g, "").split(".")) {
      field = fields?.find((each) => each[0] === name);
      fields = field?.[2];
    }
    return field?.[3]?.find((choice) => choice[1] === value)?.[0] || "";
  }

  // A single value: a number is a button that plots it.
  _value(type, path) {
    const numeric = type !== "string" && type !== "time" && type !== "duration";
    const element = numeric && this.on.plot
      ? h("button.value", { title: "click to plot", onclick: () => this.on.plot(path) })
      : h("span.value");
    element.classList.add(numeric ? (type === "bool" ? "bool" : "num") : type === "string" ? "text" : "time");
    let last;
    return { element, update: (value) => {
      const text = written(value, type === "float64" && path.endsWith("]") ? "" : type); // elements of arrays are not rounded to 15 digits: most have fewer
      if (text === last) return;
      last = text;
      element.textContent = text;
      if (value && typeof value === "object") element.title = `${seconds(value)} s`;
    } };
  }

  _message(label, path, type, depth) {
    const element = path.endsWith("]");
    const few = element && this.lengths.get(path.slice(0, path.lastIndexOf("["))) <= MAX_OPEN_MESSAGES;
    const open = element ? few && depth <= OPEN_DEPTH : depth < OPEN_DEPTH && label !== "header";
    return this._fold(label, path, type, depth, open, (value) => value.fields.map(([name, kind]) => [name, `${path}.${name}`, kind]), (value) => value.fields.map((field) => field[2]));
  }

  // A foldable row whose content is created when it is first opened, and again when its shape has changed.
  _fold(label, path, type, depth, open0, list, values) {
    let nodes = null;
    let shape = "";
    let value;
    const inside = h("div.inside", { role: "group" });
    const preview = h("span.preview");
    const caret = h("button.caret", { "aria-label": `fold ${label}`, onclick: () => { this.folds.set(path, !open()); draw(); } });
    const line = this._line(label, path, type, depth, caret, preview);
    line.addEventListener("click", (event) => { if (!event.target.closest("button")) caret.click(); });
    const open = () => this.folds.get(path) ?? open0;
    const draw = () => {
      const is = open();
      caret.textContent = is ? "▾" : "▸";
      line.setAttribute("aria-expanded", String(is));
      inside.hidden = !is;
      const text = is && value.items?.length !== 0 ? "" : summary(value);
      if (preview.textContent !== text) preview.textContent = text;
      if (!is) return;
      const entries = list(value);
      const now = entries.map(([, where, kind]) => `${where} ${kind}`).join();
      if (!nodes || now !== shape) {
        shape = now;
        nodes = this._children(entries, depth + 1);
        fill(inside, nodes.map((node) => node.element));
        if (value.more) inside.append(h("div.muted.hint", {}, "too many values to show them all"));
      }
      values(value).forEach((inner, index) => nodes[index].update(inner));
    };
    return { element: h("div.branch", {}, line, inside), update: (newValue) => { value = newValue; draw(); } };
  }

  _array(label, path, type, depth) {
    const base = type.slice(0, type.indexOf("["));
    const pager = this._pager(path);
    if (base.includes("/") || base === "string" || base === "time" || base === "duration") {
      const fold = this._fold(label, path, type, depth, false,
        ({ start, items }) => items.map((_, index) => [`[${start + index}]`, `${path}[${start + index}]`, base]),
        ({ items }) => items);
      let known = false;
      return { element: h("div.branch", {}, fold.element, pager.element), update: (value) => {
        this.lengths.set(path, value.length);
        if (!known && !this.folds.has(path)) { known = true; if (value.length <= MAX_OPEN_MESSAGES && depth < OPEN_DEPTH) this.folds.set(path, true); }
        fold.update(value);
        pager.update(value, this.folds.get(path) ?? false);
      } };
    }
    return this._numbers(label, path, type, depth, base, pager);
  }

  // Numbers are shown in one line.
  _numbers(label, path, type, depth, base, pager) {
    const list = h("div.numbers", { style: { paddingLeft: `${27 + depth * 15}px` } });
    const length = h("span.preview");
    const line = this._line(label, path, type, depth, h("i.caret"), length);
    let shape = "";
    let cells = [];
    return { element: h("div.branch", {}, line, list, pager.element), update: (value) => {
      const { items, start } = value;
      const now = `${start} ${items.length}`;
      if (now !== shape) {
        shape = now;
        cells = items.map((_, index) => this._value(base, `${path}[${start + index}]`));
        cells.forEach((cell, index) => { cell.element.title = `[${start + index}]${this.on.plot ? ": click to plot" : ""}`; });
        fill(list, cells.map((cell) => cell.element));
      }
      length.textContent = value.length ? `${value.length} value${value.length === 1 ? "" : "s"}` : "empty";
      items.forEach((item, index) => cells[index].update(item));
      pager.update(value, true);
    } };
  }

  // Long arrays are shown in chunks.
  _pager(path) {
    const text = h("span.muted");
    let now = { start: 0, items: [], length: 0 };
    const go = (start) => this.on.window?.(path, Math.max(0, Math.min(start, now.length - 1)));
    const size = () => Math.max(1, now.items.length);
    const before = h("button.quiet", { title: "elements before", onclick: () => go(now.start - 64) }, "‹");
    const after = h("button.quiet", { title: "elements after", onclick: () => go(now.start + size()) }, "›");
    const element = h("div.pager", { hidden: true }, before, text, after);
    return { element, update: (value, open) => {
      now = value;
      const end = value.start + value.items.length;
      element.hidden = !open || (value.items.length === value.length && value.start === 0);
      before.disabled = !this.on.window || value.start === 0;
      after.disabled = !this.on.window || end >= value.length;
      const line = `${value.start}–${Math.max(value.start, end - 1)} of ${value.length}`;
      if (text.textContent !== line) text.textContent = line;
    } };
  }
}

export function written(value, type = "") {
  if (value === null || value === undefined) return "";
  if (typeof value === "number" && !type.startsWith("float")) return String(value);
  if (type === "float64" && typeof value === "number" && !Number.isInteger(value)) return String(Number(value.toPrecision(15)));
  if (typeof value === "number") return number(value, type === "float32" ? 4 : 7); // approximately the type's precision
  if (typeof value === "object" && "secs" in value) {
    const time = value.secs + value.nsecs / 1e9;
    return time > 1e8 ? clock(time) : `${number(time, 7)} s`;
  }
  return String(value);
}

// Return the beginning of a value, in one line.
function summary(value) {
  let text = "";
  const walk = (part, type) => {
    if (text.length > PREVIEW_LENGTH) return;
    if (part && part.fields) part.fields.forEach(([name, kind, inner]) => { text += `${text ? "  " : ""}${name}: `; walk(inner, kind); });
    else if (part && part.items) text += part.length ? `${part.length} element${part.length === 1 ? "" : "s"}` : "empty";
    else text += written(part, type).split("\n")[0];
  };
  walk(value);
  return text.length > PREVIEW_LENGTH ? `${text.slice(0, PREVIEW_LENGTH)} …` : text;
}
