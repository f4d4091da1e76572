// A simple layered layout for graphs that are too large for dagre: its time is proportional to the number of edges. Pure.

const GAP = 18;
const LAYER_GAP = 90;
const SWEEPS = 6;
const MIN_HEIGHT = 600;
const MAX_ROWS = 16;

// boxes: [{id, width, height}]; edges: [[from, to]]. Returns a Map: id -> [x, y] of the centre.
/** @returns {Map<string, any>} */
export function layered(boxes, edges, { down, aspect }) {
  const ids = boxes.map(({ id }) => id);
  const next = new Map(ids.map((id) => [id, []]));
  const before = new Map(ids.map((id) => [id, []]));
  for (const [from, to] of edges) {
    if (from === to) continue;
    next.get(from).push(to);
    before.get(to).push(from);
  }
  const rank = rankBoxes(ids, next);
  let layers = [];
  for (const id of ids) (layers[rank.get(id)] ||= []).push(id);
  layers = layers.filter(Boolean);
  sortLayers(layers, next, before);
  const sizes = new Map(boxes.map(({ id, width, height }) => [id, down ? [height, width] : [width, height]]));
  const places = coordinates(layers, sizes, down ? 1 / aspect : aspect);
  return new Map([...places].map(([id, [along, across]]) => [id, down ? [across, along] : [along, across]]));
}

// Return the length of the longest path to each box; edges that would close a cycle are ignored.
function rankBoxes(ids, next) {
  const done = [];
  const seen = new Map(); // id -> 1 while being visited, 2 when done
  const forward = new Map(ids.map((id) => [id, []]));
  for (const start of ids) {
    if (seen.has(start)) continue;
    const stack = [[start, 0]];
    seen.set(start, 1);
    while (stack.length) {
      const top = stack[stack.length - 1];
      const [id, at] = top;
      const to = next.get(id)[at];
      if (to === undefined) {
        seen.set(id, 2);
        done.push(id);
        stack.pop();
        continue;
      }
      top[1] += 1;
      if (seen.get(to) !== 1) forward.get(id).push(to);
      if (!seen.has(to)) {
        seen.set(to, 1);
        stack.push([to, 0]);
      }
    }
  }
  const rank = new Map(ids.map((id) => [id, 0]));
  for (const id of done.reverse()) {
    for (const to of forward.get(id)) rank.set(to, Math.max(rank.get(to), rank.get(id) + 1));
  }
  return rank;
}

// Sort the boxes of each layer by the mean position of their neighbours, alternating forwards and backwards.
function sortLayers(layers, next, before) {
  const at = new Map();
  const number = (layer) => layer.forEach((id, index) => at.set(id, (index + 0.5) / layer.length));
  layers.forEach(number);
  for (let sweep = 0; sweep < SWEEPS; sweep += 1) {
    const forwards = sweep % 2 === 0;
    for (const layer of forwards ? layers : [...layers].reverse()) {
      const mean = new Map(layer.map((id) => {
        const near = (forwards ? before : next).get(id);
        return [id, near.length ? near.reduce((sum, each) => sum + at.get(each), 0) / near.length : at.get(id)];
      }));
      layer.sort((one, other) => mean.get(one) - mean.get(other));
      number(layer);
    }
  }
}

// Split layers that are too tall into several columns.
function splitTallLayers(layers, sizes, most) {
  return layers.flatMap((layer) => {
    const height = layer.reduce((sum, id) => sum + sizes.get(id)[1] + GAP, 0);
    const count = Math.ceil(height / most);
    /** @type {string[][]} */
    const columns = Array.from({ length: count }, () => []);
    layer.forEach((id, place) => columns[Math.floor((place * count) / layer.length)].push(id));
    return columns.map((ids, index) => ({
      ids, height: ids.reduce((sum, id) => sum + sizes.get(id)[1] + GAP, -GAP),
      width: Math.max(...ids.map((id) => sizes.get(id)[0])), room: index === count - 1 ? LAYER_GAP : GAP * 2,
    }));
  });
}

// Wrap a long sequence of layers into rows, like text.
function coordinates(layers, sizes, aspect) {
  const area = layers.flat().reduce((sum, id) => sum + (sizes.get(id)[0] + LAYER_GAP) * (sizes.get(id)[1] + GAP), 0);
  const columns = splitTallLayers(layers, sizes, Math.max(MIN_HEIGHT, Math.sqrt(area / aspect)));
  const rows = wrapRows(columns, aspect);
  const places = new Map();
  let top = 0;
  for (const row of rows) {
    const tall = Math.max(...row.map(({ height }) => height));
    let along = 0;
    for (const { ids, width, height, room } of row) {
      let across = top + (tall - height) / 2;
      for (const id of ids) {
        places.set(id, [along + width / 2, across + sizes.get(id)[1] / 2]);
        across += sizes.get(id)[1] + GAP;
      }
      along += width + room;
    }
    top += tall + LAYER_GAP;
  }
  return places;
}

// Choose the number of rows that gives the overall shape closest to the element's.
function wrapRows(columns, aspect) {
  const total = columns.reduce((sum, { width, room }) => sum + width + room, 0);
  let [best, found] = [Infinity, [columns]];
  for (let count = 1; count <= MAX_ROWS; count += 1) {
    const most = total / count;
    /** @type {any[][]} */
    const rows = [[]];
    let [length, longest] = [0, 0];
    for (const column of columns) {
      if (length && length + column.width > most) {
        rows.push([]);
        length = 0;
      }
      rows[rows.length - 1].push(column);
      length += column.width + column.room;
      longest = Math.max(longest, length);
    }
    const tall = rows.reduce((sum, row) => sum + Math.max(...row.map(({ height }) => height)) + LAYER_GAP, 0);
    const size = Math.max(longest, tall * aspect);
    if (size < best) [best, found] = [size, rows];
  }
  return found;
}
