// Nodes, topics and the traffic between them, like rqt_graph.

import { command, empty, fill, h, save } from "../lib/dom.js";
import { plural } from "../lib/format.js";
import { HIDE_OPTIONS, MODES, around, build, dot, matching } from "../lib/graph/model.js";
import { GraphView } from "../lib/graph/graph_view.js";
import { Sheet } from "../lib/graph/side_sheet.js";

const DEPTHS = [[-1, "group if many"], [0, "no groups"], [1, "groups: 1 level"], [2, "groups: 2 levels"], [3, "groups: 3 levels"]];
const EXAMPLE_COMMAND = "pyros1 launch minimal_nodes minimal_simulator.launch";
/** @type {ReturnType<typeof build>} */
const NO_MODEL = { boxes: [], edges: [], groups: [], all: 0, unheard: 0, cut: 0 };
const HIDDEN_BY_DEFAULT = ["debug", "tf", "leaf", "dead"];

export default {
  title: "Graph",
  description: "nodes and topics, and the messages between them",
  order: 10,
  mount: (place) => new GraphPanel(place),
};

class GraphPanel {
  constructor(place) {
    this.place = place;
    const { settings } = place;
    this.mode = MODES.some(([name]) => name === settings.mode) ? settings.mode : "active";
    this.hide = new Set(Array.isArray(settings.hide) ? HIDE_OPTIONS.map(([name]) => name).filter((name) => settings.hide.includes(name)) : HIDDEN_BY_DEFAULT);
    this.depth = DEPTHS.some(([depth]) => depth === settings.depth) ? settings.depth : -1;
    this.toggled = new Set(Array.isArray(settings.toggled) ? settings.toggled.map(String) : []);
    this.rates = settings.rates !== false;
    this.chosen = null; // {id, kind: "box" | "edge"}
    this.pendingSelection = typeof settings.selected === "string" ? settings.selected : "";
    this.model = NO_MODEL;
    this.matchIds = [];
    this.next = 0; // index of the match to which Enter goes next
    this.hideChoices = [];
    this.sheet = new Sheet(h("aside.sheet", { hidden: true, "aria-label": "details" }), place, {
      choose: (id) => this._selectById(id), close: () => this._choose(null), unfold: (group) => this._fold(group),
    });
    this._style();
    this._build();
    this.picture = new GraphView(this.canvas, place.body, {
      choose: (found) => this._choose(found),
      fold: (group) => this._fold(group),
      arranged: () => this._arranged(),
      moved: () => this._moved(),
      coveredHeight: () => this.note.offsetHeight + 6,
    });
    this.picture.scene.offsets = settings.put;
    this.stream = place.robot.stream("system", {}, {
      data: (system) => this._receive(system),
      problem: (text) => this._problem(text),
    });
    this._empty();
  }

  // Called when another panel asks to select something: {selected: "/node" or "/topic"}.
  accept({ selected }) {
    this.pendingSelection = String(selected || "");
    this._update();
  }

  unmount() {
    this.stream.close();
    this.sheet.close();
    this.picture.close();
  }

  _style() {
    const href = new URL("./graph.css", import.meta.url).href;
    if (!document.querySelector(`link[href="${href}"]`)) document.head.append(h("link", { rel: "stylesheet", href }));
  }

