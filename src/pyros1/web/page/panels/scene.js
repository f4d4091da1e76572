// The robot and what it sees, in 3D, as rviz shows it.

import { empty, fill, h, save } from "../lib/dom.js";

const COLOURS = ["#1c7ed6", "#e8590c", "#2f9e44", "#9c36b5", "#e03131", "#0c8599", "#f08c00", "#6741d9"];

export default {
  title: "3D",
  description: "frames, scans, clouds, maps, markers and paths in 3D",
  order: 40,
  mount: (place) => new Scene(place),
};

class Scene {
  constructor(place) {
    this.place = place;
    this.fixed = place.settings.fixed || "";
    this.topics = [...(place.settings.topics || [])]; // shown topics
    this.displays = new Map(); // topic -> {display, stream, type}
    this.types = {};
    this._build();
    this._begin();
  }

  // Three.js comes only when it is needed: it is large.
  async _begin() {
    let parts;
    try {
      parts = await Promise.all(["stage", "displays", "frames", "tools"].map((name) => import(`../lib/scene/${name}.js`)));
      if (this.gone) return;
      const [{ Stage, put }, { Display, TYPES }, { FrameSet }, tools] = parts;
      Object.assign(this, { Display, TYPES, tools, put });
      this.stage = new Stage(this.view);
      this.frames = new FrameSet();
      this.stage.scene.add(this.frames.object);
    } catch (error) {
      fill(this.view, empty("No 3D here", `This browser cannot draw in 3D: ${error.message}`));
      return;
    }
    this.place.body.scene = this; // for tests, and the curious
    this.onTheme = () => this.stage.colours();
    addEventListener("themechange", this.onTheme);
    const { robot } = this.place;
    this.system = robot.stream("system", {}, { data: (data) => this._system(data) });
    this.world = robot.stream("scene_frames", { fixed: this.fixed }, {
      data: (data, blob) => this._frames(data, blob),
      problem: (text) => this.place.problem(text),
    });
    for (const topic of this.topics) this._show(topic);
    this._list();
  }

  unmount() {
    this.gone = true;
    this.system?.close();
    this.world?.close();
    for (const topic of [...this.displays.keys()]) this._hide(topic);
    if (this.onTheme) removeEventListener("themechange", this.onTheme);
    this.tool?.close();
    this.stage?.close();
  }

  accept(settings) {
    for (const topic of settings.topics || []) if (!this.topics.includes(topic)) this._add(topic);
  }

  _build() {
    const { body, tools } = this.place;
    this.fixedChoice = h("select.mono", { "aria-label": "fixed frame", title: "the frame that stands still", onchange: (event) => this._fix(event.target.value) });
    const view = (name, text) => h("button.quiet", { title: `look from ${text}`, onclick: () => this.stage?.view(name) }, text);
    this.buttons = new Map([["measure", "Measure"], ["goal", "Nav goal"], ["estimate", "Pose estimate"]].map(([name, text]) =>
      [name, h("button", { "aria-pressed": "false", onclick: () => this._use(name) }, text)]));
    tools.append(h("label.check", {}, "fixed", this.fixedChoice), view("orbit", "orbit"), view("top", "top"), view("side", "side"),
      ...this.buttons.values(),
      h("button.quiet", { title: "save the picture", onclick: () => this._png() }, "PNG"));
    this.view = h("div.view");
    this.list = h("div.displays");
    this.word = h("div.word.mono", { hidden: true });
    this.view.append(this.word);
    body.classList.add("scene");
    body.append(this.list, this.view);
  }

  _save() {
    this.place.save({ fixed: this.fixed, topics: this.topics });
  }

  _system(data) {
    this.types = Object.fromEntries(Object.entries(data.topics).map(([name, { type }]) => [name, type]));
    const offered = Object.keys(this.types).filter((name) => this.TYPES[this.types[name]] && !this.topics.includes(name));
    const key = JSON.stringify([offered, this.topics.map((topic) => this.types[topic])]);
    if (key === this.offered) return;
    this.offered = key;
    this.choices = offered;
    this._list();
  }

  _frames(data, blob) {
    this.shownFixed = data.fixed;
    const names = [...data.names, ...data.lost].sort();
    const key = JSON.stringify([names, data.fixed]);
    if (key !== this.names) {
      this.names = key;
      const all = [...new Set([...names, ...(this.fixed ? [this.fixed] : [])])];
      fill(this.fixedChoice, h("option", { value: "" }, all.length ? `the root (${data.fixed})` : "no frames yet"),
        all.map((name) => h("option", { value: name, selected: name === this.fixed }, name)));
      if (!this.fixed) this._restream();
    }
    this.place.problem(data.lost.length ? `no way from ${data.fixed} to ${data.lost.slice(0, 5).join(", ")}${data.lost.length > 5 ? " …" : ""}` : "");
    this.frames.take(data, blob);
    this.stage.draw();
  }

