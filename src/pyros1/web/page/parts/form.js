// A form for a message, built from its definition: see pyros1/web/models/forms.py for the fields.

import { fill, h } from "../lib/dom.js";

const INTEGER_BITS = { int8: 7, int16: 15, int32: 31, int64: 63, byte: 7, uint8: 8, char: 8, uint16: 16, uint32: 32, uint64: 64 };
const FLOATS = new Set(["float32", "float64"]);
const MAX_ITEMS = 200; // maximum number of array items to show

// fields: [[name, type, fields or null, choices or null], ...]; value: the message as JSON, which the form edits.
// onchange(): called after each change; then `problems` lists the invalid fields.
export class Form {
  constructor(fields, value, onchange) {
    this.onchange = onchange;
    this.problems = new Map(); // element -> message
    this.element = h("div.form");
    if (fields.length) fill(this.element, this._fields(fields, value, 0));
    else fill(this.element, h("p.muted.hint", {}, "There is nothing to fill in."));
  }

  get problem() {
    for (const [element, text] of this.problems) if (element.isConnected) return text;
    return "";
  }

  _fields(fields, value, depth) {
    return fields.map((field) => {
      const [name, kind] = field;
      return this._field(field, depth, () => value[name], (newValue) => { value[name] = newValue; this.onchange(); }, name, kind);
    });
  }

  _field([, kind, inner, choices], depth, get, set, label, type) {
    if (kind.endsWith("]")) return this._array(kind, inner, choices, depth, get, set, label);
    if (kind.includes("/")) return this._message(kind, inner, depth, get, set, label);
    const control = this._control(kind, choices, get, set, `${label} (${type})`);
    return h("label.row", {}, h("span.label", {}, label), h("span.type", {}, type), control);
  }

  _message(kind, inner, depth, get, set, label) {
    const value = get();
    if (!inner || typeof value !== "object" || value === null) {
      return h("div.row", {}, h("span.label", {}, label), h("span.type", {}, kind), h("span.muted", {}, "YAML only"));
    }
    return h("details.group", { open: depth < 3 && !(label === "header" && depth > 0) },
      h("summary", {}, h("span.label", {}, label), h("span.type", {}, kind)),
      h("div.inner", {}, this._fields(inner, value, depth + 1)));
  }

  _control(kind, choices, get, set, label) {
    if (kind === "bool") {
      return h("input", { type: "checkbox", checked: Boolean(get()), "aria-label": label, onchange: (event) => set(event.target.checked) });
    }
    if (kind === "string") return this._text(choices, get, set, label);
    if (kind === "time" || kind === "duration") return this._time(kind, get, set, label);
    return this._number(kind, choices, get, set, label);
  }

  _text(choices, get, set, label) {
    const area = h("textarea.string", { rows: Math.min(6, String(get()).split("\n").length), value: String(get()), "aria-label": label, spellcheck: false,
      oninput: () => { set(area.value); area.rows = Math.min(6, area.value.split("\n").length); } });
    return choices ? this._withChoices(choices, area, get, set) : area;
  }

  _number(kind, choices, get, set, label) {
    const input = h("input.num", { value: numberText(get()), size: 12, inputMode: "decimal", "aria-label": label, spellcheck: false, autocomplete: "off", oninput: () => {
      const { value, problem } = readNumber(input.value, kind);
      if (this._validate(input, problem && `${label}: ${problem}`)) set(value);
    } });
    return choices ? this._withChoices(choices, input, get, set) : input;
  }

  _withChoices(choices, input, get, set) {
    const select = h("select", { "aria-label": "choices", onchange: () => {
      const chosen = choices[Number(select.value)];
      if (!chosen) return;
      input.value = String(chosen[1]);
      this._validate(input, "");
      set(chosen[1]);
    } }, h("option", { value: "" }, "…"), choices.map(([name], index) => h("option", { value: index }, name)));
    const show = () => { const at = choices.findIndex(([, value]) => value === get()); select.value = at < 0 ? "" : String(at); };
    show();
    input.addEventListener("input", show);
    return h("span.choice", {}, select, input);
  }

  _time(kind, get, set, label) {
    const input = h("input.num", { value: timeText(get()), size: 20, "aria-label": label, spellcheck: false, autocomplete: "off", title: kind === "time" ? "seconds, or now" : "seconds", oninput: () => {
      const { value, problem } = readTime(input.value, kind);
      if (this._validate(input, problem && `${label}: ${problem}`)) set(value);
    } });
    if (kind === "duration") return input;
    return h("span.choice", {}, input, h("button", { type: "button", title: "the time of publication", onclick: () => { input.value = "now"; this._validate(input, ""); set("now"); } }, "now"));
  }

  _validate(input, problem) {
    input.setAttribute("aria-invalid", String(Boolean(problem)));
    if (problem) this.problems.set(input, problem);
    else this.problems.delete(input);
    if (problem) this.onchange();
    return !problem;
  }

