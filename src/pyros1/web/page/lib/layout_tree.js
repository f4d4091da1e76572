// Operations on trees of panels: remove one, move one, swap two. Pure.

const MAX_PARTS = 8; // parts of a split

// Return the panels of a tree, in order.
export function panelsOf(tree) {
  return tree.parts ? tree.parts.flatMap(panelsOf) : [tree];
}

// Return the tree without a panel, or null if nothing is left.
export function without(tree, panel) {
  if (!tree.parts) return tree === panel ? null : tree;
  const remaining = tree.parts.map((part) => without(part, panel));
  const sizes = tree.sizes.filter((_, index) => remaining[index]);
  const parts = remaining.filter(Boolean);
  return parts.length > 1 ? { ...tree, sizes, parts } : parts[0] || null;
}

export function swapped(tree, one, other) {
  if (tree === one) return other;
  if (tree === other) return one;
  return tree.parts ? { ...tree, parts: tree.parts.map((part) => swapped(part, one, other)) } : tree;
}

// Move a panel to a side of another one: "left", "right", "top" or "bottom".
export function moved(tree, panel, target, side) {
  const split = side === "left" || side === "right" ? "row" : "column";
  const after = side === "right" || side === "bottom" ? 1 : 0;
  const put = (each) => {
    if (each === target) return { split, sizes: [1, 1], parts: after ? [each, panel] : [panel, each] };
    if (!each.parts) return each;
    const at = each.parts.indexOf(target);
    if (at < 0 || each.split !== split || each.parts.length >= MAX_PARTS) return { ...each, parts: each.parts.map(put) };
    const half = each.sizes[at] / 2;
    const [sizes, parts] = [[...each.sizes], [...each.parts]]; // toSpliced is too new for many browsers
    sizes.splice(at, 1, half, half);
    parts.splice(at + after, 0, panel);
    return { ...each, sizes, parts };
  };
  return put(without(tree, panel));
}

// Return which part of a box a position is in: the nearest side, or "middle".
export function sideOf({ left, top, width, height }, x, y) {
  const far = { left: (x - left) / width, right: 1 - (x - left) / width, top: (y - top) / height, bottom: 1 - (y - top) / height };
  const [side, distance] = Object.entries(far).reduce((least, each) => (each[1] < least[1] ? each : least));
  return distance < 0.3 ? side : "middle";
}
