// The drawing of a model: sizes, positions animated from one layout to the next, colours, and hit testing.

import { bytes, plural, rate } from "../format.js";
import { flowOf, stateOf, topicsOn } from "./model.js";
import { droppedText } from "./sites.js";

const ANIMATION_MS = 380; // ms
const MAX_NAME_LENGTH = 44;
const DROPPED = "messages dropped";
const MAX_LABEL_LINES = 3; // topics listed on an edge
const LINE_HEIGHT = 14;
const CHARACTER_WIDTH = 5.5; // approximate width of a character at that size in pixels
const FLOW_WIDTH = 104; // pixels reserved for a rate, so that changing digits do not move anything
const SHAPES_ONLY_SCALE = 0.25; // pixels per unit; below this, only shapes are drawn
const MIN_GROUP_FONT = 11; // pixels; minimum font size of group names
const MAX_LABELS = 400;
const MAX_MOVED_BOXES = 500; // maximum number of boxes that the user has moved
const PADDING = 14; // between the frame of a group and a box that the user has moved
const TITLE_HEIGHT = 20;
const MIN_FONT = 4.5; // pixels; smaller text is not drawn

// Return everything that a layout depends on. measure(text, size, weight) returns pixels.
export function plan(model, { rates, down, room, measure }) {
  const boxes = model.boxes.map((box) => {
    const label = shortened(box.label);
    box.shown = label;
    const width = Math.ceil(measure(label, 13, box.kind === "node" ? 600 : 400)) + (box.kind === "node" ? 34 : 22);
    if (box.kind === "node" || box.kind === "topic") return { id: box.id, width, height: box.kind === "node" ? 32 : 26, group: box.group };
    return { id: box.id, width: Math.max(width, 130), height: 48, group: box.group };
  });
  const edges = model.edges.map((edge) => {
    edge.lines = labelLines(edge);
    edge.flows = rates && edge.links.some(({ publisher, subscriber }) => publisher && subscriber); // a node that responds late must not change the layout
    const widest = Math.max(0, edge.flows ? FLOW_WIDTH : 0, ...edge.lines.map((line) => Math.ceil(measure(line, 11, 400)) + 6));
    const height = (edge.lines.length + (edge.flows ? 2 : 0)) * LINE_HEIGHT;
    return { id: edge.id, from: edge.from, to: edge.to, width: widest, height };
  });
  return { boxes, edges, groups: model.groups.map(({ name, parent }) => ({ name, parent })), down, room };
}

function labelLines(edge) {
  if (edge.from.startsWith("t:") || edge.to.startsWith("t:")) return [];
  const topics = topicsOn(edge);
  if (edge.from.startsWith("g:") || edge.to.startsWith("g:")) return [plural(topics.length, "topic")];
  const more = topics.length - MAX_LABEL_LINES;
  const dropped = edge.links.some((link) => droppedText(link.dropped)) ? [DROPPED] : []; // without a number, which would change the layout
  if (more <= 0) return [...topics.map(shortened), ...dropped];
  return [...topics.slice(0, MAX_LABEL_LINES - 1).map(shortened), `and ${more + 1} more`, ...dropped];
}

export class Scene {
  constructor() {
    this.model = null;
    this.items = new Map(); // id -> {box, width, height, home, from, to, at}; home: position in the layout
    this.lines = new Map(); // id -> {edge, home, from, to, at}
    this.frames = new Map(); // group -> {group, home, from, to, at}: [x, y, width, height]
    this.movedBoxes = new Map(); // id -> [x, y]: boxes that the user has moved
    this.pendingOffsets = new Map(); // id -> [right, down]: the same for boxes that do not exist yet, as offsets from the layout's position
    this.begin = -Infinity;
    this.whole = [0, 0, 1, 1]; // the area of the layout: [left, top, right, bottom]
    this.bounds = this.whole; // the area that also contains the boxes that the user has moved
  }

  // Update rates only.
  refresh(model) {
    this.model = model;
    for (const box of model.boxes) if (this.items.has(box.id)) this.items.get(box.id).box = box;
    for (const edge of model.edges) if (this.lines.has(edge.id)) this.lines.get(edge.id).edge = edge;
  }

