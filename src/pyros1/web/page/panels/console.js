// The log of all nodes, like rqt_console.

import { empty, command, fill, h, save } from "../lib/dom.js";
import { bytes, clock, plural } from "../lib/format.js";
import { LogBuffer } from "../lib/log_buffer.js";

/** @type {[number, string][]} */
const LEVELS = [[1, "debug"], [2, "info"], [4, "warn"], [8, "error"], [16, "fatal"]];
const LEVEL_NAMES = new Map(LEVELS);
const LIMITS = [50000, 50e6]; // messages, and characters
const ROW_HEIGHT = 24; // pixels
const MAX_LINE_LENGTH = 1000; // characters of a line: the layout of longer ones with changing writing directions takes seconds
const EXTRA_ROWS = 12; // rows above and below the visible ones
const MAX_CLICK_MOVE = 5; // pixels that the pointer may move during a click

export default {
  title: "Console",
  description: "the log of all nodes",
  order: 20,
  mount: (place) => new Console(place),
};

class Console {
  constructor(place) {
    this.place = place;
    this.buffer = new LogBuffer(...LIMITS); // entries are [number, time, level, node, text, file, function, line, topics]
    this.filtered = [];
    this.loaded = null; // messages of a file instead of the robot's: {entries, counts, note}
    this.paused = false;
    this.selected = null;
    this.rowElements = new Map(); // entry -> its row, for the visible ones
    this.scrollTarget = null; // index of a row to scroll to
    this.last = 0; // number of the last message received; the server counts messages from its start
    this.count = 0; // number of messages that this panel has received
    this.dropped = 0;
    this.counts = countsOf([]);
    this.buttons = new Map(); // level -> its button
    this.fits = (_entry) => true; // whether an entry passes the filters
    this.mark = (_entry) => false; // whether to mark an entry
    const { settings } = place;
    this.hidden = new Set(settings.hidden || []);
    this.search = settings.search || "";
    this.exclude = settings.exclude || "";
    this.node = settings.node || "";
    this.marking = settings.marking || "";
    this._build();
    this._filtersChanged();
    this.args = { after: 0, run: "" };
    this.stream = place.robot.stream("console", this.args, {
      opened: () => { this.args.after = this.last; },
      data: (data) => this._receive(data),
      problem: (text) => place.problem(text),
    });
    this.observer = new ResizeObserver(() => this._draw());
    this.observer.observe(this.list);
  }

  unmount() {
    this.stream.close();
    this.observer.disconnect();
  }

  _build() {
    const { body, tools } = this.place;
    this.buttons = new Map(LEVELS.map(([level, name]) => [level, h(`button.level.${name}`, {
      title: `show or hide ${name}`, onclick: () => {
        if (!this.hidden.delete(level)) this.hidden.add(level);
        this._filtersChanged();
      },
    })]));
    this.pause = h("button", { "aria-pressed": "false", title: "pause the list; messages are still collected", onclick: () => {
      this.paused = !this.paused;
      this.pause.setAttribute("aria-pressed", String(this.paused));
      fill(this.pause, this.paused ? "Resume" : "Pause");
      if (!this.paused) this._show(null);
    } }, "Pause");
    const field = (key, hint, title) => h("input.filter", {
      value: this[key], placeholder: hint, title, size: 10, "aria-label": hint,
      oninput: (event) => { this[key] = event.target.value; this._filtersChanged(); },
    });
    const file = h("input", { type: "file", accept: ".csv,text/csv", hidden: true, onchange: (event) => this._load(event.target.files[0]) });
    tools.append(
      h("span.levels", {}, [...this.buttons.values()]), this.pause,
      field("search", "text", "only messages with this text; /.../ is a regular expression"),
      field("exclude", "exclude", "no messages with this text; /.../ is a regular expression"),
      field("node", "node", "only messages of nodes, or about topics, with this in their names"),
      field("marking", "highlight", "mark messages with this in their text, severity, node or topics; /.../ is a regular expression"),
      h("button.quiet", { title: "clear the list", onclick: () => this._clear() }, "Clear"),
      h("button.quiet", { title: "save the messages shown, as CSV like rqt_console", onclick: () => this._save() }, "Save"),
      h("button.quiet", { title: "load a saved log", onclick: () => file.click() }, "Load"), file,
      h("button.quiet", { title: "levels of the loggers of the chosen message's node", onclick: () => this._levels() }, "Levels"));
    this.missing = h("span.muted", { hidden: true, title: "messages that arrived faster than this page could process them, or while it was not visible" });
    tools.append(this.missing);
    this.content = h("div.tall");
    this.list = h("div.log", {
      role: "log", tabIndex: 0, onscroll: () => this._scrolled(), onkeydown: (event) => this._key(event),
      // The list may have scrolled before the button is released: select what was pressed.
      onpointerdown: (event) => { this.pressed = { entry: entryOf(event), x: event.clientX, y: event.clientY }; },
      onpointerup: (event) => this._finishPress(event),
      onclick: (event) => { if (!event.detail && entryOf(event)) this._select(entryOf(event)); }, // clicks without a pointer, as from assistive technology
    }, this.content);
    this.detail = h("div.detail", { hidden: true });
    this.newest = h("button.primary.newest", { hidden: true, onclick: () => this._scrollToEnd() }, "↓ newest");
    body.classList.add("console");
    body.append(h("div.rest", {}, this.list, this.newest), this.detail);
    this.atEnd = true;
  }

