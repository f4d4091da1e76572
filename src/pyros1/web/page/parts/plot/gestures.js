// Gestures of a chart: one finger, or Shift and the mouse, pans; two fingers zoom.

const MIN_FINGER_DISTANCE = 30; // pixels between two fingers; below this they do not zoom in that direction

// on: {pan(right, down), pinch(x, y, across, along)}: pixels; x and y are the centre, across and along the zoom factors.
export function gestures(element, on) {
  const pointers = new Map();
  const moves = (event) => event.pointerType === "touch" || event.shiftKey || event.button === 1;
  element.style.touchAction = "none";
  element.addEventListener("mousedown", (event) => { if (event.shiftKey || event.button === 1) event.stopImmediatePropagation(); }, true); // uPlot would start a selection
  element.addEventListener("pointerdown", (event) => {
    if (!moves(event)) return;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    element.setPointerCapture?.(event.pointerId);
    event.preventDefault();
  });
  element.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    pointers.set(event.pointerId, now);
    if (pointers.size === 1) on.pan(now[0] - before[0], now[1] - before[1]);
    if (pointers.size !== 2) return;
    const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const { left, top } = element.getBoundingClientRect();
    const factor = (axis) => {
      const [was, is] = [before, now].map((at) => Math.abs(at[axis] - other[axis]));
      return Math.min(was, is) > MIN_FINGER_DISTANCE ? is / was : 1;
    };
    on.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
    on.pinch((now[0] + other[0]) / 2 - left, (now[1] + other[1]) / 2 - top, factor(0), factor(1));
  });
  for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, (event) => pointers.delete(event.pointerId));
}
