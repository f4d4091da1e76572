// Details of a launched process, and the end of its log.

import { fill, h } from "../../lib/dom.js";
import { bytes, duration } from "../../lib/format.js";
import { copyable, definitionList as list, outcome } from "../widgets.js";
import { commandButton, commandsFor } from "./commands.js";

export class ProcessDetails {
  constructor(panel, key, facts, entry) {
    this.panel = panel;
    this.key = key;
    this.result = outcome();
    this.facts = h("div");
    this.actions = h("div.actions");
    this.more = h("div");
    this.logs = h("div.logs", {}, h("p.muted.hint", {}, "…"));
    this.element = h("div.about.process-about", {}, h("h3", {}, copyable(entry.node || entry.label)), h("span.muted", {}, facts.title),
      this.actions, this.result.element, this.facts, this.more, h("h4", {}, "Log"), this.logs);
    const args = { launch: facts.param, process: entry.label };
    const { robot } = panel.place;
    robot.call("launches.info", args).then(({ command, cwd }) => fill(this.more, list([
      command && ["command", copyable(command)], cwd && ["folder", h("span.mono", {}, cwd)],
    ])), (error) => fill(this.more, h("p.muted.hint", {}, error.message)));
    this.stream = robot.stream("launch_log", args, {
      data: (data) => this._showLogs(data),
      problem: (text) => { if (text) fill(this.logs, h("p.muted.hint", {}, text)); },
    });
    this.update({ facts, entry });
  }

  close() {
    this.stream.close();
  }

  update(now) {
    if (!now) {
      this.result.fail("this process and its launch are gone");
      fill(this.actions);
      return;
    }
    const { facts, entry } = now;
    const restarts = Math.max(0, entry.starts - 1);
    fill(this.facts, list([
      ["state", h(`span.is-${entry.state}`, {}, h("i.lamp"), ` ${entry.state}`, entry.exit && `, ${entry.exit}`)],
      entry.pid && ["process", entry.pid],
      entry.machine && ["machine", entry.machine],
      entry.uptime !== null && ["runs for", duration(entry.uptime)],
      entry.cpu !== null && ["CPU", `${entry.cpu.toFixed(1)}%`],
      entry.memory !== null && ["memory", bytes(entry.memory)],
      ["restarts", String(restarts)],
      entry.respawn && ["respawn", "it is restarted whenever it exits"],
      entry.required && ["required", "its launch ends when it exits, but not if it is stopped here"],
    ]));
    const state = `${entry.state} ${facts.refusal} ${this.panel.place.robot.about.read_only}`;
    if (state === this.state) return;
    this.state = state;
    const launch = this.panel.launches.get(facts.param);
    fill(this.actions, commandsFor(launch, entry).map((verb) => commandButton(verb, false, () => this._sendCommand(verb, facts.param, entry))),
      h("button", { title: "the node's log, in the console", onclick: () => this.panel.place.open("console", { node: entry.node }) }, "Console"),
      h("button", { title: "its topics, services and loggers", onclick: () => this.panel.place.open("nodes", { selected: entry.node }) }, "Node"));
  }

  async _sendCommand(verb, param, entry) {
    try {
      await this.panel.sendCommand(verb, param, entry);
      this.result.say("");
    } catch (error) {
      this.result.fail(error.message);
    }
  }

  _showLogs({ files, base, folder }) {
    if (!files.length) {
      fill(this.logs, h("p.muted.hint", {}, base.startsWith(folder) ? `There is no log file ${base}*.log. With output="screen", a node's output goes only to its launch's terminal.`
        : `Its log files are not in this server's log folder, ${folder}, but at ${base}*.log`));
      return;
    }
    fill(this.logs, files.map(({ path, size, text }) => h("div.log-file", {},
      h("p.hint", {}, copyable(path, path.slice(path.lastIndexOf("/") + 1)), h("span.muted", {}, ` ${bytes(size)}`)),
      text ? h("pre.tail.mono", { tabIndex: 0 }, text) : h("p.muted.hint", {}, "empty"))));
    for (const element of this.logs.querySelectorAll(".tail")) element.scrollTop = element.scrollHeight;
  }
}
