// The side sheet: details of a node, topic or connection, and actions on it.

import { fill, h } from "../dom.js";
import { bytes, plural, rate } from "../format.js";
import { findings } from "./findings.js";
import { LatestMessage } from "./latest_message.js";
import { droppedText, siteFacts } from "./sites.js";

const MAX_ROWS = 200;

export class Sheet {
  // on: {choose(id), unfold(group), close()}
  constructor(element, place, on) {
    this.element = element;
    this.place = place;
    this.on = on;
    this.selection = null;
    this.digest = "";
    this.updaters = []; // functions that update what changes often
    this.latest = null;
    this.flow = (_topic) => undefined; // bytes per second, if known
  }

  // Show the selection: {box} or {edge} of a model; null closes the sheet.
  show(chosen, system) {
    this.latest?.close();
    this.latest = null;
    this.selection = chosen;
    this.digest = "";
    this.flow = (topic) => system?.topics[topic]?.bytes;
    this.element.hidden = !chosen;
    if (chosen) this.refresh(system);
    else fill(this.element);
  }

  close() {
    this.latest?.close();
  }

  // The system has changed; the sheet is rebuilt only if something was added or removed.
  refresh(system) {
    if (!this.selection) return;
    const { box, edge } = this.selection;
    const facts = box ? this._factsOf(box, system) : edge.links.map(({ topic, publisher, subscriber, state, dropped }) => [topic, publisher, subscriber, state, dropped]);
    const digest = JSON.stringify(facts);
    if (digest !== this.digest) {
      this.digest = digest;
      this.updaters = [];
      const [title, kind, ...parts] = edge ? this._edge(edge) : { node: this._node, topic: this._topic, group: this._group, site: this._site }[box.kind].call(this, box, facts);
      fill(this.element,
        h("header", {}, h("div", {}, h("p.kind.muted", {}, kind), h("h2.mono", {}, title)),
          h("button.quiet", { title: "close (Escape)", "aria-label": "close", onclick: () => this.on.close() }, "✕")),
        parts);
    }
    for (const update of this.updaters) update(system);
  }

  _factsOf({ kind, name }, system) {
    if (kind === "topic") {
      const { type, publishers, subscribers } = system.topics[name] || { type: "", publishers: [], subscribers: [] };
      return { type, publishers, subscribers, missing: system.missing.filter(([topic]) => topic === name).slice(0, MAX_ROWS), gone: !system.topics[name] };
    }
    if (kind === "site") return siteFacts(system, name);
    if (kind === "group") return { nodes: Object.keys(system.nodes).filter((each) => each.startsWith(`${name}/`)) };
    const all = Object.entries(system.topics);
    return {
      uri: system.nodes[name], gone: !(name in system.nodes), silent: system.silent.includes(name),
      publishes: all.filter(([, topic]) => topic.publishers.includes(name)).map(([topic]) => topic),
      subscribes: all.filter(([, topic]) => topic.subscribers.includes(name)).map(([topic]) => topic),
      services: Object.entries(system.services).filter(([, nodes]) => nodes.includes(name)).map(([service]) => service),
      missing: system.missing.filter(([, one, other]) => one === name || other === name).slice(0, MAX_ROWS),
    };
  }

  _node({ name }, { uri, gone, silent, publishes, subscribes, services, missing }) {
    if (gone) return [name, "node", h("p", {}, "This node has exited.")];
    const process = h("dd.mono.muted", {}, "…");
    const connections = h("div.muted", {}, "…");
    if (!silent) this._ask(name, process, connections);
    else fill(process, "does not answer");
    return [name, "node",
      silent && h("p.trouble", {}, "This node is registered, but it does not answer."),
      h("dl", {}, h("dt", {}, "process"), process, h("dt", {}, "address"), h("dd.mono", {}, uri || "unknown")),
      (silent || missing.length > 0) && findings(this.place.robot, "node", name, true),
      this._list("publishes", publishes, (topic) => this._topicRow(topic)),
      this._list("subscribes to", subscribes, (topic) => this._topicRow(topic)),
      this._list("services", services, (service) => h("span.mono", {}, service)),
      !silent && h("details", {}, h("summary", {}, "Connections"), connections),
      h("div.buttons", {},
        !silent && !missing.length && findings(this.place.robot, "node", name, false),
        !this.place.robot.about.read_only && this._stop(name))];
  }

