// What the graph shows of a system. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

const page = new URL("../../../src/pyros1/web/page/", import.meta.url);
const { MAX_BOXES, build, dot, flowOf, isDebugNode, matching, around, stateOf, topicsOn } = await import(new URL("lib/graph/model.js", page));
const { droppedText, siteFacts } = await import(new URL("lib/graph/sites.js", page));

const topic = (publishers, subscribers, more = {}) => ({ type: "std_msgs/String", publishers, subscribers, ...more });

// A publisher, two subscribers of which one is not connected, a tool, a topic with one end, tf and rosout.
const SYSTEM = {
  nodes: { "/talker": "http://a:1/", "/listener": "http://a:2/", "/other": "http://a:3/", "/rosout": "http://a:4/", "/rostopic_77_1700000000000": "http://a:5/" },
  silent: [],
  topics: {
    "/chat": topic(["/talker"], ["/listener", "/other"], { hz: 10, bytes: 200 }),
    "/alone": topic(["/talker"], []),
    "/two": topic(["/talker", "/other"], []),
    "/heard": topic(["/talker"], ["/rostopic_77_1700000000000"]),
    "/tf": topic(["/talker"], ["/listener"]),
    "/rosout": topic(["/talker", "/listener"], ["/rosout"]),
  },
  services: {},
  edges: [
    ["/chat", "/talker", "/listener", 10], ["/tf", "/talker", "/listener", 50], ["/heard", "/talker", "/rostopic_77_1700000000000", null],
    ["/rosout", "/talker", "/rosout", 0.1], ["/chat", "/talker", "http://elsewhere:1/", 3],
  ],
  missing: [["/chat", "/talker", "/other"]],
};
const NOTHING = { mode: "all", hide: [], depth: 0, toggled: [] };
const names = (model, kind) => model.boxes.filter((box) => box.kind === kind).map(({ name }) => name).sort();
const edge = (model, from, to) => model.edges.find((each) => each.from === from && each.to === to);

test("all: every topic with its publishers and subscribers", () => {
  const model = build(SYSTEM, NOTHING);
  assert.deepEqual(names(model, "topic"), ["/alone", "/chat", "/heard", "/rosout", "/tf", "/two"]);
  assert.equal(names(model, "node").length, 5);
  assert.ok(edge(model, "n:/talker", "t:/alone"));
});

test("active: only topics between two nodes that are shown", () => {
  assert.deepEqual(names(build(SYSTEM, { ...NOTHING, mode: "active" }), "topic"), ["/chat", "/heard", "/rosout", "/tf"]);
  assert.deepEqual(names(build(SYSTEM, { ...NOTHING, mode: "active", hide: ["debug"] }), "topic"), ["/chat", "/tf"]);
});

test("nodes only: an edge for all topics between two nodes", () => {
  const model = build(SYSTEM, { ...NOTHING, mode: "nodes" });
  assert.deepEqual(names(model, "topic"), []);
  assert.deepEqual(edge(model, "n:/talker", "n:/listener").links.map((link) => link.topic), ["/chat", "/tf"]);
  assert.deepEqual(flowOf(edge(model, "n:/talker", "n:/listener")).hz, 60);
});

test("hides nodes and topics", () => {
  const shown = (hide) => names(build(SYSTEM, { ...NOTHING, hide }), "topic");
  assert.deepEqual(shown(["debug"]), ["/alone", "/chat", "/heard", "/tf", "/two"]);
  assert.deepEqual(shown(["tf"]), ["/alone", "/chat", "/heard", "/rosout", "/two"]);
  assert.deepEqual(shown(["leaf"]), ["/chat", "/heard", "/rosout", "/tf", "/two"]);
  assert.deepEqual(shown(["dead"]), ["/chat", "/heard", "/rosout", "/tf"]);
  assert.deepEqual(shown(["debug", "leaf"]), ["/chat", "/tf", "/two"]);
  assert.deepEqual(names(build(SYSTEM, { ...NOTHING, hide: ["debug"] }), "node"), ["/listener", "/other", "/talker"]);
});

test("counts the hidden topics without subscribers", () => {
  const unheard = (mode, hide) => build(SYSTEM, { ...NOTHING, mode, hide }).unheard;
  assert.equal(unheard("active", ["debug", "tf", "leaf", "dead"]), 3); // /heard is for a tool that is hidden
  assert.equal(unheard("active", []), 2);
  assert.equal(unheard("all", ["dead"]), 2);
  assert.equal(unheard("all", ["leaf"]), 1);
  assert.equal(unheard("all", []), 0);
  assert.equal(unheard("nodes", ["dead"]), 0);
});

