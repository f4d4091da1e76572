// Export charts to one image: below each other, with a legend above.

import { h } from "../../lib/dom.js";

const [LINE, MARK, GAP] = [22, 22, 18]; // pixels: row height of the legend, width of its marks, and the gap between entries

// entries: [{label, colour, dash}]
export function exportImage(canvases, entries) {
  const ratio = devicePixelRatio || 1;
  const style = getComputedStyle(document.documentElement);
  const width = Math.max(...canvases.map((each) => each.width)) / ratio;
  const canvas = h("canvas", { width: 1, height: 1 });
  const context = canvas.getContext("2d");
  const font = `12px ${getComputedStyle(document.body).fontFamily}`;
  context.font = font;
  let [left, top] = [GAP / 2, LINE / 2 + 4];
  const places = entries.map((entry) => {
    const wide = MARK + 6 + context.measureText(entry.label).width + GAP;
    if (left > GAP && left + wide > width) [left, top] = [GAP / 2, top + LINE];
    const at = [left, top];
    left += wide;
    return at;
  });
  const head = entries.length ? top + LINE / 2 + 4 : 0;
  canvas.width = width * ratio;
  canvas.height = head * ratio + canvases.reduce((sum, each) => sum + each.height, 0);
  context.fillStyle = style.getPropertyValue("--surface");
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.save();
  context.scale(ratio, ratio);
  Object.assign(context, { font, textBaseline: "middle", lineWidth: 3 });
  entries.forEach(({ label, colour, dash }, index) => {
    const [x, y] = places[index];
    context.strokeStyle = colour;
    context.setLineDash(dash || []);
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + MARK, y);
    context.stroke();
    context.fillStyle = style.getPropertyValue("--text");
    context.fillText(label, x + MARK + 6, y);
  });
  context.restore();
  let down = head * ratio;
  for (const each of canvases) {
    context.drawImage(each, 0, down);
    down += each.height;
  }
  return canvas;
}
