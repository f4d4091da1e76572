// A launch in the panel of launches: a header, and a row for each process.

import { fill, h } from "../../lib/dom.js";
import { bytes, duration } from "../../lib/format.js";
import { commandButton, commandsFor } from "./commands.js";

const MAX_ROWS = 300;

export function keyOf(param, entry) {
  return `${param} ${entry.label}`;
}

// Return the number at the end of a label: processes are numbered in the order of their start.
function startNumber({ label }) {
  return Number(/-(\d+)$/.exec(label)?.[1] || 0);
}

export class Launch {
  constructor(panel, param) {
    this.panel = panel;
    this.param = param;
    this.rows = new Map(); // label -> {element, cells, buttons, shown}
    this.expected = new Map(); // label -> {verb, starts}: the command sent, until its effect is seen
    this.head = h("header");
    this.note = h("p.muted.hint", { hidden: true });
    this.body = h("div.processes", { role: "rowgroup" });
    this.element = h("section.launch", { dataset: { param } }, this.head, this.note, this.body);
  }

  take(facts) {
    this.facts = facts;
    for (const [label, { verb, starts, since }] of this.expected) {
      const entry = facts.processes?.find((each) => each.label === label);
      const done = !entry || (verb === "stop" ? !["running", "stopping"].includes(entry.state) : entry.starts > starts);
      if (done || performance.now() - since > 30000) this.expected.delete(label);
    }
  }

  // Show the given processes. all: also if the launch is folded, since the user searches for them.
  show(entries, all) {
    const { facts, panel } = this;
    const open = all || !panel.folded.has(this.param);
    this.element.hidden = all && !entries.length;
    this._drawHead(open);
    const words = [];
    if (!facts.problem && facts.refusal) words.push(`View only: ${facts.refusal}.`);
    if (entries.length > MAX_ROWS) words.push(`${entries.length - MAX_ROWS} more processes are not shown; the field above finds them.`);
    else if (facts.count > (facts.processes || []).length) words.push(`${facts.count - facts.processes.length} more processes are not shown.`);
    if (!facts.problem && !facts.count && !facts.expected) words.push(facts.title === "roscore" ? "The master and rosout." : "It has no processes.");
    const text = open ? words.join(" ") : "";
    this.note.hidden = !text;
    if (this.note.textContent !== text) this.note.textContent = text;
    // Processes are in starting order; if there are too many, those with problems are kept.
    const few = entries.length > MAX_ROWS ? [...entries].sort((one, other) => Number(one.state === "running") - Number(other.state === "running")).slice(0, MAX_ROWS) : entries;
    const shown = open ? [...few].sort((one, other) => startNumber(one) - startNumber(other)) : [];
    const labels = new Set(shown.map((entry) => entry.label));
    for (const [label, row] of this.rows) {
      if (labels.has(label)) continue;
      row.element.remove();
      this.rows.delete(label);
    }
    shown.forEach((entry, index) => {
      const row = this.rows.get(entry.label) || this._row(entry.label);
      if (this.body.children[index] !== row.element) this.body.insertBefore(row.element, this.body.children[index] || null);
      this._draw(row, entry);
    });
    this.showSelection();
  }

  redraw() {
    for (const row of this.rows.values()) row.state = "";
    if (this.facts) this.panel._show();
  }

  _drawHead(open) {
    const { facts, panel } = this;
    const state = JSON.stringify([open, facts.title, facts.problem, facts.pid, facts.expected, facts.processes?.map((each) => each.state)]);
    if (state !== this.headState) {
      this.headState = state;
      this.time = h("span.muted");
      const count = (what) => (facts.processes || []).filter((each) => each.state === what).length;
      fill(this.head,
        h("button.quiet.turn", { "aria-expanded": String(open), onclick: () => panel.fold(this.param), title: open ? "fold" : "unfold" },
          `${open ? "▾" : "▸"} `, h("b", {}, facts.title || "a launch that does not answer")),
        h("span.muted.where", { title: facts.uri }, `${facts.host}${facts.pid ? `, process ${facts.pid}` : ""}`), this.time,
        count("died") > 0 && h("button.badge.died", { title: "show those that died", onclick: () => panel.find("died") }, `${count("died")} died`),
        facts.expected > 0 && h("span.badge", { title: "nodes that have not started because they are waiting for something" }, `${facts.expected} waiting`),
        facts.problem && h("span.wrong", {}, facts.problem),
        facts.problem && !panel.place.robot.about.read_only && h("button", {
          title: "delete its parameter on the master; it was killed, or its machine cannot be reached", onclick: () => panel.forget(this.param),
        }, "Forget"));
    }
    const time = facts.uptime === null || facts.uptime === undefined ? "" : `for ${duration(facts.uptime)}`;
    if (this.time.textContent !== time) this.time.textContent = time;
  }

  _row(label) {
    const cells = Object.fromEntries(["name", "state", "cpu", "memory", "uptime", "starts", "verbs"].map((name) => [name, h(`div.${name}`, { role: "gridcell" })]));
    const key = keyOf(this.param, { label });
    const element = h("div.process", {
      role: "row", dataset: { key }, onclick: (event) => { if (!event.target.closest("button")) this.panel.choose(key); },
    }, Object.values(cells));
    const row = { element, cells, state: "" };
    this.rows.set(label, row);
    return row;
  }

  _draw(row, entry) {
    const { cells, element } = row;
    const expectedCommand = this.expected.get(entry.label);
    const word = expectedCommand ? { stop: "stopping", start: "starting", restart: "restarting" }[expectedCommand.verb] : entry.state;
    const state = JSON.stringify([word, entry.exit, entry.required, entry.respawn, this.facts.refusal]);
    if (state !== row.state) {
      row.state = state;
      element.className = `process is-${word}`;
      fill(cells.name, h("span.mono.node", { title: entry.label }, entry.node || entry.label),
        entry.required && h("span.badge", { title: "its launch ends when it exits" }, "required"),
        entry.respawn && h("span.badge", { title: "it is restarted whenever it exits" }, "respawn"));
      fill(cells.state, h("i.lamp"), h("span.word", { title: entry.exit }, word, entry.exit && ["died", "ended", "waiting"].includes(word) && h("span.exit", {}, `, ${entry.exit}`)));
      fill(cells.verbs, commandsFor(this, entry).map((verb) => commandButton(verb, true, () => this._sendCommand(verb, entry), Boolean(expectedCommand))));
    }
    setText(cells.cpu, entry.cpu === null ? "" : `${entry.cpu.toFixed(1)}%`, "CPU");
    setText(cells.memory, bytes(entry.memory), "memory");
    setText(cells.uptime, duration(entry.uptime), "since its last start");
    setText(cells.starts, entry.starts > 1 ? `× ${entry.starts}` : "", `started ${entry.starts} times`);
  }

  async _sendCommand(verb, entry) {
    try {
      await this.panel.sendCommand(verb, this.param, entry);
      this.panel.fail("");
    } catch (error) {
      this.panel.fail(error.message);
    }
  }

  // Remember the command that was sent; null for none.
  expect(label, verb) {
    const entry = this.facts.processes?.find((each) => each.label === label);
    if (verb && entry) this.expected.set(label, { verb, starts: entry.starts, since: performance.now() });
    else this.expected.delete(label);
    this.panel._show();
  }

  showSelection() {
    for (const row of this.rows.values()) row.element.setAttribute("aria-selected", String(row.element.dataset.key === this.panel.selected));
  }
}

function setText(cell, text, title) {
  if (cell.textContent !== text) {
    cell.textContent = text;
    cell.title = text && title;
  }
}
