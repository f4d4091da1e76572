// All nodes; for the selected one, its process, topics, services, logger levels and actions.

import { command, empty, fill, h } from "../lib/dom.js";
import { Action } from "../parts/action.js";
import { TablePanel } from "../parts/table_panel.js";
import { confirmButton, copyable, definitionList, nameLinks, outcome } from "../parts/widgets.js";

const LEVELS = ["debug", "info", "warn", "error", "fatal"];
const MAX_ACTIONS = 10;

export default {
  title: "Nodes",
  description: "nodes, their loggers and actions",
  order: 70,
  mount: (place) => new Nodes(place),
};

class Nodes {
  constructor(place) {
    this.place = place;
    this.system = null;
    this.unfoldLoggers = place.settings.loggers ? place.settings.selected : null; // the node whose loggers to show
    const number = { number: true, width: "62px", least: 520 };
    this.tablePanel = new TablePanel(place, {
      label: "nodes", noun: "node",
      searchText: (row) => `${row.name} ${row.machine}`,
      columns: [
        { title: "node", text: (row) => row.name, width: "minmax(140px, 1.6fr)" },
        { title: "machine", text: (row) => row.machine, width: "minmax(0, 1fr)", least: 420 },
        { title: "pub", text: (row) => String(row.publishes.length), value: (row) => row.publishes.length, ...number, hint: "topics that it publishes" },
        { title: "sub", text: (row) => String(row.subscribes.length), value: (row) => row.subscribes.length, ...number, hint: "topics that it subscribes to" },
        { title: "srv", text: (row) => String(row.services.length), value: (row) => row.services.length, ...number, hint: "services" },
        { title: "state", text: (row) => row.state, width: "86px" },
      ],
      details: (row) => this._details(row),
      empty: () => empty("No nodes yet", "Start one, in a terminal:", command("pyros1 run minimal_nodes minimal_publisher")),
    });
    this.stream = place.robot.stream("system", {}, {
      data: (system) => this._receive(system),
      problem: (text) => place.problem(text),
    });
  }

  unmount() {
    this.stream.close();
    this.tablePanel.close();
  }

  // Called when another panel asks for a node, or for a node's loggers.
  accept({ selected, loggers }) {
    if (loggers) this.unfoldLoggers = selected;
    if (selected) this.tablePanel.choose(selected);
  }

  _receive(system) {
    this.system = system;
    const silent = new Set(system.silent);
    /** @type {Map<string, Record<string, any>>} */
    const rows = new Map(Object.entries(system.nodes).map(([name, uri]) => [name, {
      name, uri, machine: machine(uri), state: silent.has(name) ? "silent" : "runs", dim: silent.has(name),
      publishes: [], subscribes: [], services: [], missing: [],
    }]));
    for (const [topic, facts] of Object.entries(system.topics)) {
      for (const name of facts.publishers) rows.get(name)?.publishes.push(topic);
      for (const name of facts.subscribers) rows.get(name)?.subscribes.push(topic);
    }
    for (const [service, names] of Object.entries(system.services)) for (const name of names) rows.get(name)?.services.push(service);
    for (const edge of system.missing) for (const name of edge.slice(1, 3)) rows.get(name)?.missing.push(edge);
    this.tablePanel.show([...rows.values()]);
  }

