// The boxes and edges by which the graph shows a ROS system. Pure.
//
// system: what the view "system" sends, see pyros1/web/system.py
// choice: {mode: "nodes" | "active" | "all", hide: [names of HIDE_OPTIONS], depth, toggled: [group]}
//   depth: levels of namespaces that become groups; -1 means one level if there are many boxes, initially folded
//   toggled: groups folded by the user, or unfolded if they are initially folded
// build(system, choice) -> {
//   boxes:  [{id, kind: "node" | "topic" | "group" | "site", name, label, group, silent, inside, text}]; inside: the boxes of
//           a folded group; text: describes a site; a site is silent while it is lost
//   edges:  [{id, from, to, links}]; links: [{topic, publisher, subscriber, state, hz, bytes}], state is one of
//           "ok", "broken" (it should exist, but does not), "unknown" (one end does not respond, or has just started)
//   groups: [{id, name, label, parent}]
//   all, cut: the number of boxes without hiding, and the number left out because there are too many
//   unheard: the number of topics of visible nodes that are hidden because they have no subscribers
// }

import { sitesOf, standIns } from "./sites.js";

export const MODES = [
  ["nodes", "Nodes only"],
  ["active", "Nodes/Topics (active)"],
  ["all", "Nodes/Topics (all)"],
];
export const HIDE_OPTIONS = [
  ["debug", "debug", "rosout, statistics, logger levels, and nodes of monitoring tools"],
  ["tf", "tf", "the topics of coordinate frames"],
  ["leaf", "leaf topics", "topics that only one node uses"],
  ["dead", "dead sinks", "topics without subscribers"],
];
export const MANY_BOXES = 150; // boxes
export const MAX_BOXES = 3000;
export const MAX_LINKS = 20000;

const DEBUG_TOPICS = /(^|\/)(rosout|rosout_agg|statistics)$/;
const DEBUG_NODES = /^\/(rosout|rqt|rqt_.*|rx(graph|plot|console).*)$/;
// Tools have names with a process id and a timestamp: /rostopic_4711_1700000000000.
const TOOL_NODES = /^\/(ros(topic|service|node|param|bag|graph|wtf|launch|msg)|rqt|rviz|pyros1|complete|tf_(echo|monitor)|view_frames)\w*_\d+(_\d+)*$/;
const UNPRINTABLE = /[\p{Cc}\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]/gu;
const SHORT_ESCAPES = { "\t": "\\t", "\n": "\\n", "\r": "\\r" };
const TF_TOPICS = /(^|\/)tf(_static)?$/;

export function build(system, choice) {
  const hide = new Set(choice.hide);
  const represented = standIns(system);
  const all = Object.keys(system.nodes).filter((name) => !represented.has(name));
  const listeners = new Set(all.filter((name) => !(hide.has("debug") && isDebugNode(name))));
  const tools = hide.has("debug") ? toolsThatMove(system, listeners) : []; // with the topics that they publish, not those that they subscribe to
  const nodes = new Set([...listeners, ...tools]);
  const names = [...nodes];
  const silent = new Set(system.silent);
  const topics = topicsOf(system, hide, nodes, listeners);
  const links = linksOf(system, topics, nodes, listeners);
  const boxes = names.sort().map((name) => makeBox("node", name, { silent: silent.has(name) }));
  let edges;
  if (choice.mode === "nodes") {
    edges = links.map((link) => [`n:${link.publisher}`, `n:${link.subscriber}`, link]);
  } else {
    const topicNames = choice.mode === "active" ? new Set(links.map((link) => link.topic)) : new Set(topics.keys());
    for (const [name, topic] of topics) if (topicNames.has(name)) boxes.push(makeBox("topic", name, { type: topic.type }));
    edges = topicEdges(topics, topicNames, links);
  }
  const far = sitesOf(system, nodes, (name, wanted) => !(hide.has("debug") && DEBUG_TOPICS.test(name)) && !(hide.has("tf") && TF_TOPICS.test(name)) && (wanted || !hide.has("dead")));
  for (const { name, lost, text } of far.sites) boxes.push(makeBox("site", name, { silent: lost, text }));
  edges.push(...far.links);
  const count = all.length + (choice.mode === "nodes" ? 0 : Object.keys(system.topics).length);
  return { ...limitBoxes(groupBoxes({ boxes, edges: mergeLinks(edges) }, choice)), all: count, unheard: choice.mode === "nodes" ? 0 : countUnheard(system, choice, topics, nodes, listeners) };
}

