// Publishes a message from a form: once, or at a rate while the page is open.

import { fill, h } from "../lib/dom.js";
import { clock, plural } from "../lib/format.js";
import { Editor } from "./editor.js";
import { outcome } from "./widgets.js";

export class Publisher {
  constructor(robot, topic, type) {
    this.robot = robot;
    this.topic = topic;
    this.element = h("div.publisher", {}, h("p.muted.hint", {}, "…"));
    this.outcome = outcome();
    this.stream = null;
    // Publishing must not restart by itself, perhaps much later.
    this.onState = () => {
      if (!this.stream || robot.state === "connected") return;
      this._stop();
      this.outcome.fail("the connection was lost, so publishing has stopped");
    };
    robot.addEventListener("state", this.onState);
    robot.call("topics.form", type ? { type } : { topic }).then((form) => this._build(form), (error) => {
      fill(this.element, h("p.wrong.hint", { role: "alert" }, error.message));
    });
  }

  close() {
    this.closed = true;
    this.robot.removeEventListener("state", this.onState);
    this._stop();
  }

  _build(form) {
    const editor = new Editor(this.robot, form, { onchange: () => this._changed() });
    this.form = form;
    this.editor = editor;
    this.rate = h("input.num", { type: "number", min: 0.01, max: 1000, step: "any", value: 10, "aria-label": "rate in Hz", onchange: () => this._changed() });
    this.latch = h("input", { type: "checkbox", onchange: () => this._changed() });
    this.repeat = h("button", { "aria-pressed": "false", onclick: () => (this.stream ? this._stop() : this._start(editor)) }, "Repeat");
    fill(this.element, editor.element,
      h("div.actions", {}, h("button.primary", { onclick: () => this._publishOnce(editor) }, "Publish"),
        this.repeat, h("label.check", {}, this.rate, "Hz"),
        h("label.check", { title: "later subscribers also receive the last message" }, this.latch, "latched")),
      this.outcome.element);
  }

  async _publishOnce(editor) {
    try {
      const { subscribers } = await this.robot.call("topics.publish", await this._args(editor));
      this.outcome.say(`${clock(Date.now() / 1000)}: sent to ${plural(subscribers, "subscriber")}`);
    } catch (error) {
      this.outcome.fail(error.message);
    }
  }

  async _args(editor) {
    return { topic: this.topic, type: this.form.type, value: await editor.message(), latch: this.latch.checked, hz: Number(this.rate.value) };
  }

  async _start(editor) {
    if (this.starting) return;
    this.starting = true;
    try {
      const args = await this._args(editor);
      if (this.closed) return;
      this.stream = this.robot.stream("publish", args, {
        data: ({ sent, subscribers, problem }) => (problem ? this.outcome.fail(problem) : this.outcome.say(`${sent} sent; ${plural(subscribers, "subscriber")}`)),
        problem: (text) => text && this.outcome.fail(text),
      });
      this.repeat.setAttribute("aria-pressed", "true");
      fill(this.repeat, "Stop");
    } catch (error) {
      this.outcome.fail(error.message);
    } finally {
      this.starting = false;
    }
  }

  _stop() {
    this.stream?.close();
    this.stream = null;
    this.repeat?.setAttribute("aria-pressed", "false");
    if (this.repeat) fill(this.repeat, "Repeat");
  }

  // Update the message that is published at a rate to the form's; an invalid form changes nothing.
  _changed() {
    if (!this.stream || !this.editor || this.editor.problem) return;
    const value = this.editor.value;
    this.stream.change({ topic: this.topic, type: this.form.type, value, latch: this.latch.checked, hz: Number(this.rate.value) });
  }
}
