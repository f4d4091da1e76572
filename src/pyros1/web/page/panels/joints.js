// The joints of a robot with sliders, like joint_state_publisher_gui.

import { command, empty, fill, h } from "../lib/dom.js";
import { number, plural } from "../lib/format.js";

const DEGREES = 180 / Math.PI;
const MIN_STEPS = 500; // minimum number of steps of a slider
const FOLLOW_DELAY = 600; // milliseconds after the user moves a slider during which it does not follow the robot
// The 3D panel beside the sliders: only the robot, without the names of its frames.
const SCENE_SETTINGS = { hidden: ["frames"] };

export default {
  title: "Joints",
  description: "joints of the robot, with sliders",
  order: 42,
  layout: { split: "row", sizes: [3, 2], parts: [{ panel: "scene", settings: SCENE_SETTINGS }, { panel: "joints" }] },
  mount: (place) => new Joints(place),
};

class Joints {
  constructor(place) {
    this.place = place;
    this.degrees = place.settings.degrees === true;
    this.rows = [];
    this.facts = null;
    this.pending = {}; // joint -> new position, not yet sent
    this.published = {}; // joint -> position, for the joints that this panel publishes
    this.sendRequest = 0;
    if (!document.getElementById("joints-style")) {
      document.head.append(h("link", { id: "joints-style", rel: "stylesheet", href: "panels/joints.css" }));
    }
    this._build();
    this.args = { description: place.settings.description || "/robot_description" };
    this._open();
  }

  unmount() {
    cancelAnimationFrame(this.sendRequest);
    this.stream.close();
  }

  _open() {
    this.stream?.close();
    this.stream = this.place.robot.stream("joints", this.args, {
      data: (data) => this._receive(data),
      problem: (text) => { this.problem = text; this._sendPositions(); },
    });
  }

  _build() {
    const { body, tools } = this.place;
    this.search = h("input", { placeholder: "find joints", "aria-label": "find joints", size: 10, oninput: () => this._filter() });
    this.unit = h("button", { title: "radians or degrees", onclick: () => { this.degrees = !this.degrees; this._save(); this._numbers(); } }, this.degrees ? "deg" : "rad");
    this.centre = h("button", { title: "move all joints to zero", disabled: true, onclick: () => this._moveAll((joint) => joint.zero) }, "Centre");
    this.random = h("button", { title: "move all joints to random positions within their limits", disabled: true, onclick: () => this._moveAll(randomPosition) }, "Randomize");
    this.stop = h("button", { title: "stop publishing the joints", hidden: true, onclick: () => this._publish(false) }, "Stop publishing");
    this.robotChoice = h("select.mono", { "aria-label": "robot", hidden: true, onchange: () => this._describe(this.robotChoice.value) });
    this.count = h("span.muted");
    tools.append(this.robotChoice, this.search, this.centre, this.random, this.unit, this.stop, this.count);
    this.hint = h("div.joints-hint", { hidden: true });
    this.list = h("div.joints-list");
    body.classList.add("joints");
    body.append(this.hint, this.list);
  }

  _save() {
    this.place.save({ description: this.args.description, degrees: this.degrees });
  }

  _describe(name) {
    this.args = { description: name };
    this._save();
    this._open();
  }

  _publish(on) {
    this.published = {};
    this.args = { ...this.args, publish: on, positions: this.published };
    this.stream.change(this.args);
  }

  _receive({ facts, positions }) {
    this.problem = "";
    if (facts) {
      const before = JSON.stringify(this.facts?.joints);
      this.facts = facts;
      if (JSON.stringify(facts.joints) !== before || !facts.joints.length) this._draw();
      this._state();
    }
    if (positions) {
      this.rows.forEach((row, index) => row.reported(positions[index]));
    }
    this._sendPositions();
  }

  // Describe the robot, who publishes, and whether the sliders have any effect.
  _state() {
    const { facts } = this;
    const readOnly = this.place.robot.about.read_only;
    this.movable = facts.movable && !readOnly;
    for (const row of this.rows) row.enable(this.movable);
    this.centre.disabled = this.random.disabled = !this.movable;
    this.stop.hidden = !facts.publishing;
    const names = [...new Set([facts.description, ...facts.descriptions])];
    this.robotChoice.hidden = names.length < 2;
    fill(this.robotChoice, names.map((name) => h("option", { value: name, selected: name === facts.description }, name)));
    fill(this.count, facts.joints.length ? plural(facts.joints.length + facts.more, "joint") : "");
    const free = facts.there && facts.joints.length && !facts.movable;
    this.hint.hidden = !free;
    if (!free) return;
    if (facts.publishers.length) {
      fill(this.hint, h("span", {}, "View only: ", h("b.mono", {}, facts.publishers.join(", ")), " does not accept positions from here."));
    } else {
      fill(this.hint, h("span", {}, "No node publishes ", h("b.mono", {}, facts.topic), "."),
        h("button.primary", { disabled: readOnly, onclick: () => this._publish(true) }, "Publish from here"),
        h("span.muted", {}, "or, in a terminal: ", command("pyros1 run joint_state_publisher_gui joint_state_publisher_gui")));
    }
  }

