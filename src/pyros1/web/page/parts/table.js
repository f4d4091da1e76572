// A table of things with full names: sorted, filtered, folded by namespace. Only visible rows exist in the DOM, and they are
// kept while their texts change, so that any number of rows is fast and a click always hits.

import { fill, h } from "../lib/dom.js";

const ROW_HEIGHT = 30; // pixels
const EXTRA_ROWS = 8; // rows above and below the visible ones
const MANY_ROWS = 60; // rows; above this, namespaces are initially folded

/** @typedef {{label?: string, sort?: {column: number, down: boolean} | null, tree?: boolean | null, open?: string[]}} Options */

// columns: [{title, text(row), value(row), node(row), number, width, least}]; the first is the name.
// text: what is displayed; value: what is sorted by, if not the text; node: an element instead, created once per row;
// width: the column's width in the CSS grid; least: width of the table in pixels below which the column is omitted.
// on: {select(row), changed()}; changed is called when the user has sorted or folded.
export class Table {
  constructor(columns, on, /** @type {Options} */ { label, sort = null, tree = null, open = [] } = {}) {
    this.columns = columns;
    this.on = on;
    this.sort = sort || { column: 0, down: false };
    this.tree = tree; // whether namespaces are shown as a tree; null: only if there are many rows
    this.toggled = new Set(open); // namespaces folded or unfolded by the user
    this.hasDetails = false;
    this.rows = [];
    this.items = [];
    this.selected = null;
    this.matches = () => true;
    this.searching = false;
    this.drawn = new Map();
    this.head = h("div.head", { role: "row" });
    this.content = h("div.tall", { role: "rowgroup" });
    this.element = h("div.table", {
      role: "treegrid", tabIndex: 0, "aria-label": label,
      onscroll: () => this._draw(), onkeydown: (event) => this._key(event), onclick: (event) => this._click(event),
    }, this.head, this.content);
    this.observer = new ResizeObserver(() => this._resized());
    this.observer.observe(this.element);
  }

  close() {
    this.observer.disconnect();
  }

  show(rows) {
    this.rows = rows;
    this._arrange();
  }

  filter(matches, searching) {
    this.matches = matches;
    this.searching = searching;
    this._arrange();
  }

  select(name) {
    this.selected = name;
    this._draw();
  }

  // Whether namespaces are shown as a tree.
  get isTree() {
    return this.tree ?? this.rows.length > MANY_ROWS;
  }

  // Set whether details are shown beside the table: then some columns are omitted.
  setDetailsShown(beside) {
    if (beside === this.hasDetails) return;
    this.hasDetails = beside;
    this._resized();
  }

  setTree(tree) {
    this.tree = tree;
    this._arrange();
  }

  _resized() {
    const width = this.element.clientWidth;
    if (!width) return;
    this.shown = this.columns.filter((column) => width >= (column.least || 0) && !(this.hasDetails && column.alone));
    this.element.style.setProperty("--columns", this.shown.map((column) => column.width || "minmax(0, 1fr)").join(" "));
    this._drawHead();
    this.drawn.clear();
    fill(this.content);
    this._draw();
  }

  _drawHead() {
    fill(this.head, this.shown.map((column) => {
      const index = this.columns.indexOf(column);
      const sorted = this.sort.column === index;
      const arrow = sorted ? (this.sort.down ? " ↓" : " ↑") : "";
      return h(`div.cell${column.number ? ".number" : ""}`, {
        role: "columnheader", "aria-sort": sorted ? (this.sort.down ? "descending" : "ascending") : "none",
      }, column.title && h("button.quiet.sort", { title: column.hint || `sort by ${column.title}`, onclick: () => this._sortBy(index) }, column.title + arrow));
    }));
  }

  _sortBy(index) {
    const first = Boolean(this.columns[index].number); // numbers: largest first
    this.sort = this.sort.column === index ? { column: index, down: !this.sort.down } : { column: index, down: first };
    this._drawHead();
    this._arrange();
    this.on.changed();
  }

  _arrange() {
    const column = this.columns[this.sort.column] || this.columns[0];
    const value = column.value || column.text;
    const sign = this.sort.down ? -1 : 1;
    const compare = (one, other) => {
      const [first, second] = [value(one), value(other)];
      const empty = (what) => what === undefined || what === null || what === "";
      if (empty(first) || empty(second)) return Number(empty(first)) - Number(empty(second)) || byName(one.name, other.name); // empty ones last
      const order = typeof first === "number" && typeof second === "number" ? first - second : byName(String(first), String(second));
      return sign * order || byName(one.name, other.name);
    };
    const rows = this.rows.filter(this.matches).sort(compare);
    this.count = rows.length;
    this.items = this.isTree ? this._fold(rows) : rows.map((row) => ({ key: row.name, row, depth: 0, label: row.name }));
    this._draw();
  }

  // Return the tree of namespaces as a list of items; a namespace with a single entry is not a group.
  _fold(rows) {
    const root = makeGroup("");
    for (const row of rows) {
      const words = row.name.split("/").filter(Boolean);
      let at = root;
      for (const word of words.slice(0, -1)) {
        const path = `${at.path}/${word}`;
        if (!at.below.has(word)) at.below.set(word, makeGroup(path));
        at.count += 1;
        at = at.below.get(word);
      }
      at.count += 1;
      at.rows.push(row);
    }
    const items = [];
    const add = (here, from, depth) => {
      for (let inner of [...here.below.values()].sort((one, other) => byName(one.path, other.path))) {
        if (inner.count === 1) {
          const row = singleEntry(inner);
          items.push({ key: row.name, row, depth, label: row.name.slice(from.length) || row.name });
          continue;
        }
        while (!inner.rows.length && inner.below.size === 1) [inner] = inner.below.values();
        const open = this.isOpen(inner.path);
        items.push({ key: `${inner.path}/`, group: inner, depth, label: inner.path.slice(from.length), open });
        if (open) add(inner, inner.path, depth + 1);
      }
      for (const row of here.rows) items.push({ key: row.name, row, depth, label: row.name.slice(from.length) || row.name });
    };
    add(root, "", 0);
    return items;
  }