  _array(kind, inner, choices, depth, get, set, label) {
    const base = kind.slice(0, kind.indexOf("["));
    const fixed = kind.slice(kind.indexOf("[") + 1, -1);
    if (base in INTEGER_BITS || FLOATS.has(base)) return this._numbers(kind, base, fixed && Number(fixed), get, set, label);
    const list = h("div.inner");
    const count = h("span.muted");
    const draw = () => {
      const items = get();
      fill(count, `${items.length} item${items.length === 1 ? "" : "s"}`);
      fill(list, items.slice(0, MAX_ITEMS).map((_, index) => h("div.item", {},
        this._field(["", base, inner, choices], depth + 1, () => get()[index], (newValue) => { get()[index] = newValue; this.onchange(); }, `[${index}]`, base),
        !fixed && h("button.quiet", { type: "button", title: "remove", "aria-label": `remove ${label}[${index}]`, onclick: () => { get().splice(index, 1); draw(); this.onchange(); } }, "✕"))),
      items.length > MAX_ITEMS && h("p.muted", {}, "The others are shown as YAML."),
      !fixed && h("button.add", { type: "button", onclick: () => { get().push(blank(base, inner)); draw(); this.onchange(); } }, `Add to ${label}`));
    };
    if (!Array.isArray(get())) set([]);
    draw();
    return h("details.group", { open: true }, h("summary", {}, h("span.label", {}, label), h("span.type", {}, kind), count), list);
  }

  _numbers(kind, base, fixed, get, set, label) {
    const value = get();
    const numbers = typeof value === "string" ? parseBase64(value) : value;
    const area = h("textarea.num", { rows: Math.min(4, 1 + Math.floor(numbers.length / 12)), value: numbers.map(numberText).join(", "), placeholder: "1, 2, 3", "aria-label": `${label} (${kind})`, spellcheck: false, oninput: () => {
      const words = area.value.split(/[\s,;[\]]+/).filter(Boolean);
      const read = words.map((word) => readNumber(word, base));
      const wrong = read.find((each) => each.problem);
      const problem = wrong ? wrong.problem : fixed && words.length !== fixed ? `${fixed} numbers are needed, not ${words.length}` : "";
      if (this._validate(area, problem && `${label}: ${problem}`)) set(read.map((each) => each.value));
    } });
    return h("label.row", {}, h("span.label", {}, label), h("span.type", {}, kind), area);
  }
}

// Return an empty value of a type with the given fields.
export function blank(kind, fields) {
  if (kind.endsWith("]")) {
    const base = kind.slice(0, kind.indexOf("["));
    const length = Number(kind.slice(kind.indexOf("[") + 1, -1)) || 0;
    return Array.from({ length }, () => blank(base, fields));
  }
  if (fields) {
    const value = Object.fromEntries(fields.map(([name, type, inner]) => [name, blank(type, inner)]));
    return kind === "geometry_msgs/Quaternion" ? { ...value, w: 1 } : value; // the identity; all zeros are not a rotation
  }
  if (kind === "string") return "";
  if (kind === "bool") return false;
  if (kind === "time" || kind === "duration") return { secs: 0, nsecs: 0 };
  return 0;
}

function parseBase64(text) {
  try {
    return [...atob(text)].map((letter) => letter.charCodeAt(0));
  } catch {
    return [];
  }
}

function numberText(value) {
  return { NaN: "nan", Infinity: "inf", "-Infinity": "-inf" }[value] ?? String(value);
}

// Parse a number: {value}, or {problem}.
export function readNumber(text, kind) {
  const word = text.trim().toLowerCase();
  if (FLOATS.has(kind)) {
    const special = { nan: "NaN", inf: "Infinity", "+inf": "Infinity", "-inf": "-Infinity" }[word];
    if (special) return { value: special };
    const value = Number(word);
    if (word === "" || Number.isNaN(value)) return { problem: "not a number" };
    return Number.isFinite(value) ? { value } : { problem: "too large; write inf for infinity" };
  }
  if (!/^[+-]?\d+$/.test(word)) return { problem: "not a whole number" };
  const bits = INTEGER_BITS[kind] ?? 31;
  const signed = kind.startsWith("int") || kind === "byte";
  const [least, most] = signed ? [-(2n ** BigInt(bits)), 2n ** BigInt(bits) - 1n] : [0n, 2n ** BigInt(bits) - 1n];
  const whole = BigInt(word.replace("+", ""));
  if (whole < least || whole > most) return { problem: `${kind} is from ${least} to ${most}` };
  return { value: Number.isSafeInteger(Number(whole)) ? Number(whole) : String(whole) }; // a string, since JavaScript would round it
}

export function timeText(value) {
  if (typeof value === "string") return value;
  const { secs = 0, nsecs = 0 } = value || {};
  const whole = secs < 0 && nsecs ? secs + 1 : secs;
  const part = secs < 0 && nsecs ? 1e9 - nsecs : nsecs;
  const sign = secs < 0 && nsecs && !whole ? "-" : "";
  return part ? `${sign}${whole}.${String(part).padStart(9, "0").replace(/0+$/, "")}` : String(secs);
}

export function readTime(text, kind) {
  const word = text.trim();
  if (word === "now" && kind === "time") return { value: "now" };
  const match = /^(-?)(\d+)(?:\.(\d{0,9}))?$/.exec(word);
  if (!match) return { problem: kind === "time" ? "seconds, or now" : "not a number of seconds" };
  const [, sign, whole, part = ""] = match;
  if (sign && kind === "time") return { problem: "times are not negative" };
  let [secs, nsecs] = [Number(whole), Number(part.padEnd(9, "0"))];
  if (sign) [secs, nsecs] = nsecs ? [-secs - 1, 1e9 - nsecs] : [-secs, 0];
  if (secs < -(2 ** 31) || secs >= 2 ** (kind === "time" ? 32 : 31)) return { problem: "too many seconds" };
  return { value: { secs, nsecs } };
}
