// Layouts: named arrangements of panels. Some are built in; users save their own, in the browser or in a file.

import { fill, h, save } from "./dom.js";
import { load, store } from "./store.js";

const FORMAT = "pyros1 layout 1";

export const BUILT_IN = {
  Tutorial: {
    split: "column", sizes: [3, 2], parts: [
      { split: "row", sizes: [1, 1], parts: [
        { panel: "graph" },
        { panel: "plot", settings: { curves: ["/velocity/data", "/force_cmd/data", "/vel_cmd/data"] } },
      ] },
      { split: "row", sizes: [1, 1], parts: [{ panel: "topics" }, { panel: "console" }] },
    ],
  },
  "Mobile robot": {
    split: "column", sizes: [3, 2], parts: [
      { split: "row", sizes: [2, 5], parts: [
        { split: "column", sizes: [1, 1], parts: [{ panel: "topics" }, { panel: "nodes" }] },
        { panel: "scene", settings: { topics: ["/map", "/scan"] } },
      ] },
      { split: "row", sizes: [1, 1], parts: [
        { panel: "console", settings: { hidden: [1] } },
        { panel: "plot", settings: { curves: [
          "/cmd_vel/linear/x", "/cmd_vel/angular/z", "/odom/twist/twist/linear/x", "/odom/twist/twist/angular/z",
        ] } },
      ] },
    ],
  },
  Arm: {
    split: "row", sizes: [3, 2], parts: [
      { split: "column", sizes: [2, 1], parts: [
        { panel: "scene" },
        { panel: "plot", settings: { curves: ["/joint_states/position[:]"] } },
      ] },
      { split: "column", sizes: [2, 1], parts: [{ panel: "joints" }, { panel: "console" }] },
    ],
  },
  Bag: {
    split: "column", sizes: [3, 2], parts: [
      { panel: "bag" },
      { split: "row", sizes: [1, 1], parts: [{ panel: "topics" }, { panel: "console" }] },
    ],
  },
};

// The button in the bar, and the dialog that it opens. host: {tree() -> the current arrangement, show(name, tree)}.
export function layoutsButton(host) {
  let own = load("own_layouts") || {};
  const keep = () => store("own_layouts", own);
  const sheet = h("dialog.layouts", { "aria-label": "layouts" });
  const problem = h("p.wrong", { hidden: true });
  const name = h("input", { placeholder: "name", "aria-label": "name of the layout", maxLength: 60 });
  const file = h("input", { type: "file", accept: ".json,application/json", hidden: true, onchange: () => read(file.files[0]) });

  const choose = (title, tree) => {
    sheet.close();
    host.show(title, structuredClone(tree));
  };
  const read = async (chosen) => {
    file.value = "";
    try {
      const content = JSON.parse(await chosen.text());
      if (content.form !== FORMAT || !content.tree) throw new Error();
      own[content.name || chosen.name] = content.tree;
      keep();
      draw();
    } catch {
      problem.hidden = false;
      fill(problem, `${chosen.name} is not a layout of this page`);
    }
  };
  const row = (title, tree, isOwn) => h("li", {},
    h("button.quiet.title", { onclick: () => choose(title, tree) }, title),
    h("button.quiet", { title: "save to a file", onclick: () => save(`${title}.json`, JSON.stringify({ form: FORMAT, name: title, tree }, null, 1), "application/json") }, "File"),
    isOwn && h("button.quiet", { title: "delete", "aria-label": `delete ${title}`, onclick: () => { delete own[title]; keep(); draw(); } }, "✕"));
  const draw = () => fill(sheet,
    h("h3", {}, "Layouts"),
    h("ul", {}, Object.entries(BUILT_IN).map(([title, tree]) => row(title, tree, false)), Object.entries(own).map(([title, tree]) => row(title, tree, true))),
    h("form", { method: "dialog", onsubmit: (event) => {
      event.preventDefault();
      if (!name.value.trim()) return;
      own[name.value.trim()] = structuredClone(host.tree());
      keep();
      name.value = "";
      draw();
    } }, name, h("button.primary", {}, "Save current layout")),
    problem,
    h("div.row", {}, h("button", { onclick: () => file.click() }, "Load from file …"), file, h("span.gap"), h("button", { onclick: () => sheet.close() }, "Close")));
  document.body.append(sheet);
  sheet.addEventListener("click", (event) => { if (event.target === sheet) sheet.close(); });
  return h("button.quiet", { title: "layouts of panels: built-in, your own, from files", onclick: () => { own = load("own_layouts") || {}; problem.hidden = true; draw(); sheet.showModal(); } }, "Layouts");
}
