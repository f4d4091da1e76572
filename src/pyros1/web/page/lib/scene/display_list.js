// The list beside the scene: displays with their status and options, and what can be added.

import { fill, h } from "../dom.js";

export class DisplayList {
  // host: {entries() -> [{key, title, kind, display, trouble, fixed}], hidden(key), show(key, shown), remove(key),
  //        option(key, name, value), offers() -> [{key, title, kind, text, field}], add(key), open() a file}
  constructor(element, host) {
    this.element = element;
    this.host = host;
    this.open = new Set(); // keys of entries whose options are visible
    this.lines = new Map(); // key -> the line with the status
  }

  draw() {
    const entries = this.host.entries();
    const offers = this.host.offers();
    this.lines = new Map();
    const active = /** @type {HTMLElement | null} */ (document.activeElement);
    const focused = active && this.element.contains(active) ? active.dataset.mark : null;
    fill(this.element, h("h4", {}, h("button.quiet.fold-displays", { "aria-expanded": String(this.element.classList.contains("open")), onclick: ({ currentTarget }) => currentTarget.setAttribute("aria-expanded", String(this.element.classList.toggle("open"))) }, `Displays (${entries.length})`), h("button.quiet", { title: "show the displays of an rviz file", onclick: () => this.host.open() }, "Open …")), entries.map((entry) => this._row(entry)),
      offers.length ? h("h4", {}, "Add") : entries.every(({ fixed }) => fixed) && h("p.muted", {}, "No topics are published that can be drawn: scans, clouds, maps, markers, paths, poses, images."),
      offers.map((offer) => (offer.field ? this._field(offer) : h("button.quiet.add", { title: offer.text, onclick: () => this.host.add(offer.key) }, "+ ", h("span.mono", {}, offer.title), " ", h("span.muted", {}, offer.kind)))));
    if (focused) [...this.element.querySelectorAll("[data-mark]")].find((each) => each.dataset.mark === focused)?.focus();
    for (const entry of entries) this.updateStatus(entry);
  }

  // Update the status of a display.
  updateStatus(/** @type {import("../../panels/scene.js").Entry} */ { key, display, trouble }) {
    const line = this.lines.get(key);
    if (!line) return;
    const problem = trouble || display.problem;
    const text = problem || display.status || "";
    const look = `word${problem ? " wrong" : " muted"}`;
    if (line.className !== look) line.className = look;
    if (line.textContent !== text) line.textContent = text;
  }

  // An entry to add something by its name.
  _field({ key, title, kind, text }) {
    const field = h("input.mono", { placeholder: title, "aria-label": text, title: text, maxLength: 200 });
    return h("form.add", { onsubmit: (event) => {
      event.preventDefault();
      const name = field.value.trim();
      if (name) this.host.add(`${key}${name.startsWith("/") ? "" : "/"}${name}`);
    } }, field, h("button.quiet", {}, "+ ", h("span.muted", {}, kind)));
  }

  _row({ key, title, kind, display, fixed }) {
    const line = h("div.word");
    this.lines.set(key, line);
    const controls = Object.entries(display.controls || {});
    const open = this.open.has(key);
    return h("div.display", {},
      h("label.check", {}, h("input", { type: "checkbox", checked: !this.host.hidden(key), onchange: (event) => this.host.show(key, event.target.checked) }),
        h("span.mono", { title: `${title}: ${kind}` }, title)),
      h("span.acts", {},
        controls.length > 0 && h("button.quiet", { title: "options", "aria-label": `options of ${title}`, "aria-expanded": String(open), dataset: { mark: `options ${key}` }, onclick: () => { this.open[open ? "delete" : "add"](key); this.draw(); } }, open ? "▾" : "▸"),
        !fixed && h("button.quiet", { title: "remove", "aria-label": `remove ${title}`, onclick: () => this.host.remove(key) }, "✕")),
      line,
      open && h("div.options", {}, controls.map(([name, control]) => this._control(key, display, name, control))));
  }

  _control(key, display, name, { text, kind, least, most, step, choices, none = "automatic" }) {
    const value = display.options[name];
    const mark = { mark: `${key} ${name}` };
    const set = (changed) => this.host.option(key, name, changed);
    if (kind === "check") return h("label.check", {}, h("input", { type: "checkbox", checked: value ?? true, dataset: mark, onchange: (event) => set(event.target.checked) }), text);
    let field;
    if (kind === "choice") field = h("select", { dataset: mark, onchange: (event) => set(event.target.value) }, choicesOf(choices, value).map((each) => h("option", { value: each, selected: each === value }, each || none)));
    else if (kind === "number") field = h("input", { type: "number", min: least, max: most, step, value, dataset: mark, onchange: (event) => { const number = Number(event.target.value); if (number >= least && number <= most) set(number); else event.target.value = display.options[name]; } });
    else if (kind === "colour") field = h("input", { type: "color", value, dataset: mark, onchange: (event) => set(event.target.value) });
    else field = h("input", { value: value ?? "", placeholder: none, dataset: mark, onchange: (event) => set(event.target.value.trim()) });
    return h("label.option", {}, h("span", {}, text), field);
  }
}

// Choices may change while the panel is open; the current value always remains among them.
function choicesOf(choices, value) {
  return typeof choices === "function" ? [...new Set(["", ...choices(), value])] : choices;
}
