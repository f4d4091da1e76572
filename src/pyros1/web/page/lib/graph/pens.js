// Two pens that draw the same image: on a canvas, or as SVG elements.
//
//   lines([points], {stroke, width, dash, alpha})      points: [x, y, ...], drawn as a smooth line
//   tip(x, y, angle, {fill, alpha})                    an arrow head
//   box(x, y, width, height, {radius, fill, stroke, lineWidth, dash, alpha})    x and y are the centre
//   text(x, y, text, {size, weight, fill, align, alpha})

import { s } from "../dom.js";

/** @typedef {{radius?: number, fill?: string, stroke?: string, lineWidth?: number, dash?: number[], alpha?: number}} BoxStyle */

const ARROW_HEAD = [0, 0, -9, -4, -9, 4];

export class CanvasPen {
  constructor(context, family) {
    this.context = context;
    this.family = family;
  }

  lines(every, { stroke, width, dash, alpha = 1 }) {
    const { context } = this;
    context.globalAlpha = alpha;
    context.strokeStyle = stroke;
    context.lineWidth = width;
    context.setLineDash(dash || []);
    context.beginPath();
    for (const points of every) tracePath(points, (x, y) => context.moveTo(x, y), (x, y) => context.lineTo(x, y), (a, b, x, y) => context.quadraticCurveTo(a, b, x, y));
    context.stroke();
  }

  arrowHead(x, y, angle, { fill, alpha = 1 }) {
    const { context } = this;
    context.globalAlpha = alpha;
    context.fillStyle = fill;
    context.beginPath();
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    for (let index = 0; index < ARROW_HEAD.length; index += 2) {
      context.lineTo(x + ARROW_HEAD[index] * cos - ARROW_HEAD[index + 1] * sin, y + ARROW_HEAD[index] * sin + ARROW_HEAD[index + 1] * cos);
    }
    context.fill();
  }

  box(x, y, width, height, /** @type {BoxStyle} */ { radius, fill, stroke, lineWidth = 1, dash, alpha = 1 }) {
    const { context } = this;
    context.globalAlpha = alpha;
    context.beginPath();
    if (radius) context.roundRect(x - width / 2, y - height / 2, width, height, radius);
    else context.rect(x - width / 2, y - height / 2, width, height);
    if (fill) {
      context.fillStyle = fill;
      context.fill();
    }
    if (!stroke) return;
    context.strokeStyle = stroke;
    context.lineWidth = lineWidth;
    context.setLineDash(dash || []);
    context.stroke();
  }

  text(x, y, text, { size, weight = 400, fill, align = "center", alpha = 1 }) {
    const { context } = this;
    context.globalAlpha = alpha;
    context.font = `${weight} ${size}px ${this.family}`;
    context.textAlign = align;
    context.textBaseline = "middle";
    context.fillStyle = fill;
    context.fillText(text, x, y);
  }
}

export class SvgPen {
  constructor(root, family) {
    this.root = root;
    this.family = family;
  }

  lines(every, { stroke, width, dash, alpha }) {
    const path = [];
    const say = (letter) => (...numbers) => path.push(letter + numbers.map(formatNumber).join(" "));
    for (const points of every) tracePath(points, say("M"), say("L"), say("Q"));
    this._add("path", { d: path.join(""), fill: "none", stroke, "stroke-width": width, "stroke-dasharray": dash?.join(" "), opacity: alpha });
  }

  arrowHead(x, y, angle, { fill, alpha }) {
    const turn = `translate(${formatNumber(x)} ${formatNumber(y)}) rotate(${formatNumber((angle * 180) / Math.PI)})`;
    this._add("polygon", { points: ARROW_HEAD.join(" "), transform: turn, fill, opacity: alpha });
  }

  box(x, y, width, height, /** @type {BoxStyle} */ { radius, fill, stroke, lineWidth = 1, dash, alpha }) {
    this._add("rect", {
      x: formatNumber(x - width / 2), y: formatNumber(y - height / 2), width: formatNumber(width), height: formatNumber(height), rx: radius,
      fill: fill || "none", stroke, "stroke-width": stroke && lineWidth, "stroke-dasharray": dash?.join(" "), opacity: alpha,
    });
  }

  text(x, y, text, { size, weight = 400, fill, align = "center", alpha }) {
    this._add("text", {
      x: formatNumber(x), y: formatNumber(y), fill, opacity: alpha, "font-family": this.family, "font-size": size, "font-weight": weight,
      "text-anchor": align === "center" ? "middle" : "start", "dominant-baseline": "central",
    }, text);
  }

  _add(tag, attributes, ...children) {
    this.root.append(s(tag, { ...attributes, opacity: attributes.opacity < 1 ? attributes.opacity : undefined }, ...children));
  }
}

function tracePath(points, move, line, bend) {
  move(points[0], points[1]);
  let index = 2;
  for (; index < points.length - 2; index += 2) {
    const [x, y] = [points[index], points[index + 1]];
    bend(x, y, (x + points[index + 2]) / 2, (y + points[index + 3]) / 2);
  }
  line(points[index], points[index + 1]);
}

function formatNumber(value) {
  return Math.round(value * 10) / 10;
}
