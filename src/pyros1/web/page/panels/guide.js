// The guide: an introduction to ROS 1 in steps to type into a terminal, beside panels that show the effects; and how-to pages.

import { copy, empty, fill, h } from "../lib/dom.js";

// The panels beside each step: [name, title in the guide, settings].
const PANELS_BESIDE = {
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

const PAGE_PREFIX = "howto/"; // prefix of the names of how-to pages in settings

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
    this.pages = []; // the numbered steps, followed by the other pages
    if (!document.getElementById("guide-style")) {
      document.head.append(h("link", { id: "guide-style", rel: "stylesheet", href: "panels/guide.css" }));
    }
    this.pageChoice = h("select", { "aria-label": "step or page", onchange: () => this._show(this.pageChoice.selectedIndex) });
    this.back = h("button.quiet", { title: "previous page", "aria-label": "previous page", onclick: () => this._show(this.at - 1) }, "◂");
    this.next = h("button.quiet", { title: "next page", "aria-label": "next page", onclick: () => this._show(this.at + 1) }, "▸");
    place.tools.append(h("div.guide-steps", {}, this.back, this.pageChoice, this.next));
    place.body.classList.add("guide");
    this.text = h("article.guide-text", { tabIndex: 0 });
    place.body.append(this.text);
    this._load();
  }

  unmount() {
    this.closed = true;
  }

  async _load() {
    try {
      const { robot } = this.place;
      const [steps, pages] = await Promise.all([robot.call("guide.steps", {}), robot.call("guide.pages", {})]);
      this.pages = [...steps, ...pages.map((page) => ({ ...page, name: `${PAGE_PREFIX}${page.name}` }))];
    } catch (error) {
      if (!this.closed) this.place.problem(error.message);
      return;
    }
    if (this.closed) return;
    const options = (pages) => pages.map((page) => h("option", { value: page.name }, page.heading));
    fill(this.pageChoice,
      h("optgroup", { label: "step by step" }, options(this.pages.filter((page) => page.number))),
      h("optgroup", { label: "how to" }, options(this.pages.filter((page) => !page.number))));
    this._show(Math.max(0, this._index(this.place.settings.step)));
  }

  _index(name) {
    return this.pages.findIndex((page) => page.name === name);
  }

  _show(index) {
    const page = this.pages[index];
    if (!page) {
      fill(this.text, empty("The guide has no steps", "Is pyros1 installed completely?"));
      return;
    }
    this.at = index;
    this.pageChoice.selectedIndex = index;
    this.back.disabled = index === 0;
    this.next.disabled = index === this.pages.length - 1;
    this.place.save({ step: page.name });
    fill(this.text, this._beside(page), blocks(page, (name) => this._show(this._index(`${PAGE_PREFIX}${name}`))), this._end(page));
    this.text.scrollTop = 0;
  }

  _beside(step) {
    const panels = PANELS_BESIDE[step.name];
    if (!panels) return null;
    return h("div.guide-beside", {}, "Look at it here:", panels.map(([name, title, settings]) => (
      h("button.quiet", { title: `show ${title} beside this`, onclick: () => this.place.open(name, settings || {}) }, title))));
  }

  _end(step) {
    if (!step.number) return null;
    const next = this.pages[this.at + 1];
    const result = h("p.guide-result", { role: "status", hidden: true });
    const check = h("button", { title: `the same as pyros1 guide check ${step.number}`, onclick: () => this._check(step, check, result) }, "Check the exercise");
    return h("div.guide-end", {},
      h("div.row", {}, check, next?.number && h("button.primary", { onclick: () => this._show(this.at + 1) }, `Next: ${next.title}`)),
      result);
  }

  async _check(step, button, result) {
    const say = (kind, ...text) => {
      result.hidden = false;
      result.className = `guide-result ${kind}`;
      fill(result, ...text);
    };
    button.disabled = true;
    say("", "Checking …");
    try {
      const { missing, folder } = await this.place.robot.call("guide.check", { step: step.number });
      if (missing) say("wrong", `Not yet: ${missing}`, h("small", {}, `Files are looked for in ${folder}, where pyros1 web was started.`));
      else say("good", "✓ Done.");
    } catch (error) {
      say("wrong", error.message);
    }
    button.disabled = false;
  }
}

// Convert the page's blocks to elements; consecutive items form one list. `open` shows the how-to page of a name.
function blocks(page, open) {
  const made = [];
  const inline = (text) => line(text, open);
  for (const { kind, text, language, file, rows } of page.blocks) {
    const last = made.at(-1);
    if (kind === "title") made.push(h("h2", {}, page.heading));
    else if (kind === "heading") made.push(h("h3", {}, text));
    else if (kind === "paragraph") made.push(h("p", {}, inline(text)));
    else if (kind === "table") made.push(table(rows, inline));
    else if (kind === "picture") made.push(h("figure.guide-picture", {}, h("img", { src: file, alt: text, loading: "lazy" }), h("figcaption", {}, text)));
    else if (kind === "code") made.push(code(text, language, file));
    else if (last?.tagName === "UL") last.append(h("li", {}, inline(text)));
    else made.push(h("ul", {}, h("li", {}, inline(text))));
  }
  return made;
}

function table([head, ...rows], inline) {
  const cells = (row, kind) => h("tr", {}, row.map((cell) => h(kind, {}, inline(cell))));
  return h("div.guide-table", {}, h("table", {},
    head.some(Boolean) && h("thead", {}, cells(head, "th")), h("tbody", {}, rows.map((row) => cells(row, "td")))));
}

// Convert `code`, *emphasis* and [links](page.md) in a line of text. Files of the repository are named, not linked.
function line(text, open) {
  return text.split(/(`[^`]+`|\*\w[^*]*\*|\[[^\]]+\]\([^)]+\)|<http[^>]+>)/).map((part) => {
    if (part.length > 1 && part.startsWith("`")) return h("code", {}, part.slice(1, -1));
    if (part.length > 1 && part.startsWith("*")) return h("em", {}, part.slice(1, -1));
    const [, text, to] = part.match(/^\[(.+)\]\((.+)\)$/) || part.match(/^<((http.+))>$/) || [];
    const label = text && (part.startsWith("[") ? line(text, open) : text);
    const page = to?.match(/^(\w+)\.md$/);
    if (page) return h("button.guide-link", { onclick: () => open(page[1]) }, label);
    if (to?.startsWith("http")) return h("a", { href: to, target: "_blank", rel: "noreferrer" }, label);
    return label || part;
  });
}

function code(text, language, file) {
  if (language === "console") {
    return h("pre.guide-console", {}, text.replace(/\n$/, "").split("\n").map((line) => (
      line.startsWith("$ ") ? h("div.typed", {}, "$ ", copyable(line.slice(2))) : h("div", {}, line || " "))));
  }
  const copy = h("button.quiet", { title: "copy the whole file", onclick: () => { copyText(text, copy); } }, "Copy");
  return h("figure.guide-file", {}, file && h("figcaption.mono", {}, file, copy), h("pre", {}, text));
}

// An element with a text that a click copies to the clipboard.
function copyable(text) {
  const button = h("button.guide-copy.mono", { title: "click to copy", onclick: () => { copyText(text, button); } }, text);
  return button;
}

async function copyText(text, button) {
  if (!await copy(text)) return;
  button.classList.add("copied");
  setTimeout(() => button.classList.remove("copied"), 1500);
}