  isOpen(path) {
    return this.searching || (this.rows.length <= MANY_ROWS) !== this.toggled.has(path);
  }

  _toggle(path) {
    if (!this.toggled.delete(path)) this.toggled.add(path);
    this._arrange();
    this.on.changed();
  }

  _draw() {
    if (this.drawing || !this.shown) return;
    this.drawing = requestAnimationFrame(() => {
      this.drawing = 0;
      this._drawNow();
    });
  }

  _drawNow() {
    this.content.style.height = `${this.items.length * ROW_HEIGHT}px`;
    const top = this.element.scrollTop;
    const first = Math.max(0, Math.floor(top / ROW_HEIGHT) - EXTRA_ROWS);
    const last = Math.min(this.items.length, Math.ceil((top + this.element.clientHeight) / ROW_HEIGHT) + EXTRA_ROWS);
    const unused = new Set(this.drawn.keys());
    for (let index = first; index < last; index += 1) {
      const item = this.items[index];
      unused.delete(item.key);
      this._place(item, index);
    }
    for (const key of unused) {
      this.drawn.get(key).element.remove();
      this.drawn.delete(key);
    }
  }

  _place(item, index) {
    let line = this.drawn.get(item.key);
    if (!line) {
      line = { element: h("div.line", { role: "row", dataset: { key: item.key } }), cells: [] };
      line.cells = this.shown.map((column, at) => h(`div.cell${column.number ? ".number" : ""}${at ? "" : ".name"}`, { role: "gridcell" }, !at && h("bdi")));
      line.element.append(...line.cells);
      this.drawn.set(item.key, line);
      this.content.append(line.element);
    }
    const { element, cells } = line;
    element.style.top = `${index * ROW_HEIGHT}px`;
    cells[0].style.paddingLeft = `${10 + item.depth * 16}px`;
    element.classList.toggle("group", Boolean(item.group));
    element.setAttribute("aria-selected", String(!item.group && item.key === this.selected));
    element.setAttribute("aria-level", String(item.depth + 1));
    if (item.group) {
      element.setAttribute("aria-expanded", String(item.open));
      setText(cells[0].firstChild, `${item.open ? "▾" : "▸"} ${item.label} (${item.group.count})`, item.group.path);
      return;
    }
    element.classList.toggle("dim", Boolean(item.row.dim));
    this.shown.forEach((column, at) => {
      if (column.node) {
        if (line.row !== item.row && column.changes !== false) replaceContent(cells[at], column.node(item.row));
        return;
      }
      const text = at ? column.text(item.row) : item.label;
      setText(at ? cells[at] : cells[0].firstChild, text, at ? undefined : item.row.name);
    });
    line.row = item.row;
  }

  _click(event) {
    const key = event.target.closest(".line")?.dataset.key;
    if (key === undefined || event.target.closest("button, input")) return;
    this._choose(key);
  }

  _choose(key) {
    const item = this.items.find((each) => each.key === key);
    if (!item) return;
    if (item.group) this._toggle(item.group.path);
    else this.on.select(item.row);
    this.at = key;
  }

  _key(event) {
    if (event.target !== this.element) return;
    const index = this.items.findIndex((item) => item.key === (this.at ?? this.selected));
    const item = this.items[index];
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: 12, PageUp: -12, Home: -Infinity, End: Infinity };
    if (event.key in steps) {
      const next = Math.min(this.items.length - 1, Math.max(0, index + steps[event.key]));
      this._goTo(next);
    } else if (item?.group && (event.key === "Enter" || event.key === " " || (event.key === "ArrowRight") !== item.open) && ["Enter", " ", "ArrowLeft", "ArrowRight"].includes(event.key)) {
      this._toggle(item.group.path);
    } else if (item && event.key === "Enter") {
      this.on.select(item.row);
    } else {
      return;
    }
    event.preventDefault();
  }

  _goTo(index) {
    const item = this.items[index];
    if (!item) return;
    this.at = item.key;
    const top = index * ROW_HEIGHT;
    const room = this.element.clientHeight - this.head.offsetHeight - ROW_HEIGHT;
    if (top < this.element.scrollTop) this.element.scrollTop = top;
    else if (top > this.element.scrollTop + room) this.element.scrollTop = top - room;
    for (const [key, line] of this.drawn) line.element.classList.toggle("at", key === item.key);
    if (item.row) this.on.select(item.row);
    this._draw();
  }
}

/** @returns {{path: string, below: Map<string, any>, rows: any[], count: number}} */
function makeGroup(path) {
  return { path, below: new Map(), rows: [], count: 0 };
}

function singleEntry(from) {
  let at = from;
  while (!at.rows.length) [at] = at.below.values();
  return at.rows[0];
}

// Rows that look the same are kept, so that a click on them always hits.
function replaceContent(cell, node) {
  if (!node || !cell.firstChild?.isEqualNode(node)) fill(cell, node);
}

function setText(cell, text, title = text) {
  if (cell.textContent !== text) cell.textContent = text;
  if (cell.title !== title) cell.title = title;
}

const collator = new Intl.Collator("en", { numeric: true });
function byName(one, other) {
  return collator.compare(one, other);
}
