// An editor for a message: a form and YAML text, kept in sync.

import { h } from "../lib/dom.js";
import { Form } from "./form.js";
import { outcome, tabbed } from "./widgets.js";

const PARSE_DELAY = 250; // milliseconds after the last key until the text is parsed

export class Editor {
  // form: result of topics.form, services.form or actions.form; part: "request" for services.
  constructor(robot, form, /** @type {{part?: string, onchange?: () => void}} */ { part, onchange = () => {} } = {}) {
    this.robot = robot;
    this.form = form;
    this.part = part;
    this.onchange = onchange;
    this.value = structuredClone(form.default);
    if (this.value.header?.stamp && form.fields[0]?.[1] === "std_msgs/Header") this.value.header.stamp = "now";
    this.problem = "";
    this.reading = null;
    this.outcome = outcome();
    this.tabs = tabbed([["Form", () => this._asForm()], ["YAML", () => this._asText()]]);
    this.element = h("div.editor", {}, this.tabs.element, this.outcome.element);
  }

  // Return the message, after parsing the text. If the text is invalid, the promise rejects with an empty error message, since the reason is shown already.
  async message() {
    if (this.timer) await this._read();
    await this.reading;
    if (this.problem) throw new Error("");
    return this.value;
  }

  _setProblem(problem) {
    this.problem = problem;
    this.outcome.fail(problem);
    this.onchange();
  }

  _asForm() {
    const form = new Form(this.form.fields, this.value, () => this._setProblem(form.problem));
    this._setProblem("");
    return { element: form.element };
  }

  _asText() {
    this._setProblem("");
    this.area = h("textarea.mono.yaml", { rows: 12, spellcheck: false, "aria-label": "the message as YAML", oninput: () => {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this._read(), PARSE_DELAY);
    } });
    this.robot.call("forms.yaml", { value: this.value }).then((text) => {
      this.area.value = text;
      this.area.rows = Math.max(4, Math.min(24, text.split("\n").length));
    }, (error) => this._setProblem(error.message));
    return { element: this.area, close: () => { if (this.timer) this._read(true); } };
  }

  _read(again = false) {
    clearTimeout(this.timer);
    this.timer = 0;
    const yaml = this.area.value;
    this.reading = this.robot.call("forms.value", { type: this.form.name || this.form.type, part: this.part, yaml }).then((value) => {
      this.value = value;
      this._setProblem("");
      if (again) this.tabs.choose(0);
    }, (error) => this._setProblem(error.message));
    return this.reading;
  }
}
