// Images of a topic, like rqt_image_view.

import { command, empty, fill, h } from "../lib/dom.js";
import { number, rate } from "../lib/format.js";
import { drawPicture } from "../lib/images.js";
import { Zoom } from "../lib/zoom.js";

const IMAGE_TYPES = ["sensor_msgs/Image", "sensor_msgs/CompressedImage"];
const RATE_TIMEOUT = 3; // seconds without an image, after which the rate is outdated

export default {
  title: "Image",
  description: "images of a camera",
  order: 50,
  mount: (place) => new Picture(place),
};

class Picture {
  constructor(place) {
    this.place = place;
    this.topic = place.settings.topic || "";
    this.quarterTurns = place.settings.turned || 0;
    this.range = place.settings.range || null;
    this.at = 0; // when the latest image arrived
    this.choice = h("select.mono", { "aria-label": "topic", onchange: (event) => this._choose(event.target.value) });
    this.pause = h("button", { onclick: () => this._pause(!this.paused) });
    const limit = (index, hint) => h("input", {
      type: "number", step: "any", placeholder: hint, "aria-label": `${hint} value`, title: `the ${hint} value of depth and other single-channel images; empty: taken from the image`,
      value: this.range?.[index] ?? "", className: "limit", hidden: true, onchange: () => this._limits(),
    });
    this.limits = [limit(0, "least"), limit(1, "greatest")];
    place.tools.append(this.choice, this.pause,
      h("button.quiet", { title: "rotate by 90°", onclick: () => { this.quarterTurns = (this.quarterTurns + 1) % 4; this._save(); this._fit(); } }, "Rotate"),
      h("button.quiet", { title: "save this image", onclick: () => this._png() }, "PNG"), ...this.limits);
    this.canvas = h("canvas", { onmousemove: (event) => this._point(event), onmouseleave: () => { this.pointerPosition = null; this._status(); } });
    this.frame = h("div.frame", { title: "wheel or two fingers: zoom; drag: move; double-click: show all of it" }, this.canvas);
    this.zoom = new Zoom(this.frame, () => this._fit());
    this.status = h("div.status.mono");
    this.hint = h("div.hint");
    place.body.classList.add("image");
    place.body.append(this.hint, this.frame, this.status);
    this.observer = new ResizeObserver(() => this._fit());
    this.observer.observe(this.frame);
    this.system = place.robot.stream("system", {}, { data: (data) => this._topics(data) });
    this.timer = setInterval(() => { if (this.facts && this._rate() !== this.rate) this._status(); }, 500);
    this._choose(this.topic);
  }

  unmount() {
    clearInterval(this.timer);
    this.system.close();
    this.stream?.close();
    this.observer.disconnect();
  }

  accept(settings) {
    if (settings.topic) this._choose(settings.topic);
  }

  _save() {
    this.place.save({ topic: this.topic, turned: this.quarterTurns, range: this.range });
  }

  _topics(data) {
    const names = Object.entries(data.topics).filter(([, { type }]) => IMAGE_TYPES.includes(type)).map(([name]) => name);
    const all = [...new Set([...names, ...(this.topic ? [this.topic] : [])])].sort();
    if (JSON.stringify(all) !== this.known) {
      this.known = JSON.stringify(all);
      fill(this.choice, h("option", { value: "" }, all.length ? "choose a topic" : "no images yet"),
        all.map((name) => h("option", { value: name, selected: name === this.topic }, name)));
    }
    if (!this.topic && names.length === 1) this._choose(names[0]);
    this._showHint();
  }

  _pause(paused) {
    this.paused = paused;
    this.pause.setAttribute("aria-pressed", String(paused));
    fill(this.pause, paused ? "Resume" : "Pause");
    if (!paused && this.pendingImage) this._receive(...this.pendingImage); // no later image may arrive
    this.pendingImage = null;
  }

