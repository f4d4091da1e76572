// Local storage of the browser, and links that contain a layout.

const PREFIX = "pyros1.";
const fallback = new Map(); // fallback if the browser stores nothing, as in private windows

export function load(key) {
  try {
    return JSON.parse(fallback.get(key) ?? localStorage.getItem(PREFIX + key));
  } catch {
    return null;
  }
}

export function store(key, value) {
  const text = JSON.stringify(value);
  try {
    localStorage.setItem(PREFIX + key, text);
  } catch {
    fallback.set(key, text);
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
