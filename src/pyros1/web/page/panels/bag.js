// Recorded bags: their contents over time, playback and recording.

import { fill, h } from "../lib/dom.js";
import { bytes, moment, plural } from "../lib/format.js";
import { Chart } from "../parts/bag/chart.js";
import { FileChooser } from "../parts/bag/file_chooser.js";
import { Inspector } from "../parts/bag/inspector.js";
import { Player } from "../parts/bag/player.js";
import { Recorder } from "../parts/bag/recorder.js";
import { formatElapsed } from "../parts/bag/times.js";
import { Timeline } from "../parts/bag/timeline.js";

export default {
  title: "Bag",
  description: "recorded messages over time",
  order: 55,
  mount: (place) => new BagPanel(place),
};

class BagPanel {
  constructor(place) {
    this.place = place;
    const { settings, robot } = place;
    this.files = texts(settings.files);
    this.path = String(settings.path || this.files[0] || "");
    this.selected = new Set(texts(settings.topics));
    this.time = 0;
    this.problems = new Map();
    for (const href of ["parts/parts.css", "panels/bag.css"]) {
      if (!document.querySelector(`link[href="${href}"]`)) document.head.append(h("link", { rel: "stylesheet", href }));
    }
    const said = (who) => (text) => this._problem(who, text);
    this.timeline = new Timeline(robot, {
      seek: (time) => this.seek(time), view: (begin, end) => this.chart.setView([begin, end]), room: () => this.chart.resize(),
      select: (topic, several) => this._select(topic, several), problem: said("timeline"),
    });
    this.chart = new Chart(robot, {
      gutter: () => this.timeline.gutter, seek: (time) => this.seek(time), changed: () => this._save(), problem: said("chart"),
    });
    this.inspector = new Inspector(robot, {
      plot: (text) => this.chart.add(text), step: (topics, forward) => this._step(topics, forward),
      drop: (topic) => this._select(topic, true), problem: said("inspector"),
    });
    this.player = new Player(robot, { time: (time) => this._moved(time, true), selected: () => [...this.selected], problem: said("player") }, Boolean(settings.clock));
    this.recorder = new Recorder(robot, { open: (path) => this.open(path), problem: said("recorder") });
    this._build();
    this.onTheme = () => { this.timeline.draw(); this.chart.resize(); };
    addEventListener("themechange", this.onTheme);
    for (const text of texts(settings.curves)) this.chart.add(text);
    if (this.path) this.open(this.path, true);
    else this._choose();
  }

  // Called when another panel asks for a bag.
  accept(settings) {
    if (settings.path) this.open(String(settings.path));
  }

  unmount() {
    this.stream?.close();
    for (const part of [this.player, this.recorder, this.chart, this.inspector, this.timeline]) part.close();
    removeEventListener("themechange", this.onTheme);
  }

  _build() {
    const { body, tools } = this.place;
    this.opener = h("button", { title: "choose another bag", onclick: () => this._choose() }, "Open …");
    const zoom = (text, title, act) => h("button.quiet", { title, "aria-label": title, onclick: act }, text);
    this.clock = h("span.clock.mono", { title: "time of the cursor" });
    this.zooms = h("span.zooms", { hidden: true },
      zoom("−", "zoom out (−)", () => this.timeline.zoom(1.6)), zoom("+", "zoom in (+)", () => this.timeline.zoom(1 / 1.6, this._inSight())), zoom("All", "the whole bag (0)", () => this.timeline.all()));
    tools.append(this.opener, this.player.element, this.clock, this.zooms, h("span.gap"), this.recorder.button);
    this.about = h("div.about");
    this.rows = h("div.bag-rows", {}, this.timeline.element, this.chart.element);
    this.content = h("div.content", { hidden: true }, this.rows, this.inspector.element);
    this.other = h("div.other");
    body.classList.add("bag");
    body.append(this.recorder.strip, this.about, this.content, this.other);
    body.bag = this; // for tests and debugging
    body.addEventListener("keydown", (event) => this._key(event));
  }