  _receive({ entries, dropped, run }) {
    if (this.count && this.args.run === run) this.dropped += dropped;
    this.args.run = run;
    this.last = entries.at(-1)[0];
    for (const entry of entries) {
      entry[0] = ++this.count;
      this.buffer.push(entry);
      this.counts.set(entry[2], (this.counts.get(entry[2]) || 0) + 1);
      if (!this.paused && this.fits(entry)) this.filtered.push(entry);
    }
    if (this.buffer.trim() && !this.paused) {
      const [first] = this.buffer.entries;
      this.filtered = this.filtered.filter((entry) => entry[0] >= first[0]);
    }
    this._drawCounts();
    this._draw();
  }

  _filtersChanged() {
    const text = matcher(this.search);
    const exclude = this.exclude ? matcher(this.exclude) : { test: () => false };
    const node = matcher(this.node);
    const mark = matcher(this.marking);
    this.mark = ([, , level, name, said, , , , topics]) => Boolean(this.marking) && !mark.problem
      && (mark.test(said) || mark.test(name) || mark.test(LEVEL_NAMES.get(level) || "info") || topics.some(mark.test));
    this.place.problem(text.problem || exclude.problem || node.problem || mark.problem || this.loaded?.note || "");
    this.fits = (entry) => !this.hidden.has(entry[2]) && text.test(entry[4]) && (Boolean(exclude.problem) || !exclude.test(entry[4])) && (node.test(entry[3]) || (Boolean(this.node) && entry[8].some(node.test)));
    this.filtered = (this.loaded || this.buffer).entries.filter(this.fits);
    this.place.save({ hidden: [...this.hidden], search: this.search, exclude: this.exclude, node: this.node, marking: this.marking });
    this._drawCounts();
    this._draw();
  }

  _drawCounts() {
    for (const [level, button] of this.buttons) {
      button.setAttribute("aria-pressed", String(!this.hidden.has(level)));
      const count = (this.loaded || this).counts.get(level);
      const text = `${LEVEL_NAMES.get(level)} ${count < 1e4 ? count : bytes(count, "")}`;
      if (button.textContent !== text) button.textContent = text;
    }
    this.missing.hidden = !this.dropped || Boolean(this.loaded);
    fill(this.missing, `${this.dropped < 1e4 ? this.dropped : bytes(this.dropped, "")} missing`);
  }

  _scrolled() {
    this.atEnd = this.list.scrollTop + this.list.clientHeight >= this.list.scrollHeight - ROW_HEIGHT;
    this._draw();
  }

  _scrollToEnd() {
    this.atEnd = true;
    this._draw();
  }

  // Only visible rows exist in the DOM, so any number of messages is fast.
  _draw() {
    if (this.drawing) return;
    this.drawing = requestAnimationFrame(() => {
      this.drawing = 0;
      this._drawNow();
    });
  }