  async _ask(name, process, connections) {
    try {
      const { pid, connections: found = [], problem } = await this.place.robot.call("nodes.info", { node: name });
      fill(process, problem || String(pid));
      fill(connections, found.length ? rows(found, ({ topic, peer, direction, transport }) => h("li", {},
        h("span.mono", {}, `${direction === "o" ? "→" : direction === "i" ? "←" : "↔"} ${topic}`), " ", h("span.muted.mono", {}, `${peer} ${transport}`))) : "none");
    } catch (error) {
      fill(process, error.message);
    }
  }

  _stop(name) {
    const where = h("span");
    const ask = () => fill(where, h("button.danger", { title: "ask the node to shut down", onclick: question }, "Stop …"));
    const question = () => {
      const yes = h("button.danger", { onclick: stop }, "Stop it");
      fill(where, h("span.question", { role: "alertdialog", "aria-label": "stop the node" }, `Stop ${name}?`), " ", yes, " ", h("button", { onclick: ask }, "No"));
      yes.focus();
    };
    const stop = async () => {
      fill(where, h("span.muted", {}, "stopping …"));
      try {
        await this.place.robot.call("nodes.kill", { node: name });
        fill(where, h("span.muted", {}, "it was asked to shut down"));
      } catch (error) {
        fill(where, h("span.trouble", {}, error.message));
      }
    };
    ask();
    return where;
  }

  _topic({ name }, { type, publishers, subscribers, missing, gone }) {
    if (gone) return [name, "topic", h("p", {}, "No node uses this topic any more.")];
    const flow = h("dd.mono");
    this.updaters.push((system) => {
      const topic = system.topics[name];
      const text = topic?.hz === null ? "…" : topic?.hz === undefined ? "unknown: nothing is connected, or its publishers report no statistics" : topic.hz && !topic.bytes ? rate(topic.hz) // nothing is serialised within a process
        : `${rate(topic.hz)}${topic.hz ? ` of ${bytes(topic.bytes / topic.hz)}` : ""}, ${bytes(topic.bytes, "B/s")}`;
      if (flow.textContent !== text) fill(flow, text);
    });
    const published = publishers.length > 0;
    if (!this.latest?.isOf(name, type, published)) { // otherwise the displayed message would vanish whenever a subscriber comes or goes
      this.latest?.close();
      this.latest = new LatestMessage(this.place, name, type, published, this.flow(name));
    }
    const latest = this.latest;
    return [name, "topic",
      h("dl", {}, h("dt", {}, "type"), h("dd.mono", {}, type || "unknown"), h("dt", {}, "flow"), flow),
      missing.length > 0 && h("p.trouble", {}, `${plural(missing.length, "connection")} ${missing.length === 1 ? "is" : "are"} missing.`),
      missing.length > 0 && findings(this.place.robot, "topic", name, true),
      this._list("publishers", publishers, (node) => this._nodeLink(node)),
      this._list("subscribers", subscribers, (node) => this._nodeLink(node)),
      latest.element,
      h("div.buttons", {},
        h("button", { title: "the latest message as a tree", onclick: () => this.place.open("topics", { selected: name }) }, "Inspect"),
        h("button", { title: "plot the first number of its messages; click another number to plot that one", onclick: () => latest.plot() }, "Plot"),
        !missing.length && findings(this.place.robot, "topic", name, false))];
  }

  _group({ name }, { nodes }) {
    return [name, "namespace", this._list("nodes", nodes, (node) => this._nodeLink(node)),
      h("div.buttons", {}, h("button", { onclick: () => this.on.unfold(name) }, "Unfold"))];
  }

