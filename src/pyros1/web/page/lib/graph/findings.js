// The findings of `pyros1 wtf` about a topic or node.

import { fill, h } from "../dom.js";

// Return an element with a button that runs the check; with atOnce, the check runs immediately. kind: "topic" or "node".
export function findings(robot, kind, name, atOnce) {
  const element = h("div.findings", { role: "status" });
  const ask = async () => {
    fill(element, h("p.muted", {}, `checking ${name} …`));
    try {
      show(element, await robot.call(`doctor.${kind}`, { [kind]: name }), ask);
    } catch (error) {
      fill(element, h("p.trouble", {}, error.message), button(ask, "Check again"));
    }
  };
  if (atOnce) ask();
  else fill(element, button(ask, "Check"));
  return element;
}

function show(element, found, ask) {
  fill(element, found.length ? found.map(({ severity, text, items, cure }) => h(`div.finding.${severity}`, {},
    h("p", {}, text), items.length > 0 && h("ul", {}, items.slice(0, 20).map((item) => h("li.mono", {}, item))), h("p.cure", {}, h("b", {}, "fix: "), cure)))
    : h("p.fine", {}, "No problems found."), button(ask, "Check again"));
}

function button(onclick, text) {
  return h("button", { title: "what pyros1 wtf finds here", onclick }, text);
}
