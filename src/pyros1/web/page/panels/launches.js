// Launched processes: their states and logs, with buttons to stop, start and restart them.

import { command, empty, fill, h } from "../lib/dom.js";
import { plural } from "../lib/format.js";
import { ProcessDetails } from "../parts/launches/process_details.js";
import { Launch, keyOf } from "../parts/launches/launch.js";

document.head.append(h("link", { rel: "stylesheet", href: "parts/parts.css" }), h("link", { rel: "stylesheet", href: "panels/launches.css" }));

export default {
  title: "Launches",
  description: "what launch files run",
  order: 75,
  mount: (place) => new Launches(place),
};

class Launches {
  constructor(place) {
    this.place = place;
    const { settings } = place;
    this.search = String(settings.search || "");
    this.folded = new Set(Array.isArray(settings.folded) ? settings.folded.slice(0, 100) : []);
    this.selected = settings.selected || null; // key of the selected process
    this.wantedNode = settings.node || null; // a node to select when it appears
    this.launches = new Map(); // parameter -> Launch
    this.details = null;
    this.trouble = ""; // a problem that affects the whole panel
    this.commandProblem = ""; // why the last command failed
    this._build();
    this.stream = place.robot.stream("launches", {}, {
      data: (data) => this._receive(data),
      problem: (text) => { // every update reports the problem again
        this.trouble = text;
        this.fail(this.commandProblem);
      },
    });
    this.onAbout = () => { for (const launch of this.launches.values()) launch.redraw(); };
    place.robot.addEventListener("about", this.onAbout);
  }

  unmount() {
    this.stream.close();
    this.details?.close();
    this.place.robot.removeEventListener("about", this.onAbout);
  }

  // Show why a command failed; "" for nothing.
  fail(text) {
    this.commandProblem = text;
    this.place.problem(this.trouble || text);
  }

  accept({ node }) {
    this.wantedNode = node || null;
    if (this.data) this._receive(this.data);
  }

  _build() {
    const { body, tools } = this.place;
    this.field = h("input.search", {
      value: this.search, placeholder: "find processes", type: "search", size: 14, "aria-label": "find processes",
      title: "a part of a name, or of a state such as died",
      oninput: () => { this.search = this.field.value; this._show(); this._save(); },
      onkeydown: (event) => { if (event.key === "ArrowDown") { this.list.focus(); event.preventDefault(); } },
    });
    this.counter = h("span.muted.counter");
    tools.append(this.field, this.counter);
    this.rest = h("p.muted.hint", { hidden: true });
    this.groups = h("div.groups");
    this.list = h("div.launches", { tabIndex: 0, "aria-label": "processes of launches", role: "treegrid", onkeydown: (event) => this._key(event) }, this.groups, this.rest);
    this.side = h("aside.details", { hidden: true });
    body.classList.add("listing");
    body.append(h("div.list", {}, this.list), this.side);
    body.addEventListener("keydown", (event) => {
      if (event.target.matches("input, textarea, select")) return;
      if (event.key === "/") { this.field.focus(); event.preventDefault(); }
      if (event.key === "Escape" && this.selected) this.choose(null);
    });
  }

  _receive(data) {
    this.data = data;
    const there = new Set(data.launches.map((each) => each.param));
    for (const [param, launch] of this.launches) {
      if (there.has(param)) continue;
      launch.element.remove();
      this.launches.delete(param);
    }
    for (const facts of data.launches) {
      if (!this.launches.has(facts.param)) this.launches.set(facts.param, new Launch(this, facts.param));
      this.launches.get(facts.param).take(facts);
    }
    this._show();
  }

  _show() {
    const { launches, more } = this.data || { launches: [], more: 0 };
    if (!this.data) return;
    const words = this.search.toLowerCase().split(/\s+/).filter(Boolean);
    const fits = (facts, entry) => words.every((word) => `${facts.title} ${entry.node} ${entry.label} ${entry.state} ${entry.required ? "required" : ""}`.toLowerCase().includes(word));
    let count = 0;
    let all = 0;
    for (const facts of launches) {
      const launch = this.launches.get(facts.param);
      const shown = (facts.processes || []).filter((entry) => fits(facts, entry));
      launch.show(shown, words.length > 0);
      count += shown.length;
      all += facts.count || 0;
    }
    this._arrange(launches);
    fill(this.counter, count === all ? `${plural(launches.length, "launch").replace(/launchs$/, "launches")}, ${all} process${all === 1 ? "" : "es"}` : `${count} of ${all} processes`);
    this.rest.hidden = !more && !(all && !count);
    fill(this.rest, more ? `${more} more launches are not shown.` : "No names match.");
    if (this.wantedNode) this._selectWanted(launches);
    const chosen = this._find(this.selected);
    if (chosen) this._open(chosen);
    else if (this.details) this.details.update(null);
    if (!launches.length) this._emptyMessage();
  }

