// The parameters as a tree with in-place editing; and dynamic_reconfigure servers with sliders.

import { command, empty, fill, h } from "../lib/dom.js";
import { TablePanel } from "../parts/table_panel.js";
import { confirmButton, copyable, outcome } from "../parts/widgets.js";
import { Reconfigure } from "../parts/reconfigure.js";

const RECONFIGURE_TYPE = "dynamic_reconfigure/Reconfigure";

export default {
  title: "Parameters",
  description: "parameters, and dynamic_reconfigure",
  order: 60,
  mount: (place) => new Parameters(place),
};

class Parameters {
  constructor(place) {
    this.place = place;
    this.params = new Map(); // name -> [kind, text, more]
    this.servers = new Map(); // service -> whether it belongs to dynamic_reconfigure
    const add = this.add = h("button", { title: "a new parameter", onclick: () => this._add() }, "New …");
    this.configure = h("select", { hidden: true, "aria-label": "dynamic_reconfigure", title: "nodes with dynamic_reconfigure", onchange: () => {
      if (this.configure.value) this._configure(this.configure.value);
      this.configure.value = "";
    } });
    this.tablePanel = new TablePanel(place, {
      label: "parameters", noun: "parameter", tree: true, tools: [add, this.configure],
      searchText: (row) => `${row.name} ${row.text}`,
      columns: [
        { title: "parameter", text: (row) => row.name, width: "minmax(140px, 1fr)" },
        { title: "value", text: (row) => row.text.split("\n")[0] + (row.more || row.text.trimEnd().includes("\n") ? " …" : ""), value: (row) => (row.kind === "int" || row.kind === "double" ? Number(row.text) : row.text), width: "minmax(0, 1fr)" },
        { title: "kind", text: (row) => row.kind, width: "70px", least: 480 },
      ],
      details: (row) => this._details(row),
      empty: () => empty("No parameters yet", "Nodes and launch files set them. Try, in a terminal:", command("pyros1 param set /answer 42")),
    });
    this.stream = place.robot.stream("params", {}, {
      data: (changes) => this._receive(changes),
      problem: (text) => place.problem(text),
    });
    this.more = 0;
    this.system = place.robot.stream("system", {}, { data: ({ services }) => this._findServers(services), problem: () => {} });
    this.onAbout = () => { add.hidden = place.robot.about.read_only; };
    this.onAbout();
    place.robot.addEventListener("about", this.onAbout);
  }

  unmount() {
    this.stream.close();
    this.system.close();
    this.tablePanel.close();
    this.place.robot.removeEventListener("about", this.onAbout);
  }

  accept({ selected, configure }) {
    if (configure) this._configure(configure);
    else if (selected) this.tablePanel.choose(selected);
  }

  _receive({ all, set, gone, more }) {
    if (all) this.params.clear();
    for (const [name, value] of Object.entries(set)) this.params.set(name, value);
    for (const name of gone) this.params.delete(name);
    if (more !== this.more) this.place.problem(more ? `${more} more parameters are not shown` : "");
    this.more = more;
    this.tablePanel.show([...this.params].map(([name, [kind, text, cut]]) => ({ name, kind, text, more: cut })));
  }

  // Nodes with dynamic_reconfigure have a service with a certain name and type.
  async _findServers(services) {
    const ends = "/set_parameters";
    const there = Object.keys(services).filter((name) => name.endsWith(ends));
    for (const name of this.servers.keys()) if (!(name in services)) this.servers.delete(name); // another node may register the name
    const newServers = there.filter((name) => !this.servers.has(name)).slice(0, 50);
    if (this.isRequesting) return;
    this.isRequesting = true;
    try {
      if (newServers.length) {
        const types = await this.place.robot.call("services.types", { services: newServers });
        for (const name of newServers) if (types[name]) this.servers.set(name, types[name] === RECONFIGURE_TYPE); // undefined: it did not respond
      }
    } catch {
      return; // types are requested again after the next change
    } finally {
      this.isRequesting = false;
    }
    const found = there.filter((name) => this.servers.get(name)).map((name) => name.slice(0, -ends.length)).sort();
    if (String(found) === this.found) return;
    this.found = String(found);
    this.configure.hidden = !found.length;
    fill(this.configure, h("option", { value: "" }, `Reconfigure (${found.length})`), found.map((name) => h("option", { value: name }, name)));
    const { configure, reconfigure } = this.place.settings; // the server to show: configure is set by another panel, reconfigure by a command
    if (configure && found.includes(configure)) this._configure(configure);
    if (reconfigure === undefined) return;
    const wanted = reconfigure ? found.find((name) => name === reconfigure) : found[0];
    this.place.problem(wanted ? "" : reconfigure ? `${reconfigure} has no dynamic_reconfigure, or is not running` : "No node with dynamic_reconfigure is running.");
    if (!wanted) return;
    delete this.place.settings.reconfigure; // only once
    this._configure(wanted);
  }

