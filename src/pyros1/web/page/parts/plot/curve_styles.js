// Styles of curves: ten colours, then the same with dashes; and the text of a legend's entry.

import { isolated } from "../../lib/curves.js";

const COLOURS = ["#1c7ed6", "#e8590c", "#2f9e44", "#9c36b5", "#e03131", "#0c8599", "#f08c00", "#6741d9", "#c2255c", "#5c940d"];
const DASHES = [undefined, [9, 5], [2, 4], [12, 4, 2, 4]];

// Return the style of a curve by its index: {colour, dash}.
export function styleOf(index) {
  return { colour: COLOURS[index % COLOURS.length], dash: DASHES[Math.floor(index / COLOURS.length) % DASHES.length] };
}

// Return a curve's style as a CSS background.
export function swatch({ colour = "var(--border)", dash }) {
  if (!dash) return colour;
  return `repeating-linear-gradient(90deg, ${colour} 0 ${Math.min(5, dash[0])}px, transparent 0 ${Math.min(5, dash[0]) + 3}px)`;
}

// The dots of uPlot, for isolated points that no line connects.
export function dots(colour) {
  return { show: false, filter: (chart, number) => isolated(chart.data[number]), size: 5, fill: colour };
}

// Show the problem of a curve, or what it waits for, which is not an error; otherwise the values.
export function showLegendText(mark, curves, values) {
  const problem = curves.map((curve) => curve?.problem).find(Boolean) || "";
  const waits = problem ? "" : curves.map((curve) => curve?.waits).find(Boolean) || "";
  const text = problem || waits || values;
  if (mark.textContent !== text) mark.textContent = text;
  mark.classList.toggle("wrong", Boolean(problem));
  mark.classList.toggle("muted", Boolean(waits));
}