  _fix(frame) {
    this.fixed = frame;
    this.names = "";
    this.world.change({ fixed: frame });
    this._restream();
    this._save();
  }

  _restream() {
    for (const { stream, topic } of this.displays.values()) stream.change({ topic, fixed: this._fixedFrame() });
  }

  _fixedFrame() {
    return this.fixed || this.shownFixed || "";
  }

  _add(topic) {
    this.topics.push(topic);
    this._show(topic);
    this._save();
    this.offered = "";
    this._list();
  }

  _remove(topic) {
    this.topics = this.topics.filter((each) => each !== topic);
    this._hide(topic);
    this._save();
    this.offered = "";
    this._list();
  }

  _show(topic) {
    const display = new this.Display(COLOURS[this.displays.size % COLOURS.length]);
    this.stage.scene.add(display.object);
    const entry = { topic, display };
    this.displays.set(topic, entry);
    entry.stream = this.place.robot.stream("scene_topic", { topic, fixed: this._fixedFrame() }, {
      data: (data, blob) => {
        if (this.types[topic] === "nav_msgs/Odometry") display.trail = true;
        display.take(data, blob);
        this._tell(entry);
        this.stage.draw();
      },
      problem: (text) => { entry.trouble = text; this._tell(entry); },
    });
  }

  _hide(topic) {
    const entry = this.displays.get(topic);
    if (!entry) return;
    this.displays.delete(topic);
    entry.stream.close();
    this.stage.scene.remove(entry.display.object);
    entry.display.close();
    this.stage.draw();
  }

  _list() {
    const names = h("label.check", {}, h("input", { type: "checkbox", checked: this.frames?.names ?? true, onchange: (event) => { this.frames.showNames(event.target.checked); this.stage.draw(); } }), "names of frames");
    fill(this.list, h("h4", {}, "Displays"), names,
      this.topics.map((topic) => {
        const entry = this.displays.get(topic);
        if (!entry) return null;
        entry.line = h("div.word");
        const row = h("div.display", {},
          h("label.check", {}, h("input", { type: "checkbox", checked: entry.display.object.visible, onchange: (event) => { entry.display.object.visible = event.target.checked; this.stage.draw(); } }),
            h("span.mono", { title: topic }, topic)),
          h("button.quiet", { title: "remove", "aria-label": `remove ${topic}`, onclick: () => this._remove(topic) }, "✕"),
          entry.line);
        this._tell(entry);
        return row;
      }),
      (this.choices || []).length ? h("h4", {}, "Add") : !this.topics.length && h("p.muted", {}, "No topics that can be drawn are published: scans, clouds, maps, markers, paths, poses."),
      (this.choices || []).map((topic) => h("button.quiet.add", { title: this.types[topic], onclick: () => this._add(topic) }, "+ ", h("span.mono", {}, topic), " ", h("span.muted", {}, this.TYPES[this.types[topic]]))));
  }

  _tell({ display, line, trouble }) {
    if (!line) return;
    const problem = trouble || display.problem;
    line.className = `word${problem ? " wrong" : " muted"}`;
    const text = problem || display.word;
    if (line.textContent !== text) line.textContent = text;
  }

  _use(name) {
    const before = this.using;
    this.tool?.close();
    this.tool = null;
    this.using = "";
    this.word.hidden = true;
    if (name !== before && this.stage) {
      this.using = name;
      const { ArrowTool, MeasureTool } = this.tools;
      this.tool = name === "measure"
        ? new MeasureTool(this.stage, (text) => this._say(text))
        : new ArrowTool(this.stage, name === "goal" ? 0xae3ec9 : 0x2f9e44, (x, y, yaw) => this._publish(name, x, y, yaw));
      if (name !== "measure") this._say("press at the place, and release in the direction");
    }
    for (const [each, button] of this.buttons) button.setAttribute("aria-pressed", String(each === this.using));
  }

  _say(text) {
    this.word.hidden = !text;
    fill(this.word, text);
  }

  async _publish(name, x, y, yaw) {
    const pose = { position: { x, y, z: 0 }, orientation: { x: 0, y: 0, z: Math.sin(yaw / 2), w: Math.cos(yaw / 2) } };
    const [topic, type, value] = this.tools.MESSAGES[name](pose, this._fixedFrame());
    this._use(name);
    try {
      const { subscribers } = await this.place.robot.call("topics.publish", { topic, type, value });
      this._say(`${topic}: (${x.toFixed(2)}, ${y.toFixed(2)}), ${(yaw * 180 / Math.PI).toFixed(0)}°, to ${subscribers} subscriber${subscribers === 1 ? "" : "s"}`);
    } catch (error) {
      this._say(error.message);
    }
  }

  async _png() {
    if (this.stage) save("scene.png", await this.stage.png(), "image/png");
  }
}
