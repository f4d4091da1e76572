// The part of a large plane that an element shows, with dragging, wheel, pinch, and animated moves.

const MIN_SCALE = 0.02;
const MAX_SCALE = 4;
const MAX_CLICK_MOVE = 5; // pixels that the pointer may move during a click
const ANIMATION_MS = 260; // ms

export class Camera {
  // on: {changed(), click(x, y), double(x, y), hover(x, y), userMoved(), grab(x, y, touch), drag(right, down), drop(), coveredHeight()}; x and y in plane coordinates.
  // grab returns whether a drag from this point moves an object; otherwise it moves the plane.
  // coveredHeight returns the height in pixels covered by the line of numbers at the bottom.
  // userMoved is called when the user moves the view, so that it is no longer fitted automatically.
  constructor(element, on) {
    this.element = element;
    this.on = on;
    this.x = 0; // the point of the plane in the middle of the element
    this.y = 0;
    this.scale = 1; // pixels per unit
    this.pointers = new Map();
    this.moved = 0; // pixels that the pointer has moved since it was pressed
    this.target = null;
    const listen = (name, use) => element.addEventListener(name, use, { passive: false });
    listen("wheel", (event) => this._wheel(event));
    listen("pointerdown", (event) => this._down(event));
    listen("pointermove", (event) => this._move(event));
    listen("pointerup", (event) => this._up(event));
    listen("pointercancel", (event) => this._up(event));
    listen("pointerleave", () => on.hover(NaN, NaN));
    listen("dblclick", (event) => on.double(...this.toPlane(event.offsetX, event.offsetY)));
  }

  get size() {
    return [this.element.clientWidth || 1, this.element.clientHeight || 1];
  }

  toPlane(left, top) {
    const [width, height] = this.size;
    return [this.x + (left - width / 2) / this.scale, this.y + (top - height / 2) / this.scale];
  }

  toScreen(x, y) {
    const [width, height] = this.size;
    return [(x - this.x) * this.scale + width / 2, (y - this.y) * this.scale + height / 2];
  }

  // Return the visible part of the plane: [left, top, right, bottom].
  visibleArea() {
    const [width, height] = this.size;
    return [...this.toPlane(0, 0), ...this.toPlane(width, height)];
  }

  move(right, down) {
    this._moveTo(this.x + right / this.scale, this.y + down / this.scale, this.scale);
  }

  zoom(factor, left = this.size[0] / 2, top = this.size[1] / 2) {
    const [width, height] = this.size;
    const [x, y] = this.toPlane(left, top);
    const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, this.scale * factor));
    this._moveTo(x - (left - width / 2) / scale, y - (top - height / 2) / scale, scale);
  }

  // Fit a part of the plane into the element, with a scale of at most `most`.
  show(/** @type {number[]} */ [left, top, right, bottom], most, glide = true) {
    const [width, height] = this.size;
    const coveredHeight = this.on.coveredHeight();
    const scale = Math.max(MIN_SCALE, Math.min(most, (width - 40) / Math.max(1, right - left), (height - 40 - coveredHeight) / Math.max(1, bottom - top)));
    this.go((left + right) / 2, (top + bottom) / 2 + coveredHeight / 2 / scale, scale, glide);
  }

  go(x, y, scale, glide = true) {
    if (!glide || matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.target = null;
      [this.x, this.y, this.scale] = [x, y, scale];
    } else {
      this.target = { from: [this.x, this.y, this.scale], to: [x, y, scale], begin: performance.now() };
    }
    this.on.changed();
  }

  // Advance an animated move. Returns whether it is still running.
  step(now) {
    if (!this.target) return false;
    const { from, to, begin } = this.target;
    const part = Math.min(1, Math.max(0, (now - begin) / ANIMATION_MS));
    const t = 1 - (1 - part) ** 3;
    this.scale = from[2] * (to[2] / from[2]) ** t;
    [this.x, this.y] = [from[0] + (to[0] - from[0]) * t, from[1] + (to[1] - from[1]) * t];
    if (part === 1) this.target = null;
    return part < 1;
  }

  _moveTo(x, y, scale) {
    this.target = null;
    [this.x, this.y, this.scale] = [x, y, scale];
    this.on.userMoved();
    this.on.changed();
  }

  _wheel(event) {
    event.preventDefault();
    if (event.shiftKey) {
      this.move(event.deltaY || event.deltaX, 0);
      return;
    }
    const lines = event.deltaMode === 1 ? 20 : 1;
    this.zoom(Math.exp(-Math.max(-200, Math.min(200, event.deltaY * lines)) * (event.ctrlKey ? 0.01 : 0.0018)), event.offsetX, event.offsetY);
  }

  _down(event) {
    if (event.button > 1) return;
    this.element.focus({ preventScroll: true });
    this.element.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    this.moved = this.pointers.size > 1 ? MAX_CLICK_MOVE : 0;
    if (this.heldObject) this.on.drop(); // a second finger starts a pinch
    this.heldObject = this.pointers.size === 1 && event.button === 0 && this.on.grab(...this.toPlane(event.offsetX, event.offsetY), event.pointerType === "touch");
  }

  _move(event) {
    const before = this.pointers.get(event.pointerId);
    const now = [event.offsetX, event.offsetY];
    if (!before) {
      this.on.hover(...this.toPlane(...now));
      return;
    }
    this.moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
    if (this.moved < MAX_CLICK_MOVE) return;
    if (this.heldObject) {
      this.on.drag((now[0] - before[0]) / this.scale, (now[1] - before[1]) / this.scale);
    } else if (this.pointers.size === 1) {
      this.move(before[0] - now[0], before[1] - now[1]);
    } else {
      const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const apart = (at) => Math.max(10, Math.hypot(at[0] - other[0], at[1] - other[1]));
      this.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      this.move((before[0] - now[0]) / 2, (before[1] - now[1]) / 2);
    }
    this.pointers.set(event.pointerId, now);
  }

  _up(event) {
    const before = this.pointers.get(event.pointerId);
    this.pointers.delete(event.pointerId);
    if (this.heldObject) this.on.drop();
    this.heldObject = false;
    if (before && this.moved < MAX_CLICK_MOVE && event.type === "pointerup") this.on.click(...this.toPlane(event.offsetX, event.offsetY));
  }
}