  // Apply a new layout: what stays is animated to its new position, and everything is shifted so that the chosen box, or
  // else most boxes, stay where they are.
  arrange(model, what, found, chosen, now) {
    const sizes = new Map(what.boxes.map((box) => [box.id, box]));
    const anchors = found.boxes[chosen] && this.items.has(chosen) ? [[chosen, found.boxes[chosen]]] : Object.entries(found.boxes);
    const staying = anchors.filter(([id]) => this.items.has(id)).map(([id, at]) => {
      const old = this.items.get(id).home;
      return [old[0] - at[0], old[1] - at[1]];
    });
    const [dx, dy] = staying.length ? [middle(staying.map(([x]) => x)), middle(staying.map(([, y]) => y))] : [0, 0];
    const shift = (list) => list.map((value, index) => value + (index % 2 ? dy : dx));
    const first = !this.items.size;
    const follow = (old, home) => ({ home, to: home, from: old?.at, at: old?.at, fresh: !old && !first });
    const [items, lines, frames] = [new Map(), new Map(), new Map()];
    for (const box of model.boxes) {
      const size = sizes.get(box.id);
      items.set(box.id, { box, width: size.width, height: size.height, ...follow(this.items.get(box.id), shift(found.boxes[box.id])) });
    }
    for (const edge of model.edges) {
      const { points, label } = found.edges[edge.id];
      lines.set(edge.id, { edge, ...follow(this.lines.get(edge.id), shift([...points, ...label])) });
    }
    for (const group of model.groups) {
      const frame = found.frames[group.name];
      if (frame) frames.set(group.name, { group, ...follow(this.frames.get(group.name), [frame[0] + dx, frame[1] + dy, frame[2], frame[3]]) });
    }
    Object.assign(this, { model, items, lines, frames, begin: now });
    this.whole = [dx, dy, dx + found.width, dy + found.height];
    for (const [id, [right, down]] of this.pendingOffsets) {
      const item = items.get(id);
      if (item && this.pendingOffsets.delete(id)) this.movedBoxes.set(id, [item.home[0] + right, item.home[1] + down]);
    }
    this._computeTargets();
    for (const set of [items, lines, frames]) {
      for (const each of set.values()) {
        each.from ||= each.to;
        each.at ||= each.to;
      }
    }
  }

  // Move a box to a position that it keeps in all layouts.
  move(id, right, down) {
    const item = this.items.get(id);
    if (!item) return;
    if (this.movedBoxes.size >= MAX_MOVED_BOXES && !this.movedBoxes.has(id)) this.movedBoxes.delete(this.movedBoxes.keys().next().value);
    this.movedBoxes.set(id, [item.to[0] + right, item.to[1] + down]);
    this._computeTargets(id);
  }

  // Offsets of the boxes that the user has moved, as stored in a link: [[id, right, down], ...].
  get offsets() {
    const there = [...this.movedBoxes].filter(([id]) => this.items.has(id)).map(([id, [x, y]]) => {
      const { home } = this.items.get(id);
      return [id, Math.round(x - home[0]), Math.round(y - home[1])];
    });
    return [...[...this.pendingOffsets].map(([id, way]) => [id, ...way]), ...there];
  }

  // Store offsets from a link, which is untrusted input: invalid entries are ignored.
  set offsets(list) {
    const good = (each) => Array.isArray(each) && typeof each[0] === "string" && each.length === 3 && each.slice(1).every(Number.isFinite);
    this.pendingOffsets = new Map((Array.isArray(list) ? list : []).filter(good).slice(0, MAX_MOVED_BOXES).map(([id, ...way]) => [id, way]));
  }

  // Animate all boxes back to the positions of the layout.
  release(now) {
    this.movedBoxes.clear();
    this.pendingOffsets.clear();
    for (const set of [this.items, this.lines, this.frames]) for (const each of set.values()) each.from = each.at;
    this.begin = now;
    this._computeTargets();
  }

  // Compute all target positions: the layout's, unless the user has moved the box, or an end of the edge.
  // moved: the box that is being dragged; it and its edges move without animation.
  _computeTargets(moved = null) {
    const away = (id) => {
      const [item, put] = [this.items.get(id), this.movedBoxes.get(id)];
      return item && put ? [put[0] - item.home[0], put[1] - item.home[1]] : null;
    };
    const set = (each, to, now) => {
      each.to = to;
      if (now) each.at = each.from = to;
    };
    for (const [id, item] of this.items) if (!moved || id === moved) set(item, this.movedBoxes.get(id) || item.home, moved);
    for (const line of this.lines.values()) {
      const { from, to } = line.edge;
      if (!moved || from === moved || to === moved) set(line, moveEnds(line.home, away(from), away(to)), moved);
    }
    this.bounds = [...this.whole];
    for (const frame of this.frames.values()) {
      const inside = [...this.movedBoxes.keys()].map((id) => this.items.get(id)).filter((item) => item && isWithin(item.box.group, frame.group.name));
      set(frame, inside.length ? expandFrame(frame.home, inside) : frame.home, moved);
      if (inside.length) this._reach(frame.to, frame.to[2], frame.to[3]);
    }
    for (const id of this.movedBoxes.keys()) if (this.items.has(id)) this._reach(this.items.get(id).to, this.items.get(id).width, this.items.get(id).height);
  }

