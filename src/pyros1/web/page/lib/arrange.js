// Trees of panels: without one of them, with one elsewhere, with two in each other's place. Nothing is drawn here.

const MOST = 8; // parts of a split

// The panels of a tree, in order.
export function panelsOf(tree) {
  return tree.parts ? tree.parts.flatMap(panelsOf) : [tree];
}

// null if nothing is left.
export function without(tree, panel) {
  if (!tree.parts) return tree === panel ? null : tree;
  const kept = tree.parts.map((part) => without(part, panel));
  const sizes = tree.sizes.filter((_, index) => kept[index]);
  const parts = kept.filter(Boolean);
  return parts.length > 1 ? { ...tree, sizes, parts } : parts[0] || null;
}

export function swapped(tree, one, other) {
  if (tree === one) return other;
  if (tree === other) return one;
  return tree.parts ? { ...tree, parts: tree.parts.map((part) => swapped(part, one, other)) } : tree;
}

// The panel is at a side of another one: "left", "right", "top" or "bottom".
export function moved(tree, panel, target, side) {
  const split = side === "left" || side === "right" ? "row" : "column";
  const after = side === "right" || side === "bottom" ? 1 : 0;
  const put = (each) => {
    if (each === target) return { split, sizes: [1, 1], parts: after ? [each, panel] : [panel, each] };
    if (!each.parts) return each;
    const at = each.parts.indexOf(target);
    if (at < 0 || each.split !== split || each.parts.length >= MOST) return { ...each, parts: each.parts.map(put) };
    const half = each.sizes[at] / 2;
    const [sizes, parts] = [[...each.sizes], [...each.parts]]; // toSpliced is younger than many a browser
    sizes.splice(at, 1, half, half);
    parts.splice(at + after, 0, panel);
    return { ...each, sizes, parts };
  };
  return put(without(tree, panel));
}

// The part of a box that a place is in: the side that it is near to, or "middle".
export function sideOf({ left, top, width, height }, x, y) {
  const far = { left: (x - left) / width, right: 1 - (x - left) / width, top: (y - top) / height, bottom: 1 - (y - top) / height };
  const [side, distance] = Object.entries(far).reduce((least, each) => (each[1] < least[1] ? each : least));
  return distance < 0.3 ? side : "middle";
}