  _problem(who, text) {
    if (text) this.problems.set(who, text);
    else if (!this.problems.delete(who)) return;
    this.place.problem([...new Set(this.problems.values())].join("; "));
  }

  _save() {
    const { settings } = this.place;
    this.place.save({ ...(settings.clock ? { clock: true } : {}), files: this.files, path: this.path, topics: [...this.selected], curves: this.chart.curves.map(({ text }) => text) });
  }

  _choose() {
    this._leave();
    this.path = "";
    this._save();
    this.opener.hidden = true;
    const files = new FileChooser(this.place.robot, {
      open: (path) => this.open(path), problem: (text) => this._problem("files", text), folder: (path) => { this.folder = path; },
    }, this.folder || "");
    fill(this.other, files.element);
  }

  _leave() {
    this.stream?.close();
    this.stream = null;
    this.facts = null;
    this.timeline.closeStream();
    this.timeline.facts = null;
    this.chart.closeStream();
    this.inspector.close();
    this.player.show("", null);
    this.content.hidden = this.zooms.hidden = true;
    this.other.hidden = false;
    fill(this.clock);
    fill(this.about);
    this.problems.clear();
    this.place.problem("");
  }

  open(path, keep = false) {
    this._leave();
    this.path = path;
    if (!keep) this.selected = new Set();
    this.folder = path.slice(0, path.lastIndexOf("/"));
    this._save();
    this.opener.hidden = false;
    fill(this.other, h("div.empty", {}, h("h3", {}, "Opening …"), h("p.mono", {}, path)));
    this.stream = this.place.robot.stream("bag_file", { path }, {
      data: (data) => this._opened(data),
      problem: (text) => { if (text) this._failed(text); },
    });
  }

  _opened(data) {
    if (data.reading !== undefined) {
      const part = data.size ? data.reading / data.size : 0;
      fill(this.other, h("div.empty", {}, h("h3", {}, "Reading …"), h("p", {}, "This bag has no index, so all of it is read."),
        h("progress", { max: 1, value: part, "aria-label": "reading" }), h("p.muted", {}, `${bytes(data.reading)} of ${bytes(data.size)}`)));
    } else if (data.problem) this._failed(data.problem);
    else if (!this.facts) this._shown(data);
  }

  _failed(text) {
    if (this.facts) {
      this._problem("file", text);
      return;
    }
    fill(this.other, h("div.empty", { role: "alert" }, h("h3", {}, "This bag cannot be opened"), h("p", {}, text),
      h("p", {}, h("button", { onclick: () => this._choose() }, "Choose another bag"))));
  }

  _shown(facts) {
    this.facts = facts;
    this._describe();
    if (!facts.topics.length) {
      fill(this.other, h("div.empty", {}, h("h3", {}, "This bag is empty"), h("p", {}, "It has no messages: nothing was published on its topics while it was recorded."),
        h("p", {}, h("button", { onclick: () => this._choose() }, "Choose another bag"))));
      return;
    }
    this.other.hidden = true;
    this.content.hidden = this.zooms.hidden = false;
    const known = new Set(facts.topics.map(({ name }) => name));
    this.selected = new Set([...this.selected].filter((name) => known.has(name)));
    this.timeline.show(this.path, facts);
    this.chart.show(this.path, this.timeline.view);
    this.inspector.show(this.path, facts);
    this.player.show(this.path, facts);
    this._selectAll();
    this._moved(0, false);
  }