  _drawNow() {
    const count = this.filtered.length;
    if (!count) {
      const { length } = (this.loaded || this.buffer).entries;
      fill(this.content, length
        ? empty("No messages match the filters", `${plural(length, "message")} in all.`)
        : empty("No messages yet", "The log of running nodes appears here. Try, in a terminal:", command("pyros1 run minimal_nodes minimal_publisher")));
      this.rowElements.clear();
      this.content.style.height = "100%";
      this.newest.hidden = true;
      return;
    }
    this.content.style.height = `${count * ROW_HEIGHT}px`;
    if (this.atEnd && !this.paused) this.list.scrollTop = this.list.scrollHeight;
    if (this.scrollTarget !== null) {
      const { scrollTop, clientHeight } = this.list;
      this.list.scrollTop = Math.min(this.scrollTarget * ROW_HEIGHT, Math.max(scrollTop, (this.scrollTarget + 1) * ROW_HEIGHT - clientHeight));
      this.scrollTarget = null;
    }
    this.newest.hidden = this.atEnd;
    const first = Math.max(0, Math.floor(this.list.scrollTop / ROW_HEIGHT) - EXTRA_ROWS);
    const last = Math.min(count, Math.ceil((this.list.scrollTop + this.list.clientHeight) / ROW_HEIGHT) + EXTRA_ROWS);
    if (!this.rowElements.size) fill(this.content);
    const unused = new Set(this.rowElements.keys());
    for (let index = first; index < last; index += 1) {
      const entry = this.filtered[index];
      unused.delete(entry);
      this._place(entry, index * ROW_HEIGHT);
    }
    for (const entry of unused) {
      this.rowElements.get(entry).remove();
      this.rowElements.delete(entry);
    }
  }

  // A row is kept while it is visible, so that its text can be selected and copied.
  _place(entry, top) {
    let row = this.rowElements.get(entry);
    if (!row) {
      const [, time, level, node, text] = entry;
      const name = LEVEL_NAMES.get(level) || "info";
      row = h(`div.entry.${name}`, {},
        h("span.time", {}, clock(time)), h("span.severity", {}, name), h("span.of", { title: node }, node), h("span.text", {}, text.split("\n", 1)[0].slice(0, MAX_LINE_LENGTH)));
      row.entry = entry;
      this.rowElements.set(entry, row);
      this.content.append(row);
    }
    row.style.top = `${top}px`;
    row.classList.toggle("marked", this.mark(entry));
    row.setAttribute("aria-selected", String(this.selected === entry[0]));
  }

  _finishPress({ clientX, clientY }) {
    const { entry, x, y } = this.pressed || {};
    this.pressed = null;
    if (entry && Math.hypot(clientX - x, clientY - y) < MAX_CLICK_MOVE) this._select(entry);
  }

