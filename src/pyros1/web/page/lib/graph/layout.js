// Compute positions of boxes and edges. Pure.
//
// layout(what) takes
//   {boxes: [{id, width, height, group}], edges: [{id, from, to, width, height}], groups: [{name, parent}], down, room: [width, height]}
//   down: whether to try top to bottom before left to right; the second is used only if the first is too small to read, and the second clearly larger
//   width and height of an edge: the size of its label; 0 without a label
// and returns
//   {boxes: {id: [x, y]}, edges: {id: {points: [x, y, ...], label: [x, y]}}, frames: {group: [x, y, width, height]}, width, height, down}
//   x and y are centres; an edge has POINTS points.
//
// Unconnected parts are laid out one by one and then packed. dagre gives the best layout, but takes minutes for a thousand
// boxes; above MAX_FOR_DAGRE a simpler method is used, with namespaces as boxes that contain boxes.
// If any site sends, all sites are placed before their bridge, and edges to sites are laid out as if they came from
// them. Otherwise, sites would stand among the topics that come out of the bridge, and their edges would go around these.

import * as dagre from "../../vendor/dagre.js";
import { layered } from "./layered.js";

export const POINTS = 10;
export const MAX_FOR_DAGRE = 260; // boxes and edges of a connected part
const MAX_IN_NAMESPACE = 60; // boxes and edges of a namespace in a large part; the limit is lower, since there may be many namespaces
const GAP = 44;
const READABLE_SCALE = 1; // pixels per unit; below this, the other direction is tried as well
const LARGE_GRAPH = 1500; // boxes and edges
const BETTER_BY = 1.2;
const MUCH_BETTER_BY = 1.5; // factor by which the simple method must be better, since its edges cross boxes
const MAX_ALWAYS_DAGRE = 30; // boxes and edges of a connected part; up to this number, even the simple method uses dagre
const STUB_LENGTH = 16; // how far a backward edge continues before it turns
const CHANNEL_GAP = 9; // distance between a backward edge and a box
const BESIDE = 5; // distance between the middle of a site and the edges from and to it
const PADDING = 14;
const TITLE_HEIGHT = 20;

export function layout(what) {
  const sends = what.edges.some(({ from }) => isSite(from));
  const turned = new Set(sends ? what.edges.filter(({ from, to }) => isSite(to) && !isSite(from)).map(({ id }) => id) : []);
  const edges = what.edges.map((edge) => (turned.has(edge.id) ? { ...edge, from: edge.to, to: edge.from, turned: true } : edge));
  const found = layoutForward({ ...what, edges });
  for (const id of turned) found.edges[id].points = reversed(found.edges[id].points);
  return found;
}

const isSite = (id) => id.startsWith("s:");

function reversed(points) {
  return points.map((_, index) => points[points.length - 2 - index + 2 * (index % 2)]);
}

function layoutForward(what) {
  const { down, room: [width, height] } = what;
  const scale = (found) => Math.min(width / found.width, height / found.height);
  let best = layoutInDirection(what, down);
  if (what.boxes.length + what.edges.length > LARGE_GRAPH) return best; // each attempt takes seconds
  for (const [way, plain, factor] of [[!down, false, BETTER_BY], [down, true, MUCH_BETTER_BY]]) {
    if (scale(best) > READABLE_SCALE) break;
    const other = layoutInDirection(what, way, plain);
    if (scale(other) > scale(best) * factor) best = other;
  }
  return best;
}

function layoutInDirection(what, down, plain = false) {
  const aspect = what.room[0] / what.room[1];
  const parts = partsOf(what).map((part) => {
    const few = plain ? MAX_ALWAYS_DAGRE : MAX_FOR_DAGRE;
    const small = part.boxes.length + part.edges.length <= few;
    return withFrames(small ? layoutByDagre(part, down) : layoutNamespaces(part, { down, aspect }), part);
  });
  return { ...packParts(parts, aspect), down };
}

// Split the graph into connected parts; a top-level group is never split.
function partsOf({ boxes, edges, groups }) {
  const home = new Map(boxes.map(({ id }) => [id, id]));
  const find = (id) => {
    while (home.get(id) !== id) {
      home.set(id, home.get(home.get(id)));
      id = home.get(id);
    }
    return id;
  };
  const join = (one, other) => home.set(find(one), find(other));
  for (const { from, to } of edges) join(from, to);
  const first = new Map();
  for (const { id, group } of boxes) {
    const outermost = group.split("/").slice(0, 2).join("/");
    if (!outermost) continue;
    if (first.has(outermost)) join(id, first.get(outermost));
    else first.set(outermost, id);
  }
  const parts = new Map();
  for (const each of boxes) {
    const key = find(each.id);
    if (!parts.has(key)) parts.set(key, { boxes: [], edges: [], groups });
    parts.get(key).boxes.push(each);
  }
  for (const each of edges) parts.get(find(each.from)).edges.push(each);
  return [...parts.values()];
}

