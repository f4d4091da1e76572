// All topics with their rates; for the selected one, its messages, a form to publish, and its definition.

import { command, empty, fill, h } from "../lib/dom.js";
import { bytes, rate } from "../lib/format.js";
import { Inspector } from "../parts/inspector.js";
import { TablePanel } from "../parts/table_panel.js";
import { copyable, definitionList, nameLinks, tabbed } from "../parts/widgets.js";
import { Publisher } from "../parts/publisher.js";

const MAX_MEASURED = 50; // same as in pyros1/web/views/rates.py
const UPDATES_UNTIL_KNOWN = 3; // number of updates after which a rate is known: one until connected, and two measurements

export default {
  title: "Topics",
  description: "topics with rates, messages, and a form to publish",
  order: 40,
  mount: (place) => new Topics(place),
};

class Topics {
  constructor(place) {
    this.place = place;
    this.measured = new Map(); // topic -> {hz, bytes}
    this.updateCounts = new Map(); // topic -> number of updates in which it had publishers and subscribers
    this.system = null;
    const publish = h("button", { title: "publish on a new topic", onclick: () => this._newTopic() }, "New …");
    this.publish = publish;
    this.all = h("button", { hidden: true, "aria-pressed": "false", onclick: () => this._measureAll() });
    this.tablePanel = new TablePanel(place, {
      label: "topics", noun: "topic", tools: [publish, this.all],
      searchText: (row) => `${row.name} ${row.type}`,
      columns: [
        { title: "topic", text: (row) => row.name, width: "minmax(140px, 2.2fr)" },
        { title: "type", text: (row) => row.type, width: "minmax(0, 1.5fr)", least: 480, alone: true },
        { title: "pub", text: (row) => String(row.publishers.length), value: (row) => row.publishers.length, number: true, width: "52px", least: 640, hint: "publishers" },
        { title: "sub", text: (row) => String(row.subscribers.length), value: (row) => row.subscribers.length, number: true, width: "52px", least: 640, hint: "subscribers" },
        { title: "rate", node: (row) => this._rate(row), value: (row) => row.hz, number: true, width: "94px" },
        { title: "flow", text: (row) => (row.bytes ? `${bytes(row.bytes)}/s` : ""), value: (row) => row.bytes, number: true, width: "88px", least: 400 },
      ],
      details: (row) => this._details(row),
      empty: () => empty("No topics yet", "The topics of running nodes appear here. Try, in a terminal:", command("pyros1 launch minimal_nodes minimal_simulator.launch")),
    });
    this.stream = place.robot.stream("system", {}, {
      data: (system) => { this._receive(system); this._show(); this._begin(); },
      problem: (text) => place.problem(text),
    });
    this.rates = null;
    this.onAbout = () => { publish.hidden = place.robot.about.read_only; };
    this.onAbout();
    place.robot.addEventListener("about", this.onAbout);
  }

  unmount() {
    this.stream.close();
    this.rates?.close();
    this.tablePanel.close();
    this.place.robot.removeEventListener("about", this.onAbout);
  }

  // If a command has requested the form to publish, on a given topic or on any, show it.
  _begin() {
    const { publish } = this.place.settings;
    if (publish === undefined || this.hasBegun) return;
    this.hasBegun = true; // only once
    if (this.system.topics[publish]) {
      this.tab = 1;
      this.tablePanel.choose(publish);
    } else this._newTopic(String(publish));
  }

  // Called when another panel asks for a topic.
  accept({ selected }) {
    if (selected) this.tablePanel.choose(selected);
  }

  _receive(system) {
    this.system = system;
    const flows = Object.entries(system.topics).filter(([, { publishers, subscribers }]) => publishers.length && subscribers.length);
    this.updateCounts = new Map(flows.map(([name]) => [name, (this.updateCounts.get(name) || 0) + 1]));
  }

  _show() {
    this.tablePanel.show(Object.entries(this.system.topics).map(([name, facts]) => {
      const measured = this.measured.get(name);
      const ours = measured && measured.hz !== undefined && !facts.hz;
      return { name, ...facts, ...(ours ? measured : {}), measured: Boolean(measured), problem: measured?.problem };
    }));
    const count = this.measured.size;
    this.all.hidden = !count && !this._unheardTopics().length;
    this.all.setAttribute("aria-pressed", String(count > 0));
    const text = count ? `Stop measuring (${count})` : "Measure all";
    if (this.all.textContent !== text) fill(this.all, text);
    this.all.title = count ? "stop listening" : `subscribe to topics without subscribers to measure their rates: the first ${MAX_MEASURED} of those found`;
  }

  // Return the names of the topics that match the search, and have publishers but no subscribers.
  _unheardTopics() {
    return this.tablePanel.found.filter(({ publishers, subscribers }) => publishers.length && !subscribers.length).map(({ name }) => name);
  }

