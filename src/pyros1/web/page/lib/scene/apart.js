// Which of the names in a picture are seen. Nothing is drawn here.

// boxes: {left, top, wide, high} in pixels, the most important first. Returns for each whether it is clear of those that are
// seen before it.
export function apart(boxes) {
  const kept = [];
  return boxes.map((box) => {
    const covered = kept.some((other) => box.left < other.left + other.wide && other.left < box.left + box.wide
      && box.top < other.top + other.high && other.top < box.top + box.high);
    if (!covered) kept.push(box);
    return !covered;
  });
}
