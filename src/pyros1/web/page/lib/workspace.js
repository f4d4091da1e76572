// Panels beside and below each other. A layout is a tree: {panel, settings} or {split: "row" | "column", sizes, parts}.

import { moved, panelsOf, sideOf, swapped, without } from "./layout_tree.js";
import { fill, h, s } from "./dom.js";

const MAX_DEPTH = 6;
const MIN_SIZE = 0.08; // fraction of a split
const KEY_STEP = 0.02; // fraction of a split per press of an arrow key
const MIN_DRAG = 6; // pixels after which a drag begins
const MIN_WIDTH_FOR_TWO = 900; // pixels; a panel of at least this width can be split into two columns

export class Workspace {
  // changed(tree) is called when the user arranges something, or a panel saves its settings.
  constructor(root, panels, robot, changed) {
    this.root = root;
    this.panels = panels;
    this.robot = robot;
    this.changed = changed;
    this.tree = null;
    this._mounted = new Map();
    this._bodies = new Map();
    this._banner = h("div.banner", { role: "alert", hidden: true });
    this._place = h("div.place");
    fill(root, this._banner, this._place); // this replaces the text "Loading …"
  }

  show(tree) {
    this.tree = this._clean(tree, 0) || { panel: this.panels[0].name };
    for (const mounted of this._mounted.values()) mounted.unmount?.();
    this._mounted.clear();
    this._bodies.clear();
    fill(this._place, this._draw(this.tree));
    this._mountAll(this.tree);
  }

  trouble(text) {
    this._banner.hidden = !text;
    fill(this._banner, text);
  }

  // A tree from a link is untrusted input.
  _clean(tree, depth) {
    if (!tree || typeof tree !== "object" || depth > MAX_DEPTH) return null;
    if (Array.isArray(tree.parts)) {
      const parts = tree.parts.slice(0, 8).map((part) => this._clean(part, depth + 1)).filter(Boolean);
      if (parts.length < 2) return parts[0] || null;
      const valid = Array.isArray(tree.sizes) && tree.sizes.length === parts.length && tree.sizes.every((size) => size > 0);
      return { split: tree.split === "column" ? "column" : "row", sizes: valid ? tree.sizes : parts.map(() => 1), parts };
    }
    if (!this.panels.some((panel) => panel.name === tree.panel)) return null;
    const settings = tree.settings && typeof tree.settings === "object" ? tree.settings : {};
    return { panel: tree.panel, settings };
  }

  _draw(node) {
    return node.parts ? this._drawSplit(node) : this._drawPanel(node);
  }

  _drawSplit(node) {
    const element = h(`div.split.${node.split}`);
    const parts = node.parts.map((part) => this._draw(part));
    const set = () => parts.forEach((part, index) => { part.style.flexGrow = String(node.sizes[index]); });
    parts.forEach((part, index) => {
      if (index) element.append(this._separator(node, index, element, set));
      element.append(part);
    });
    set();
    return element;
  }

  // The separator between two parts: drag it, or move it with the arrow keys.
  _separator(node, index, element, set) {
    const total = node.sizes.reduce((sum, size) => sum + size, 0);
    const both = node.sizes[index - 1] + node.sizes[index];
    const resize = (size) => {
      const first = Math.min(Math.max(size, MIN_SIZE * total), both - MIN_SIZE * total);
      node.sizes[index - 1] = first;
      node.sizes[index] = both - first;
      set();
      updateValue();
    };
    const move = (event) => {
      const box = element.getBoundingClientRect();
      const before = node.sizes.slice(0, index - 1).reduce((sum, size) => sum + size, 0);
      const isRow = getComputedStyle(element).flexDirection === "row"; // on a narrow page all parts are below each other
      const at = isRow ? (event.clientX - box.left) / box.width : (event.clientY - box.top) / box.height;
      resize(at * total - before);
    };
    const keys = { ArrowLeft: -KEY_STEP, ArrowUp: -KEY_STEP, ArrowRight: KEY_STEP, ArrowDown: KEY_STEP, Home: -1, End: 1 };
    const handle = h("div.handle", {
      role: "separator", tabIndex: 0, "aria-label": "size of the panels", "aria-orientation": node.split === "row" ? "vertical" : "horizontal",
      "aria-valuemin": "0", "aria-valuemax": "100", title: "drag it, or move it with the arrow keys",
      onkeydown: (event) => {
        if (!keys[event.key]) return;
        event.preventDefault();
        resize(node.sizes[index - 1] + keys[event.key] * total);
        this.changed(this.tree);
      },
      onpointerdown: (event) => {
        event.target.setPointerCapture(event.pointerId);
        event.target.onpointermove = move;
        event.target.onpointerup = () => {
          event.target.onpointermove = null;
          this.changed(this.tree);
        };
      },
    });
    const updateValue = () => handle.setAttribute("aria-valuenow", String(Math.round(100 * node.sizes[index - 1] / both)));
    updateValue();
    return handle;
  }