  _reach([x, y], width, height) {
    const [left, top, right, bottom] = this.bounds;
    this.bounds = [Math.min(left, x - width / 2), Math.min(top, y - height / 2), Math.max(right, x + width / 2), Math.max(bottom, y + height / 2)];
  }

  // Advance the animation. Returns whether it is still running.
  step(now) {
    const part = matchMedia("(prefers-reduced-motion: reduce)").matches ? 1 : Math.min(1, Math.max(0, (now - this.begin) / ANIMATION_MS));
    const t = part < 0.5 ? 4 * part ** 3 : 1 - (2 - 2 * part) ** 3 / 2;
    for (const set of [this.items, this.lines, this.frames]) {
      for (const each of set.values()) {
        each.alpha = each.fresh ? t : 1;
        if (each.at === each.to) continue;
        each.at = part === 1 ? each.to : each.from.map((value, index) => value + (each.to[index] - value) * t);
      }
    }
    return part < 1;
  }

  // Return what is at a point: {box}, {group}, {edge} or null. near: maximum distance from an edge.
  find(x, y, near) {
    for (const { box, at, width, height } of this.items.values()) {
      if (Math.abs(x - at[0]) <= width / 2 && Math.abs(y - at[1]) <= height / 2) return { box };
    }
    for (const { group, at } of this.frames.values()) {
      if (Math.abs(x - at[0]) <= at[2] / 2 && y >= at[1] - at[3] / 2 && y <= at[1] - at[3] / 2 + 26) return { group };
    }
    /** @type {[number, {edge: any} | null]} */
    let [best, found] = [near, null];
    for (const { edge, at } of this.lines.values()) {
      const [left, top] = at.slice(-2);
      if (edge.lines.length && Math.abs(x - left) < 50 && Math.abs(y - top) < edge.lines.length * LINE_HEIGHT / 2) return { edge };
      for (let index = 0; index < at.length - 4; index += 2) {
        const away = distance(x, y, at[index], at[index + 1], at[index + 2], at[index + 3]);
        if (away < best) [best, found] = [away, { edge }];
      }
    }
    return found;
  }

  // Return the nearest box in a direction: [1, 0] is to the right.
  neighbour(id, [right, down]) {
    const { at: [x, y] } = this.items.get(id);
    let [best, found] = [Infinity, null];
    for (const { box, at } of this.items.values()) {
      const [dx, dy] = [at[0] - x, at[1] - y];
      const ahead = dx * right + dy * down;
      if (ahead < 8) continue;
      const cost = ahead + 2.5 * Math.abs(dx * down + dy * right);
      if (cost < best) [best, found] = [cost, box.id];
    }
    return found;
  }

  boundsOf(ids) {
    const found = [Infinity, Infinity, -Infinity, -Infinity];
    for (const id of ids) {
      const item = this.items.get(id);
      if (!item) continue;
      const [x, y] = item.to;
      found[0] = Math.min(found[0], x - item.width / 2);
      found[1] = Math.min(found[1], y - item.height / 2);
      found[2] = Math.max(found[2], x + item.width / 2);
      found[3] = Math.max(found[3], y + item.height / 2);
    }
    return found;
  }

  // Draw with a pen (see pens.js). look: {colours, scale, visibleArea: [left, top, right, bottom], highlighted: {boxes, edges} (sets of ids) or null, chosen: id, hovered: id}
  draw(pen, look) {
    const [left, top, right, bottom] = look.visibleArea;
    const outside = (x, y, width, height) => x + width / 2 < left || x - width / 2 > right || y + height / 2 < top || y - height / 2 > bottom;
    const text = (size) => size * look.scale >= MIN_FONT;
    for (const frame of this.frames.values()) {
      const [x, y, width, height] = frame.at;
      if (!outside(x, y, width, height)) drawFrame(pen, look, frame);
    }
    const labels = [];
    const strokes = new Map(); // when zoomed out, lines with the same style are drawn together
    for (const line of this.lines.values()) {
      const points = line.at.slice(0, -2);
      if (outsideLine(points, look.visibleArea)) continue;
      const style = styleOf(look, line);
      if (look.scale < SHAPES_ONLY_SCALE) {
        const key = Object.values(style).join();
        if (!strokes.has(key)) strokes.set(key, { style, lines: [] });
        strokes.get(key).lines.push(points);
        continue;
      }
      pen.lines([points], style);
      const [x, y, bx, by] = points.slice(-4);
      pen.arrowHead(bx, by, Math.atan2(by - y, bx - x), { fill: style.stroke, alpha: style.alpha });
      if (text(11)) labels.push(line);
    }
    for (const { style, lines } of strokes.values()) pen.lines(lines, style);
    const boxes = [...this.items.values()].filter(({ at, width, height }) => !outside(...at, width, height));
    const occupied = boxes.map(({ at: [x, y], width, height }) => [x, y, width, height]);
    if (labels.length <= MAX_LABELS) for (const line of labels) drawLabel(pen, look, line, occupied);
    for (const item of boxes) drawBox(pen, look, item, text(13));
    for (const frame of this.frames.values()) drawTitle(pen, look, frame);
  }
}