function layoutByDagre({ boxes, edges, groups }, down) {
  const graph = new dagre.Graph({ directed: true, multigraph: true, compound: true });
  graph.setGraph({ rankdir: down ? "TB" : "LR", nodesep: 22, ranksep: 46, edgesep: 14, marginx: 4, marginy: 4 });
  const used = new Set(boxes.flatMap(({ group }) => ancestors(group)));
  for (const { name } of groups) if (used.has(name)) graph.setNode(`g:${name}/`, {});
  for (const { name, parent } of groups) if (used.has(name) && parent) graph.setParent(`g:${name}/`, `g:${parent}/`);
  for (const { id, width, height, group } of boxes) {
    graph.setNode(id, { width, height });
    if (group) graph.setParent(id, `g:${group}/`);
  }
  for (const { id, from, to, width, height } of edges) {
    graph.setEdge(from, to, { width, height, labelpos: "c", labeloffset: 0 }, id);
  }
  dagre.layout(graph);
  const found = { boxes: {}, edges: {} };
  for (const { id } of boxes) {
    const { x, y } = graph.node(id);
    found.boxes[id] = [x, y];
  }
  for (const { id, from, to } of edges) {
    const { points, x, y } = graph.edge(from, to, id);
    points[0] = exitPoint(graph.node(from), points[1], down) || points[0];
    points[points.length - 1] = exitPoint(graph.node(to), points.at(-2), down) || points.at(-1);
    const line = resample(points.flatMap((point) => [point.x, point.y]), POINTS);
    found.edges[id] = { points: line, label: x === undefined ? middle(line) : [x, y] };
  }
  return found;
}

// Return where an edge leaves a box: on the side that faces the next layer, shifted towards its next point.
function exitPoint({ x, y, width, height }, next, down) {
  const [ahead, aside, half, room] = down ? [next.y - y, next.x - x, height / 2, width * 0.3] : [next.x - x, next.y - y, width / 2, height * 0.22];
  if (Math.abs(ahead) <= half) return null;
  const [along, across] = [Math.sign(ahead) * half, Math.max(-room, Math.min(room, aside * 0.25))];
  return down ? { x: x + across, y: y + along } : { x: x + along, y: y + across };
}

// Lay out each namespace separately, then treat it as one box in its parent.
function layoutNamespaces({ boxes, edges, groups }, { down, aspect }, outside = "") {
  const inner = groups.filter(({ parent }) => parent === outside);
  const rooms = [];
  for (const { name } of inner) {
    const within = boxes.filter(({ group }) => group === name || group.startsWith(`${name}/`));
    if (!within.length) continue;
    const ids = new Set(within.map(({ id }) => id));
    const own = edges.filter(({ from, to }) => ids.has(from) && ids.has(to));
    const small = within.length + own.length <= MAX_IN_NAMESPACE;
    const placed = small && !groups.some(({ parent }) => parent === name)
      ? layoutByDagre({ boxes: within, edges: own, groups: [] }, down)
      : layoutNamespaces({ boxes: within, edges: own, groups }, { down, aspect }, name);
    rooms.push({ id: `g:${name}/`, ids, placed: withFrames(placed, { boxes: within, groups, edges: own }) });
  }
  const home = new Map();
  for (const room of rooms) for (const id of room.ids) home.set(id, room.id);
  const outer = [
    ...boxes.filter(({ id }) => !home.has(id)),
    ...rooms.map(({ id, placed }) => ({ id, width: placed.width + GAP, height: placed.height + 2 * GAP })),
  ];
  const links = new Map();
  for (const { from, to } of edges) {
    const [one, other] = [home.get(from) || from, home.get(to) || to];
    if (one !== other) links.set(`${one} ${other}`, [one, other]);
  }
  const places = layered(outer, [...links.values()], { down, aspect });
  const found = { boxes: {}, edges: {} };
  for (const { id } of outer) if (!id.endsWith("/")) found.boxes[id] = places.get(id);
  for (const { id, placed } of rooms) {
    const [x, y] = places.get(id);
    const [dx, dy] = [x - placed.width / 2, y - placed.height / 2];
    for (const [inside, at] of Object.entries(placed.boxes)) found.boxes[inside] = [at[0] + dx, at[1] + dy];
    for (const [inside, edge] of Object.entries(placed.edges)) found.edges[inside] = moveEdge(edge, dx, dy);
  }
  const sizes = new Map(boxes.map((each) => [each.id, each]));
  const obstacles = outer.map(({ id, width, height }) => [...places.get(id), width, height]);
  const seat = (id) => obstacles[outer.findIndex((each) => each.id === (home.get(id) || id))];
  const pairs = new Set(edges.filter((each) => each.turned).map(({ from, to }) => `${from} ${to}`));
  for (const { id, from, to, turned } of edges) {
    if (found.edges[id]) continue;
    /** @type {[[number, number], object, [number, number], object]} */
    const ends = [found.boxes[from], sizes.get(from), found.boxes[to], sizes.get(to)];
    const axis = down ? 1 : 0;
    const ahead = ends[2][axis] - ends[0][axis] > 0;
    const points = ahead ? curve(...ends, down) : routeBackwards(ends, seat(from), seat(to), obstacles, down);
    if (pairs.has(`${from} ${to}`)) for (let at = 1 - axis; at < points.length; at += 2) points[at] += turned ? BESIDE : -BESIDE;
    found.edges[id] = { points, label: middle(points) };
  }
  return found;
}