  _site({ name }, { gone, states, nodes, sent, received }) {
    if (gone) return [name, "site", h("p", {}, "No bridge knows this site any more.")];
    const row = ({ topic, wanted, dropped }) => h("span", {}, wanted ? this._topicRow(topic) : h("span.mono.muted", {}, topic),
      droppedText(dropped) && h("div.trouble", {}, `dropped: ${droppedText(dropped)}`));
    return [name, "site",
      states.map(({ bridge, lost, text }) => h(lost ? "p.trouble" : "p", {}, this._nodeLink(bridge), ` ${lost ? "says: it " : "reaches it: "}${lost && text === "lost" ? "is lost" : text}`)),
      this._list("receives", sent, row),
      this._list("sends", received, row),
      this._list("its nodes", nodes, (node) => h("span.mono", {}, node)),
      h("p.muted", {}, "More: ", h("code", {}, "pyros1 bridge status"))];
  }

  _edge(edge) {
    if (edge.from.startsWith("s:") || edge.to.startsWith("s:")) return this._siteEdge(edge);
    const [from, to] = [edge.from.slice(2), edge.to.slice(2)];
    const broken = [...new Set(edge.links.filter(({ state }) => state === "broken").map(({ topic }) => topic))];
    const unknown = edge.links.some(({ state }) => state === "unknown");
    const pairs = edge.links.filter(({ publisher, subscriber }) => publisher && subscriber);
    return [`${from} → ${to}`, pairs.length > 1 ? plural(pairs.length, "connection") : "connection",
      broken.length > 0 && h("p.trouble", {}, "These nodes should be connected, but are not. Why:"),
      unknown && h("p.trouble", {}, "It is not known whether they are connected: one of them does not answer, or has just started."),
      broken.slice(0, 5).map((topic) => findings(this.place.robot, "topic", topic, true)),
      this._list("between", pairs, ({ topic, publisher, subscriber, state, hz, bytes: size }) => h("span", {}, this._link(`t:${topic}`, topic), " ",
        h("span.muted", {}, state === "ok" ? (hz === null ? "" : `${rate(hz)}${size ? `, ${bytes(size, "B/s")}` : ""}`) : state === "broken" ? "not connected" : "not known"),
        h("div.muted", {}, this._nodeLink(publisher), " → ", this._nodeLink(subscriber)))),
      !pairs.length && h("p.muted", {}, "No connection here: the topic has only one end."),
    ];
  }

  _siteEdge({ from, to, links }) {
    const topics = links.filter(({ topic }) => topic);
    return [`${from.slice(2)} → ${to.slice(2)}`, "between sites",
      links.some(({ state }) => state === "broken") && h("p.trouble", {}, "The site is lost."),
      this._list("topics", topics, ({ topic, hz, bytes: size, dropped }) => h("span", {}, this._link(`t:${topic}`, topic), " ",
        h("span.muted", {}, hz === null ? "" : `${rate(hz)}${size ? `, ${bytes(size, "B/s")}` : ""}`),
        droppedText(dropped) && h("div.trouble", {}, `dropped: ${droppedText(dropped)}`))),
      !topics.length && h("p.muted", {}, "No topics are exchanged.")];
  }

  _topicRow(topic) {
    const flow = h("span.muted");
    this.updaters.push((system) => {
      const text = rate(system.topics[topic]?.hz);
      if (flow.textContent !== text) fill(flow, text);
    });
    return h("span", {}, this._link(`t:${topic}`, topic), " ", flow);
  }

  _nodeLink(node) {
    return this._link(`n:${node}`, node);
  }

  _link(id, text) {
    return h("button.link.mono", { onclick: () => this.on.choose(id) }, text);
  }

  _list(title, items, draw) {
    return items.length > 0 && h("section", {}, h("h3", {}, `${title} `, h("span.muted", {}, items.length)), rows(items, (item) => h("li", {}, draw(item))));
  }
}

function rows(items, draw) {
  const more = items.length - MAX_ROWS;
  return h("ul", {}, items.slice(0, MAX_ROWS).map(draw), more > 0 && h("li.muted", {}, `and ${more} more`));
}
