// A camera's image in a corner of the scene.

import { h } from "../dom.js";
import { drawPicture } from "../images.js";

export class Overlay {
  // place: the element to overlay.
  constructor(place, title, changed) {
    this.canvas = h("canvas", { "aria-label": `image of ${title}` });
    this.figure = h("figure.overlay", { title, onclick: () => this.figure.classList.toggle("large") }, this.canvas, h("figcaption.mono", {}, title));
    place.append(this.figure);
    this.object = null; // no object in the scene
    this.status = "no image yet";
    this.problem = "";
    this.changed = changed;
  }

  // Apply data of the view image. Returns a promise that resolves when it is drawn.
  async update(facts, blob) {
    try {
      if (await drawPicture(this.canvas, facts, new Uint8Array(blob.buffer, blob.offset))) this.status = `${this.canvas.width} × ${this.canvas.height}`;
      this.problem = "";
    } catch (error) {
      this.problem = error.message;
    }
    this.changed();
  }

  show(visible) {
    this.figure.hidden = !visible;
  }

  close() {
    this.figure.remove();
  }
}