  _draw() {
    const { facts } = this;
    this.rows = facts.joints.map((joint) => new Row(joint, this));
    if (!facts.there) {
      fill(this.list, empty("No robot here", `Its URDF would be in the parameter ${facts.description}, which a launch file sets. Try:`,
        command("pyros1 launch two_wheeler display.launch")));
    } else if (!facts.joints.length) {
      fill(this.list, empty("No movable joints", "The robot's description has no movable joints."));
    } else {
      fill(this.list, this.rows.map((row) => row.element),
        facts.more ? h("p.muted.joints-more", {}, `and ${plural(facts.more, "joint")} more, which are not shown`) : null);
    }
    this._numbers();
    this._filter();
  }

  _numbers() {
    fill(this.unit, this.degrees ? "deg" : "rad");
    for (const row of this.rows) row.draw(true);
  }

  _filter() {
    const word = this.search.value.toLowerCase();
    for (const row of this.rows) row.element.hidden = !row.joint.name.toLowerCase().includes(word);
  }

  _moveAll(place) {
    for (const row of this.rows) if (!row.joint.follows && !row.element.hidden) row.move(place(row.joint, row));
  }

  // Send a position that the user has chosen. Positions are sent at most once per frame, however often a slider moves.
  moved(name, position) {
    this.pending[name] = position;
    this.sendRequest ||= requestAnimationFrame(() => {
      this.sendRequest = 0;
      const { publishing } = this.facts;
      if (publishing) Object.assign(this.published, this.pending);
      this.args = { ...this.args, publish: publishing, positions: publishing ? this.published : this.pending };
      this.stream.change(this.args);
      this.args.positions = this.published; // after a reconnect, nothing may move by itself
      this.pending = {};
    });
  }

  _sendPositions() {
    this.place.problem(this.problem || this.facts?.problem || "");
  }
}

class Row {
  constructor(joint, panel) {
    this.joint = joint;
    this.panel = panel;
    this.position = null;
    this.lastTouch = -Infinity;
    const { name, type, lower, upper, follows } = joint;
    this.step = 10 ** Math.floor(Math.log10((upper - lower || 1) / MIN_STEPS));
    this.slider = h("input", {
      type: "range", "aria-label": name, title: "double-click: move to zero", disabled: true, min: lower, max: upper, step: "any", value: joint.zero,
      oninput: () => this.move(this.round(Number(this.slider.value))),
      ondblclick: () => this.move(joint.zero),
    });
    this.field = h("input.joints-number", {
      "aria-label": `position of ${name}`, disabled: true, inputMode: "decimal", size: 7,
      onchange: () => this._typed(), onfocus: () => this.field.select(), onblur: () => this.draw(),
    });
    this.ends = [h("span.muted"), h("span.muted")];
    this.element = h("div.joints-row", { dataset: { joint: name }, className: `joints-row${follows ? " follows" : ""}` },
      h("span.joints-name.mono", { title: name }, name),
      h("span.joints-kind.muted", { title: follows ? `follows ${follows}` : type }, follows ? `follows ${follows}` : type),
      this.field, this.unit = h("span.joints-unit.muted"), h("span.joints-range", {}, this.ends[0], this.slider, this.ends[1]));
  }

  enable(on) {
    this.slider.disabled = this.field.disabled = !on || Boolean(this.joint.follows);
  }

  // Called when the robot reports a joint's position, perhaps only once.
  reported(position) {
    clearTimeout(this.lastReported);
    const left = FOLLOW_DELAY - (performance.now() - this.lastTouch);
    if (left > 0) this.lastReported = setTimeout(() => this.reported(position), left);
    else if (position !== this.position) {
      this.position = position;
      this.draw();
    }
  }

  move(position) {
    this.lastTouch = performance.now();
    this.position = position;
    this.draw();
    this.panel.moved(this.joint.name, position);
  }

  // Format rounded numbers, but never round the limits.
  round(value) {
    const { lower, upper } = this.joint;
    return Math.min(Math.max(Number((Math.round(value / this.step) * this.step).toPrecision(12)), lower), upper);
  }

  _typed() {
    const typed = Number(this.field.value.trim().replace(",", ".") || "x") / this._scale();
    this.field.classList.toggle("wrong", !Number.isFinite(typed));
    if (Number.isFinite(typed)) this.move(Math.min(Math.max(typed, this.joint.lower), this.joint.upper));
  }

  _scale() {
    return this.joint.type !== "prismatic" && this.panel.degrees ? DEGREES : 1;
  }

  // always: also update a field that is being edited, since its unit has changed.
  draw(always = false) {
    const scale = this._scale();
    const { position, joint } = this;
    const shown = (value) => number(Number((value * scale).toFixed(scale === 1 ? 4 : 2)));
    fill(this.unit, joint.type === "prismatic" ? "m" : scale === 1 ? "rad" : "°");
    fill(this.ends[0], shown(joint.lower));
    fill(this.ends[1], shown(joint.upper));
    if (always || document.activeElement !== this.field || performance.now() - this.lastTouch < FOLLOW_DELAY) {
      this.field.value = position === null || position === undefined ? "" : shown(position);
      this.field.classList.remove("wrong");
    }
    this.slider.value = position ?? joint.zero;
    this.element.classList.toggle("outside", position !== null && (position < joint.lower - 1e-9 || position > joint.upper + 1e-9));
  }
}

function randomPosition({ lower, upper }, row) {
  return row.round(lower + Math.random() * (upper - lower));
}
