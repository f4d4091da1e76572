// Small widgets used by several panels.

import { copy, fill, h } from "../lib/dom.js";

// An element with a text that a click copies to the clipboard.
export function copyable(text, shown = text) {
  const element = h("button.copy.mono", { title: `click to copy ${text}`, onclick: () => {
    copy(text);
    element.classList.add("done");
    setTimeout(() => element.classList.remove("done"), 1000);
  } }, shown);
  return element;
}

// A button that asks for confirmation; act() may return a promise.
export function confirmButton(label, question, act, props = {}) {
  const holder = h("span.asking");
  const button = h("button.danger", { ...props, onclick: ask }, label);
  function ask() {
    const no = h("button", { onclick: back }, "No");
    fill(holder, h("span", { role: "alert" }, question), h("button.danger", { onclick: () => { back(); act(); } }, "Yes"), no);
    no.focus();
  }
  function back() {
    fill(holder, button);
  }
  back();
  return holder;
}

// Tabs: [[title, make() -> {element, close?}], ...]. Returns {element, close, choose}.
export function tabbed(tabs, first = 0, /** @type {(index: number) => void} */ onchange = () => {}) {
  const place = h("div.tabbed-body");
  const bar = h("div.tabbar", { role: "tablist" });
  let shown = null;
  const buttons = tabs.map(([title], index) => h("button.tab", {
    role: "tab", onclick: () => choose(index),
    onkeydown: (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const next = (index + step + tabs.length) % tabs.length;
      choose(next);
      buttons[next].focus();
    },
  }, title));
  function choose(index) {
    shown?.close?.();
    shown = tabs[index][1]();
    fill(place, shown.element);
    buttons.forEach((button, at) => button.setAttribute("aria-selected", String(at === index)));
    buttons.forEach((button, at) => button.toggleAttribute("aria-current", at === index));
    onchange(index);
  }
  fill(bar, buttons);
  choose(Math.min(first, tabs.length - 1));
  return { element: h("div.tabbed", {}, bar, place), close: () => shown?.close?.(), choose, get shown() { return shown; } };
}

// A line that reports success or failure: say(text), fail(text).
export function outcome() {
  const element = h("div.outcome", { role: "status", hidden: true });
  const set = (text, wrong) => {
    element.hidden = !text;
    element.classList.toggle("wrong", wrong);
    if (element.textContent !== text) fill(element, text);
  };
  return { element, say: (text) => set(text, false), fail: (text) => set(text, true) };
}

// Names as links to another panel; long lists are truncated.
export function nameLinks(names, open, most = 30) {
  if (!names.length) return h("span.muted", {}, "none");
  return h("span.links", {}, names.slice(0, most).map((name) => h("button.link.mono", { onclick: () => open(name) }, name)),
    names.length > most && h("span.muted", {}, `and ${names.length - most} more`));
}

// A definition list: [[label, element or text], ...].
export function definitionList(pairs) {
  return h("dl", {}, pairs.filter(Boolean).map(([label, value]) => [h("dt", {}, label), h("dd", {}, value)]));
}
