// The robot and its sensor data in 3D, like rviz.

import { empty, fill, h, save } from "../lib/dom.js";
import { ROBOT_DESCRIPTION, ROBOT_PREFIX, addableDisplays, imageTopics, parseKey } from "../lib/scene/display_kinds.js";
import { DisplayList } from "../lib/scene/display_list.js";
import { FixedChoice } from "../lib/scene/fixed_choice.js";
import { Toolbox } from "../lib/scene/toolbox.js";
import { ViewChoice } from "../lib/scene/view_choice.js";

const COLOURS = ["#1c7ed6", "#e8590c", "#2f9e44", "#9c36b5", "#e03131", "#0c8599", "#f08c00", "#6741d9"];
const LIBRARY_MODULES = ["stage", "displays", "frames", "tools", "robot_model", "interactive_markers", "interaction", "overlay", "camera_view", "efforts", "select_tool"];
const FRAMES_KEY = "frames"; // keys of displays; display_kinds.js describes the keys of all others
const GRID_KEY = "grid";

/**
 * A row of the list of displays.
 *
 * @typedef {object} Entry
 * @property {string} key
 * @property {string} title
 * @property {string} kind
 * @property {{close(): void, change(args: object): void}} stream
 * @property {string} [topic]
 * @property {any} [display]
 * @property {string} [trouble]
 * @property {string} [shownFrames]
 */

document.head.append(h("link", { rel: "stylesheet", href: "panels/scene.css" }));

export default {
  title: "3D",
  description: "the robot, frames, scans, clouds, maps, markers and paths in 3D",
  order: 40,
  mount: (place) => new Scene(place),
};

class Scene {
  constructor(place) {
    this.place = place;
    const { fixed, topics, robots, options, hidden, view, target, background } = place.settings; // links are untrusted input
    this.background = /^#[0-9a-f]{6}$/i.test(background) ? background : ""; // from an rviz file
    this.fixed = new FixedChoice(String(fixed || ""), () => this._fixedFrameChanged());
    this.topics = texts(topics) || []; // keys of displayed topics
    this.robots = texts(robots) || [ROBOT_DESCRIPTION]; // parameters with URDFs
    this.options = { ...options }; // key of a display -> the chosen options
    this.hidden = new Set(texts(hidden)); // keys
    this.look = new ViewChoice({ view, target }, { changed: () => this.saveSettings(), robot: () => this._robotAlone() });
    this.displays = new Map(); // key -> {key, topic, display, stream}
    this.types = {};
    this.toolbox = new Toolbox(this, place.settings.tools);
    this.list = this._displayList();
    this._build();
    const { notes } = place.settings; // what an rviz file contains, but this panel does not support
    if (texts(notes)?.length) this.say(notes.join("\n"));
    this.onAbout = () => this.toolbox.updatePermissions();
    place.robot.addEventListener("about", this.onAbout);
    this.toolbox.updatePermissions();
    this._loadLibrary();
  }

  // three.js is loaded only when needed: it is large.
  async _loadLibrary() {
    try {
      const parts = await Promise.all(LIBRARY_MODULES.map((name) => import(`../lib/scene/${name}.js`)));
      if (this.closed) return;
      this.lib = Object.assign({}, ...parts);
      this.stage = new this.lib.Stage(this.view);
      Object.assign(this.stage, { background: this.background }).colours();
    } catch (error) {
      fill(this.view, empty("No 3D here", `This browser cannot draw in 3D: ${error.message}`));
      return;
    }
    this.frames = new this.lib.FrameSet();
    this.look.begin(this.stage, this.frames);
    this.stage.before.push(() => this.frames.faceCamera(this.stage), () => this._reportFrameTimes());
    this.place.body.scene = this; // for tests and debugging
    this.onTheme = () => { this.frames.colours(); this.stage.colours(); };
    addEventListener("themechange", this.onTheme);
    const { robot } = this.place;
    this._addEntry({ key: FRAMES_KEY, display: this.frames, title: "TF", kind: "TF", fixed: true });
    this._addEntry({ key: GRID_KEY, display: this.stage.grid, title: "Grid", kind: "Grid", fixed: true });
    for (const name of this.robots) this._showRobot(name);
    for (const key of this.topics) this._show(key);
    this.mouse = new this.lib.Interaction(this.stage, {
      sets: () => [...this.displays.values()].map(({ display }) => display).filter((each) => each instanceof this.lib.InteractiveSet),
      fixed: () => this.fixedFrame(),
      publish: (topic, type, value) => robot.call("topics.publish", { topic, type, value }),
      onError: (text) => this.say(text),
    });
    this.toolbox.updatePermissions();
    this.system = robot.stream("system", {}, { data: (data) => this._system(data) });
    this.world = robot.stream("scene_frames", this._framesArgs(), {
      data: (data, blob) => this._frames(data, blob),
      problem: (text) => this.place.problem(text),
    });
    this.list.draw();
  }

