// The choice of the fixed frame: the root, a listed frame, or one that the user types.

import { fill, h } from "../dom.js";

const OTHER = "\n"; // not a valid frame name

export class FixedChoice {
  // chosen(frame): the user has chosen a frame; "" for the default.
  constructor(frame, chosen) {
    this.frame = frame;
    this.chosen = chosen;
    this.list = h("select.mono", { "aria-label": "fixed frame", title: "the fixed frame of the view", onchange: () => this._listed(this.list.value) });
    this.field = h("input.mono", { "aria-label": "name of the fixed frame", placeholder: "frame", size: 10, maxLength: 200, hidden: true,
      onchange: () => this._setFrame(this.field.value.trim().replace(/^\/+/, "") || this.frame), onblur: () => this._typing(false),
      onkeydown: (event) => { if (event.key === "Escape") this._typing(false); } });
    this.element = h("label.check", {}, h("span.what", {}, "fixed"), this.list, this.field);
  }

  // names: known frames; defaultText: describes the default fixed frame. Returns whether anything has changed.
  offer(names, defaultText) {
    const key = JSON.stringify([names, defaultText, this.frame]);
    if (key === this.key) return false;
    this.key = key;
    fill(this.list, h("option", { value: "" }, defaultText), names.map((name) => h("option", { value: name, selected: name === this.frame }, name)),
      h("option", { value: OTHER }, "another …"));
    return true;
  }

  _listed(name) {
    if (name === OTHER) this._typing(true);
    else this._setFrame(name);
  }

  _typing(typing) {
    this.list.hidden = typing;
    this.field.hidden = !typing;
    if (typing) this.field.focus();
    else this.list.value = this.frame;
  }

  _setFrame(frame) {
    this._typing(false);
    if (frame === this.frame) return;
    this.frame = frame;
    this.chosen(frame);
  }
}
