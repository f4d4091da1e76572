// Zoom an image with the wheel or two fingers, pan it by dragging, and reset it with a double click.

const MAX_ZOOM = 64; // zoom factor
const ZOOM_PER_DELTA = 0.0015; // zoom per unit of the wheel's deltaY

export class Zoom {
  // changed(): the position or size has changed.
  constructor(frame, changed) {
    this.frame = frame;
    this.changed = changed;
    this.pointers = new Map();
    this.scale = 1;
    this.shift = [0, 0]; // pixels
    frame.style.touchAction = "none"; // disable the browser's own gestures
    frame.addEventListener("wheel", (event) => {
      event.preventDefault();
      this._zoom(Math.exp(-Math.max(-200, Math.min(200, event.deltaY)) * ZOOM_PER_DELTA), this._place(event));
    }, { passive: false });
    frame.addEventListener("pointerdown", (event) => {
      frame.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, this._place(event));
    });
    frame.addEventListener("pointermove", (event) => this._move(event));
    for (const name of ["pointerup", "pointercancel"]) frame.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    frame.addEventListener("dblclick", () => this.reset());
  }

  reset() {
    this.scale = 1;
    this.shift = [0, 0];
    this.changed();
  }

  _move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = this._place(event);
    this.pointers.set(event.pointerId, now);
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) this._zoom(distance(now, other) / Math.max(1, distance(before, other)), other);
    else if (this.scale > 1) this.shift = this.shift.map((value, index) => value + now[index] - before[index]);
    this.changed();
  }

  // Zoom around a position, which stays fixed.
  _zoom(times, place) {
    const scale = Math.min(MAX_ZOOM, Math.max(1, this.scale * times));
    this.shift = scale === 1 ? [0, 0] : this.shift.map((value, index) => place[index] - (place[index] - value) * scale / this.scale);
    this.scale = scale;
    this.changed();
  }

  // Return a position relative to the middle of the frame.
  _place({ clientX, clientY }) {
    const { left, top, width, height } = this.frame.getBoundingClientRect();
    return [clientX - left - width / 2, clientY - top - height / 2];
  }
}

function distance(one, other) {
  return Math.hypot(one[0] - other[0], one[1] - other[1]);
}
