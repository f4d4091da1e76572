// A camera's picture in a corner of the scene.

import { h } from "../dom.js";
import { drawPicture } from "../images.js";

export class Overlay {
  // place: the element over which it lies.
  constructor(place, title, changed) {
    this.canvas = h("canvas", { "aria-label": `image of ${title}` });
    this.figure = h("figure.overlay", { title, onclick: () => this.figure.classList.toggle("large") }, this.canvas, h("figcaption.mono", {}, title));
    place.append(this.figure);
    this.object = null; // nothing in the scene
    this.word = "no image yet";
    this.problem = "";
    this.changed = changed;
  }

  // Take a push of the view image. Returns a promise: the next one may come when this one is shown.
  async take(facts, blob) {
    try {
      if (await drawPicture(this.canvas, facts, new Uint8Array(blob.buffer, blob.offset))) this.word = `${this.canvas.width} × ${this.canvas.height}`;
      this.problem = "";
    } catch (error) {
      this.problem = error.message;
    }
    this.changed();
  }

  show(shown) {
    this.figure.hidden = !shown;
  }

  close() {
    this.figure.remove();
  }
}