  _measureAll() {
    const names = this.measured.size ? [] : this._unheardTopics().slice(0, MAX_MEASURED);
    this.measured = new Map(names.map((name) => [name, {}]));
    this._listen();
  }

  // A publisher without subscribers sends nothing, so its rate is known only if we subscribe.
  _rate(row) {
    if (row.hz > 0 || (row.hz === 0 && row.measured)) {
      const text = h("span", {}, rate(row.hz));
      return row.measured ? h("button.measure.on", { title: "measured by this page; click to stop", onclick: () => this._measure(row.name) }, text) : text;
    }
    if (row.measured) return h("button.measure.on", { title: row.problem || "click to stop", onclick: () => this._measure(row.name) }, row.problem ? "problem" : "…");
    if (!row.publishers.length) return h("span.muted", { title: "no node publishes it" }, "–");
    if (row.subscribers.length) {
      if (row.hz === 0) return h("span.muted", {}, "0 Hz");
      if (row.hz === null) return h("span.muted", { title: "a rate needs two messages" }, "…");
      return this.updateCounts.get(row.name) < UPDATES_UNTIL_KNOWN ? h("span.muted", { title: "a moment: a rate needs two readings" }, "…") : h("span.muted", { title: "nothing is connected, or its publishers report no statistics" }, "?");
    }
    return h("button.measure", { title: "no subscribers: listen to measure the rate", onclick: () => this._measure(row.name) }, "measure");
  }

  _measure(name) {
    if (!this.measured.delete(name)) {
      if (this.measured.size >= MAX_MEASURED) this.measured.delete(this.measured.keys().next().value);
      this.measured.set(name, {});
    }
    this._listen();
  }

  _listen() {
    const { robot } = this.place;
    const args = { topics: [...this.measured.keys()] };
    this.rates ??= robot.stream("rates", args, {
      data: (found) => {
        for (const [topic, figures] of Object.entries(found)) if (this.measured.has(topic)) this.measured.set(topic, figures);
        this._show();
      },
      problem: (text) => this.place.problem(text),
    });
    this.rates.change(args);
    this._show();
  }

  _details(row) {
    const { place } = this;
    const { robot } = place;
    const people = h("div.people");
    const type = h("span.mono");
    const plot = (curve) => place.open("plot", { curves: [curve] });
    let publisher = null; // keeps publishing while another tab is visible
    const publishing = () => {
      publisher ??= new Publisher(robot, row.name, "");
      return { element: publisher.element };
    };
    const tabs = tabbed([
      ["Message", () => new Inspector(robot, row.name, { plot })],
      !robot.about.read_only && ["Publish", publishing],
      ["Definition", () => this._definition(row.name)],
    ].filter(Boolean), this.tab || 0, (index) => { this.tab = index; });
    let known = "";
    const update = (now) => {
      const text = now ? JSON.stringify([now.type, now.publishers, now.subscribers]) : "gone";
      if (text === known) return;
      known = text;
      fill(type, now ? now.type || "type not known" : "this topic is gone");
      if (!now) return;
      const node = (name) => place.open("nodes", { selected: name });
      fill(people, definitionList([["published by", nameLinks(now.publishers, node)], ["subscribed by", nameLinks(now.subscribers, node)]]));
    };
    update(row);
    return { element: h("div.about", {}, h("h3", {}, copyable(row.name)), type, people, tabs.element), update, close: () => { tabs.close(); publisher?.close(); } };
  }

  _definition(topic) {
    const element = h("div.definition", {}, h("p.muted.hint", {}, "…"));
    this.place.robot.call("topics.form", { topic }).then(
      (form) => fill(element, h("pre.mono", {}, form.text || "# no fields")),
      (error) => fill(element, h("p.wrong.hint", {}, error.message)));
    return { element };
  }

  // Show the form for a topic that does not exist yet.
  _newTopic(begin = "") {
    const name = h("input.mono", { value: begin, placeholder: "/topic", "aria-label": "topic", spellcheck: false, required: true });
    const type = h("input.mono", { placeholder: "std_msgs/String", "aria-label": "type", spellcheck: false, required: true });
    const list = h("datalist", { id: `types${Math.random()}` });
    type.setAttribute("list", list.id);
    const suggest = async () => {
      const names = await this.place.robot.call("topics.types", { begin: type.value }).catch(() => []);
      fill(list, names.map((value) => h("option", { value })));
    };
    type.addEventListener("focus", suggest);
    type.addEventListener("input", suggest);
    const under = h("div");
    let publisher = null;
    const form = h("form.actions", { onsubmit: (event) => {
      event.preventDefault();
      publisher?.close();
      const topic = name.value.trim().replace(/^\/?/, "/");
      publisher = new Publisher(this.place.robot, topic, type.value.trim());
      fill(under, publisher.element);
    } }, name, type, list, h("button.primary", {}, "Fill in"));
    this.tablePanel.showElement(h("div.about", {}, h("h3", {}, "Publish on a new topic"), form, under), () => publisher?.close());
    name.focus();
  }
}
