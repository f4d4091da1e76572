// Helpers that create DOM elements. Strings become text nodes: nothing that is received from a robot becomes markup.

const SVG = "http://www.w3.org/2000/svg";

// Make an element: h("button.primary", {onclick: f, title: "..."}, "text", child, [children]).
export function h(tag, props, ...children) {
  return build(document.createElement(tagName(tag)), tag, props, children);
}

// Make an SVG element, in the same way; properties are set as attributes.
export function s(tag, props, ...children) {
  return build(document.createElementNS(SVG, tagName(tag)), tag, props, children);
}

function tagName(tag) {
  return tag.split(".")[0] || "div";
}

function build(element, tag, props, children) {
  for (const word of tag.split(".").slice(1)) element.classList.add(word);
  for (const [key, value] of Object.entries(props || {})) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (key === "style") Object.assign(element.style, value);
    else if (key === "dataset") Object.assign(element.dataset, value);
    else if (element instanceof SVGElement || key.includes("-") || key === "for" || key === "role") element.setAttribute(key, value);
    else if (key in element) element[key] = value;
    else element.setAttribute(key, value);
  }
  add(element, children);
  return element;
}

function add(element, children) {
  for (const child of children) {
    if (child === undefined || child === null || child === false) continue;
    if (Array.isArray(child)) add(element, child);
    else element.append(child instanceof Node ? child : String(child));
  }
}

// Replace the children of an element.
export function fill(element, ...children) {
  element.replaceChildren();
  add(element, children);
  return element;
}

// The content of a panel that has nothing to show: what is missing, and what to do.
export function empty(title, ...hints) {
  return h("div.empty", {}, h("h3", {}, title), hints.map((hint) => h("p", {}, hint)));
}

// Copy a string to the clipboard. Return whether it succeeded.
export async function copy(text) {
  if (navigator.clipboard) return navigator.clipboard.writeText(text).then(() => true, () => false);
  const focused = /** @type {HTMLElement | null} */ (document.activeElement);
  const area = h("textarea", { value: text }); // over plain http from another host there is no navigator.clipboard
  document.body.append(area);
  area.select();
  const copied = document.execCommand("copy");
  area.remove();
  focused?.focus();
  return copied;
}

// An element with a command that a click copies to the clipboard.
export function command(text) {
  const take = async ({ currentTarget: element }) => { if (await copy(text)) element.classList.add("copied"); };
  return h("code.command", {
    role: "button", tabIndex: 0, title: "click to copy", onclick: take, onkeydown: (event) => { if (event.key === "Enter") take(event); },
  }, text);
}

// Let the user save a file.
export function save(fileName, content, type) {
  const link = h("a", { href: URL.createObjectURL(new Blob([content], { type })), download: fileName });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