test("tool nodes are recognised by name, user nodes are not", () => {
  for (const name of ["/rosout", "/rqt_gui_py_node_12", "/rosbag_12_1700000000000", "/pyros1_web_3_1700000000000"]) assert.ok(isDebugNode(name), name);
  for (const name of ["/talker", "/talker_12_1700000000000", "/robot/rosout_filter", "/rosie_1", "/play_12_1700000000000"]) assert.ok(!isDebugNode(name), name);
});

test("a missing connection marks its edges as broken, and names the nodes", () => {
  const model = build(SYSTEM, { ...NOTHING, mode: "active", hide: ["debug"] });
  assert.equal(stateOf(edge(model, "t:/chat", "n:/other")), "broken");
  assert.equal(stateOf(edge(model, "t:/chat", "n:/listener")), "ok");
  assert.deepEqual(edge(model, "t:/chat", "n:/other").links.map(({ publisher }) => publisher), ["/talker"]);
});

test("the connections of a node that does not answer are unknown", () => {
  const model = build({ ...SYSTEM, silent: ["/other"], missing: [] }, { ...NOTHING, mode: "active" });
  assert.equal(stateOf(edge(model, "t:/chat", "n:/other")), "unknown");
  assert.ok(model.boxes.find(({ id }) => id === "n:/other").silent);
});

test("a publisher's edge counts each message once, whatever the number of subscribers", () => {
  const edges = [["/chat", "/talker", "/listener", 10], ["/chat", "/talker", "/other", 8]];
  const model = build({ ...SYSTEM, edges, missing: [] }, { ...NOTHING, mode: "active" });
  assert.deepEqual(flowOf(edge(model, "n:/talker", "t:/chat")), { hz: 10, bytes: 200 });
  assert.deepEqual(flowOf(edge(model, "t:/chat", "n:/other")), { hz: 8, bytes: 160 });
  assert.deepEqual(flowOf(edge(build(SYSTEM, NOTHING), "n:/talker", "t:/alone")), { hz: null, bytes: null });
});

// Two robots with two nodes each, and one node outside.
const ROBOTS = {
  nodes: Object.fromEntries(["/a/one", "/a/two", "/b/one", "/b/two", "/outside"].map((name) => [name, "http://x:1/"])),
  silent: [], services: {}, missing: [],
  topics: { "/a/inner": topic(["/a/one"], ["/a/two"]), "/b/inner": topic(["/b/one"], ["/b/two"]), "/shared": topic(["/a/one"], ["/b/one"]) },
  edges: [["/a/inner", "/a/one", "/a/two", 1], ["/b/inner", "/b/one", "/b/two", 1], ["/shared", "/a/one", "/b/one", 1]],
};

test("groups are namespaces, names inside are short, and single nodes stay outside", () => {
  const model = build(ROBOTS, { ...NOTHING, depth: 1 });
  assert.deepEqual(model.groups.map(({ name, parent }) => [name, parent]), [["/a", ""], ["/b", ""]]);
  assert.equal(model.boxes.find(({ id }) => id === "n:/a/one").label, "one");
  assert.equal(model.boxes.find(({ id }) => id === "n:/outside").group, "");
});

test("a folded group is one box, with the edges that leave it", () => {
  const model = build(ROBOTS, { ...NOTHING, depth: 1, toggled: ["/a"] });
  const [box] = model.boxes.filter(({ kind }) => kind === "group");
  assert.deepEqual([box.name, box.inside.length, box.nodes], ["/a", 3, 2]);
  assert.ok(edge(model, "g:/a", "t:/shared"));
  assert.equal(model.edges.filter(({ from, to }) => from === to).length, 0);
  assert.deepEqual([...matching(model, "/a/two")], ["g:/a"], "a search looks into it");
});

function large(count) {
  const nodes = Object.fromEntries(Array.from({ length: count }, (_, index) => [`/r${index % 10}/n${index}`, "http://x:1/"]));
  return { nodes, silent: [], services: {}, missing: [], topics: {}, edges: [] };
}

