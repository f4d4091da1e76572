// What the browser keeps, and links that say what is shown.

const PREFIX = "pyros1.";

export function load(key) {
  try {
    return JSON.parse(localStorage.getItem(PREFIX + key));
  } catch {
    return null;
  }
}

export function store(key, value) {
  try {
    localStorage.setItem(PREFIX + key, JSON.stringify(value));
  } catch {
    // private windows may keep nothing
  }
}

// "#plot" shows a tab; "#plot=..." a whole layout.
export function linkFor(name, tree) {
  name = encodeURIComponent(name);
  if (!tree) return `${location.pathname}${location.search}#${name}`;
  const bytes = new TextEncoder().encode(JSON.stringify(tree));
  const text = btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
  return `${location.pathname}${location.search}#${name}=${text.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
}

export function fromLink(hash) {
  const [word, text] = hash.replace(/^#/, "").split("=", 2);
  let name = "";
  try {
    name = decodeURIComponent(word);
  } catch {
    // not a link of this page
  }
  if (!text) return { name, tree: null };
  try {
    const raw = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(raw, (letter) => letter.charCodeAt(0));
    return { name, tree: JSON.parse(new TextDecoder().decode(bytes)) };
  } catch {
    return { name, tree: null };
  }
}