const faint = (look, highlighted) => (highlighted ? 1 : look.colours.dark ? 0.28 : 0.32);

function drawFrame(pen, { colours, hovered, scale }, { group, at: [x, y, width, height], alpha }) {
  const stroke = hovered === group.id ? colours.accent : colours.border;
  pen.box(x, y, width, height, { radius: 10, fill: colours.group, stroke, lineWidth: Math.max(1, 0.8 / scale), alpha });
}

// Group names never become too small to read: when zoomed out they are all that is left.
function drawTitle(pen, { colours, hovered, scale, visibleArea }, { group, at: [x, y, width, height], alpha }) {
  const size = Math.max(12, MIN_GROUP_FONT / scale);
  const within = Math.min(Math.max(y - height / 2, visibleArea[1]), y + height / 2 - 30); // keep the name of a large group visible
  const [left, top] = [Math.max(x - width / 2, Math.min(visibleArea[0], x)) + (size > 14 ? 0 : 12), size > 14 ? y - height / 2 - size * 0.7 : within + 16];
  const text = `▾ ${group.label}`;
  if (size > 14) pen.box(left + text.length * size * 0.3, top, text.length * size * 0.6, size * 1.2, { radius: size / 4, fill: colours.surface, alpha });
  pen.text(left, top, text, { size, weight: 600, fill: hovered === group.id ? colours.accent : colours.muted, align: "left", alpha });
}

function styleOf(look, { edge, alpha }) {
  const { colours, highlighted, chosen, hovered, scale } = look;
  const state = stateOf(edge);
  const here = edge.id === hovered || edge.id === chosen;
  const { hz, bytes: size } = flowOf(edge);
  const dim = state === "unknown" || (state === "ok" && !hz);
  const stroke = here ? colours.accent : state === "broken" ? colours.error : dim ? colours.border2 : colours.edge;
  const width = size > 0 ? Math.min(4.5, 1.2 + Math.max(0, Math.log10(size) - 2) * 0.55) : 1.2;
  return {
    stroke, width: Math.max(width + (here ? 1 : 0), (here ? 2 : state === "broken" ? 1.2 : 0.6) / scale),
    dash: state === "broken" ? [7, 5] : state === "unknown" ? [2, 4] : undefined, alpha: alpha * faint(look, !highlighted || highlighted.edges.has(edge.id)),
  };
}

// Leave out labels that would cover a box or another label, and labels of dimmed edges.
function drawLabel(pen, look, { edge, at, alpha }, occupied) {
  const { colours, highlighted } = look;
  if (highlighted && !highlighted.edges.has(edge.id)) return;
  const broken = new Set(edge.links.filter((link) => link.state === "broken").map(({ topic }) => shortened(topic)));
  const rows = edge.lines.map((line) => [line, broken.has(line) || line === DROPPED ? colours.error : colours.topic]);
  if (edge.flows) rows.push(...flowTexts(edge).map((text) => [text, colours.muted]));
  const [x, y] = at.slice(-2);
  if (!rows.length) return;
  const widest = Math.max(...rows.map(([text]) => text.length)) * CHARACTER_WIDTH + 8;
  const height = rows.length * LINE_HEIGHT + 2;
  if (occupied.some(([left, top, wide, high]) => Math.abs(left - x) * 2 < wide + widest - 4 && Math.abs(top - y) * 2 < high + height - 4)) return;
  occupied.push([x, y, widest, height]);
  pen.box(x, y, widest, height, { radius: 3, fill: colours.surface, alpha });
  rows.forEach(([text, fill], index) => {
    pen.text(x, y + (index - (rows.length - 1) / 2) * LINE_HEIGHT, text, { size: 11, fill, alpha });
  });
}

// Return the rate and size of a message, then the bandwidth.
export function flowTexts(edge) {
  const { hz, bytes: size } = flowOf(edge);
  if (hz === null) return [];
  return size && hz ? [`${rate(hz)} · ${bytes(size / hz)}`, bytes(size, "B/s")] : [rate(hz)];
}

