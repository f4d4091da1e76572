// Thumbnails along the row of an image topic. Only visible ones are requested; some are cached.

import { fill, h } from "../../lib/dom.js";

const THUMBNAIL_HEIGHT = 46; // pixels
const MIN_DISTANCE = 76; // minimum pixels between two thumbnails
const CACHE_SIZE = 200;

export class Thumbnails {
  constructor(robot, path, topic, drawn, problem) {
    this.robot = robot;
    this.path = path;
    this.topic = topic;
    this.drawn = drawn;
    this.lastProblem = problem;
    this.known = new Map(); // requested time -> {time, url, problem}
    this.requested = new Set();
    this.problem = "";
  }

  close() {
    this.stream?.close();
    for (const { url } of this.known.values()) URL.revokeObjectURL(url);
    this.known.clear();
  }

  // The times of the thumbnails: fixed, so that they do not change while the timeline pans.
  _times({ view: [begin, end], width, facts }) {
    const least = (MIN_DISTANCE / width) * (end - begin);
    const step = 2 ** Math.ceil(Math.log2(least));
    const times = [];
    for (let index = Math.floor(begin / step); index * step < end && times.length < 60; index += 1) {
      const time = index * step;
      if (time >= 0 && time <= facts.length) times.push(time);
    }
    if (begin <= 0) times.unshift(Math.min(step / 4, facts.length)); // the first image is rarely at the very beginning
    return times;
  }

  ask(timeline) {
    const missing = this._times(timeline).filter((time) => !this.known.has(time));
    const text = missing.join();
    if (!missing.length || text === this.text) return;
    this.text = text;
    const args = { path: this.path, topic: this.topic, times: missing.slice(0, 64), height: THUMBNAIL_HEIGHT * 2 };
    if (this.stream) this.stream.change(args);
    else this.stream = this.robot.stream("bag_pictures", args, { data: (data, blob) => this._receive(data, blob) });
  }

  _receive(data, blob) {
    const bytes = new Uint8Array(blob.buffer, blob.offset);
    const url = bytes.length ? URL.createObjectURL(new Blob([bytes], { type: "image/jpeg" })) : "";
    this.known.set(data.wanted, { ...data, url });
    while (this.known.size > CACHE_SIZE) {
      const [[first, { url: old }]] = this.known;
      URL.revokeObjectURL(old);
      this.known.delete(first);
    }
    this.problem = data.problem;
    this.drawn();
  }

  draw(holder, timeline) {
    const shown = [];
    let last = null;
    for (const time of this._times(timeline)) {
      const found = this.known.get(time);
      if (!found?.url || found.time === last) continue; // sparse images are shown only once
      last = found.time;
      const x = timeline.x(Math.max(found.time, timeline.view[0]));
      if (x < timeline.width - 20) shown.push({ x, url: found.url });
    }
    const spaced = shown.filter((each, index) => !index || each.x - shown[index - 1].x > 24);
    const key = spaced.map(({ x, url }) => `${x.toFixed(1)} ${url}`).join() + this.problem;
    if (holder.key === key) return;
    holder.key = key;
    fill(holder, spaced.map(({ x, url }) => h("img", { src: url, alt: "", draggable: false, height: THUMBNAIL_HEIGHT, style: { left: `${x}px` } })),
      !spaced.length && this.problem && h("span.wrong", {}, this.problem));
  }
}
