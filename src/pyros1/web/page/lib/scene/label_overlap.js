// Which of the labels in an image are visible. Pure.

// boxes: {left, top, wide, high} in pixels, in order of importance. Returns for each whether it overlaps no visible one
// before it.
export function visibleLabels(boxes) {
  const kept = [];
  return boxes.map((box) => {
    const covered = kept.some((other) => box.left < other.left + other.wide && other.left < box.left + box.wide
      && box.top < other.top + other.high && other.top < box.top + box.high);
    if (!covered) kept.push(box);
    return !covered;
  });
}