  unmount() {
    this.closed = true;
    this.system?.close();
    this.world?.close();
    for (const key of [...this.displays.keys()]) this._hide(key);
    if (this.onTheme) removeEventListener("themechange", this.onTheme);
    this.place.robot.removeEventListener("about", this.onAbout);
    this.toolbox.close();
    this.mouse?.close();
    this.stage?.close();
  }

  accept(settings) {
    for (const topic of settings.topics || []) this._add(topic);
  }

  _build() {
    const { body, tools } = this.place;
    this.file = h("input", { type: "file", accept: ".rviz,.yaml,.yml", hidden: true, onchange: () => this._open(this.file) });
    const more = h("span.more", {}, h("label.check", {}, "follow", this.look.frames), this.toolbox.elements,
      h("button.quiet", { title: "back to the initial view", onclick: () => this.look.reset() }, "Reset"),
      h("button.quiet", { title: "save the image", onclick: () => this._png() }, "PNG"));
    tools.append(this.fixed.element, h("label.check", {}, h("span.what", {}, "view"), this.look.views, this.look.axes),
      h("button", { title: "show everything", onclick: () => this.look.fit([...this.displays.values()]) }, "Fit"),
      h("button.fold-tools", { "aria-expanded": "false", onclick: ({ currentTarget }) => currentTarget.setAttribute("aria-expanded", String(more.classList.toggle("open"))) }, "Tools"), more);
    this.view = h("div.view");
    this.status = h("div.word.mono", { hidden: true, role: "status" });
    this.pictures = h("div.pictures");
    this.view.append(this.pictures, this.status);
    body.classList.add("scene");
    body.append(this.list.element, this.view, this.file);
  }

  _displayList() {
    return new DisplayList(h("div.displays"), {
      entries: () => [...this.displays.values()],
      hidden: (key) => this.hidden.has(key),
      show: (key, shown) => this._setHidden(key, shown),
      remove: (key) => this._remove(key),
      option: (key, name, value) => this._option(key, name, value),
      offers: () => addableDisplays(this.types, this.topics, this.robots),
      open: () => this.file.click(),
      add: (key) => (key.startsWith(ROBOT_PREFIX) ? this._addRobot(key.slice(ROBOT_PREFIX.length)) : this._add(key)),
    });
  }

  saveSettings() {
    const { topics } = this.toolbox;
    this.place.save({ fixed: this.fixed.frame, topics: this.topics, robots: this.robots, options: this.options, hidden: [...this.hidden], view: this.look.stored, target: this.look.target, ...(this.background ? { background: this.background } : {}), ...(Object.keys(topics).length ? { tools: topics } : {}) });
  }

  _system(data) {
    this.types = Object.fromEntries(Object.entries(data.topics).map(([name, { type }]) => [name, type]));
    const offered = JSON.stringify([addableDisplays(this.types, this.topics, this.robots), this.topics.map((key) => [parseKey(key, this.types).kind, this.types[parseKey(key, this.types).topic]])]);
    if (offered === this.offered) return;
    this.offered = offered;
    for (const key of this.topics) { // the topic's type may have become known, or may have changed
      const { kind, topic } = parseKey(key, this.types);
      const { kind: before, display } = this.displays.get(key);
      if (!kind && !before) display.status = this._unknown(topic);
      if (!kind || before === kind) continue;
      this._hide(key);
      this._show(key);
    }
    this.list.draw();
  }

  // Explain why a topic has no display.
  _unknown(topic) {
    const type = this.types[topic];
    return type ? `there is no display of ${type}` : "no node publishes it yet";
  }

  _frames(data, blob) {
    this.lastFrames = data;
    this.frames.update(data, blob);
    const others = this._updateFrameChoices();
    for (const entry of this.displays.values()) {
      entry.display.place?.(this.frames);
      this.list.updateStatus(entry);
    }
    this.look.fitRobot(others); // the robot may have moved
    this.look.follow();
  }