// Find tools that move the robot: a "topic pub" whose messages are received by a node.
function toolsThatMove(system, listeners) {
  const found = new Set();
  for (const [name, { publishers, subscribers }] of Object.entries(system.topics)) {
    if (DEBUG_TOPICS.test(name) || !subscribers.some((node) => listeners.has(node))) continue;
    for (const node of publishers) if (TOOL_NODES.test(node) && node in system.nodes) found.add(node);
  }
  return found;
}

export function isDebugNode(name) {
  return DEBUG_NODES.test(name) || TOOL_NODES.test(name);
}

// Return the visible topics with their visible publishers and subscribers.
function topicsOf(system, hide, nodes, listeners) {
  const found = new Map();
  for (const [name, topic] of Object.entries(system.topics)) {
    if ((hide.has("debug") && DEBUG_TOPICS.test(name)) || (hide.has("tf") && TF_TOPICS.test(name))) continue;
    const publishers = topic.publishers.filter((node) => nodes.has(node));
    const subscribers = topic.subscribers.filter((node) => listeners.has(node));
    if (!publishers.length && !subscribers.length) continue;
    if (hide.has("dead") && !subscribers.length) continue;
    if (hide.has("leaf") && publishers.length + subscribers.length < 2) continue;
    found.set(name, { ...topic, publishers, subscribers });
  }
  return found;
}

function countUnheard(system, { mode, hide }, topics, nodes, listeners) {
  const all = topicsOf(system, new Set(hide.filter((name) => name !== "dead" && name !== "leaf")), nodes, listeners);
  return [...all].filter(([name, { subscribers }]) => !subscribers.length && (mode === "active" || !topics.has(name))).length;
}

// Return a link per topic, publisher and subscriber: those reported by nodes, and those expected from the registrations.
function linksOf(system, topics, nodes, listeners) {
  const links = new Map();
  const add = (topic, publisher, subscriber, state, hz) => {
    const facts = topics.get(topic);
    if (!facts || !nodes.has(publisher) || !listeners.has(subscriber)) return;
    const key = `${topic} ${publisher} ${subscriber}`;
    if (links.has(key) || links.size >= MAX_LINKS) return;
    const size = facts.hz ? facts.bytes / facts.hz : null; // bytes per message
    const known = typeof hz === "number";
    links.set(key, { topic, publisher, subscriber, state, hz: known ? hz : null, bytes: known && (size !== null || !hz) ? hz * (size || 0) : null });
  };
  for (const [topic, publisher, subscriber] of system.missing) add(topic, publisher, subscriber, "broken", null);
  for (const [topic, publisher, subscriber, hz] of system.edges) add(topic, publisher, subscriber, "ok", hz);
  for (const [topic, { publishers, subscribers }] of topics) {
    for (const publisher of publishers) {
      for (const subscriber of subscribers) {
        if (links.size >= MAX_LINKS) break;
        add(topic, publisher, subscriber, "unknown", null);
      }
    }
  }
  return [...links.values()].sort((one, other) => compare(one.topic, other.topic) || compare(one.publisher, other.publisher)
    || compare(one.subscriber, other.subscriber));
}

function topicEdges(topics, topicNames, links) {
  const edges = [];
  for (const [name, { publishers, subscribers }] of topics) {
    if (!topicNames.has(name)) continue;
    const nothing = { topic: name, state: "ok", hz: null, bytes: null };
    for (const publisher of publishers) edges.push([`n:${publisher}`, `t:${name}`, { ...nothing, publisher, subscriber: "" }]);
    for (const subscriber of subscribers) edges.push([`t:${name}`, `n:${subscriber}`, { ...nothing, publisher: "", subscriber }]);
  }
  for (const link of links) {
    if (!topicNames.has(link.topic)) continue;
    edges.push([`n:${link.publisher}`, `t:${link.topic}`, link], [`t:${link.topic}`, `n:${link.subscriber}`, link]);
  }
  return edges;
}