  _choose(topic) {
    this.pendingImage = null; // the pending image belongs to the previous topic
    this._pause(false); // otherwise no image on the new topic would be shown
    this.stream?.close();
    this.stream = null;
    this.topic = topic;
    this.facts = null;
    this.problem = ""; // why the topic cannot be shown
    this.zoom.reset();
    this.choice.value = topic;
    this.place.problem("");
    this._save();
    this._showHint();
    if (!topic) return;
    this.stream = this.place.robot.stream("image", { topic }, {
      data: (data, blob) => {
        this.hz = data.hz;
        this.at = performance.now();
        if (!this.paused) return this._receive(data, blob);
        this.pendingImage = [data, blob];
        return null;
      },
      problem: (text) => this._failed(text),
    });
  }

  _failed(text) {
    this.problem = text;
    this.place.problem(text);
    this._showHint();
  }

  _showHint() {
    const none = !this.facts;
    this.hint.hidden = !none;
    this.frame.hidden = none;
    if (!none) return;
    fill(this.hint, this.problem
      ? empty("No image", `What arrives on ${this.topic} cannot be shown: ${this.problem}`)
      : this.topic
      ? empty("No image yet", `No message has arrived on ${this.topic} since this panel was opened.`)
      : empty("No topic chosen", "Image topics appear above. To see some, play a bag, or start a camera:", command("pyros1 bag play camera.bag")));
  }

  async _receive(facts, blob) {
    const data = new Uint8Array(blob.buffer, blob.offset);
    try {
      const bounds = await drawPicture(this.canvas, facts, data, this.range);
      if (!bounds) return;
      this.place.problem("");
      this.values = bounds.least === null ? "" : `  ${number(bounds.least)} … ${number(bounds.most)}`;
    } catch (error) {
      this._failed(error.message);
      return;
    }
    const ranged = this.values && !["mono8", "8uc1"].includes((facts.encoding || "").toLowerCase());
    for (const field of this.limits) field.hidden = !ranged && !this.range;
    const first = !this.facts;
    this.facts = facts;
    this.data = data;
    if (first) this._showHint();
    this._fit();
    this._status();
  }

  // Fit the image into the panel, rotated as chosen.
  _fit() {
    const { clientWidth, clientHeight } = this.frame;
    const { width, height } = this.canvas;
    const [across, down] = this.quarterTurns % 2 ? [height, width] : [width, height];
    const { scale: larger, shift: [x, y] } = this.zoom;
    const scale = (Math.min(clientWidth / across, clientHeight / down) || 1) * larger;
    this.canvas.style.transform = `translate(calc(-50% + ${x}px), calc(-50% + ${y}px)) rotate(${this.quarterTurns * 90}deg) scale(${scale})`;
    this.canvas.style.imageRendering = scale > 2 ? "pixelated" : "auto";
  }

  // Return the current rate, also while paused.
  _rate() {
    const age = (performance.now() - this.at) / 1000;
    return age > Math.max(RATE_TIMEOUT, this.hz ? 3 / this.hz : 0) ? "0 Hz" : rate(this.hz);
  }

  _status() {
    const { facts } = this;
    if (!facts) return;
    const what = facts.encoding || facts.format;
    this.rate = this._rate();
    fill(this.status, `${this.canvas.width} × ${this.canvas.height}  ${what}  ${this.rate}  ${facts.frame}${this.values}${this._underPointer()}`);
  }

  _point(event) {
    this.pointerPosition = [Math.floor(event.offsetX), Math.floor(event.offsetY)];
    this._status();
  }

  // Show the position and colour under the pointer, and update them with each image.
  _underPointer() {
    const [x, y] = this.pointerPosition || [-1, -1];
    if (x < 0 || y < 0 || x >= this.canvas.width || y >= this.canvas.height) return "";
    const [red, green, blue] = this.canvas.getContext("2d").getImageData(x, y, 1, 1).data;
    return `   (${x}, ${y}): ${red} ${green} ${blue}`;
  }

  _limits() {
    const [least, most] = this.limits.map((input) => (input.value === "" ? NaN : Number(input.value)));
    this.range = least < most ? [least, most] : null;
    this._save();
  }

  _png() {
    if (!this.facts) return;
    this.canvas.toBlob((blob) => {
      const link = h("a", { href: URL.createObjectURL(blob), download: `${this.topic.slice(1).replaceAll("/", "_")}.png` });
      link.click();
    });
  }
}
