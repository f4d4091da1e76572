// Parse curves as rqt_plot accepts them, and place and format the ticks of a chart.

import { number } from "../../lib/format.js";

const SHORT_LABEL = 8; // characters of a number
const MAX_VALUE = 8e307; // twice this value is still finite
const MIN_RELATIVE_STEP = 1e-12; // relative: floats have 16 digits, and an axis has several ticks

const FIELD_PATTERN = "[\\w/]*(?:\\[[-+\\d:]*\\][\\w/]*)*";
const EXPRESSION_PATTERN = new RegExp(`^\\s*[\\w/~]+\\s*:(?!${FIELD_PATTERN}(?::${FIELD_PATTERN})*\\s*(?:,|$))`); // what follows the colon is not a list of field names
const FIELD_SEPARATOR = /:(?![^[\]]*\])/; // between fields, not in a slice

// Split /a/x:y, /a/x[0]:y[0] and /a,/b into several curves; an expression is a single one.
export function splitCurves(text) {
  if (EXPRESSION_PATTERN.test(text)) return [text];
  return text.split(",").filter(Boolean).flatMap((part) => {
    if (EXPRESSION_PATTERN.test(part)) return [part];
    const [head, ...others] = part.trim().split(FIELD_SEPARATOR);
    const folder = head.slice(0, head.lastIndexOf("/"));
    return [head, ...others.filter(Boolean).map((other) => `${folder}/${other}`)];
  });
}

// Return approximately a given number of times that are a round number of seconds from the origin.
export function roundTimes(origin, begin, end, count) {
  const least = (end - begin) / Math.max(2, count);
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= least) ?? 10 * power;
  const first = Math.ceil((begin - origin) / step - 1e-6);
  const last = Math.floor((end - origin) / step + 1e-6);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, index) => origin + (first + index) * step);
}

// Format the ticks of an axis, with as many digits as their distance requires: 0.25, 1795706846.5, 1.8e+9.
export function tickLabels(ticks) {
  const [largest, step] = [Math.max(...ticks.map(Math.abs)), Math.abs(ticks[1] - ticks[0])];
  if (!(step > 0) || !largest) return ticks.map((tick) => number(tick));
  let digits = -Math.floor(Math.log10(step)); // number of decimals; negative if there are zeros before the point
  const last = digits + 3;
  while (digits < last && Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) > 1e-3) digits += 1;
  const fixed = ticks.map((tick) => tick.toFixed(Math.min(100, Math.max(0, digits))));
  const scientific = ticks.map((tick) => (tick ? tick.toExponential(Math.min(15, Math.max(0, digits + Math.floor(Math.log10(largest))))) : "0"));
  const length = (texts) => Math.max(...texts.map((text) => text.length));
  return length(fixed) > SHORT_LABEL && length(scientific) < length(fixed) ? scientific : fixed;
}

// Return the width in pixels of an axis with these tick labels.
export function axisWidth(_, texts) {
  return Math.max(64, 24 + 7 * Math.max(0, ...(texts || []).map(({ length }) => length)));
}

// Return the range of an axis for values from least to most, with a margin.
/** @returns {[number, number]} */
export function paddedRange(least, most) {
  if (least === null || most === null || !Number.isFinite(least) || !Number.isFinite(most)) return [0, 1];
  const room = least === most ? Math.abs(least) * 0.1 || 0.5 : (most - least) * 0.08;
  return safeRange([least - room, most + room]);
}

// Widen a range until uPlot can compute its ticks: it would loop forever where a step changes nothing, as between 1e17 and
// 1e17 + 16, and cannot start at an infinite value.
/** @returns {[number, number]} */
export function safeRange(ends) {
  const [least, most] = ends.map((end) => Math.min(MAX_VALUE, Math.max(-MAX_VALUE, end)));
  const lacks = Math.max(Math.abs(least), Math.abs(most)) * MIN_RELATIVE_STEP - (most - least);
  return lacks > 0 ? [least - lacks / 2, most + lacks / 2] : [least, most];
}
