// Commands for a launched process, and their buttons.

import { h } from "../../lib/dom.js";

const BUTTON_TEXTS = {
  stop: ["Stop", "■", "stop it; its launch does not restart it"],
  start: ["Start", "▶", "start it as in its launch file"],
  restart: ["Restart", "↻", "stop it and start it again"],
};

// Return the commands for a process in some state; none if the page is read-only.
export function commandsFor(launch, entry) {
  if (launch.facts.refusal || launch.panel.place.robot.about.read_only) return [];
  if (entry.state === "running" || entry.state === "stopping") return ["restart", "stop"];
  return entry.state === "waiting" ? ["start", "stop"] : ["start"];
}

export function commandButton(verb, small, act, disabled = false) {
  const [word, sign, about] = BUTTON_TEXTS[verb];
  const props = { title: `${word}: ${about}`, "aria-label": word, disabled, onclick: act };
  return small ? h("button.quiet.verb", props, sign) : h("button", props, `${sign} ${word}`);
}