  _details(row) {
    const { place } = this;
    const { robot } = place;
    const { read_only: readOnly } = robot.about;
    const result = outcome();
    const [host, address, process] = [h("span"), h("span.mono"), h("span")];
    let uri = null;
    const lists = h("div");
    const actions = h("div");
    const shown = [];
    const ask = () => {
      fill(process, "…");
      robot.call("nodes.info", { node: row.name }).then(
        ({ pid, problem }) => fill(process, problem ? h("span.wrong", {}, problem) : String(pid)),
        (error) => fill(process, h("span.wrong", {}, error.message)));
    };
    const open = (panel) => (name) => place.open(panel, { selected: name });
    const state = h("span.muted");
    let known = "";
    const update = (now) => {
      fill(state, now ? (now.state === "silent" ? "does not answer" : "") : "this node is gone");
      if (!now) return;
      if (uri === null || (now.uri && now.uri !== uri)) { // the node was restarted, so its process is another one
        uri = now.uri;
        fill(host, machine(uri));
        fill(address, uri);
        ask();
      }
      const text = JSON.stringify([now.publishes, now.subscribes, now.services, now.missing]);
      if (text === known) return;
      known = text;
      fill(lists, definitionList([
        ["publishes", nameLinks(now.publishes, open("topics"))],
        ["subscribes to", nameLinks(now.subscribes, open("topics"))],
        ["services", nameLinks(now.services, open("services"))],
      ]), now.missing.slice(0, 10).map(([topic, publisher, subscriber]) => h("p.wrong.hint", {}, `${subscriber} does not get ${topic} from ${publisher}: `, command("pyros1 wtf"))));
      const names = actionsOf(now).slice(0, MAX_ACTIONS);
      if (String(names) === this.actionNames && shown.length) return;
      this.actionNames = String(names);
      for (const action of shown.splice(0)) action.close();
      shown.push(...names.map((name) => new Action(robot, name)));
      fill(actions, shown.map((action) => action.element));
    };
    update(row);
    const stop = async () => {
      try {
        await robot.call("nodes.kill", { node: row.name });
        result.say("asked to shut down");
      } catch (error) {
        result.fail(error.message);
      }
    };
    const configure = row.services.includes(`${row.name}/set_parameters`);
    return {
      element: h("div.about", {}, h("h3", {}, copyable(row.name)), state,
        definitionList([["machine", host], ["address", address], ["process", process]]),
        h("div.actions", {},
          !readOnly && confirmButton("Stop", `Stop ${row.name}?`, stop),
          configure && h("button", { onclick: () => place.open("params", { configure: row.name }) }, "Reconfigure"),
          h("button", { onclick: () => place.open("console", { node: row.name }) }, "Log"),
          h("button", { title: "its process, if a launch runs it: exit code, memory, restart", onclick: () => place.open("launches", { node: row.name }) }, "Process")),
        result.element, lists, actions, this._loggers(row)),
      update,
      close: () => { for (const action of shown) action.close(); },
    };
  }

  _loggers(row) {
    const { robot } = this.place;
    const list = h("div.inner", {}, h("p.muted.hint", {}, "…"));
    const result = outcome();
    const load = async () => {
      try {
        const loggers = await robot.call("nodes.loggers", { node: row.name });
        loggers.sort((one, other) => one[0].localeCompare(other[0]));
        fill(list, loggers.slice(0, 300).map(([logger, level]) => h("label.row", {}, h("span.label.mono", {}, logger),
          h("select", { disabled: robot.about.read_only, onchange: async (event) => {
            try {
              await robot.call("nodes.set_level", { node: row.name, logger, level: event.target.value });
              result.say(`${logger} is at ${event.target.value}`);
            } catch (error) {
              result.fail(error.message);
              load();
            }
          } }, LEVELS.map((each) => h("option", { value: each, selected: each === level.toLowerCase() }, each))))));
        if (!loggers.length) fill(list, h("p.muted.hint", {}, "This node has no loggers."));
      } catch (error) {
        fill(list, h("p.muted.hint", {}, error.message));
      }
    };
    return h("details.group.loggers", { open: this.unfoldLoggers === row.name, ontoggle: (event) => { if (event.target.open) load(); else this.unfoldLoggers = null; } }, h("summary", {}, "Levels of loggers"), list, result.element);
  }
}

// An action's server publishes the states of goals, and subscribes to goals.
function actionsOf({ publishes, subscribes }) {
  const listens = new Set(subscribes);
  return publishes.filter((name) => name.endsWith("/status")).map((name) => name.slice(0, -"/status".length))
    .filter((name) => listens.has(`${name}/goal`) && listens.has(`${name}/cancel`));
}

function machine(uri) {
  try {
    return new URL(uri).hostname.replace(/^\[|\]$/g, "");
  } catch {
    return "";
  }
}