  _drawPanel(node) {
    const panel = this.panels.find((each) => each.name === node.panel);
    const choice = h("select.kind", {
      "aria-label": "panel",
      onchange: (event) => {
        node.panel = event.target.value;
        node.settings = {};
        this._redraw();
      },
    }, this.panels.map((each) => h("option", { value: each.name, selected: each === panel }, each.title)));
    node.tools = h("span.tools");
    node.body = h("div.body", { tabIndex: -1 });
    node.note = h("div.note", { role: "alert", hidden: true });
    const grip = h("button.quiet.arrange.grip", {
      title: "drag it to another panel: to its side, or onto it to swap them; arrow keys swap them, too", "aria-label": `move ${panel.title}`,
      onpointerdown: (event) => this._drag(node, event), onkeydown: (event) => this._swapByKey(node, event),
    }, "⠿");
    return h("section.panel", { dataset: { panel: panel.name }, "aria-label": panel.title },
      h("header", { onpointerdown: (event) => { if (event.pointerType === "mouse" && event.target.matches("header, .tools, .gap")) this._drag(node, event); } },
        choice, node.tools, h("span.arrangement", {}, this.tree.parts && grip,
        h("button.quiet.arrange", { title: "add a panel to the right", "aria-label": "add a panel to the right", onclick: () => this._split(node, "row") }, halves("row")),
        h("button.quiet.arrange", { title: "add a panel below", "aria-label": "add a panel below", onclick: () => this._split(node, "column") }, halves("column")),
        h("button.quiet.arrange.close", { title: "close this panel", onclick: () => this._remove(node) }, "✕"))),
      node.note, node.body);
  }

  _mountAll(node) {
    if (node.parts) {
      node.parts.forEach((part) => this._mountAll(part));
      return;
    }
    const panel = this.panels.find((each) => each.name === node.panel);
    const { body, tools, note } = node;
    for (const key of ["body", "tools", "note"]) delete node[key]; // the tree is saved as it is
    this._bodies.set(node, body);
    const problem = (text) => {
      note.hidden = !text;
      fill(note, text);
    };
    const place = {
      body, tools, problem,
      robot: this.robot,
      settings: node.settings || {},
      save: (settings) => {
        node.settings = settings;
        this.changed(this.tree);
      },
      open: (name, settings) => this._openBeside(node, name, settings),
      restart: (settings) => {
        node.settings = settings;
        this._redraw();
      },
    };
    this._mounted.set(node, this._mount(panel, place));
  }

  // Settings from a link or file may be invalid: then the panel starts with none.
  _mount(panel, place) {
    try {
      return panel.mount(place) || {};
    } catch (error) {
      if (Object.keys(place.settings).length) {
        fill(place.body);
        fill(place.tools);
        place.body.className = "body";
        return this._mount(panel, { ...place, settings: {} });
      }
      place.problem(`this panel has failed: ${error.message}`);
      console.error(error);
      return {};
    }
  }

  _redraw() {
    this.changed(this.tree);
    this.show(this.tree);
  }

  _split(node, split, part = { panel: node.panel, settings: {} }) {
    const copy = { panel: node.panel, settings: node.settings };
    for (const key of Object.keys(node)) delete node[key];
    Object.assign(node, { split, sizes: [1, 1], parts: [copy, part] });
    this._redraw();
  }

  // Show another panel: an existing one of that kind accepts the settings, otherwise a new one is created.
  _openBeside(node, name, settings) {
    const others = [...this._mounted].filter(([other]) => other !== node);
    const known = others.find(([other, mounted]) => other.panel === name && mounted.accept);
    const same = others.find(([other]) => other.panel === name);
    if (known) known[1].accept(settings);
    else if (same && !Object.keys(settings).length) this._highlight(same[0]);
    else {
      const [at, split] = this._panelToSplit(node);
      this._split(at, split, { panel: name, settings });
    }
  }

