// A panel with a table, and details of the selected row beside or below it.

import { fill, h } from "../lib/dom.js";
import { plural } from "../lib/format.js";
import { Table } from "./table.js";

const style = h("link", { rel: "stylesheet", href: "parts/parts.css" });
document.head.append(style);

// options: {columns, label, noun, tree, searchText(row), details(row), empty(), tools}
// tree: whether the table starts as a tree; null: only if there are many rows; noun: what a row is; searchText: the text to search; details: creates {element, update(row), close()};
// empty: what to show if there are no rows; tools: more elements for the panel's head.
export class TablePanel {
  constructor(place, options) {
    this.place = place;
    this.options = options;
    this.rows = null;
    this.details = null;
    this.extra = {}; // additional settings of the panel
    const { settings } = place;
    this.search = String(settings.search || "");
    this.selected = settings.selected || null;
    this.table = new Table(options.columns, {
      select: (row) => this.choose(row.name),
      changed: () => this.save(),
    }, { label: options.label, sort: settings.sort, tree: settings.tree ?? options.tree ?? null, open: Array.isArray(settings.open) ? settings.open : [] });
    this._build();
    this._filter();
    this.onAbout = () => this._reopen();
    place.robot.addEventListener("about", this.onAbout);
  }

  close() {
    this.details?.close?.();
    this.table.close();
    this.place.robot.removeEventListener("about", this.onAbout);
  }

  _build() {
    const { body, tools } = this.place;
    this.field = h("input.search", {
      value: this.search, placeholder: `find ${this.options.noun}s`, type: "search", size: Math.max(14, this.options.noun.length + 9), "aria-label": `find ${this.options.noun}s`,
      title: "words that the name or type must contain; /.../ is a regular expression",
      oninput: () => { this.search = this.field.value; this._filter(); this.save(); },
      onkeydown: (event) => { if (event.key === "ArrowDown") { this.table.element.focus(); event.preventDefault(); } },
    });
    this.folder = h("button", { title: "names as a tree of namespaces", onclick: () => {
      this.table.setTree(!this.table.isTree);
      this._drawTools();
      this.save();
    } }, "Tree");
    this.counter = h("span.muted.counter");
    tools.append(this.field, this.folder, ...(this.options.tools || []), this.counter);
    this.nothing = h("div.nothing", { hidden: true });
    this.side = h("aside.details", { hidden: true });
    body.classList.add("listing");
    body.append(h("div.list", {}, this.table.element, this.nothing), this.side);
    this.onKey = (event) => {
      if (event.key === "/" && !event.target.matches("input, textarea, select")) { this.field.focus(); event.preventDefault(); }
      if (event.key === "Escape" && this.selected && !event.target.matches("input, textarea, select")) this.choose(null);
    };
    body.addEventListener("keydown", this.onKey);
  }

  // Show rows: [{name, ...}]. Called whenever something has changed.
  show(rows) {
    this.rows = rows;
    this.table.show(rows);
    this._drawTools();
    const row = rows.find((each) => each.name === this.selected);
    if (row && !this.details) this._open(row); // a link may name a row that appears later
    else if (this.details && row) this.details.update?.(row);
    else if (this.details) this.details.update?.(null);
  }

  // Show the details of a row; null for none.
  choose(name) {
    this.selected = name;
    this.table.select(name);
    this._open(this.rows?.find((each) => each.name === name));
    this.save();
  }

  // Show something other than a row.
  showElement(element, close) {
    this.selected = null;
    this.table.select(null);
    this._replace({ element, close });
  }

  _reopen() {
    const row = this.rows?.find((each) => each.name === this.selected);
    if (row && this.details) this._open(row);
  }

  _open(row) {
    this.table.select(row ? row.name : null);
    this._replace(row ? this.options.details(row) : null);
  }

  _replace(details) {
    this.details?.close?.();
    this.details = details;
    this.side.hidden = !details;
    this.place.body.classList.toggle("chosen", Boolean(details));
    this.table.setDetailsShown(Boolean(details));
    if (details) {
      fill(this.side, h("button.quiet.shut", { title: "close (Esc)", "aria-label": "close details", onclick: () => this.choose(null) }, h("span.back", {}, "‹ back"), h("span.cross", {}, "✕")), details.element);
    } else fill(this.side);
  }

  // Return the rows that match the search.
  get found() {
    return (this.rows || []).filter(this.table.matches);
  }

  _filter() {
    const { test, problem } = matcher(this.search);
    this.place.problem(problem || "");
    this.table.filter((row) => test(this.options.searchText(row)), Boolean(this.search));
    this._drawTools();
  }

  _drawTools() {
    this.folder.setAttribute("aria-pressed", String(this.table.isTree));
    const [all, count] = [this.rows?.length ?? 0, this.table.count ?? 0];
    fill(this.counter, this.rows ? (count === all ? plural(all, this.options.noun) : `${count} of ${all}`) : "");
    const nothing = this.rows && !count;
    this.nothing.hidden = !nothing;
    if (!nothing) return;
    fill(this.nothing, all ? h("div.empty", {}, h("h3", {}, "No names match"), h("p", {}, `${plural(all, this.options.noun)} in all.`)) : this.options.empty());
  }

  save() {
    const { sort, tree, toggled } = this.table;
    this.place.save({ ...this.extra, search: this.search, selected: this.selected, sort, tree, open: [...toggled].slice(0, 500) });
  }
}

// Return a matcher for the search: a regular expression such as /^\/arm/i, or words that must all occur, in any order.
function matcher(text) {
  const expression = /^\/(.+)\/([iu]*)$/.exec(text);
  if (expression && expression[1].length > 1) {
    try {
      const compiled = new RegExp(expression[1], expression[2]);
      return { test: (value) => compiled.test(value) };
    } catch {
      // a name such as /a/ is not a regular expression
    }
  }
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  return { test: (value) => { const low = value.toLowerCase(); return words.every((word) => low.includes(word)); } };
}
