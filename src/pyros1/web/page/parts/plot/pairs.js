// Pairs of curves: the second of each is plotted against the first.

import { fill, h } from "../../lib/dom.js";
import { number } from "../../lib/format.js";
import { styleOf, showLegendText, swatch } from "./curve_styles.js";

const MAX_PAIRS = 50;

// on: {curves() -> the existing ones, add(text), remove(texts): remove curves, changed(), redraw()}
export class Pairs {
  constructor(on) {
    this.on = on;
    this.list = []; // {x, y, hidden, looks, at, mark}: x and y are texts of curves; y is "" until it is known
  }

  // The first of two curves is x, the second y; a single one waits for the other.
  add(texts) {
    for (const text of texts.map((each) => each.trim()).filter(Boolean)) {
      const last = this.list.at(-1);
      if (last && !last.y) {
        last.y = text;
        this.on.add(text);
      } else this.pair(text, "");
    }
    this.on.changed();
  }

  pair(x, y) {
    if (this.list.length >= MAX_PAIRS || (y && this.list.some((pair) => pair.x === x && pair.y === y))) return;
    this.list.push({ x, y, hidden: false });
    for (const text of [x, y]) this.on.add(text);
  }

  // Convert the curves over time to pairs.
  pairAll() {
    const texts = this.on.curves().map(({ text }) => text);
    for (let index = 0; index < texts.length; index += 2) this.pair(texts[index], texts[index + 1] || "");
  }

  remove(pair) {
    this.list = this.list.filter((each) => each !== pair);
    const used = new Set(this.list.flatMap(({ x, y }) => [x, y]));
    this.on.remove([pair.x, pair.y].filter((text) => !used.has(text)));
    this.on.changed();
  }

  // Pair the lines; elements of arrays go with the same element, or with a curve that is no array.
  trails() {
    const trails = [];
    for (const pair of this.list) {
      const [x, y] = [pair.x, pair.y].map((text) => this.on.curves().find((curve) => curve.text === text));
      pair.looks = [];
      for (const [part, points] of y ? [...y.points].sort((one, other) => one[0] - other[0]) : []) {
        const across = x?.points.get(part) || x?.points.get(-1);
        if (!across) continue;
        const look = styleOf(trails.length);
        pair.looks.push(look);
        trails.push({ pair, x: across, y: points, ...look });
      }
    }
    return trails;
  }

  // Return the entries of the legend.
  entries() {
    return this.trails().filter(({ pair }) => !pair.hidden).map(({ pair, colour, dash }) => ({ label: pairLabel(pair), colour, dash }));
  }

  pointAt(pairs, found) {
    for (const pair of this.list) pair.at = null;
    if (found) pairs[found.trail].pair.at = found;
  }

  drawLegend(legend) {
    this.trails();
    fill(legend, this.list.map((pair) => {
      pair.mark = h("span.value.mono");
      return h("span.chip", { title: "click to hide or show" },
        h("button", { className: `name mono${pair.hidden ? " hidden-curve" : ""}`, onclick: () => {
          pair.hidden = !pair.hidden;
          this.on.redraw();
        } }, (pair.looks.length ? pair.looks : [{}]).map((look) => h("i.swatch", { style: { background: swatch(look) } })), pairLabel(pair)),
        pair.mark,
        h("button.quiet", { title: "remove", "aria-label": `remove ${pairLabel(pair)}`, onclick: () => this.remove(pair) }, "✕"));
    }));
  }

  drawValues(now) {
    for (const pair of this.list) {
      if (!pair.mark) continue;
      const [x, y] = [pair.x, pair.y].map((text) => this.on.curves().find((curve) => curve.text === text));
      const last = (curve) => [...(curve?.points.values() || [])][0]?.lastValue();
      const at = pair.at ? [pair.at.x, pair.at.y] : [last(x), last(y)];
      const age = pair.at ? `, ${number(pair.at.time - now, 2)} s` : "";
      showLegendText(pair.mark, [x, y], at.includes(undefined) ? "" : `${at.map((value) => number(value, 3)).join(", ")}${age}`);
    }
  }
}

// Name the message of two fields only once: /pose x, y.
function pairLabel({ x, y }) {
  if (!y) return `${x}: type the field to plot against it`;
  const folder = x.slice(0, x.lastIndexOf("/") + 1);
  return y.startsWith(folder) && !y.slice(folder.length).includes("/") ? `${folder.slice(0, -1)} ${x.slice(folder.length)}, ${y.slice(folder.length)}` : `${x}, ${y}`;
}