// Route a backward edge: out of one box, along a free channel between or around the others, and into the front of the target.
export function routeBackwards([at1, one, at2, other], seat1, seat2, obstacles, down) {
  const turn = ([x, y, ...size]) => (down ? [y, x, ...size.reverse()] : [x, y, ...size]); // computed as if it ran from left to right
  const [[x1, y1], [x2, y2], [s1, , w1], [s2, , w2]] = [at1, at2, seat1, seat2].map(turn);
  const [ax, bx] = [x1 + (down ? one.height : one.width) / 2, x2 - (down ? other.height : other.width) / 2];
  const [right, left] = [s1 + w1 / 2 + STUB_LENGTH, s2 - w2 / 2 - STUB_LENGTH];
  const boxes = obstacles.map(turn);
  const free = (y) => boxes.every(([x, at, wide, high]) => x + wide / 2 <= left || x - wide / 2 >= right || Math.abs(at - y) >= high / 2 + 4);
  const channels = boxes.flatMap(([, at, , high]) => [at - high / 2 - CHANNEL_GAP, at + high / 2 + CHANNEL_GAP]).filter(free);
  const cost = (y) => Math.abs(y - y1) + Math.abs(y - y2);
  const channel = channels.reduce((best, y) => (cost(y) < cost(best) ? y : best)); // always free above and below everything
  const line = [[ax, y1], [right, y1], [right, channel]];
  const along = POINTS - 6;
  for (let step = 1; step <= along; step += 1) line.push([right + ((left - right) * step) / (along + 1), channel]);
  line.push([left, channel], [left, y2], [bx, y2]);
  return line.flatMap(([x, y]) => (down ? [y, x] : [x, y]));
}

