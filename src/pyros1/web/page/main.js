// The page: a bar with tabs, and the workspace that shows the panels of one layout.

import { copy, fill, h } from "./lib/dom.js";
import { Robot } from "./lib/robot.js";
import { panelList } from "./lib/panels.js";
import { Workspace } from "./lib/workspace.js";
import { BUILT_IN, layoutsButton } from "./lib/layouts.js";
import { fromLink, linkFor, load, store } from "./lib/store.js";

const storedTheme = load("theme");
if (storedTheme) document.documentElement.dataset.theme = storedTheme;
const token = new URLSearchParams(location.search).get("token") || "";
const robot = new Robot(token);
const panels = await panelList().catch((error) => {
  fill(document.querySelector(".loading"), `The page cannot be loaded: ${error.message}. Please reload it.`);
  throw error;
});
const bar = elementOf("bar");
const state = h("span.state", { role: "status" });
const tabs = h("nav", { "aria-label": "views" });
const menu = h("select.menu", { "aria-label": "all views", title: "all views", onchange: () => choose(menu.value) }); // for narrow windows
const workspace = new Workspace(elementOf("workspace"), panels, robot, storeLayout);
const SHORTCUTS = 9; // number of panels with a keyboard shortcut
let current = "";

fill(bar,
  h("a.logo", { href: "#", title: "pyros1", onclick: (event) => { event.preventDefault(); choose(panels[0].name); } },
    h("img", { src: "icon.svg", alt: "", width: 22, height: 22 })),
  tabs, menu,
  h("span.gap"),
  state,
  layoutsButton({ tree: () => workspace.tree, show: (name, tree) => choose(name, tree) }),
  h("button.quiet", { title: "copy a link to what is shown", "aria-label": "copy a link", onclick: copyLink }, "Link"),
  h("button.quiet", { title: "light or dark", "aria-label": "light or dark", onclick: toggleTheme }, "◐"),
);

// Return an element of index.html.
function elementOf(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html has no element ${id}`);
  return element;
}

function drawTabs() {
  const layoutName = panels.some((panel) => panel.name === current) ? null : current;
  const used = load("layouts") || {};
  fill(tabs, layoutName && h("button.tab", { "aria-current": "page", title: "a layout" }, `▦ ${layoutName}`), panels.map((panel, index) => (panel.rare && panel.name !== current && !used[panel.name] ? null : h("button.tab", {
    "aria-current": panel.name === current ? "page" : null,
    title: `${panel.description}${index < SHORTCUTS ? ` (key ${index + 1})` : ""}`,
    onclick: () => choose(panel.name),
  }, panel.title))));
  fill(menu, layoutName && h("option", { value: layoutName }, `▦ ${layoutName}`), panels.map(({ name, title }) => h("option", { value: name }, title)));
  menu.value = current;
  document.title = `${panels.find((panel) => panel.name === current)?.title || current} – pyros1`;
  scrollToTab();
}

// Scroll to the tab of the current layout; edges with more tabs behind them fade, and the menu lists all.
function scrollToTab() {
  bar.classList.remove("crowded"); // the menu needs space as well
  bar.classList.toggle("crowded", tabs.scrollWidth > tabs.clientWidth + 1);
  tabs.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest", inline: "nearest" });
  fadeEdges();
}

function fadeEdges() {
  const left = tabs.scrollLeft > 1;
  const right = tabs.scrollLeft + tabs.clientWidth < tabs.scrollWidth - 1;
  tabs.style.setProperty("--left", left ? "24px" : "0px");
  tabs.style.setProperty("--right", right ? "24px" : "0px");
}

tabs.addEventListener("scroll", fadeEdges);
new ResizeObserver(scrollToTab).observe(bar);

// Show a tab or a named layout. Each tab is a layout that starts as a single panel, or as the panel specifies.
function choose(name, tree) {
  const layouts = load("layouts") || {}; // another page in this browser may have changed them
  const known = tree || layouts[name] || Object.hasOwn(BUILT_IN, name) || panels.some((panel) => panel.name === name);
  current = known ? name : panels[0].name;
  const initial = BUILT_IN[current] || panels.find((panel) => panel.name === current)?.layout;
  workspace.show(tree || layouts[current] || (initial ? structuredClone(initial) : { panel: current }));
  if (tree) storeLayout(workspace.tree);
  drawTabs();
  history.replaceState(null, "", linkFor(current, null));
}

function storeLayout(tree) {
  store("layouts", { ...load("layouts"), [current]: tree });
}

async function copyLink() {
  const link = linkFor(current, workspace.tree);
  history.replaceState(null, "", link);
  showMessage(await copy(location.href) ? "link copied" : "the link is in the address bar");
}

let stateTimer = 0;
function showMessage(text) {
  clearTimeout(stateTimer);
  fill(state, text);
  stateTimer = setTimeout(drawState, 2000);
}

function toggleTheme() {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
  store("theme", root.dataset.theme);
  window.dispatchEvent(new Event("themechange"));
}

// The system may change its theme, for example at sunset.
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => window.dispatchEvent(new Event("themechange")));

function drawState() {
  const masterProblem = robot.state === "connected" && robot.masterProblem;
  state.className = `state ${masterProblem ? "lost" : robot.state}`;
  const text = masterProblem ? { connected: "no master" } : { connecting: "connecting …", connected: h("span.master", {}, robot.about.master.replace(/^http:\/\/|\/$/g, "")), refused: "refused" };
  fill(state, h("i.lamp"), text[robot.state], robot.about.read_only && h("span.badge", {}, "read-only"));
  state.title = robot.trouble || masterProblem || "the master";
  workspace.trouble(robot.state === "connected" ? "" : robot.trouble);
  scrollToTab(); // the bar's width has changed
}

robot.addEventListener("state", drawState);
robot.addEventListener("about", drawState);
robot.addEventListener("master", drawState);

addEventListener("keydown", (event) => {
  if ((event.target instanceof Element && event.target.matches("input, textarea, select")) || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
  const index = Number(event.key) - 1;
  if (panels[index]) choose(panels[index].name);
});
addEventListener("hashchange", showFromLink);

function showFromLink() {
  const { name, tree } = fromLink(location.hash);
  choose(name || panels[0].name, tree);
}

showFromLink();
drawState();
Object.assign(window, { robot }); // for debugging in the browser's console
