// All services; for the selected one, a form for the request, and the response.

import { command, empty, fill, h } from "../lib/dom.js";
import { Editor } from "../parts/editor.js";
import { TablePanel } from "../parts/table_panel.js";
import { copyable, definitionList, nameLinks, outcome, tabbed } from "../parts/widgets.js";
import { Tree } from "../parts/tree.js";

const REQUESTED_TYPES = 40; // maximum number of types to request at a time
const INTERNAL_SERVICES = /\/(get_loggers|set_logger_level)$/; // services that every node provides

export default {
  title: "Services",
  description: "services, with a form to call them",
  order: 50,
  mount: (place) => new Services(place),
};

class Services {
  constructor(place) {
    this.place = place;
    this.types = new Map(); // service and node -> type
    this.all = Boolean(place.settings.all) || INTERNAL_SERVICES.test(place.settings.selected || "");
    this.services = {};
    const everything = this.everything = h("button", { "aria-pressed": String(this.all), title: "show the logger services, which every node has", onclick: () => {
      this.all = !this.all;
      everything.setAttribute("aria-pressed", String(this.all));
      this.tablePanel.extra = { all: this.all };
      this.tablePanel.save();
      this._show();
    } }, "Loggers");
    this.tablePanel = new TablePanel(place, {
      label: "services", noun: "service", tools: [everything],
      searchText: (row) => `${row.name} ${row.type || ""} ${row.nodes.join(" ")}`,
      columns: [
        { title: "service", text: (row) => row.name, width: "minmax(140px, 1.6fr)" },
        { title: "type", text: (row) => row.type ?? "…", value: (row) => row.type, width: "minmax(0, 1.3fr)", least: 420 },
        { title: "node", text: (row) => row.nodes.join(" "), width: "minmax(0, 1fr)", least: 560 },
      ],
      details: (row) => this._details(row),
      empty: () => empty("No services", this.all ? "The services of running nodes appear here." : "“Loggers” also shows the logger services that every node has.", command("pyros1 run turtlesim turtlesim_node")),
    });
    this.tablePanel.extra = { all: this.all };
    this.stream = place.robot.stream("system", {}, {
      data: (system) => { this.services = system.services; this._show(); this._requestTypes(); },
      problem: (text) => place.problem(text),
    });
  }

  unmount() {
    this.stream.close();
    this.tablePanel.close();
  }

  accept({ selected }) {
    if (!selected) return;
    if (INTERNAL_SERVICES.test(selected) && !this.all) this.everything.click();
    this._show();
    this.tablePanel.choose(selected);
  }

  _show() {
    const rows = Object.entries(this.services).filter(([name]) => this.all || !INTERNAL_SERVICES.test(name));
    this.tablePanel.show(rows.map(([name, nodes]) => ({ name, nodes, type: this.types.get(`${name} ${nodes}`) })));
  }

  // The master does not know types: ask the providers, a few at a time.
  async _requestTypes() {
    if (this.isRequesting) return;
    this.isRequesting = true;
    try {
      for (;;) {
        const rows = (this.tablePanel.rows || []).filter((row) => row.type === undefined).slice(0, REQUESTED_TYPES);
        if (!rows.length) break;
        const found = await this.place.robot.call("services.types", { services: rows.map((row) => row.name) });
        for (const row of rows) this.types.set(`${row.name} ${row.nodes}`, found[row.name] || "");
        this._show();
      }
    } catch {
      // the server or the master is unreachable; types are requested again after the next change
    } finally {
      this.isRequesting = false;
    }
  }

  _details(row) {
    const { robot } = this.place;
    const inside = h("div", {}, h("p.muted.hint", {}, "…"));
    const node = (name) => this.place.open("nodes", { selected: name });
    let tabs = null;
    robot.call("services.form", { service: row.name }).then((form) => {
      const { read_only: readOnly } = robot.about;
      tabs = tabbed([
        !readOnly && ["Call", () => ({ element: this._caller(row.name, form) })],
        ["Definition", () => ({ element: h("pre.mono.definition", {}, form.request.text || "# no fields", "\n---\n", form.response.text || "# no fields") })],
      ].filter(Boolean));
      fill(inside, definitionList([["type", h("span.mono", {}, form.type)]]), tabs.element);
    }, (error) => fill(inside, h("p.wrong.hint", { role: "alert" }, error.message)));
    return {
      element: h("div.about", {}, h("h3", {}, copyable(row.name)), definitionList([["provided by", nameLinks(row.nodes, node)]]), inside),
      close: () => tabs?.close(),
    };
  }

  _caller(service, form) {
    const editor = new Editor(this.place.robot, { ...form.request, name: form.type }, { part: "request" });
    const result = outcome();
    const tree = new Tree({}, "");
    const button = h("button.primary", { onclick: async () => {
      button.disabled = true;
      result.say("calling …");
      tree.show(null);
      try {
        const { value, seconds } = await this.place.robot.call("services.call", { service, value: await editor.message(), timeout: Number(timeoutInput.value) || 10 });
        result.say(`answered in ${seconds < 1 ? `${(seconds * 1000).toFixed(1)} ms` : `${seconds.toFixed(2)} s`}`);
        tree.show(value);
      } catch (error) {
        result.fail(error.message);
      } finally {
        button.disabled = false;
      }
    } }, "Call");
    const timeoutInput = h("input.num", { type: "number", min: 0.1, max: 600, step: "any", value: 10, "aria-label": "seconds to wait" });
    return h("div.caller", {}, editor.element, h("div.actions", {}, button, h("label.check", { title: "how long to wait for the response" }, "at most", timeoutInput, "s")), result.element, tree.element);
  }
}
