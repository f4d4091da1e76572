// The parameters of a dynamic_reconfigure server: sliders, checkboxes, choices and texts, synchronised in both directions.

import { fill, h } from "../lib/dom.js";
import { number } from "../lib/format.js";
import { copyable, outcome } from "./widgets.js";

const MAX_SLIDER_RANGE = 1e6; // maximum range of a slider
const MIN_STEPS = 500; // minimum number of steps of a slider

export class Reconfigure {
  constructor(robot, node) {
    this.robot = robot;
    this.node = node;
    this.controls = new Map(); // name -> {set(value)}
    this.groups = new Map(); // path of a group -> {element, open, pendingRequests}; open: the state of the node, or the requested one
    this.states = []; // states of all groups, as reported by the node
    this.pending = null; // name -> value, to be sent next
    this.sent = null; // name -> value, sent to the node, which has not responded yet
    this.values = {};
    this.isBusy = false;
    this.outcome = outcome();
    this.list = h("div.configure", {}, h("p.muted.hint", {}, "…"));
    this.element = h("div.about", {}, h("h3", {}, copyable(node)), h("span.muted", {}, "dynamic_reconfigure"), this.list, this.outcome.element);
    this.stream = robot.stream("reconfigure", { node }, {
      data: (data) => this._receive(data),
      problem: (text) => this.outcome.fail(text),
    });
  }

  close() {
    this.stream.close();
  }

  _receive({ parameters, values, groups }) {
    const shape = JSON.stringify(parameters);
    if (shape !== this.shape) {
      this.shape = shape;
      this.types = Object.fromEntries(parameters.map((each) => [each.name, each.type]));
      this._build(parameters);
    }
    this.values = values;
    this._show();
    this.states = groups;
    this._showGroups();
  }

  // Open, close and hide groups as the node reports, but not those that the user has just opened or closed.
  _showGroups() {
    for (const { path, type, state } of this.states) {
      const group = this.groups.get(String(path));
      if (!group) continue; // an empty group
      group.element.hidden = type === "hide" && !state;
      const open = type !== "collapse" || state;
      if (open !== group.open && !group.pendingRequests) group.element.open = group.open = open;
    }
  }

  // Called when the user has opened or closed a group. For the type "collapse", the node stores that for all clients.
  async _groupToggled(key) {
    const group = this.groups.get(key);
    const its = ({ path, type }) => type === "collapse" && this.groups.get(String(path));
    if (group.element.open === group.open || !this.states.some((each) => its(each) === group)) return;
    group.open = group.element.open;
    if (this.losesGroupStates || this.robot.about.read_only) return;
    group.pendingRequests += 1;
    const groups = this.states.map((each) => ({ name: each.name, id: each.id, parent: each.parent, state: its(each) ? its(each).open : each.state }));
    try {
      await this.robot.call("reconfigure.turn", { node: this.node, groups });
    } catch (error) {
      this.losesGroupStates = true; // like Python servers in stock ROS
      this.outcome.say(`This node does not store which groups are closed: ${error.message}`);
    } finally {
      group.pendingRequests -= 1;
    }
  }

  // Parameters being changed here keep their values until the node has responded.
  _show() {
    for (const [name, value] of Object.entries(this.values)) {
      if (!Object.hasOwn({ ...this.pending, ...this.sent }, name)) this.controls.get(name)?.set(value);
    }
  }

