// A gamepad connected to this computer, published as sensor_msgs/Joy like joy_node does.

import { command, empty, fill, h } from "../lib/dom.js";
import { JoyReader, ORDERS, Sender, inputNames } from "../lib/gamepad.js";
import { plural } from "../lib/format.js";
import { outcome } from "../parts/widgets.js";

const TELEOP = "pyros1 run teleop_twist_joy teleop_node _enable_button:=2 _axis_linear:=1 _axis_angular:=0";
const AWAY = 500; // milliseconds without a state after which the server assumes that the gamepad was released
const DEFAULTS = { topic: "/joy", frame: "gamepad", deadzone: 0.05, hz: 20, order: "xbox" };

export default {
  title: "Gamepad",
  description: "a gamepad connected to this computer, as the robot's joystick",
  order: 78,
  rare: true,
  mount: (place) => new Gamepads(place),
};

class Gamepads {
  constructor(place) {
    this.place = place;
    this.settings = { ...DEFAULTS, ...place.settings };
    if (!ORDERS[this.settings.order]) this.settings.order = DEFAULTS.order;
    this.fields = {};
    this.frameRequest = 0;
    this.frameAt = 0; // when the gamepad was read last
    this.outcome = outcome();
    this.reader = new JoyReader(this.settings.order);
    this.pad = null;
    this.choice = null; // the chosen pad, kept while it is unplugged
    this.idle = ""; // why the gamepad counts as released; "" if it does not
    this.stream = null;
    this.sender = null;
    if (!document.getElementById("gamepad-style")) {
      document.head.append(h("link", { id: "gamepad-style", rel: "stylesheet", href: "panels/gamepad.css" }));
    }
    this._build();
    // Publishing must not restart by itself after a reconnect, perhaps much later.
    this.onState = () => {
      if (this.stream && place.robot.state !== "connected") this._stop("the connection was lost, so publishing has stopped");
    };
    this.onAbout = () => this._state();
    place.robot.addEventListener("state", this.onState);
    place.robot.addEventListener("about", this.onAbout);
    // A hidden page draws nothing, so these events must release the gamepad.
    this.onLeave = () => this._update(null);
    document.addEventListener("visibilitychange", this.onLeave);
    window.addEventListener("blur", this.onLeave);
    this._frame();
  }

  unmount() {
    cancelAnimationFrame(this.frameRequest);
    this._stop();
    this.place.robot.removeEventListener("state", this.onState);
    this.place.robot.removeEventListener("about", this.onAbout);
    document.removeEventListener("visibilitychange", this.onLeave);
    window.removeEventListener("blur", this.onLeave);
  }

  _build() {
    const { body, tools } = this.place;
    const { settings } = this;
    this.padChoice = h("select", { "aria-label": "gamepad", hidden: true, onchange: () => this._choose(JSON.parse(this.padChoice.value)) });
    this.publish = h("button.primary", { "aria-pressed": "false", onclick: () => (this.stream ? this._stop() : this._start()) }, "Publish");
    tools.append(this.padChoice, this.publish);
    const field = (label, name, props) => {
      const input = h("input", { value: settings[name], "aria-label": label, ...props, onchange: () => this._set(name, input) });
      this.fields[name] = input;
      return h("label.check", {}, label, input);
    };
    this.order = h("select", { "aria-label": "order", onchange: () => this._setOrder() },
      Object.entries(ORDERS).map(([name, { title }]) => h("option", { value: name, selected: name === settings.order }, title)));
    this.controls = h("div.gamepad-controls", {},
      field("topic", "topic", { className: "mono", size: 14 }),
      field("frame", "frame", { className: "mono", size: 10 }),
      field("dead zone", "deadzone", { type: "number", className: "num", min: 0, max: 0.9, step: 0.01 }),
      field("Hz", "hz", { type: "number", className: "num", min: 5, max: 100, step: 1, title: "how often an unchanged state is published" }),
      h("label.check", { title: "which axis and button has which number" }, "numbered", this.order));
    const missing = "getGamepads" in navigator ? "Connect one to this computer and press one of its buttons: browsers show a gamepad only then."
      : "This browser allows only pages at localhost or https addresses to use gamepads. From another machine, use a tunnel: ssh -L 9090:localhost:9090 ROBOT";
    this.hint = h("div.hint", {}, empty("No gamepad yet", missing,
      h("span", {}, "To turn its state into commands for a robot: ", command(TELEOP))));
    this.name = h("div.gamepad-name.muted");
    this.axes = h("div.gamepad-axes");
    this.buttons = h("div.gamepad-buttons");
    this.shown = h("div.gamepad-shown", { hidden: true }, this.name, this.axes, this.buttons);
    body.classList.add("gamepad");
    body.append(this.controls, this.outcome.element, this.hint, this.shown);
    this._state();
  }

  _set(name, input) {
    const value = input.type === "number" ? Number(input.value) : input.value.trim();
    if (!input.checkValidity() || value === "" || input.value === "") input.value = this.settings[name];
    else this.settings[name] = value;
    this.place.save(this.settings);
  }

  _setOrder() {
    this.settings.order = this.order.value;
    this.place.save(this.settings);
    if (this.pad) this._adopt(this.pad);
  }