// A curve from the side of one box to the side of another.
export function curve([x1, y1], one, [x2, y2], other, down) {
  const points = [];
  const [ax, ay] = down ? [x1, y1 + one.height / 2] : [x1 + one.width / 2, y1];
  const [bx, by] = down ? [x2, y2 - other.height / 2] : [x2 - other.width / 2, y2];
  const ahead = down ? by - ay : bx - ax;
  const reach = ahead > 0 ? Math.max(20, ahead / 2) : Math.min(160, 30 - ahead / 4);
  const [cx, cy, dx, dy] = down ? [ax, ay + reach, bx, by - reach] : [ax + reach, ay, bx - reach, by];
  for (let index = 0; index < POINTS; index += 1) {
    const t = index / (POINTS - 1);
    const [p, q, r, s] = [(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t ** 3];
    points.push(p * ax + q * cx + r * dx + s * bx, p * ay + q * cy + r * dy + s * by);
  }
  return points;
}

// Resample a line at equal distances, so that lines can be interpolated.
export function resample(line, count) {
  const lengths = [0];
  for (let index = 2; index < line.length; index += 2) {
    lengths.push(lengths[lengths.length - 1] + Math.hypot(line[index] - line[index - 2], line[index + 1] - line[index - 1]));
  }
  const total = lengths[lengths.length - 1];
  const found = [];
  let at = 0;
  for (let number = 0; number < count; number += 1) {
    const wanted = (total * number) / (count - 1);
    while (at < lengths.length - 2 && lengths[at + 1] < wanted) at += 1;
    const part = lengths[at + 1] > lengths[at] ? (wanted - lengths[at]) / (lengths[at + 1] - lengths[at]) : 0;
    for (const axis of [0, 1]) {
      const [begin, end] = [line[at * 2 + axis], line[at * 2 + 2 + axis] ?? line[at * 2 + axis]];
      found.push(begin + Math.min(1, part) * (end - begin));
    }
  }
  return found;
}

function middle(line) {
  const at = line.length / 2 - (line.length / 2) % 2;
  return [(line[at - 2] + line[at]) / 2, (line[at - 1] + line[at + 1]) / 2];
}

function moveEdge({ points, label }, dx, dy) {
  return { points: points.map((value, index) => value + (index % 2 ? dy : dx)), label: [label[0] + dx, label[1] + dy] };
}

// Compute the frames of groups, and move everything so that it starts at 0, 0.
function withFrames(found, { boxes, groups, edges }) {
  const frames = {};
  const deepest = [...groups].sort((one, other) => other.name.split("/").length - one.name.split("/").length);
  const grow = (frame, left, top, right, bottom) => [
    Math.min(frame[0], left), Math.min(frame[1], top), Math.max(frame[2], right), Math.max(frame[3], bottom),
  ];
  const none = [Infinity, Infinity, -Infinity, -Infinity];
  for (const { id, width, height, group } of boxes) {
    if (!group) continue;
    const [x, y] = found.boxes[id];
    frames[group] = grow(frames[group] || none, x - width / 2, y - height / 2, x + width / 2, y + height / 2);
  }
  for (const { name, parent } of deepest) {
    if (!frames[name]) continue;
    const [left, top, right, bottom] = frames[name];
    frames[name] = [left - PADDING, top - PADDING - TITLE_HEIGHT, right + PADDING, bottom + PADDING];
    if (parent) frames[parent] = grow(frames[parent] || none, ...frames[name]);
  }
  let total = none;
  for (const { id, width, height } of boxes) {
    const [x, y] = found.boxes[id];
    total = grow(total, x - width / 2, y - height / 2, x + width / 2, y + height / 2);
  }
  for (const frame of Object.values(frames)) total = grow(total, ...frame);
  for (const { id, width, height } of edges) {
    const { points, label: [x, y] } = found.edges[id];
    for (let index = 0; index < points.length; index += 2) total = grow(total, points[index], points[index + 1], points[index], points[index + 1]);
    if (width) total = grow(total, x - width / 2, y - height / 2, x + width / 2, y + height / 2);
  }
  const [dx, dy] = [-total[0], -total[1]];
  return {
    width: total[2] - total[0], height: total[3] - total[1],
    boxes: Object.fromEntries(Object.entries(found.boxes).map(([id, [x, y]]) => [id, [x + dx, y + dy]])),
    edges: Object.fromEntries(Object.entries(found.edges).map(([id, edge]) => [id, moveEdge(edge, dx, dy)])),
    frames: Object.fromEntries(Object.entries(frames).map(([name, [a, b, c, d]]) => [name, [(a + c) / 2 + dx, (b + d) / 2 + dy, c - a, d - b]])),
  };
}

// Pack the parts into rows, largest first, in roughly the shape of the element.
function packParts(parts, aspect) {
  const area = parts.reduce((sum, { width, height }) => sum + (width + GAP) * (height + GAP), 0);
  const widest = Math.max(0, ...parts.map(({ width }) => width));
  const room = Math.max(widest, Math.sqrt(area * aspect) * 1.05);
  const order = parts.map((part, index) => [part, index]).sort(([one, a], [other, b]) => other.height * other.width - one.height * one.width || a - b);
  const total = { boxes: {}, edges: {}, frames: {}, width: 0, height: 0 };
  let [left, top, tall] = [0, 0, 0];
  for (const [part] of order) {
    if (left && left + part.width > room) [left, top, tall] = [0, top + tall + GAP, 0];
    for (const [id, [x, y]] of Object.entries(part.boxes)) total.boxes[id] = [x + left, y + top];
    for (const [id, edge] of Object.entries(part.edges)) total.edges[id] = moveEdge(edge, left, top);
    for (const [name, [x, y, width, height]] of Object.entries(part.frames)) total.frames[name] = [x + left, y + top, width, height];
    left += part.width + GAP;
    tall = Math.max(tall, part.height);
    total.width = Math.max(total.width, left - GAP);
    total.height = Math.max(total.height, top + tall);
  }
  return total;
}

function ancestors(name) {
  const words = name.split("/").slice(1);
  return words.map((_, index) => `/${words.slice(0, index + 1).join("/")}`);
}