  _build(parameters) {
    this.controls.clear();
    this.groups.clear();
    const rows = (list) => list.map((parameter) => {
      const control = this._control(parameter);
      this.controls.set(parameter.name, control);
      return h("div.row", { title: parameter.description }, h("span.label", {}, parameter.name), control.element,
        parameter.description && h("span.muted.what", {}, parameter.description));
    });
    // Groups are nested; those with parameters are in the node's order, with a group's own parameters first.
    const inside = (list, depth) => {
      const below = new Map();
      for (const each of list.filter(({ groups }) => groups.length > depth)) {
        const name = each.groups[depth];
        if (!below.has(name)) below.set(name, []);
        below.get(name).push(each);
      }
      return [rows(list.filter(({ groups }) => groups.length === depth)), [...below].map(([name, those]) => {
        const key = String(those[0].groups.slice(0, depth + 1));
        const element = h("details.group", { open: true, ontoggle: () => this._groupToggled(key) }, h("summary", {}, h("span.label", {}, name)), h("div.inner", {}, inside(those, depth + 1)));
        this.groups.set(key, { element, open: true, pendingRequests: 0 });
        return element;
      })];
    };
    fill(this.list, inside(parameters, 0));
    if (!parameters.length) fill(this.list, h("p.muted.hint", {}, "This server has no parameters."));
  }

  _control(parameter) {
    const { name, type, choices } = parameter;
    const disabled = this.robot.about.read_only;
    const label = { "aria-label": name, disabled };
    if (choices.length) {
      const select = h("select", { ...label, onchange: () => this._send(name, choices[Number(select.value)][1]) }, choices.map(([word, value], index) => h("option", { value: index }, `${word} (${value})`)));
      return { element: select, set: (value) => { select.value = String(choices.findIndex((each) => each[1] === value)); } };
    }
    if (type === "bool") {
      const box = h("input", { ...label, type: "checkbox", onchange: () => this._send(name, box.checked) });
      return { element: box, set: (value) => { box.checked = value; } };
    }
    if (type === "str") {
      const field = h("input.mono", { ...label, onchange: () => this._send(name, field.value) });
      return { element: field, set: (value) => { if (document.activeElement !== field) field.value = value; } };
    }
    return this._number(parameter, label);
  }

  _number({ name, type, min, max }, label) {
    const whole = type === "int";
    const bounded = min !== null && max !== null && max > min && max - min <= MAX_SLIDER_RANGE;
    const step = whole ? 1 : 10 ** Math.floor(Math.log10((max - min) / MIN_STEPS));
    const clean = (value) => (whole ? Math.round(value) : Number((Math.round(value / step) * step).toPrecision(9)));
    const field = h("input.num.mono", { ...label, type: "number", step: whole ? 1 : "any", min: bounded ? min : undefined, max: bounded ? max : undefined, onchange: () => {
      if (field.value !== "" && Number.isFinite(Number(field.value))) this._send(name, whole ? clean(Number(field.value)) : Number(field.value));
    } });
    const slider = bounded && h("input", { ...label, type: "range", min, max, step: whole ? 1 : "any", oninput: () => {
      const value = Math.min(max, Math.max(min, clean(Number(slider.value))));
      field.value = number(value, 6);
      this._send(name, value);
    } });
    const ends = bounded ? `${number(min)} to ${number(max)}` : "";
    return { element: h("span.ranged", { title: ends }, slider, field), set: (value) => {
      if (value === null) return;
      if (document.activeElement !== field) field.value = number(value, 6);
      if (slider && document.activeElement !== slider) slider.value = String(value);
      else if (slider && !this.isBusy) slider.value = String(value);
    } };
  }

  // One request at a time; changes made meanwhile are sent with the next one.
  async _send(name, value) {
    this.pending = { ...this.pending, [name]: value };
    if (this.isBusy) return;
    this.isBusy = true;
    try {
      while (this.pending) {
        const values = this.sent = this.pending;
        const before = this.values;
        this.pending = null;
        await this.robot.call("reconfigure.update", { node: this.node, values, types: this.types });
        this.sent = null;
        if (this.values !== before) this._show(); // the response is not displayed: other clients may have changed values since; the stream delivers the current ones
        this.outcome.say("");
      }
    } catch (error) {
      this.pending = this.sent = null;
      this._show();
      this.outcome.fail(error.message);
    } finally {
      this.isBusy = false;
    }
  }
}
