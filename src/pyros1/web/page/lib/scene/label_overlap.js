// Selects the labels in an image that are visible, so that none overlap. Pure.

// boxes: {left, top, wide, high} in pixels, in order of importance. Returns, for each, whether it is visible: it overlaps
// no visible box before it.
export function visibleLabels(boxes) {
  const visible = [];
  return boxes.map((box) => {
    const covered = visible.some((other) => box.left < other.left + other.wide && other.left < box.left + box.wide
      && box.top < other.top + other.high && other.top < box.top + box.high);
    if (!covered) visible.push(box);
    return !covered;
  });
}
