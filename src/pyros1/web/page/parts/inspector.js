// The latest message of a topic as a tree, with its rate, size and age.

import { fill, h } from "../lib/dom.js";
import { bytes, plural, rate } from "../lib/format.js";
import { Tree } from "./tree.js";

const RATE_TIMEOUT = 3; // seconds without a message, after which the rate is outdated

export class Inspector {
  // on: {plot(path)}
  constructor(robot, topic, on) {
    this.robot = robot;
    this.topic = topic;
    this.windows = {};
    this.frozen = false;
    this.data = null;
    this.tree = new Tree({
      plot: (path) => on.plot(`${topic}/${path.replaceAll(".", "/")}`),
      window: (path, start) => { this.windows = { ...this.windows, [path]: start }; this._change(); },
    }, topic);
    this.freeze = h("button", { "aria-pressed": "false", title: "keep this message", onclick: () => this._freeze() }, "Freeze");
    this.figures = h("div.figures");
    this.problem = h("div.outcome.wrong", { role: "alert", hidden: true });
    this.at = 0; // when the shown message arrived
    this.waiting = h("p.muted.hint", {}, "No message yet. This page is listening; messages will appear as they arrive.");
    this.element = h("div.inspector", {}, h("div.actions", {}, this.figures, h("span.gap"), this.freeze), this.problem, this.waiting, this.tree.element);
    this.stream = robot.stream("message", this._args(), {
      data: (data) => this._receive(data),
      problem: (text) => this._problem(text),
    });
    this.timer = setInterval(() => this._drawFigures(), 250);
  }

  close() {
    clearInterval(this.timer);
    this.stream.close();
  }

  _args() {
    return { topic: this.topic, windows: this.windows, frozen: this.frozen };
  }

  _change() {
    this.stream.change(this._args());
  }

  _freeze() {
    this.frozen = !this.frozen;
    this.freeze.setAttribute("aria-pressed", String(this.frozen));
    fill(this.freeze, this.frozen ? "Resume" : "Freeze");
    this._change();
  }

  _problem(text) {
    this.problem.hidden = !text;
    fill(this.problem, text);
  }

  _receive(data) {
    if (data.type !== this.data?.type) {
      this.tree.fields = null; // the type has changed
      this._loadConstants();
    }
    this.at = performance.now() - 1000 * data.age;
    this.data = data;
    this.waiting.hidden = true;
    this._problem(data.problem || "");
    this.tree.show(data.value);
    this._drawFigures();
  }

  // Load the names of constants. The type of a new topic may not be known yet.
  async _loadConstants(times = 5) {
    try {
      const { type, fields } = await this.robot.call("topics.form", { topic: this.topic });
      if (type !== this.data.type) throw new Error("a message of another type has arrived in the meantime");
      this.tree.fields = fields;
      this.tree.show(this.data.value);
    } catch {
      // without a definition, numbers have no names
      if (times > 1) setTimeout(() => this._loadConstants(times - 1), 1000);
    }
  }

  _drawFigures() {
    if (!this.data) return;
    const { hz, bytes: flow, size, count, publisher, latched, time, value } = this.data;
    const age = (performance.now() - this.at) / 1000;
    const stamp = value?.fields.find(([name]) => name === "header")?.[2].fields?.find(([name]) => name === "stamp")?.[2];
    const delay = stamp && stamp.secs ? time - stamp.secs - stamp.nsecs / 1e9 : null;
    const figure = (label, text, title) => text && h("span.figure", { title }, h("span.muted", {}, label), text);
    const quiet = !this.frozen && age > Math.max(RATE_TIMEOUT, hz ? 3 / hz : 0);
    fill(this.figures,
      figure("rate", quiet ? "0 Hz" : rate(hz) || "…", "messages per second over the last 5 s; for slow topics, between the latest two messages"),
      figure("flow", quiet || !flow ? "" : `${bytes(flow)}/s`, "bytes per second"),
      figure("size", bytes(size), "of this message"),
      figure("delay", delay !== null && Math.abs(delay) < 1e5 ? seconds(delay) : "", "time from its stamp to its arrival here"),
      figure("age", age < 1 && !this.frozen ? "now" : seconds(age), "time since it arrived"),
      figure("from", publisher, "its publisher"), latched && h("span.badge", {}, "latched"), h("span.muted", {}, plural(count, "message")));
  }
}

function seconds(value) {
  const size = Math.abs(value);
  if (size < 1) return `${(value * 1000).toFixed(size < 0.01 ? 1 : 0)} ms`;
  return size < 120 ? `${value.toFixed(size < 10 ? 1 : 0)} s` : `${(value / 60).toFixed(0)} min`;
}
