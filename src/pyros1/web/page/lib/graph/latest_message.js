// A topic's definition and latest message, for the side sheet.

import { fill, h } from "../dom.js";
import { bytes, number, rate, seconds } from "../format.js";

const MAX_AUTOMATIC_FLOW = 2e6; // bytes per second; above this, messages are requested only after a click
const LARGE_TYPES = /^sensor_msgs\/(Image|CompressedImage|PointCloud2?|LaserScan)$|\/OccupancyGrid$/;
const MAX_LINES = 80;
const UPDATE_INTERVAL = 200; // milliseconds
const MAX_ITEMS = 8;

export class LatestMessage {
  // published: whether the topic has publishers; flow: bytes per second, if known
  constructor(place, topic, type, published, flow) {
    this.place = place;
    this.topic = topic;
    this.type = type;
    this.published = published;
    this.firstNumber = null; // path of the first numeric field
    this.value = h("div.message.mono");
    this.facts = h("span.muted");
    this.definition = h("pre.mono");
    const text = h("details", { ontoggle: () => text.open && this._loadDefinition() }, h("summary", {}, "Definition"), this.definition);
    this.element = h("section", {}, text, h("h3", {}, "latest message ", this.facts), this.value);
    if (!published) fill(this.value, h("p.muted", {}, "No node publishes it."));
    else if (LARGE_TYPES.test(type) || flow > MAX_AUTOMATIC_FLOW) fill(this.value, h("button", { title: "this subscribes to the topic", onclick: () => this._open() }, "Show messages"));
    else this._open();
  }

  // Return whether this object was created with these arguments.
  isOf(topic, type, published) {
    return !this.closed && this.topic === topic && this.type === type && this.published === published;
  }

  close() {
    this.closed = true;
    clearTimeout(this.timer);
    this.stream?.close();
  }

  // Plot the first numeric field of the messages.
  async plot() {
    try {
      const [field] = this.firstNumber ? [this.firstNumber] : await this.place.robot.call("topics.fields", { begin: `${this.topic}/` });
      if (!field) throw new Error(`${this.topic} has no numbers`);
      this.place.open("plot", { curves: [field] });
    } catch (error) {
      this.place.problem(error.message);
    }
  }

  _open() {
    fill(this.value, h("p.muted", {}, "none received yet"));
    this.stream = this.place.robot.stream("message", { topic: this.topic }, {
      data: (data) => {
        this.data = data;
        this._scheduleUpdate(0);
      },
      problem: (text) => text && fill(this.value, h("p.trouble", {}, text)),
    });
  }

  // Show the latest message, at a readable rate.
  _scheduleUpdate(pause) {
    this.timer ||= setTimeout(() => {
      this.timer = 0;
      if (this.data) this._show();
    }, pause);
  }

  _show() {
    if (this.value.contains(document.activeElement)) { // do not replace a button that has the focus
      this._scheduleUpdate(UPDATE_INTERVAL);
      return;
    }
    const { value, problem, count, hz, size, bytes: flow } = this.data;
    this.data = null;
    this._scheduleUpdate(UPDATE_INTERVAL);
    fill(this.facts, [hz && rate(hz), bytes(size), flow > MAX_AUTOMATIC_FLOW && bytes(flow, "B/s"), `number ${count}`].filter(Boolean).join(" · "));
    if (problem) {
      fill(this.value, h("p.trouble", {}, problem));
      return;
    }
    const lines = [];
    this.firstNumber = null;
    this._lines(value, "", this.topic, 0, lines);
    fill(this.value, lines.slice(0, MAX_LINES), lines.length > MAX_LINES && h("div.muted", {}, "… (“Inspect” shows all)"));
  }

  _lines(value, name, path, depth, lines) {
    if (lines.length > MAX_LINES) return;
    const row = (...what) => lines.push(h("div", { style: { paddingLeft: `${depth * 14}px` } }, name && h("span.muted", {}, `${name}: `), ...what));
    if (value?.fields) {
      if (name) row();
      for (const [field, , inner] of value.fields) this._lines(inner, field, `${path}/${field}`, name ? depth + 1 : depth, lines);
      if (!value.fields.length) row(h("span.muted", {}, "(empty)"));
    } else if (value?.items) {
      const plain = value.items.every((item) => typeof item !== "object");
      const more = value.length - Math.min(value.items.length, MAX_ITEMS);
      const items = value.items.slice(0, MAX_ITEMS);
      if (plain) {
        row("[", items.map((item, index) => [index ? ", " : "", this._formatValue(item, `${path}[${index}]`)]), more > 0 ? `, … ${value.length} in all]` : "]");
        return;
      }
      row(h("span.muted", {}, `${value.length} in all`));
      items.forEach((item, index) => this._lines(item, `[${index}]`, `${path}[${index}]`, depth + 1, lines));
    } else if (value && typeof value === "object") {
      row(seconds(value));
    } else {
      row(this._formatValue(value, path));
    }
  }

  _formatValue(value, path) {
    if (typeof value !== "number") return typeof value === "string" ? JSON.stringify(value) : String(value);
    this.firstNumber ||= path;
    return h("button.link", { title: `plot ${path}`, onclick: () => this.place.open("plot", { curves: [path] }) }, number(value));
  }

  async _loadDefinition() {
    if (this.definition.textContent) return;
    try {
      const { text } = await this.place.robot.call("topics.form", { topic: this.topic });
      fill(this.definition, text);
    } catch (error) {
      fill(this.definition, error.message);
    }
  }
}