test("large graphs start folded, small ones do not, and toggling opens a group", () => {
  const choice = { ...NOTHING, depth: -1 };
  assert.equal(build(large(100), choice).boxes.length, 100);
  assert.equal(build(large(200), choice).boxes.length, 10);
  assert.equal(build(large(200), { ...choice, toggled: ["/r3"] }).boxes.length, 29);
});

test("boxes beyond the limit are left out and counted", () => {
  const model = build(large(MAX_BOXES + 7), NOTHING);
  assert.deepEqual([model.boxes.length, model.cut], [MAX_BOXES, 7]);
});

test("survives invalid names from the robot", () => {
  const wild = 'x"</svg>\\\n__proto__';
  const model = build({ ...SYSTEM, nodes: { [wild]: "", "/__proto__": "" }, silent: [wild], topics: { [wild]: topic([wild], [wild]) }, edges: [[wild, wild, wild, 1]], missing: [] }, { ...NOTHING, depth: 2 });
  assert.equal(model.edges.length, 2);
  assert.ok(dot(model).includes('x\\"</svg>\\\\'));
});

test("search matches parts of names, and whole types", () => {
  const model = build(SYSTEM, NOTHING);
  assert.deepEqual([...matching(model, "TALK")], ["n:/talker"]);
  assert.equal(matching(model, "std_msgs/String").size, 6);
  assert.equal(matching(model, "  "), null);
  assert.deepEqual([...around(model, "t:/tf")].sort(), ["n:/listener", "n:/talker", "t:/tf"]);
});

test("DOT files look like those of `pyros1 graph --dot`", () => {
  const model = build({ ...SYSTEM, silent: ["/other"] }, { ...NOTHING, mode: "nodes", hide: ["debug", "tf"] });
  assert.equal(dot(model), `digraph system {
  rankdir=LR;
  "/listener";
  "/other" [style=dashed];
  "/talker";
  "/talker" -> "/listener" [label="/chat"];
  "/talker" -> "/other" [label="/chat", color=red, style=dashed];
}
`);
  const grouped = dot(build(ROBOTS, { ...NOTHING, mode: "active", depth: 1 }));
  assert.ok(grouped.includes('  subgraph "cluster /a" {\n    label="/a";\n    "/a/one";\n    "/a/two";\n    "t:/a/inner" [label="/a/inner", shape=box];\n  }\n'));
});

test("a tool that publishes to a node is not a debug node, and is shown without its subscriptions", () => {
  const tool = "/rostopic_78_1700000000000";
  const system = {
    ...SYSTEM, nodes: { ...SYSTEM.nodes, [tool]: "http://a:6/" },
    topics: { ...SYSTEM.topics, "/goal": topic([tool], ["/listener"]), "/chat": topic(["/talker"], ["/listener", tool]) },
    edges: [["/goal", tool, "/listener", 10], ["/chat", "/talker", tool, 10]],
  };
  const { boxes, edges } = build(system, { ...NOTHING, mode: "active", hide: ["debug"] });
  const ids = boxes.map(({ id }) => id);
  assert.ok(ids.includes(`n:${tool}`) && ids.includes("t:/goal") && !ids.includes("n:/rostopic_77_1700000000000"));
  assert.deepEqual(edges.filter(({ from, to }) => [from, to].includes(`n:${tool}`)).map(({ to }) => to), ["t:/goal"]);
});

test("names in DOT files have no control characters, like those of pyros1 graph --dot", () => {
  const nodes = { "/a\n\x1b[31m": "", '/b"\u202e\\': "", "/é\x7f": "" };
  const model = build({ nodes, silent: [], topics: {}, services: {}, edges: [], missing: [] }, { mode: "nodes", hide: [], depth: 0, toggled: [] });
  assert.deepEqual(dot(model).split("\n").slice(2, -2), ['  "/a\\\\n\\\\x1b[31m";', '  "/b\\"\\\\u202e\\\\";', '  "/é\\\\x7f";']);
});