  _build() {
    const { body, tools } = this.place;
    const choice = (key, values, label) => h("select", { "aria-label": label, title: label, onchange: (event) => {
      this[key] = typeof values[0][0] === "number" ? Number(event.target.value) : event.target.value;
      this._changed();
    } }, values.map(([value, text]) => h("option", { value, selected: value === this[key] }, text)));
    const hiding = HIDE_OPTIONS.map(([name, text, title]) => h("label.check", { title }, h("input", {
      type: "checkbox", checked: this.hide.has(name), dataset: { hide: name },
      onchange: (event) => {
        if (event.target.checked) this.hide.add(name);
        else this.hide.delete(name);
        this._changed();
      },
    }), text));
    this.hideChoices = hiding;
    const rates = h("label.check", { title: "on the edges: messages per second, bytes of a message, bytes per second" }, h("input", {
      type: "checkbox", checked: this.rates, onchange: (event) => {
        this.rates = event.target.checked;
        this._changed();
      },
    }), "rates");
    this.search = h("input", {
      type: "search", placeholder: "search ( / )", size: 14, "aria-label": "search", spellcheck: false,
      title: "part of a name, or a type; Enter goes to the next match",
      oninput: () => this._showMatches(true), onkeydown: (event) => this._searchKey(event),
    });
    this.count = h("span.muted");
    const menu = h("details.menu", { onkeydown: (event) => {
      if (event.key !== "Escape") return;
      menu.open = false;
      menu.firstChild.focus();
      event.stopPropagation();
    }, onfocusout: (event) => {
      if (event.relatedTarget && !menu.contains(event.relatedTarget)) menu.open = false;
    } }, h("summary", { title: "filters, groups, files" }, "Options"), h("div.choices", {},
      h("b", {}, "Hide"), hiding, h("b", {}, "Show"), rates, choice("depth", DEPTHS, "groups of namespaces"),
      h("b", {}, "Save"), h("span", {},
        h("button", { title: "save the image", onclick: () => save("graph.svg", this.picture.svg(), "image/svg+xml") }, "SVG"), " ",
        h("button", { title: "save the graph in the dot language of Graphviz", onclick: () => save("graph.dot", dot(this.model), "text/vnd.graphviz") }, "DOT"))));
    this.modes = choice("mode", MODES, "what is shown");
    tools.append(this.modes, menu, this.search, this.count);
    this.canvas = h("canvas", { tabIndex: 0, role: "application", "aria-label": "graph" });
    this.status = h("span.said", { role: "status" });
    this.note = h("div.note");
    this.emptyMessage = h("div.nothing");
    const view = (text, title, onclick) => h("button", { title, "aria-label": title, onclick }, text);
    this.canvas.addEventListener("pointerdown", () => { menu.open = false; });
    this.back = view("↺", "reset dragged boxes (r)", () => this.picture.release());
    this.back.hidden = true;
    this.stage = h("div.stage", {}, this.canvas, this.emptyMessage, this.status, this.note, h("div.zoom", {},
      view("+", "larger (+)", () => this.picture.camera.zoom(1.4)), view("−", "smaller (-)", () => this.picture.camera.zoom(1 / 1.4)),
      view("⤢", "show all (f)", () => this.picture.fit()), this.back));
    body.graph = this; // for tests and debugging
    body.classList.add("graph");
    body.append(this.stage, this.sheet.element);
    body.addEventListener("keydown", (event) => this._key(event));
  }

  _save() {
    const put = this.picture.scene.offsets;
    this.place.save({ mode: this.mode, hide: [...this.hide], depth: this.depth, toggled: [...this.toggled], rates: this.rates, ...(put.length ? { put } : {}) });
  }

  _changed() {
    this._save();
    this._update();
  }

  // Called when the user has moved boxes, or moved them back.
  _moved() {
    this.back.hidden = !this.picture.scene.movedBoxes.size;
    this._save();
  }

  _receive(system) {
    this.system = system;
    this._update();
  }

  _problem(text) {
    if (text === this.trouble) return; // every update reports the problem again
    this.trouble = text;
    this.place.problem(text && this.system ? `this may be out of date: ${text}` : "");
    if (!this.system) this._empty();
  }

  _update() {
    if (!this.system) return;
    this.model = build(this.system, { mode: this.mode, hide: [...this.hide], depth: this.depth, toggled: [...this.toggled] });
    this.picture.show(this.model, this.rates);
    if (this.pendingSelection) {
      const name = this.pendingSelection;
      this.pendingSelection = "";
      if (name in this.system.nodes) this._selectById(`n:${name}`);
      else if (name in this.system.topics) this._selectById(`t:${name}`);
    }
    this._follow();
    this._showMatches(false);
    this._empty();
    this._describe();
  }

  // Update the selection: the selected box or edge may have changed or disappeared.
  _follow() {
    if (!this.chosen) return;
    const { id, kind } = this.chosen;
    const of = (kind === "box" ? this.model.boxes : this.model.edges).find((each) => each.id === id);
    if (of) this.sheet.selection = { [kind]: of };
    this.sheet.refresh(this.system);
  }

  _arranged() {
    if (this.pending) this.picture.centre(this.pending);
    this.pending = null;
    this.back.hidden = !this.picture.scene.movedBoxes.size;
  }

  _describe() {
    const { boxes, edges, cut, unheard } = this.model;
    const of = (kind) => boxes.filter((box) => box.kind === kind).length;
    const silent = boxes.filter((box) => box.silent && box.kind !== "site").length;
    const lost = boxes.filter((box) => box.silent && box.kind === "site").length;
    const lacking = edges.filter(({ from, to }) => !from.startsWith("s:") && !to.startsWith("s:")).flatMap(({ links }) => links).filter(({ state }) => state === "broken");
    const broken = new Set(lacking.map((link) => `${link.topic} ${link.publisher} ${link.subscriber}`)).size;
    const parts = [plural(of("node"), "node"), this.mode !== "nodes" && plural(of("topic"), "topic"), of("site") && plural(of("site"), "site"), of("group") && `${of("group")} folded`,
      cut && `${cut} more are not shown`].filter(Boolean);
    const bad = [silent && `${silent} silent`, lost && `${plural(lost, "site")} lost`, broken && `${broken} broken`].filter(Boolean);
    const text = parts.join(" · ");
    const hidden = unheard ? `${plural(unheard, "topic")} without subscribers hidden` : "";
    const description = JSON.stringify([text, bad, hidden]);
    if (description !== this.described) {
      fill(this.note, h("span", {}, text), bad.map((each) => h("b.bad", {}, each)), hidden && h("span", {}, `${hidden} · `, h("button.link", { onclick: () => this._showUnheard() }, "show")));
    }
    this.described = description;
    this.canvas.setAttribute("aria-label", `graph: ${[...parts, ...bad].join(", ")}. Arrow keys move, Enter chooses`);
  }