  // Return the panel to split, and how: the requesting one if it is wide, otherwise the largest other one.
  _panelToSplit(node) {
    const size = (other) => this._bodies.get(other).getBoundingClientRect();
    const others = [...this._mounted.keys()].filter((other) => other !== node);
    if (!others.length || size(node).width >= MIN_WIDTH_FOR_TWO) return [node, "row"];
    const area = (other) => size(other).width * size(other).height;
    const largest = others.reduce((most, other) => (area(other) > area(most) ? other : most));
    return [largest, size(largest).width >= MIN_WIDTH_FOR_TWO ? "row" : "column"];
  }

  _highlight(node) {
    const panel = this._bodies.get(node).closest(".panel");
    panel.scrollIntoView({ block: "nearest" });
    panel.animate([{ outline: "2px solid var(--accent)" }, { outline: "2px solid transparent" }], 900);
  }

  _remove(node) {
    this.tree = without(this.tree, node) || { panel: this.panels[0].name, settings: {} };
    this._redraw();
  }

  // Drag a panel until the pointer is released over another one, or Escape is pressed.
  _drag(node, event) {
    const { currentTarget: from, clientX, clientY, pointerId } = event;
    if (event.button || !this.tree.parts) return;
    const mark = h("div.landing", { hidden: true });
    let place = null; // {target, side}
    const end = () => {
      mark.remove();
      from.onpointermove = from.onpointerup = from.onpointercancel = null;
      removeEventListener("keydown", escape);
    };
    const escape = ({ key }) => { if (key === "Escape") end(); };
    from.setPointerCapture(pointerId);
    addEventListener("keydown", escape);
    from.onpointermove = ({ clientX: x, clientY: y }) => {
      if (!mark.isConnected && Math.hypot(x - clientX, y - clientY) < MIN_DRAG) return;
      this.root.append(mark);
      place = this._dropTarget(node, x, y);
      mark.hidden = !place;
      if (place) Object.assign(mark.style, place.style);
    };
    from.onpointercancel = end;
    from.onpointerup = () => {
      end();
      if (place) this._applyTree(place.side === "middle" ? swapped(this.tree, node, place.target) : moved(this.tree, node, place.target, place.side));
    };
  }

  // Return the panel under the pointer, the side of it, and where the dragged one would go.
  _dropTarget(node, x, y) {
    for (const [target, body] of this._bodies) {
      const box = body.closest(".panel").getBoundingClientRect();
      if (target === node || x < box.left || x > box.right || y < box.top || y > box.bottom) continue;
      const side = sideOf(box, x, y);
      const [wide, high] = [side === "left" || side === "right" ? 0.5 : 1, side === "top" || side === "bottom" ? 0.5 : 1];
      const style = {
        left: `${box.left + (side === "right" ? box.width / 2 : 0)}px`, top: `${box.top + (side === "bottom" ? box.height / 2 : 0)}px`,
        width: `${box.width * wide}px`, height: `${box.height * high}px`,
      };
      return { target, side, style };
    }
    return null;
  }

  // Arrow keys swap a panel with its predecessor or successor.
  _swapByKey(node, event) {
    const step = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const all = panelsOf(this.tree);
    const at = all.indexOf(node) + step;
    if (!all[at]) return;
    this._applyTree(swapped(this.tree, node, all[at]));
    this.root.querySelectorAll(".grip")[at]?.focus();
  }

  // Show another tree. If it is too deep, cleaning would drop panels: then nothing changes.
  _applyTree(tree) {
    const cleaned = this._clean(tree, 0);
    if (panelsOf(cleaned).length !== panelsOf(this.tree).length) return;
    this.tree = cleaned;
    this._redraw();
  }
}

// An icon of two halves, the second one filled.
function halves(split) {
  const half = split === "row" ? { x: 8, y: 2, width: 5, height: 12 } : { x: 2, y: 8, width: 12, height: 6 };
  return s("svg", { viewBox: "0 0 16 16", width: 15, height: 15, "aria-hidden": "true" },
    s("rect", { x: 1.5, y: 1.5, width: 13, height: 13, rx: 2, fill: "none", stroke: "currentColor" }), s("rect", { ...half, width: half.width + (split === "row" ? 1 : 0), fill: "currentColor" }));
}
