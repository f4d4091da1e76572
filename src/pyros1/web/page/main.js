// The page: a bar with tabs, and the workspace that shows the panels of one layout.

import { copy, fill, h } from "./lib/dom.js";
import { Robot } from "./lib/robot.js";
import { panelList } from "./lib/panels.js";
import { Workspace } from "./lib/workspace.js";
import { BUILT_IN, layoutsButton } from "./lib/layouts.js";
import { fromLink, linkFor, load, store } from "./lib/store.js";

const theme0 = load("theme");
if (theme0) document.documentElement.dataset.theme = theme0;
const token = new URLSearchParams(location.search).get("token") || "";
const robot = new Robot(token);
const panels = await panelList().catch((error) => {
  fill(document.querySelector(".loading"), `The page cannot be loaded: ${error.message}. Please reload it.`);
  throw error;
});
const bar = document.getElementById("bar");
const state = h("span.state", { role: "status" });
const tabs = h("nav", { "aria-label": "views" });
const menu = h("select.menu", { "aria-label": "all views", title: "all views", onchange: () => choose(menu.value) }); // for narrow windows
const workspace = new Workspace(document.getElementById("workspace"), panels, robot, changed);
const SHORTCUTS = 9; // number of panels with a keyboard shortcut
let current = "";

fill(bar,
  h("a.logo", { href: "#", title: "pyros1", onclick: (event) => { event.preventDefault(); choose(panels[0].name); } },
    h("img", { src: "icon.svg", alt: "", width: 22, height: 22 })),
  tabs, menu,
  h("span.gap"),
  state,
  layoutsButton({ tree: () => workspace.tree, show: (name, tree) => choose(name, tree) }),
  h("button.quiet", { title: "copy a link to what is shown", "aria-label": "copy a link", onclick: share }, "Link"),
  h("button.quiet", { title: "light or dark", "aria-label": "light or dark", onclick: theme }, "◐"),
);

function drawTabs() {
  const other = panels.some((panel) => panel.name === current) ? null : current;
  const used = load("layouts") || {};
  fill(tabs, other && h("button.tab", { "aria-current": "page", title: "a layout" }, `▦ ${other}`), panels.map((panel, index) => (panel.rare && panel.name !== current && !used[panel.name] ? null : h("button.tab", {
    "aria-current": panel.name === current ? "page" : null,
    title: `${panel.description}${index < SHORTCUTS ? ` (key ${index + 1})` : ""}`,
    onclick: () => choose(panel.name),
  }, panel.title))));
  fill(menu, other && h("option", { value: other }, `▦ ${other}`), panels.map(({ name, title }) => h("option", { value: name }, title)));
  menu.value = current;
  document.title = `${panels.find((panel) => panel.name === current)?.title || current} – pyros1`;
  seeTab();
}

// Scroll to the tab of the current layout; edges with more tabs behind them fade, and the menu lists all.
function seeTab() {
  bar.classList.remove("crowded"); // the menu needs space as well
  bar.classList.toggle("crowded", tabs.scrollWidth > tabs.clientWidth + 1);
  tabs.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest", inline: "nearest" });
  fade();
}

function fade() {
  const left = tabs.scrollLeft > 1;
  const right = tabs.scrollLeft + tabs.clientWidth < tabs.scrollWidth - 1;
  tabs.style.setProperty("--left", left ? "24px" : "0px");
  tabs.style.setProperty("--right", right ? "24px" : "0px");
}

tabs.addEventListener("scroll", fade);
new ResizeObserver(seeTab).observe(bar);

// Show a tab or a named layout. Each tab is a layout that starts as a single panel, or as the panel specifies.
function choose(name, tree) {
  const layouts = load("layouts") || {}; // another page in this browser may have changed them
  const known = tree || layouts[name] || Object.hasOwn(BUILT_IN, name) || panels.some((panel) => panel.name === name);
  current = known ? name : panels[0].name;
  const begun = BUILT_IN[current] || panels.find((panel) => panel.name === current)?.layout;
  workspace.show(tree || layouts[current] || (begun ? structuredClone(begun) : { panel: current }));
  if (tree) changed(workspace.tree);
  drawTabs();
  history.replaceState(null, "", linkFor(current, null));
}

function changed(tree) {
  store("layouts", { ...load("layouts"), [current]: tree });
}

async function share() {
  const link = linkFor(current, workspace.tree);
  history.replaceState(null, "", link);
  say(await copy(location.href) ? "link copied" : "the link is in the address bar");
}

let saying = 0;
function say(text) {
  clearTimeout(saying);
  fill(state, text);
  saying = setTimeout(drawState, 2000);
}

function theme() {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
  store("theme", root.dataset.theme);
  window.dispatchEvent(new Event("themechange"));
}

// The system may change its theme, for example at sunset.
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => window.dispatchEvent(new Event("themechange")));

function drawState() {
  const lost = robot.state === "connected" && robot.lost;
  state.className = `state ${lost ? "lost" : robot.state}`;
  const text = lost ? { connected: "no master" } : { connecting: "connecting …", connected: h("span.master", {}, robot.about.master.replace(/^http:\/\/|\/$/g, "")), refused: "refused" };
  fill(state, h("i.lamp"), text[robot.state], robot.about.read_only && h("span.badge", {}, "read-only"));
  state.title = robot.trouble || lost || "the master";
  workspace.trouble(robot.state === "connected" ? "" : robot.trouble);
  seeTab(); // the bar's width has changed
}

robot.addEventListener("state", drawState);
robot.addEventListener("about", drawState);
robot.addEventListener("master", drawState);

addEventListener("keydown", (event) => {
  if ((event.target instanceof Element && event.target.matches("input, textarea, select")) || event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
  const index = Number(event.key) - 1;
  if (panels[index]) choose(panels[index].name);
});
addEventListener("hashchange", begin);

function begin() {
  const { name, tree } = fromLink(location.hash);
  choose(name || panels[0].name, tree);
}

begin();
drawState();
Object.assign(window, { robot }); // for debugging in the browser's console