  _empty() {
    const any = this.model.boxes.length > 0;
    this.emptyMessage.hidden = any;
    if (any) return;
    const what = !this.system ? this.trouble || "wait" : this.model.all ? "hidden" : "none";
    if (what === this.emptyReason) return;
    this.emptyReason = what;
    fill(this.emptyMessage, what === "wait" ? empty("Looking at the robot …")
      : what === "hidden" ? empty("Everything is hidden", "Only tools and debug topics are running.", h("button", { onclick: () => this._showAll() }, "Show them"), "To see more, start some nodes, in a terminal:", command(EXAMPLE_COMMAND))
        : what === "none" ? empty("No nodes are running yet", "Start some, in a terminal:", command(EXAMPLE_COMMAND))
          : empty("No robot yet", this.trouble, command("pyros1 core")));
  }

  _showAll() {
    this._unhide([...this.hide]);
  }

  // Show topics without subscribers.
  _showUnheard() {
    this.mode = this.modes.value = "all";
    this._unhide(["dead", "leaf"]);
  }

  _unhide(names) {
    for (const name of names) {
      this.hide.delete(name);
      this.hideChoices.find((label) => label.querySelector(`[data-hide="${name}"]`)).querySelector("input").checked = false;
    }
    this._changed();
  }

  _choose(found) {
    const [kind, of] = found?.box ? ["box", found.box] : found?.edge ? ["edge", found.edge] : ["", null];
    this.chosen = of && { id: of.id, kind };
    this.sheet.show(of && { [kind]: of }, this.system);
    if (kind === "box") this.picture.reveal(of.id);
    fill(this.status, of ? `${of.kind || "connection"} ${of.name || ""}` : "");
    this._highlight();
  }

  // Select a box or edge by its id, even if it is folded or hidden.
  _selectById(id) {
    const home = this.model.boxes.find(({ inside }) => inside?.some((each) => each.id === id));
    if (home) {
      this._fold(home.name);
      this.pending = [id];
    }
    const box = this.model.boxes.find((each) => each.id === id) || { id, kind: { n: "node", s: "site" }[id[0]] || "topic", name: id.slice(2) };
    this._choose({ box });
    const near = around(this.model, id);
    if (!home) this.picture.centre(near.size > 12 ? [id] : near);
  }

  _fold(group) {
    if (!this.toggled.delete(group)) this.toggled.add(group);
    if (this.chosen?.id === `g:${group}`) this._choose(null);
    this._changed();
  }

  // Highlight the matches of the search, or the selection with its neighbours; dim everything else.
  _highlight() {
    const id = this.chosen?.id;
    const { edges } = this.model;
    if (this.matches) {
      const boxes = this.matches;
      this.picture.highlight(id, { boxes, edges: new Set(edges.filter(({ from, to }) => boxes.has(from) && boxes.has(to)).map((edge) => edge.id)) });
    } else if (this.chosen?.kind === "box" && this.model.boxes.some((box) => box.id === id)) {
      const own = edges.filter(({ from, to }) => from === id || to === id);
      this.picture.highlight(id, { boxes: around(this.model, id), edges: new Set(own.map((edge) => edge.id)) });
    } else if (this.chosen?.kind === "edge") {
      const [from, to] = id.split(" ");
      this.picture.highlight(id, { boxes: new Set([from, to]), edges: new Set([id]) });
    } else this.picture.highlight(null, null);
  }

  _showMatches(move) {
    this.matches = this.system ? matching(this.model, this.search.value) : null;
    this.matchIds = this.matches ? [...this.matches] : [];
    if (move) this.next = 0;
    fill(this.count, this.matches ? `${this.matchIds.length} found` : "");
    if (move && this.matchIds.length) this.picture.centre(this.matchIds);
    this._highlight();
  }

  _searchKey(event) {
    if (event.key === "Enter" && this.matchIds.length) {
      const id = this.matchIds[this.next % this.matchIds.length];
      const box = this.model.boxes.find((each) => each.id === id);
      this.next += 1;
      if (box.inside && !box.name.toLowerCase().includes(this.search.value.trim().toLowerCase())) {
        this.next = 0;
        this._fold(box.name); // unfold the group that contains the match
      } else {
        this._choose({ box });
        this.picture.centre([id]);
      }
    } else if (event.key === "Escape") {
      this.search.value = "";
      this._showMatches(true);
      this.picture.fit();
      this.canvas.focus();
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }

  _key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input, select, textarea")) return;
    if (event.key === "/") this.search.focus();
    else if (event.key === "Escape" && this.chosen) {
      this._choose(null);
      this.canvas.focus();
    } else if (event.key === "f") this.picture.fit();
    else return;
    event.preventDefault();
  }
}
