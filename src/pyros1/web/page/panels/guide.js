// The guide: ROS 1 in steps that one types into a terminal, beside panels that show what happens.

import { empty, fill, h } from "../lib/dom.js";

// What to look at beside a step, by the step's name: panels, with their titles here, and their settings.
const BESIDE = {
  publisher: [["topics", "Topics"], ["graph", "Graph"]],
  look: [["graph", "Graph"], ["topics", "Topics"]],
  launch: [["graph", "Graph"], ["launches", "Launches"]],
  log: [["console", "Console"]],
  record: [["bag", "Bag"], ["plot", "Plot", { curves: ["/topic1/data"] }]],
  simulator: [["plot", "Plot", { curves: ["/velocity/data", "/force_cmd/data", "/vel_cmd/data"] }], ["graph", "Graph"]],
  parameters: [["params", "Parameters"]],
  services: [["services", "Services"]],
  frames: [["frames", "Frames"], ["scene", "3D"]],
  robot: [["scene", "3D"], ["joints", "Joints"]],
  actions: [["services", "Services"], ["topics", "Topics"]],
  machines: [["nodes", "Nodes"]],
};

export default {
  title: "Guide",
  description: "learn ROS 1 step by step",
  order: 90,
  rare: true,
  layout: { split: "row", sizes: [1, 1], parts: [{ panel: "guide" }, { panel: "graph" }] },
  mount: (place) => new Guide(place),
};

class Guide {
  constructor(place) {
    this.place = place;
    this.steps = [];
    if (!document.getElementById("guide-style")) {
      document.head.append(h("link", { id: "guide-style", rel: "stylesheet", href: "panels/guide.css" }));
    }
    this.which = h("select", { "aria-label": "step", onchange: () => this._show(this.which.selectedIndex) });
    this.back = h("button.quiet", { title: "the step before", "aria-label": "the step before", onclick: () => this._show(this.at - 1) }, "◂");
    this.next = h("button.quiet", { title: "the next step", "aria-label": "the next step", onclick: () => this._show(this.at + 1) }, "▸");
    place.tools.append(this.back, this.which, this.next);
    place.body.classList.add("guide");
    this.text = h("article.guide-text", { tabIndex: 0 });
    place.body.append(this.text);
    this._load();
  }

  unmount() {
    this.gone = true;
  }

  async _load() {
    try {
      this.steps = await this.place.robot.call("guide.steps", {});
    } catch (error) {
      if (!this.gone) this.place.problem(error.message);
      return;
    }
    if (this.gone) return;
    fill(this.which, this.steps.map((step) => h("option", { value: step.name }, `${step.number}. ${step.title}`)));
    const saved = this.steps.findIndex((step) => step.name === this.place.settings.step);
    this._show(Math.max(0, saved));
  }

  _show(index) {
    const step = this.steps[index];
    if (!step) {
      fill(this.text, empty("The guide has no steps", "Is pyros1 installed completely?"));
      return;
    }
    this.at = index;
    this.which.selectedIndex = index;
    this.back.disabled = index === 0;
    this.next.disabled = index === this.steps.length - 1;
    this.place.save({ step: step.name });
    fill(this.text, this._beside(step), blocks(step), this._end(step, this.steps[index + 1]));
    this.text.scrollTop = 0;
  }

  _beside(step) {
    const panels = BESIDE[step.name];
    if (!panels) return null;
    return h("div.guide-beside", {}, "Look at it here:", panels.map(([name, title, settings]) => (
      h("button.quiet", { title: `show ${title} beside this`, onclick: () => this.place.open(name, settings || {}) }, title))));
  }

  _end(step, next) {
    return h("div.guide-end", {},
      h("p", {}, "Done? ", copied(`pyros1 guide check ${step.number}`), " in the folder where you type says what is missing."),
      next && h("button.primary", { onclick: () => this._show(this.at + 1) }, `Next: ${next.title}`));
  }
}

// The step's blocks as elements; items that follow one another are one list.
function blocks(step) {
  const made = [];
  for (const { kind, text, language, file } of step.blocks) {
    const last = made.at(-1);
    if (kind === "title") made.push(h("h2", {}, `${step.number}. ${text}`));
    else if (kind === "heading") made.push(h("h3", {}, text));
    else if (kind === "paragraph") made.push(h("p", {}, inline(text)));
    else if (kind === "code") made.push(code(text, language, file));
    else if (last?.tagName === "UL") last.append(h("li", {}, inline(text)));
    else made.push(h("ul", {}, h("li", {}, inline(text))));
  }
  return made;
}

// `code` and *words that matter* in a line of text.
function inline(text) {
  return text.split(/(`[^`]+`|\*\w[^*]*\*)/).map((part) => {
    if (part.length > 1 && part.startsWith("`")) return h("code", {}, part.slice(1, -1));
    if (part.length > 1 && part.startsWith("*")) return h("em", {}, part.slice(1, -1));
    return part;
  });
}

function code(text, language, file) {
  if (language === "console") {
    return h("pre.guide-console", {}, text.replace(/\n$/, "").split("\n").map((line) => (
      line.startsWith("$ ") ? h("div.typed", {}, "$ ", copied(line.slice(2))) : h("div", {}, line || " "))));
  }
  const copy = h("button.quiet", { title: "copy the whole file", onclick: () => { copyText(text, copy); } }, "Copy");
  return h("figure.guide-file", {}, file && h("figcaption.mono", {}, file, copy), h("pre", {}, text));
}

// Text that a click copies.
function copied(text) {
  const button = h("button.guide-copy.mono", { title: "click to copy", onclick: () => { copyText(text, button); } }, text);
  return button;
}

async function copyText(text, button) {
  await navigator.clipboard?.writeText(text);
  button.classList.add("copied");
  setTimeout(() => button.classList.remove("copied"), 1500);
}