  // The available frames: from tf, and from messages. Without tf, the first display's frame is the fixed frame.
  _updateFrameChoices() {
    const { fixed, names, lost } = this.lastFrames;
    const shownFrames = [...new Set([...this.displays.values()].map(({ display }) => display.frame).filter(Boolean))];
    const tf = names.length + lost.length > 0;
    this.firstFrame = tf ? "" : shownFrames[0] || "";
    const defaultText = this.firstFrame ? `${this.firstFrame} (there is no tf)` : this.fixed.frame ? (tf ? "the root" : "no frames yet") : `${tf ? "the root" : "no frames yet"} (${fixed})`;
    const all = [...new Set([...names, ...lost, ...shownFrames, this.fixed.frame, this.look.target])].filter(Boolean).sort();
    const others = this.fixed.offer(all, defaultText);
    if (others) {
      this.look.offer(all);
      if (!this.fixed.frame) this._restream();
    }
    const away = [...new Set([...lost, ...[...this.displays.values()].map(({ display }) => display.missingFrame).filter(Boolean)])];
    const { disconnected } = this.frames;
    const what = `no transform from ${this.fixedFrame()} to ${away.slice(0, 5).join(", ")}${away.length > 5 ? " …" : ""}`;
    this.place.problem(away.length ? `${what}${disconnected ? `: ${disconnected}` : ": choose another fixed frame"}, or publish a transform between them (tf)` : "");
    return others;
  }

  _fixedFrameChanged() {
    this.stage.followed = null;
    this.world.change(this._framesArgs());
    this._restream();
    this.saveSettings();
  }

  // The fixed frame: the chosen one, or the robot's root.
  _framesArgs() {
    const [robot] = this._robots();
    return { fixed: this.fixed.frame, robot: robot?.root || "" };
  }

  _restream() {
    for (const entry of this.displays.values()) if (entry.topic && entry.kind !== "Image") this.updateStream(entry); // an image without camera has no pose
  }

  // A browser that was slow may be able to draw more points again.
  _reportFrameTimes() {
    for (const entry of this.displays.values()) if (entry.topic && entry.display.reportFrame?.(this.stage.lag, false)) this.updateStream(entry);
  }

  updateStream(/** @type {Entry} */ { stream, display, topic }) {
    stream.change({ topic, fixed: this.fixedFrame(), ...display.args });
  }

  fixedFrame() {
    return this.fixed.frame || this.firstFrame || this.lastFrames?.fixed || "";
  }

  _add(key) {
    if (this.topics.includes(key)) return;
    this.topics.push(key);
    if (!this.stage) return; // the display will be created with the others, when three.js has been loaded
    this._show(key);
    this._changed();
  }

  _addRobot(name) {
    if (this.robots.includes(name)) return;
    this.robots.push(name);
    this._showRobot(name);
    this._changed();
  }

  _remove(key) {
    this.topics = this.topics.filter((each) => each !== key);
    this.robots = this.robots.filter((each) => ROBOT_PREFIX + each !== key);
    this.hidden.delete(key);
    delete this.options[key];
    this._hide(key);
    this._changed();
  }

  _changed() {
    this.saveSettings();
    this.offered = "";
    this.list.draw();
    this.stage.draw();
  }

  // Add a display to the scene, with its stored options.
  _addEntry(entry) {
    const { key, display } = entry;
    this.displays.set(key, entry);
    if (display.object) this.stage.scene.add(display.object);
    const chosen = Object.entries(this.options[key] || {}).filter(([name, value]) => typeof value === typeof (display.options?.[name] ?? true));
    if (chosen.length) display.set?.(Object.fromEntries(chosen));
    display.show?.(!this.hidden.has(key));
    return entry;
  }

  _showRobot(name) {
    const display = new this.lib.RobotModel(this.place.robot.token, () => {
      this.look.fitRobot(true);
      this._displayChanged(entry);
    });
    const entry = this._addEntry({ key: ROBOT_PREFIX + name, title: name, kind: "RobotModel", display });
    entry.stream = this.place.robot.stream("param", { param: name }, {
      data: (data) => { display.update(data); display.place(this.frames); this.world?.change(this._framesArgs()); this.look.fitRobot(true); this._displayChanged(entry); },
      problem: (text) => { entry.trouble = text; this.list.updateStatus(entry); },
    });
  }

