// Bridges in the graph: other sites are shown as boxes beside their bridge, with the topics that they exchange. Pure.
//
// bridges: as in the system that pages get, see pyros1/web/transforms/bridges.py

// Return the local nodes that represent nodes of other sites; the graph shows the sites instead.
export function standIns(system) {
  return new Set((system.bridges || []).flatMap(({ sites }) => sites.flatMap(({ nodes }) => nodes)));
}

// Return {sites: [{name, lost, text}], links: [[from, to, link]]}.
// nodes: the nodes that are shown; isShown(topic, wanted): whether a topic is shown
export function sitesOf(system, nodes, isShown) {
  const sites = new Map();
  const links = [];
  for (const bridge of system.bridges || []) {
    if (!nodes.has(bridge.node)) continue;
    const lost = new Set();
    for (const { name, state, round_trip: trip } of bridge.sites) {
      if (state !== "present") lost.add(name);
      const known = sites.get(name);
      if (known && !known.lost) continue; // another bridge reaches it
      const text = state === "present" ? `site${trip === null ? "" : ` · ${(trip * 1000).toFixed(trip < 0.01 ? 1 : 0)} ms`}` : state === "lost" ? "site lost" : "does not answer";
      sites.set(name, { name, lost: state !== "present", text });
    }
    for (const { topic, site, out, wanted, hz, bytes, dropped } of bridge.flows) {
      if (!sites.has(site) || !isShown(topic, wanted)) continue;
      const state = lost.has(site) ? "broken" : "ok";
      const [from, to] = out ? [`n:${bridge.node}`, `s:${site}`] : [`s:${site}`, `n:${bridge.node}`];
      const [publisher, subscriber] = out ? [bridge.node, site] : [site, bridge.node];
      links.push([from, to, { topic, publisher, subscriber, state, hz: state === "ok" ? hz : null, bytes: state === "ok" ? bytes : null, dropped }]);
    }
    for (const name of sites.keys()) { // a site without topics still belongs to its bridge
      if (bridge.sites.some((site) => site.name === name) && !links.some(([from, to]) => from === `s:${name}` || to === `s:${name}`)) {
        links.push([`n:${bridge.node}`, `s:${name}`, { topic: "", publisher: "", subscriber: "", state: lost.has(name) ? "broken" : "ok", hz: null, bytes: null, dropped: {} }]);
      }
    }
  }
  return { sites: [...sites.values()].sort((one, other) => (one.name < other.name ? -1 : 1)), links };
}

// Return what is known about a site: {gone, states: [text], nodes, sent, received}; sent and received are lists of flows.
export function siteFacts(system, name) {
  /** @type {{gone: boolean, states: object[], nodes: string[], sent: object[], received: object[]}} */
  const facts = { gone: true, states: [], nodes: [], sent: [], received: [] };
  for (const bridge of system.bridges || []) {
    for (const site of bridge.sites.filter((each) => each.name === name)) {
      facts.gone = false;
      facts.states.push({ bridge: bridge.node, lost: site.state !== "present", text: site.state === "present" ? "present" : site.state === "lost" ? "lost" : "has been heard, but does not answer" });
      facts.nodes.push(...site.nodes);
    }
    for (const flow of bridge.flows) if (flow.site === name) (flow.out ? facts.sent : facts.received).push(flow);
  }
  return facts;
}

// Describe the dropped messages in words; empty if none were dropped.
export function droppedText(dropped) {
  return Object.entries(dropped || {}).map(([reason, count]) => `${count} ${reason}`).join(", ");
}