  _state() {
    const readOnly = this.place.robot.about.read_only;
    this.publish.disabled = !this.stream && (readOnly || !this.pad);
    this.publish.title = readOnly ? "this server is read-only" : "publish this gamepad while this window is in use";
    this.publish.setAttribute("aria-pressed", String(Boolean(this.stream)));
    fill(this.publish, this.stream ? "Stop" : "Publish");
    this.fields.topic.disabled = this.fields.frame.disabled = this.order.disabled = Boolean(this.stream);
  }

  _args(state) {
    return { topic: this.settings.topic, frame_id: this.settings.frame, hz: this.settings.hz, state };
  }

  _start() {
    this.stream = this.place.robot.stream("gamepad", this._args(null), {
      data: (status) => this._report(status),
      problem: (text) => text && this._stop(text),
    });
    this.sender = new Sender((state) => this.stream.change(this._args(state)));
    this.outcome.say("");
    this._state();
  }

  _stop(problem = "") {
    this.stream?.close(); // the server then publishes a state with everything released
    this.stream = this.sender = null;
    this.status = null;
    this.outcome.fail(problem);
    this._state();
  }

  _report(status) {
    this.status = status;
    this._say();
  }

  _say() {
    if (!this.stream || !this.status) return;
    const { topic, sent, subscribers, problem } = this.status;
    if (problem || this.idle) this.outcome.fail(problem || this.idle);
    else this.outcome.say(`${topic}: ${sent} sent; ${plural(subscribers, "subscriber")}`);
  }

  // Read the gamepad whenever the browser draws.
  _frame() {
    this.frameRequest = requestAnimationFrame(() => this._frame());
    const pads = connectedPads();
    this._list(pads);
    // While a gamepad is published, no other one replaces it.
    const pad = pads.find((each) => isSame(each, this.choice)) ?? (this.stream ? null : pads[0]) ?? null;
    if (pad && !(this.pad && isSame(pad, this.pad))) this._adopt(pad);
    else if (!pad && this.pad) this._lose();
    this.pad = pad;
    const before = this.idle;
    this.idle = !pad ? "the gamepad is gone, so everything is released" : inUse() ? "" : "this window is not in use, so everything is released";
    // If the user returns with a stick pushed, the robot does not move until the stick does; also after the page was frozen.
    const now = performance.now();
    if ((before && !this.idle) || now - this.frameAt > AWAY) this.reader = new JoyReader(this.settings.order);
    this.frameAt = now;
    const state = pad && this.reader.read(pad, this.settings.deadzone);
    if (state) this._draw(state);
    this._update(this.idle ? null : state);
  }

  _update(state) {
    if (!this.sender) return;
    this.sender.update(state, performance.now());
    this._say();
  }

  _list(pads) {
    const text = JSON.stringify(pads.map(({ index, id }) => [index, id]));
    if (text === this.listed) return;
    this.listed = text;
    this.padChoice.hidden = pads.length < 2;
    fill(this.padChoice, pads.map((pad) => h("option", { value: JSON.stringify([pad.index, pad.id]), selected: isSame(pad, this.choice) }, pad.id)));
  }

  _choose([index, id]) {
    this._stop();
    this.choice = { index, id };
  }

  // Show a gamepad that was chosen or plugged in.
  _adopt(pad) {
    this.choice = { index: pad.index, id: pad.id };
    this.pad = pad;
    this.reader = new JoyReader(this.settings.order);
    const named = inputNames(pad, this.settings.order);
    const state = this.reader.read(pad, this.settings.deadzone);
    const row = (_, index) => {
      const bar = h("span.gamepad-bar");
      const value = h("span.gamepad-value.mono");
      const element = h("div.gamepad-axis", { dataset: { axis: index } }, h("span.mono", {}, index), h("span.muted", {}, named.axes[index] ?? ""),
        h("span.gamepad-track", {}, bar), value);
      return { element, bar, value };
    };
    this.rows = state.axes.map(row);
    this.chips = state.buttons.map((_, index) => h("span.gamepad-button", { dataset: { button: index } }, h("b.mono", {}, index), h("span", {}, named.buttons[index] ?? "")));
    fill(this.name, pad.id, pad.mapping !== "standard" && h("p", {}, "The browser does not know this gamepad, so its axes and buttons keep the browser's numbers."));
    fill(this.axes, this.rows.map(({ element }) => element));
    fill(this.buttons, this.chips);
    this.hint.hidden = true;
    this.shown.hidden = false;
    this._state();
  }

  _lose() {
    this.pad = null;
    this.hint.hidden = false;
    this.shown.hidden = true;
    this._state();
  }

  _draw({ axes, buttons }) {
    axes.forEach((value, index) => {
      const { bar, value: text } = this.rows[index];
      // Left is positive, as in the message.
      bar.style.left = `${50 - 50 * Math.max(value, 0)}%`;
      bar.style.width = `${50 * Math.abs(value)}%`;
      const written = value.toFixed(2);
      if (text.textContent !== written) fill(text, written);
    });
    buttons.forEach((value, index) => this.chips[index].classList.toggle("pressed", value === 1));
  }
}

function connectedPads() {
  return [...(navigator.getGamepads?.() ?? [])].filter((each) => each !== null && each.connected);
}

function isSame(one, other) {
  return one.index === other?.index && one.id === other?.id;
}

// Whether this page is visible and has the keyboard focus.
function inUse() {
  return document.visibilityState === "visible" && document.hasFocus();
}