  _describe() {
    const { facts } = this;
    const name = this.path.split("/").at(-1);
    const compression = Object.keys(facts.storage).filter((each) => each !== "none").map((each) => {
      const [, size, stored] = facts.storage[each];
      return size ? `${each} ${Math.round((100 * stored) / size)}%` : each;
    });
    const chunks = Object.values(facts.storage).reduce((sum, [count]) => sum + count, 0);
    const figures = [
      formatElapsed(facts.length, 0.1), plural(facts.messages, "message"), plural(facts.topics.length + facts.more, "topic"), bytes(facts.size),
      compression.join(", ") || "not compressed", plural(chunks, "chunk"), facts.encryption && "encrypted",
    ].filter(Boolean);
    const several = this.files.length > 1 && this.files.includes(this.path) && h("select.mono", { "aria-label": "bag", onchange: (event) => this.open(event.target.value) },
      this.files.map((path) => h("option", { value: path, selected: path === this.path }, path.split("/").at(-1))));
    fill(this.about,
      h("div.line", {}, several || h("b.mono", { title: this.path }, name), h("span.muted", { title: `version ${facts.version}` }, figures.join(" · ")),
        facts.start > 0 && h("span.muted", {}, `from ${moment(facts.start)}`)),
      facts.problems.length > 0 && h("ul.problems", {}, facts.problems.map((text) => h("li", {}, text))),
      facts.more > 0 && h("p.muted", {}, `${facts.more} more topics are not shown.`));
  }

  _select(topic, several) {
    if (several) {
      if (!this.selected.delete(topic)) this.selected.add(topic);
    } else if (this.selected.size === 1 && this.selected.has(topic)) this.selected.clear();
    else this.selected = new Set([topic]);
    this._selectAll();
    this._save();
  }

  _selectAll() {
    this.timeline.select(this.selected);
    this.inspector.select(this.selected);
    this.player.selected();
  }

  // Called when the user has moved the cursor.
  seek(time) {
    if (!this.facts) return;
    this._moved(time, false);
    this.player.seek(time);
  }

  _moved(time, following) {
    if (!this.facts) return;
    this.time = time;
    this.timeline.setTime(time);
    if (following) this.timeline.follow();
    this.chart.setTime(time);
    this.inspector.seek(time);
    const text = `${formatElapsed(time)}`;
    if (this.clock.textContent !== text) this.clock.textContent = text;
    if (this.facts.start > 0) this.clock.title = `${(this.facts.start + time).toFixed(6)}\n${moment(this.facts.start + time)}`;
  }

  _inSight() {
    const [begin, end] = this.timeline.view;
    return this.time >= begin && this.time <= end ? this.time : (begin + end) / 2;
  }

  async _step(topics, forward) {
    if (!this.facts) return;
    this.player.pause();
    try {
      const names = topics.length ? topics : this.facts.topics.map(({ name }) => name);
      const time = await this.place.robot.call("bags.step", { path: this.path, time: this.time, topics: names, forward });
      if (time === null) return;
      this.seek(time);
      this.timeline.follow();
    } catch (error) {
      this._problem("step", error.message);
    }
  }

  _key(event) {
    if (this.content.hidden || event.target.matches("input, textarea, select") || event.ctrlKey || event.metaKey || event.altKey) return;
    const size = this.timeline.view[1] - this.timeline.view[0];
    const jump = (by) => {
      this.seek(Math.max(0, Math.min(this.facts.length, this.time + by)));
      this.timeline.follow();
    };
    const step = (forward) => (event.shiftKey ? jump((forward ? 1 : -1) * size * 0.05) : this._step([...this.selected], forward));
    const acts = {
      " ": () => event.target.matches("button, summary") || this.player.toggle(),
      ArrowLeft: () => step(false), ArrowRight: () => step(true),
      Home: () => jump(-this.time), End: () => jump(this.facts.length - this.time),
      "+": () => this.timeline.zoom(1 / 1.6, this._inSight()), "-": () => this.timeline.zoom(1.6), 0: () => this.timeline.all(),
    };
    const act = acts[event.key];
    if (!act || act() === true) return;
    event.preventDefault();
  }
}

// Return a setting that must be a list of strings. It may come from a link, which is untrusted input.
function texts(list) {
  return Array.isArray(list) ? list.slice(0, 200).map(String) : [];
}
