// An action's goals with states, feedback and results, a form to send one, and buttons to cancel.

import { fill, h } from "../lib/dom.js";
import { clock } from "../lib/format.js";
import { Editor } from "./editor.js";
import { copyable, outcome } from "./widgets.js";
import { Tree } from "./tree.js";

const STATUS_NAMES = ["pending", "active", "preempted", "succeeded", "aborted", "rejected", "preempting", "recalling", "recalled", "lost"];
const UNFINISHED = new Set([0, 1, 6, 7]);

export class Action {
  constructor(robot, name) {
    this.robot = robot;
    this.name = name;
    this.goals = new Map(); // id -> {element, update}
    this.outcome = outcome();
    this.list = h("div.goals", {}, h("p.muted.hint", {}, "No goals yet."));
    this.sender = h("div");
    this.element = h("div.action", {}, h("h4", {}, "Action ", copyable(name)), this.sender, this.outcome.element, this.list);
    this.stream = robot.stream("action", { action: name }, {
      data: ({ goals }) => this._show(goals),
      problem: (text) => text && this.outcome.fail(text),
    });
    if (!robot.about.read_only) this._form();
  }

  close() {
    this.stream.close();
  }

  async _form() {
    try {
      const form = await this.robot.call("actions.form", { action: this.name });
      const editor = new Editor(this.robot, form);
      const send = async () => {
        try {
          const { subscribers } = await this.robot.call("actions.send", { action: this.name, value: await editor.message() });
          if (subscribers) this.outcome.say("sent");
          else this.outcome.fail("no server received the goal");
        } catch (error) {
          this.outcome.fail(error.message);
        }
      };
      fill(this.sender, editor.element, h("div.actions", {}, h("button.primary", { onclick: send }, "Send goal"),
        h("button", { onclick: () => this._cancel("") }, "Cancel all")));
    } catch (error) {
      fill(this.sender, h("p.wrong.hint", {}, error.message));
    }
  }

  async _cancel(id) {
    try {
      await this.robot.call("actions.cancel", { action: this.name, id });
    } catch (error) {
      this.outcome.fail(error.message);
    }
  }

  _show(goals) {
    if (!goals.length) return;
    const unused = new Set(this.goals.keys());
    const elements = goals.map((goal) => {
      unused.delete(goal.id);
      if (!this.goals.has(goal.id)) this.goals.set(goal.id, this._goal(goal));
      const shown = this.goals.get(goal.id);
      shown.update(goal);
      return shown.element;
    });
    for (const id of unused) this.goals.delete(id);
    if (elements.some((element, index) => this.list.children[index] !== element) || this.list.children.length !== elements.length) fill(this.list, elements);
  }

  _goal({ id, stamp }) {
    const state = h("b.status");
    const text = h("span.muted");
    const feedback = new Tree({});
    const result = new Tree({});
    const feedbackPart = h("div", { hidden: true }, h("span.muted", {}, "feedback"), feedback.element);
    const resultPart = h("div", { hidden: true }, h("span.muted", {}, "result"), result.element);
    const cancel = h("button", { onclick: () => this._cancel(id) }, "Cancel");
    const element = h("div.goal", {}, h("div.actions", {}, state, h("span.muted", {}, clock(stamp)), text, h("span.gap"), !this.robot.about.read_only && cancel),
      h("div.muted.mono.id", {}, id), feedbackPart, resultPart);
    return { element, update: (goal) => {
      const word = STATUS_NAMES[goal.status] || String(goal.status);
      fill(state, word);
      state.className = `status ${word}`;
      fill(text, goal.text);
      cancel.hidden = !UNFINISHED.has(goal.status);
      feedbackPart.hidden = !goal.feedback;
      resultPart.hidden = !goal.result;
      if (goal.feedback) feedback.show(goal.feedback);
      if (goal.result) result.show(goal.result);
    } };
  }
}