  _key(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step && this.filtered.length) {
      const now = this.filtered.findIndex((entry) => entry[0] === this.selected);
      const next = now < 0 ? this.filtered.length - 1 : Math.min(this.filtered.length - 1, Math.max(0, now + step));
      if (next !== now) this._select(this.filtered[next]);
      this.atEnd = false; // stop scrolling, so that the message can be read
      this.scrollTarget = next;
      this._draw();
    } else if (event.key === "Escape" && this.selected !== null) this._select(null);
    else return;
    event.preventDefault();
  }

  // Show the details of a message; close them if they are shown already, or for null.
  _select(entry) {
    this.selected = !entry || this.selected === entry[0] ? null : entry[0];
    this.detail.hidden = this.selected === null;
    this._draw();
    this.of = this.selected === null ? null : entry[3];
    if (this.selected !== null) this._describe(entry);
  }

  _levels() {
    if (this.of) this.place.open("nodes", { selected: this.of, loggers: true });
    else {
      this.detail.hidden = false;
      fill(this.detail, h("p.muted.hint", {}, "Choose a message first: “Levels” shows the loggers of its node. ",
        h("button", { onclick: () => this.place.open("nodes", {}) }, "All nodes")));
    }
  }

  _describe([, time, level, node, text, file, fn, line, topics, nanoseconds]) {
    const row = (label, value) => value && [h("dt", {}, label), h("dd.mono", {}, value)];
    fill(this.detail, h("pre.mono", {}, text), h("dl", {},
      row("node", node), row("level", LEVEL_NAMES.get(level)), row("time", `${clock(time)} (${parseTime(time, nanoseconds)})`),
      row("place", file && `${file}:${line}${fn ? ` in ${fn}` : ""}`), row("topics", topics.join(" "))));
  }

  _clear() {
    this.buffer.clear();
    this.counts = countsOf([]);
    this.dropped = 0;
    this._show(null);
  }

  // Show the messages of a file, or the robot's.
  _show(loaded) {
    this.loaded = loaded;
    this._select(null);
    this._filtersChanged();
  }

  // The file format of rqt_console: a header, then message;severity;node;stamp;topics;location, each in quotation marks.
  _save() {
    const quote = (value) => `"${String(value).replaceAll('"', '\\"').replace(/\\$/, "\\ ")}"`; // a backslash at the end would escape the quotation mark
    const rows = this.filtered.map(([, time, level, node, text, file, fn, line, topics, nanoseconds]) => [
      text, level, node, parseTime(time, nanoseconds), topics.join(","), `${file}:${fn}:${line}`,
    ].map(quote).join(";"));
    save("console.csv", ["message;severity;node;stamp;topics;location", ...rows].join("\n") + "\n", "text/csv");
  }

  async _load(file) {
    if (!file) return;
    const text = await file.text();
    const found = parseFile(text);
    if (!found.length) {
      this.place.problem(`${file.name} has no messages; it should be a file saved by this console or rqt_console`);
      return;
    }
    this.paused = true;
    this.pause.setAttribute("aria-pressed", "true");
    fill(this.pause, "Resume");
    this._show({ entries: found, counts: countsOf(found), note: `${plural(found.length, "message")} of ${file.name}; “Resume” shows the robot's again` });
  }
}

function countsOf(entries) {
  const counts = new Map(LEVELS.map(([level]) => [level, 0]));
  for (const [, , level] of entries) counts.set(level, (counts.get(level) || 0) + 1);
  return counts;
}

function entryOf(event) {
  return event.target.closest(".entry")?.entry;
}

function matcher(text) {
  if (!text) return { test: () => true };
  const expression = /^\/(.+)\/([iu]*)$/.exec(text);
  if (expression) {
    try {
      const compiled = new RegExp(expression[1], expression[2]);
      return { test: (value) => compiled.test(value) };
    } catch (error) {
      return { test: () => true, problem: error.message };
    }
  }
  const lowered = text.toLowerCase();
  return { test: (value) => value.toLowerCase().includes(lowered) };
}

// Parse a time as seconds and nanoseconds: a plain number has only microseconds.
function parseTime(time, nanoseconds) {
  return `${Math.round(time - nanoseconds / 1e9)}.${String(nanoseconds).padStart(9, "0")}`;
}

function nanoseconds(stamp) {
  return Number((/\.(\d{1,9})/.exec(stamp)?.[1] || "0").padEnd(9, "0"));
}

function parseFile(text) {
  const found = [];
  const row = /"((?:[^"]|(?<=\\)")*)"(;|\r?\n|$)/g; // an escaped quotation mark is text, as for rqt_console, if the row still ends afterwards
  let fields = [];
  for (let match = row.exec(text); match; match = row.exec(text)) {
    fields.push(match[1].replaceAll('\\"', '"'));
    if (match[2] === ";") continue;
    if (fields.length >= 6) {
      const [message, severity, node, stamp, topics, location] = fields;
      const [, file, fn, line] = /^([^:]*):(.*):([^:]*)$/s.exec(location) || [null, location]; // names of C++ functions contain colons
      const level = Number(severity) || LEVELS.find(([, name]) => name === severity.toLowerCase())?.[0] || 2;
      found.push([found.length + 1, Number(stamp), level, node, message, file || "", fn || "", Number(line) || 0, topics ? topics.split(",") : [], nanoseconds(stamp)]);
    }
    fields = [];
  }
  return found;
}