  _configure(name) {
    const panel = new Reconfigure(this.place.robot, name);
    this.tablePanel.showElement(panel.element, () => panel.close());
  }

  _details(row) {
    const { robot } = this.place;
    const readOnly = robot.about.read_only;
    const kind = h("span.muted", {}, row.kind);
    const area = h("textarea.mono.yaml", { rows: 1, spellcheck: false, readOnly, onkeydown: (event) => {
      if (event.key === "Enter" && (event.ctrlKey || event.metaKey || area.rows === 1) && !event.shiftKey) { event.preventDefault(); save(); }
    }, oninput: () => state() });
    const result = outcome();
    const sent = h("button.primary", { onclick: () => save() }, "Save");
    const undo = h("button", { onclick: () => { area.value = loaded; state(); } }, "Undo");
    const changed = h("p.muted.hint", { hidden: true }, "This parameter has been changed elsewhere in the meantime.",
      " ", h("button", { onclick: () => load() }, "Show"));
    let loaded = "";
    let shown = `${row.kind} ${row.text}`;
    const state = () => {
      const dirty = area.value !== loaded;
      sent.disabled = undo.disabled = !dirty;
      area.rows = Math.max(1, Math.min(20, area.value.split("\n").length));
      return dirty;
    };
    let [value, asYaml] = [row, false];
    const plain = () => value.kind === "text" && !value.more && !asYaml; // strings are edited without quotation marks
    const yaml = h("button.quiet", { title: "to give it a value of another type", onclick: () => { asYaml = true; load(); } }, "as YAML");
    const load = async () => {
      try {
        yaml.hidden = readOnly || !plain();
        loaded = plain() ? value.text : (await robot.call("params.get", { name: row.name })).replace(/\n$/, "");
        area.value = loaded;
        area.setAttribute("aria-label", plain() ? "value as text" : "value as YAML");
        changed.hidden = true;
        state();
      } catch (error) {
        result.fail(error.message);
      }
    };
    const save = async () => {
      try {
        await robot.call("params.put", { name: row.name, yaml: plain() ? JSON.stringify(area.value) : `${area.value}\n` });
        loaded = area.value;
        state();
        result.say("saved");
        this.stream.change({});
      } catch (error) {
        result.fail(error.message);
      }
    };
    load();
    const update = (now) => {
      if (!now) { result.fail("this parameter is gone"); return; }
      value = now;
      fill(kind, now.kind);
      const text = `${now.kind} ${now.text}`;
      if (text === shown) return;
      shown = text;
      if (area.value === loaded) load();
      else changed.hidden = false;
    };
    const namespace = row.name.slice(0, row.name.lastIndexOf("/"));
    const element = h("div.about", {}, h("h3", {}, copyable(row.name)), h("div.actions", {}, kind, yaml), area, changed,
      !readOnly && h("div.actions", {}, sent, undo, h("span.gap"),
        confirmButton("Delete", "Delete this parameter?", () => this._delete(row.name, result)),
        namespace && confirmButton(`Delete ${namespace}/`, `Delete ${namespace}/ with all ${[...this.params.keys()].filter((name) => name.startsWith(`${namespace}/`)).length} parameters?`, () => this._delete(namespace, result))),
      result.element);
    return { element, update };
  }

  async _delete(name, result) {
    try {
      await this.place.robot.call("params.delete", { name });
      this.stream.change({});
      this.tablePanel.choose(null);
    } catch (error) {
      result.fail(error.message);
    }
  }

  _add() {
    const name = h("input.mono", { placeholder: "/name", "aria-label": "name", spellcheck: false, required: true });
    const value = h("textarea.mono.yaml", { rows: 3, placeholder: "a value as YAML: 1.5, true, text, [1, 2]", "aria-label": "value as YAML", spellcheck: false });
    const result = outcome();
    const form = h("form", { onsubmit: async (event) => {
      event.preventDefault();
      const full = name.value.trim().replace(/^\/?/, "/");
      try {
        await this.place.robot.call("params.put", { name: full, yaml: value.value });
        this.stream.change({});
        result.say(`${full} is set`);
        this.tablePanel.selected = full;
      } catch (error) {
        result.fail(error.message);
      }
    } }, h("div.row", {}, name), value, h("div.actions", {}, h("button.primary", {}, "Set")), result.element);
    this.tablePanel.showElement(h("div.about", {}, h("h3", {}, "A new parameter"), form));
    name.focus();
  }
}
