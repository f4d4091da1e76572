// The messages at the cursor, as trees or images.

import { empty, fill, h } from "../../lib/dom.js";
import { Tree } from "../tree.js";
import { formatElapsed } from "./times.js";

const MAX_TOPICS = 8; // maximum number of topics

// on: {plot(text), step(topic, forward), drop(topic), problem(text)}
export class Inspector {
  constructor(robot, on) {
    this.robot = robot;
    this.on = on;
    this.element = h("div.inspected");
    this.sections = new Map();
    this._drawHint();
  }

  close() {
    this.stream?.close();
    this.stream = null;
    for (const section of this.sections.values()) section.close?.();
    this.sections.clear();
  }

  show(path, facts) {
    this.close();
    this.path = path;
    this.facts = facts;
    this.args = { path, time: 0, topics: [] };
    this.stream = this.robot.stream("bag_cursor", this.args, {
      opened: () => this.args && Object.assign(this.args, this._streamArgs()),
      data: (data) => this._receive(data),
      problem: (text) => this.on.problem(text),
    });
    this._drawHint();
  }

  _streamArgs() {
    return { path: this.path, time: this.time || 0, topics: [...this.sections.keys()] };
  }

  select(selected) {
    const wanted = [...selected].slice(0, MAX_TOPICS);
    for (const [name, section] of this.sections) {
      if (wanted.includes(name)) continue;
      section.close?.();
      this.sections.delete(name);
    }
    for (const name of wanted) if (!this.sections.has(name)) this.sections.set(name, this._section(name));
    if (!this.sections.size) this._drawHint();
    else fill(this.element, [...this.sections.values()].map((section) => section.element), selected.size > MAX_TOPICS && h("p.muted.hint", {}, `${selected.size - MAX_TOPICS} more topics are selected; the first ${MAX_TOPICS} are shown.`));
    this.seek(this.time || 0);
  }

  seek(time) {
    this.time = time;
    if (!this.stream) return;
    this.args = this._streamArgs();
    this.stream.change(this.args);
    for (const section of this.sections.values()) section.picture?.(time);
  }

  _drawHint() {
    fill(this.element, empty("Messages", "Click a topic to see its messages at the cursor.", "Click a number in a message to plot it over the bag's time."));
  }

  _section(name) {
    const topic = this.facts.topics.find((each) => each.name === name);
    const when = h("span.when.mono");
    const body = h("div.message");
    const absolute = name.startsWith("/") ? name : `/${name}`;
    const tree = new Tree({ plot: (path) => this.on.plot(`${absolute}/${path.replaceAll(".", "/")}`) }, absolute);
    const head = h("header", {},
      h("b.mono", { title: topic.type }, name), h("span.muted", {}, topic.type), h("span.gap"), h("span.steps", {}, when,
      h("button.quiet", { title: "message before (←)", "aria-label": `message before on ${name}`, onclick: () => this.on.step([name], false) }, "‹"),
      h("button.quiet", { title: "next message (→)", "aria-label": `next message on ${name}`, onclick: () => this.on.step([name], true) }, "›"),
      h("button.quiet", { title: "hide it", "aria-label": `deselect ${name}`, onclick: () => this.on.drop(name) }, "✕")));
    const section = { element: h("section.topic-message", { dataset: { topic: name } }, head, body), tree, when, body, name };
    if (topic.image) this._picture(section);
    return section;
  }

  // Images are shown above their fields.
  _picture(section) {
    const image = h("img.picture", { alt: `image of ${section.name}`, hidden: true });
    const word = h("p.muted.hint");
    section.element.insertBefore(h("div.pictured", {}, image, word), section.body);
    let url = "";
    let stream = null;
    section.picture = (time) => {
      const args = { path: this.path, topic: section.name, times: [time], height: 480 };
      if (stream) stream.change(args);
      else {
        stream = this.robot.stream("bag_pictures", args, { data: (data, blob) => {
          const bytes = new Uint8Array(blob.buffer, blob.offset);
          URL.revokeObjectURL(url);
          url = bytes.length ? URL.createObjectURL(new Blob([bytes], { type: "image/jpeg" })) : "";
          image.hidden = !url;
          if (url) image.src = url;
          fill(word, data.problem || (url ? `${data.width} × ${data.height}` : "no image yet"));
        } });
      }
    };
    section.close = () => {
      stream?.close();
      URL.revokeObjectURL(url);
    };
  }

  _receive({ messages }) {
    for (const section of this.sections.values()) {
      const found = messages[section.name];
      if (!found || found.problem) {
        if (found) fill(section.body, h("p.hint.wrong", {}, found.problem));
        else if (!section.body.querySelector(".first")) fill(section.body, h("p.hint.muted", {}, "No message yet at this time. ", h("button.first", { onclick: () => this.on.step([section.name], true) }, "Go to the first one")));
        fill(section.when);
        continue;
      }
      if (section.body.firstChild !== section.tree.element) fill(section.body, section.tree.element);
      section.tree.show(found.value);
      fill(section.when, formatElapsed(found.time, 0.001));
      section.when.title = found.publisher ? `from ${found.publisher}` : "";
    }
  }
}