// Combine all links between two boxes into one edge.
function mergeLinks(edges) {
  const found = new Map();
  for (const [from, to, link] of edges) {
    const id = `${from} ${to}`;
    if (!found.has(id)) found.set(id, { id, from, to, links: [] });
    found.get(id).links.push(link);
  }
  for (const edge of found.values()) {
    const real = edge.links.filter((link) => link.publisher && link.subscriber && link.topic);
    if (real.length) edge.links = real; // links that are only registrations are needed only for edges without others
  }
  return [...found.values()];
}

function makeBox(kind, name, more) {
  return { id: `${kind[0]}:${name}`, kind, name, label: name, group: "", silent: false, ...more };
}

// Put boxes into their namespaces up to a depth; a folded namespace becomes one box.
function groupBoxes({ boxes, edges }, { depth: query, toggled }) {
  const automatic = query < 0 && boxes.length > MANY_BOXES;
  const depth = query < 0 ? Number(automatic) : query;
  if (!depth) return { boxes, edges, groups: [] };
  const groups = new Map();
  for (const each of boxes) each.group = namespace(each.name, depth);
  const sizes = new Map();
  for (const each of boxes) for (const name of ancestors(each.group)) sizes.set(name, (sizes.get(name) || 0) + 1);
  const changed = new Set(toggled);
  const closed = { has: (name) => changed.has(name) !== automatic };
  const kept = new Map();
  const home = new Map(); // id of a box -> id of the box that represents it
  for (const each of boxes) {
    while (each.group && sizes.get(each.group) < 2) each.group = parent(each.group); // a frame around a single box is useless
    const line = ancestors(each.group); // from the outermost inwards
    const outermost = line.find((name) => closed.has(name));
    if (outermost === undefined) {
      for (const name of line) groups.set(name, frame(name));
      each.label = isBelow(each.name, each.group);
      kept.set(each.id, each);
      continue;
    }
    const id = `g:${outermost}`;
    home.set(each.id, id);
    if (!kept.has(id)) {
      const above = parent(outermost);
      for (const name of ancestors(above)) groups.set(name, frame(name));
      kept.set(id, { ...makeBox("group", outermost, {}), label: isBelow(outermost, above), group: above, nodes: 0, inside: [] });
    }
    kept.get(id).inside.push(each);
    kept.get(id).nodes += each.kind === "node" ? 1 : 0;
    kept.get(id).silent ||= each.silent;
  }
  const moved = edges.flatMap((edge) => {
    const from = home.get(edge.from) || edge.from;
    const to = home.get(edge.to) || edge.to;
    if (from === to && from.startsWith("g:")) return [];
    return edge.links.map((link) => [from, to, link]);
  });
  return { boxes: [...kept.values()], edges: mergeLinks(moved), groups: [...groups.values()] };
}

function frame(name) {
  return { id: `g:${name}`, name, label: isBelow(name, parent(name)), parent: parent(name) };
}

export function namespace(name, depth) {
  return name.split("/").slice(0, -1).slice(0, depth + 1).join("/");
}

function parent(name) {
  return name.slice(0, Math.max(0, name.lastIndexOf("/")));
}

function ancestors(name) {
  const found = [];
  for (let each = name; each; each = parent(each)) found.unshift(each);
  return found;
}

function isBelow(name, group) {
  return group ? name.slice(group.length + 1) : name;
}

// Keep the first boxes if there are too many to be useful, nodes before topics.
function limitBoxes({ boxes, edges, groups }) {
  if (boxes.length <= MAX_BOXES) return { boxes, edges, groups, cut: 0 };
  const kept = boxes.slice(0, MAX_BOXES);
  const ids = new Set(kept.map(({ id }) => id));
  const used = new Set(kept.flatMap(({ group }) => ancestors(group)));
  return {
    boxes: kept, cut: boxes.length - kept.length, groups: groups.filter(({ name }) => used.has(name)),
    edges: edges.filter(({ from, to }) => ids.has(from) && ids.has(to)),
  };
}

// Return the worst state of an edge's links.
export function stateOf(edge) {
  const states = new Set(edge.links.map(({ state }) => state));
  return states.has("broken") ? "broken" : states.has("unknown") ? "unknown" : "ok";
}