function drawBox(pen, look, { box, at: [x, y], width, height, alpha }, named) {
  const { colours, highlighted, chosen, hovered, scale } = look;
  const of = !highlighted || highlighted.boxes.has(box.id);
  const shade = alpha * faint(look, of);
  const here = chosen === box.id;
  const radius = box.kind === "node" ? height / 2 : 5;
  const [fill, edge] = { node: [colours.nodeSoft, colours.node], topic: [colours.topicSoft, colours.border2], group: [colours.raised, colours.muted], site: [colours.raised, colours.node] }[box.kind];
  const stroke = here || hovered === box.id ? colours.accent : box.silent ? colours.error : edge;
  if (!of) pen.box(x, y, width, height, { radius, fill: colours.surface, alpha });
  pen.box(x, y, width, height, {
    radius, fill: box.silent ? colours.surface : fill, stroke, dash: box.silent ? [5, 4] : undefined, alpha: shade,
    lineWidth: Math.max(here ? 2.5 : 1.3, (here ? 2.5 : 0.8) / scale),
  });
  const words = { fill: box.silent ? colours.muted : colours.text, alpha: shade };
  if (box.kind === "group") {
    const topics = box.inside.length - box.nodes;
    const size = Math.max(13, MIN_GROUP_FONT / scale);
    pen.text(x, named && size < 20 ? y - 8 : y, size > 13 ? box.shown : `▸ ${box.shown}`, { size, weight: 600, ...words });
    const text = `${plural(box.nodes, "node")}${topics ? `, ${plural(topics, "topic")}` : ""}`;
    if (named && size < 20) pen.text(x, y + 11, text, { size: 11, fill: colours.muted, alpha: shade });
  } else if (box.kind === "site") {
    if (named) pen.text(x, y - 8, box.shown, { size: 13, weight: 600, ...words });
    if (named) pen.text(x, y + 11, box.text, { size: 11, fill: box.silent ? colours.error : colours.muted, alpha: shade });
  } else if (named) {
    pen.text(x, y + 0.5, box.shown, { size: 13, weight: box.kind === "node" ? 600 : 400, ...words });
  }
}

export function shortened(text) {
  if (text.length <= MAX_NAME_LENGTH) return text;
  return `${text.slice(0, MAX_NAME_LENGTH / 2 - 3)}…${text.slice(2 - MAX_NAME_LENGTH / 2)}`;
}

function middle(values) {
  const sorted = [...values].sort((one, other) => one - other);
  return sorted[Math.floor(sorted.length / 2)];
}

// Move a line (points, then the position of its label) with its ends. Points in between move in proportion.
function moveEnds(home, first, last) {
  if (!first && !last) return home;
  const [[ax, ay], [bx, by]] = [first || [0, 0], last || [0, 0]];
  const count = home.length / 2 - 1;
  return home.map((value, index) => {
    const point = Math.floor(index / 2);
    const t = point === count ? 0.5 : point / (count - 1);
    return value + (index % 2 ? ay + (by - ay) * t : ax + (bx - ax) * t);
  });
}

function isWithin(group, name) {
  return group === name || group.startsWith(`${name}/`);
}

// Return the frame of a group that has boxes moved by the user.
function expandFrame([x, y, width, height], items) {
  let [left, top, right, bottom] = [x - width / 2, y - height / 2, x + width / 2, y + height / 2];
  for (const { to, width: wide, height: high } of items) {
    left = Math.min(left, to[0] - wide / 2 - PADDING);
    top = Math.min(top, to[1] - high / 2 - PADDING - TITLE_HEIGHT);
    right = Math.max(right, to[0] + wide / 2 + PADDING);
    bottom = Math.max(bottom, to[1] + high / 2 + PADDING);
  }
  return [(left + right) / 2, (top + bottom) / 2, right - left, bottom - top];
}

function outsideLine(points, [left, top, right, bottom]) {
  let [a, b, c, d] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let index = 0; index < points.length; index += 2) {
    a = Math.min(a, points[index]);
    b = Math.min(b, points[index + 1]);
    c = Math.max(c, points[index]);
    d = Math.max(d, points[index + 1]);
  }
  return c < left || a > right || d < top || b > bottom;
}

function distance(x, y, x1, y1, x2, y2) {
  const [dx, dy] = [x2 - x1, y2 - y1];
  const t = Math.max(0, Math.min(1, ((x - x1) * dx + (y - y1) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(x - x1 - t * dx, y - y1 - t * dy);
}