const BRIDGED = {
  ...SYSTEM,
  nodes: { ...SYSTEM.nodes, "/bridge_base": "http://a:6/", "/red/driver": "http://a:7/" },
  topics: { ...SYSTEM.topics, "/red/odom": topic(["/bridge_base"], ["/listener"], { hz: 10, bytes: 200 }) },
  bridges: [{
    node: "/bridge_base", site: "base", link: "",
    sites: [{ name: "red", state: "present", round_trip: 0.02, nodes: ["/red/driver"] }, { name: "blue", state: "lost", round_trip: null, nodes: [] }, { name: "green", state: "heard", round_trip: null, nodes: [] }],
    flows: [
      { topic: "/red/odom", site: "red", out: false, wanted: true, hz: 10, bytes: 200, dropped: { "too old": 3 } },
      { topic: "/red/tf", site: "red", out: false, wanted: true, hz: 50, bytes: 2000, dropped: {} },
      { topic: "/red/map", site: "red", out: false, wanted: false, hz: 0, bytes: 0, dropped: {} },
      { topic: "/red/cmd_vel", site: "red", out: true, wanted: true, hz: 20, bytes: 960, dropped: {} },
      { topic: "/blue/odom", site: "blue", out: false, wanted: true, hz: 7, bytes: 200, dropped: {} },
    ],
  }],
};

test("sites: shown as boxes next to their bridge, with their topics and rates", () => {
  const model = build(BRIDGED, { ...NOTHING, hide: ["tf", "dead"] });
  assert.deepEqual(model.boxes.filter(({ kind }) => kind === "site").map(({ id, silent, text }) => [id, silent, text]),
    [["s:blue", true, "site lost"], ["s:green", true, "does not answer"], ["s:red", false, "site · 20 ms"]]);
  assert.ok(!names(model, "node").includes("/red/driver"), "it stands in for a node of the site");
  const red = edge(model, "s:red", "n:/bridge_base");
  assert.deepEqual(red.links.map((link) => link.topic), ["/red/odom"]);
  assert.deepEqual([stateOf(red), flowOf(red)], ["ok", { hz: 10, bytes: 200 }]);
  assert.deepEqual(edge(model, "n:/bridge_base", "s:red").links.map((link) => link.topic), ["/red/cmd_vel"]);
  const blue = edge(model, "s:blue", "n:/bridge_base");
  assert.deepEqual([stateOf(blue), flowOf(blue)], ["broken", { hz: null, bytes: null }]);
  const green = edge(model, "n:/bridge_base", "s:green");
  assert.deepEqual([stateOf(green), topicsOn(green)], ["broken", []]);
  assert.deepEqual(edge(build(BRIDGED, NOTHING), "s:red", "n:/bridge_base").links.map((link) => link.topic), ["/red/odom", "/red/tf", "/red/map"]);
});

test("sites: shown with their bridge in all modes, and in DOT files", () => {
  for (const mode of ["nodes", "active", "all"]) assert.deepEqual(names(build(BRIDGED, { ...NOTHING, mode }), "site"), ["blue", "green", "red"]);
  const nodes = { ...BRIDGED.nodes };
  delete nodes["/bridge_base"];
  assert.deepEqual(names(build({ ...BRIDGED, nodes }, NOTHING), "site"), []);
  const text = dot(build(BRIDGED, { ...NOTHING, mode: "nodes" }));
  assert.match(text, /"s:red" \[label="red", shape=box\];/);
  assert.match(text, /"s:red" -> "\/bridge_base" \[label="\/red\/odom"\];/);
  assert.match(text, /"\/bridge_base" -> "s:green" \[color=red, style=dashed\];/);
  assert.deepEqual([...matching(build(BRIDGED, NOTHING), "green")], ["s:green"]);
});

test("sites: one that is connected to two bridges is lost only if both have lost it", () => {
  const other = { ...BRIDGED.bridges[0], node: "/talker", sites: [{ name: "blue", state: "present", round_trip: null, nodes: [] }], flows: [] };
  for (const bridges of [[BRIDGED.bridges[0], other], [other, BRIDGED.bridges[0]]]) {
    const model = build({ ...BRIDGED, bridges }, NOTHING);
    assert.deepEqual(model.boxes.filter(({ id }) => id === "s:blue").map(({ silent, text }) => [silent, text]), [[false, "site"]]);
  }
});

test("sites: the text of the details sheet", () => {
  const red = siteFacts(BRIDGED, "red");
  assert.deepEqual([red.gone, red.nodes, red.states[0].lost, red.sent.length, red.received.length], [false, ["/red/driver"], false, 1, 3]);
  assert.deepEqual(siteFacts(BRIDGED, "blue").states.map(({ lost, text }) => [lost, text]), [[true, "lost"]]);
  assert.ok(siteFacts(BRIDGED, "nowhere").gone && siteFacts(SYSTEM, "red").gone);
  assert.equal(droppedText({ "too old": 3, lost: 1 }), "3 too old, 1 lost");
});