// Return the traffic along an edge: {hz, bytes}, null for unknown. The edges of a topic carry the same messages to each
// subscriber, so the fastest one counts from a publisher to its topic; several topics add up.
export function flowOf(edge) {
  const fastest = new Map();
  for (const { topic, publisher, subscriber, hz, bytes } of edge.links) {
    if (hz === null) continue;
    const key = edge.to.startsWith("t:") ? publisher : edge.from.startsWith("t:") ? `${publisher} ${subscriber}` : `${topic} ${publisher} ${subscriber}`;
    if (!fastest.has(key) || fastest.get(key).hz < hz) fastest.set(key, { hz, bytes });
  }
  if (!fastest.size) return { hz: null, bytes: null };
  const every = [...fastest.values()];
  return {
    hz: every.reduce((sum, each) => sum + each.hz, 0),
    bytes: every.some((each) => each.bytes === null) ? null : every.reduce((sum, each) => sum + each.bytes, 0),
  };
}

export function topicsOn(edge) {
  return [...new Set(edge.links.map(({ topic }) => topic))].filter(Boolean);
}

// Return the ids of a box and its neighbours.
export function around(model, id) {
  const found = new Set([id]);
  for (const { from, to } of model.edges) {
    if (from === id) found.add(to);
    if (to === id) found.add(from);
  }
  return found;
}

// Return the ids of the boxes that match a search, or that contain a match; null for an empty search.
export function matching(model, text) {
  const query = text.trim().toLowerCase();
  if (!query) return null;
  const fits = ({ name, type, inside }) => name.toLowerCase().includes(query) || type?.toLowerCase() === query || inside?.some(fits);
  return new Set(model.boxes.filter(fits).map(({ id }) => id));
}

// Write the model in Graphviz's dot language; in the mode "nodes", like `pyros1 graph --dot`.
export function dot(model) {
  const quote = (text) => `"${printable(text).replaceAll("\\", "\\\\").replaceAll('"', '\\"')}"`;
  const lines = ["digraph system {", "  rankdir=LR;"];
  const id = (each) => (each.kind === "node" ? each.name : each.id);
  const ids = new Map(model.boxes.map((each) => [each.id, quote(id(each))]));
  const write = (each, indent) => {
    const facts = [];
    if (each.kind !== "node") facts.push(`label=${quote(each.name)}`, "shape=box");
    if (each.silent) facts.push("style=dashed");
    lines.push(`${indent}${ids.get(each.id)}${facts.length ? ` [${facts.join(", ")}]` : ""};`);
  };
  const group = (name, indent) => {
    for (const each of model.boxes) if (each.group === name) write(each, indent);
    for (const each of model.groups) {
      if (each.parent !== name) continue;
      lines.push(`${indent}subgraph ${quote(`cluster ${each.name}`)} {`, `${indent}  label=${quote(each.name)};`);
      group(each.name, `${indent}  `);
      lines.push(`${indent}}`);
    }
  };
  group("", "  ");
  const rows = model.edges.flatMap((edge) => {
    const ofTopic = edge.from.startsWith("t:") || edge.to.startsWith("t:") || !edge.links[0].topic;
    const state = stateOf(edge);
    if (ofTopic) return [["", edge, "", state]];
    const states = new Map();
    for (const { topic, state: its } of edge.links) if (!states.has(topic) || its === "broken") states.set(topic, its);
    return [...states].map(([topic, its]) => [topic, edge, topic, its]);
  });
  rows.sort(([one, a], [other, b]) => compare(one, other) || compare(a.from, b.from) || compare(a.to, b.to));
  for (const [, { from, to }, label, state] of rows) {
    const facts = [label && `label=${quote(label)}`, state === "broken" && "color=red, style=dashed", state === "unknown" && "style=dashed"].filter(Boolean);
    lines.push(`  ${ids.get(from)} -> ${ids.get(to)}${facts.length ? ` [${facts.join(", ")}]` : ""};`);
  }
  return [...lines, "}"].join("\n") + "\n";
}

// Escape control characters and marks that change the writing direction, like `pyros1.ground.terminal_text.one_line`:
// the file may be viewed in a terminal.
function printable(text) {
  return text.replace(UNPRINTABLE, (letter) => SHORT_ESCAPES[letter] || `\\${letter < "\u0100" ? "x" : "u"}${letter.charCodeAt(0).toString(16).padStart(letter < "\u0100" ? 2 : 4, "0")}`);
}

function compare(one, other) {
  return one < other ? -1 : one > other ? 1 : 0;
}