  _emptyMessage() {
    fill(this.groups, empty("No launch is running", "Start one, in a terminal:",
      command("pyros1 launch minimal_nodes minimal_simulator.launch"),
      "Nodes that were started individually are in the Nodes tab."));
  }

  // Launches with running processes come first, those that do not respond last.
  _arrange(launches) {
    const rank = (facts) => (facts.problem ? 2 : facts.count ? 0 : 1);
    const sorted = [...launches].sort((one, other) => rank(one) - rank(other) || (one.title || "").localeCompare(other.title || "") || one.param.localeCompare(other.param));
    const elements = sorted.map((facts) => this.launches.get(facts.param).element);
    if (elements.length !== this.groups.children.length || elements.some((each, index) => this.groups.children[index] !== each)) fill(this.groups, elements);
  }

  _selectWanted(launches) {
    for (const { param, processes = [] } of launches) {
      const entry = processes.find((each) => each.node === this.wantedNode);
      if (!entry) continue;
      this.wantedNode = null;
      this.selected = keyOf(param, entry);
      this.fail("");
      return;
    }
    this.fail(`No launch is running ${this.wantedNode}: it was started in another way, or has ended with its launch.`);
  }

  _find(key) {
    for (const facts of this.data?.launches || []) {
      for (const entry of facts.processes || []) if (keyOf(facts.param, entry) === key) return { facts, entry };
    }
    return null;
  }

  choose(key) {
    this.selected = key;
    for (const launch of this.launches.values()) launch.showSelection();
    const chosen = this._find(key);
    if (chosen) this._open(chosen);
    else this._closeDetails();
    this._save();
  }

  _open({ facts, entry }) {
    const key = keyOf(facts.param, entry);
    if (this.details?.key === key) {
      this.details.update({ facts, entry });
      return;
    }
    this.details?.close();
    this.details = new ProcessDetails(this, key, facts, entry);
    this.side.hidden = false;
    this.place.body.classList.add("chosen");
    fill(this.side, h("button.quiet.shut", { title: "close (Esc)", "aria-label": "close details", onclick: () => this.choose(null) },
      h("span.back", {}, "‹ back"), h("span.cross", {}, "✕")), this.details.element);
    for (const launch of this.launches.values()) launch.showSelection();
  }

  _closeDetails() {
    this.details?.close();
    this.details = null;
    this.side.hidden = true;
    this.place.body.classList.remove("chosen");
    fill(this.side);
  }

  // Send a command for a process to a launch; the promise rejects with the reason for a failure.
  async sendCommand(verb, param, entry) {
    this.launches.get(param)?.expect(entry.label, verb);
    try {
      await this.place.robot.call("launches.control", { launch: param, process: entry.label, verb });
    } catch (error) {
      this.launches.get(param)?.expect(entry.label, null);
      throw error;
    }
    this.stream.change({});
  }

  async forget(param) {
    try {
      await this.place.robot.call("launches.forget", { launch: param });
      this.stream.change({});
    } catch (error) {
      this.fail(error.message);
    }
  }

  find(words) {
    this.field.value = this.search = this.search === words ? "" : words;
    this._show();
    this._save();
  }

  fold(param) {
    if (!this.folded.delete(param)) this.folded.add(param);
    this._show();
    this._save();
  }

  _key(event) {
    if (event.target !== this.list) return;
    const rows = [...this.groups.querySelectorAll(".process")];
    const at = rows.findIndex((row) => row.dataset.key === this.selected);
    const next = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: rows.length - 1 }[event.key];
    if (next === undefined || !rows.length) return;
    const row = rows[Math.min(rows.length - 1, Math.max(0, next))];
    row.scrollIntoView({ block: "nearest" });
    this.choose(row.dataset.key);
    event.preventDefault();
  }

  _save() {
    this.place.save({ search: this.search, folded: [...this.folded].slice(0, 100), selected: this.selected });
  }
}