  _show(key) {
    const { topic, kind, view } = parseKey(key, this.types);
    const { stage, frames } = this;
    const changed = (what) => this._displayChanged(entry, what);
    const { robot } = this.place;
    const host = { robot, token: robot.token, stage, frames, changed, pictures: () => imageTopics(this.types) };
    /** @type {Entry} */
    const entry = { key, title: key, kind, stream: { close() {}, change() {} } };
    if (kind === "InteractiveMarkers") {
      entry.display = new this.lib.InteractiveSet(topic, host);
      const feedback = { topic: `${entry.display.topic}/feedback`, type: "visualization_msgs/InteractiveMarkerFeedback" };
      robot.call("topics.advertise", feedback).catch(() => {}); // if it fails, a drag reports why
    } else if (kind === "Image") entry.display = new this.lib.Overlay(this.pictures, topic, changed);
    else if (kind === "Effort") entry.display = new this.lib.EffortSet(host);
    else if (kind === "Camera") entry.display = new this.lib.CameraView(this.pictures, topic, host);
    else entry.display = new this.lib.Display(COLOURS[(this.displays.size - 1) % COLOURS.length], kind, host);
    entry.display.inspect?.(this.toolbox.activeTool === "select");
    this._addEntry(entry);
    if (!kind) { // the kind of display is unknown until the topic's type is known
      entry.display.status = this._unknown(topic);
      return;
    }
    entry.topic = topic;
    entry.stream = robot.stream(view, { topic, fixed: this.fixedFrame(), ...entry.display.args }, {
      data: (data, blob) => {
        const shown = entry.display.update(data, blob);
        entry.display.place?.(this.frames);
        if (entry.display.reportFrame?.(this.stage.lag, true)) this.updateStream(entry);
        this._displayChanged(entry);
        return shown;
      },
      problem: (text) => { entry.trouble = text; this.list.updateStatus(entry); },
    });
  }

  _displayChanged(entry, what) {
    const shownFrames = `${entry.display.frame} ${entry.display.missingFrame}`;
    if (this.lastFrames && shownFrames !== entry.shownFrames) {
      entry.shownFrames = shownFrames;
      this._updateFrameChoices();
    }
    if (what === "controls") this.list.draw();
    else this.list.updateStatus(entry);
    this.stage.draw();
  }

  _hide(key) {
    const entry = this.displays.get(key);
    if (!entry) return;
    this.displays.delete(key);
    entry.stream?.close();
    if (entry.display.object) this.stage.scene.remove(entry.display.object);
    entry.display.close?.();
    this.stage.draw();
  }

  _setHidden(key, shown) {
    if (shown) this.hidden.delete(key);
    else this.hidden.add(key);
    this.displays.get(key).display.show(shown);
    this.saveSettings();
    this.stage.draw();
  }

  _option(key, name, value) {
    const entry = this.displays.get(key);
    const { display } = entry;
    this.options[key] = { ...this.options[key], [name]: value };
    const before = JSON.stringify(display.args);
    display.set({ [name]: value });
    if (entry.topic && JSON.stringify(display.args) !== before) this.updateStream(entry);
    this.saveSettings();
    this.stage.draw();
  }

  // Fit a robot without other displays into the view, as soon as its shapes are loaded.
  _robotAlone() {
    if (this.topics.length) return null;
    const [robot] = this._robots();
    return robot && !robot.loading ? robot.object : null;
  }

  _robots() {
    return [...this.displays.values()].map(({ display }) => display).filter((each) => each instanceof this.lib.RobotModel && each.links.size);
  }

  say(text) {
    this.status.hidden = !text;
    fill(this.status, text);
  }

  async _open(input) {
    const [file] = input.files;
    input.value = ""; // so that the same file can be opened again
    if (!file) return;
    try {
      const { settings, notes } = await this.place.robot.call("scene.rviz", { text: await file.text() });
      this.place.restart(notes.length ? { ...settings, notes } : settings);
    } catch (error) {
      this.say(`${file.name} ${error.message}`);
    }
  }

  async _png() {
    if (this.stage) save("scene.png", await this.stage.png(), "image/png");
  }
}

function texts(list) {
  return Array.isArray(list) ? [...new Set(list.filter((each) => typeof each === "string"))] : undefined;
}
