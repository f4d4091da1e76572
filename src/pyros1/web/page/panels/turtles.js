// The turtles of turtlesim and their trails, like the window of turtlesim_node.

import { command, empty, fill, h } from "../lib/dom.js";
import { drawPicture } from "../lib/images.js";

const SIZE = 500; // width and height of the drawing
const PIXELS_PER_UNIT = 45;
const BACKGROUND = "#4556ff";
const SHELLS = ["#3f9142", "#b4690e", "#8e44ad", "#c0392b", "#16808a", "#7f6000"]; // colours, used in turn
const SKINS = ["#8fd694", "#f0b765", "#c99be0", "#ef9a90", "#7fd6de", "#d8bd5a"];

export default {
  title: "Turtles",
  description: "turtles of turtlesim, and what they draw",
  order: 80,
  rare: true,
  mount: (place) => new Turtles(place),
};

class Turtles {
  constructor(place) {
    this.place = place;
    this.turtles = {};
    this.facts = null;
    this.drawing = document.createElement("canvas");
    this.hasDrawing = false;
    this.pendingDrawing = 0;
    if (!document.getElementById("turtles-style")) {
      document.head.append(h("link", { id: "turtles-style", rel: "stylesheet", href: "panels/turtles.css" }));
    }
    this.nodeChoice = h("select.mono", { "aria-label": "simulator", hidden: true, onchange: () => this._choose(this.nodeChoice.value) });
    this.buttons = [["clear", "clear the drawing"], ["reset", "start again with one turtle"]].map(([name, title]) => (
      h("button", { title, disabled: true, onclick: () => this._call(name) }, name === "clear" ? "Clear" : "Reset")));
    place.tools.append(this.nodeChoice, ...this.buttons);
    this.canvas = h("canvas", { "aria-label": "turtles", role: "img" });
    this.frame = h("div.turtles-frame", { hidden: true }, this.canvas);
    this.status = h("div.turtles-status.mono", { hidden: true });
    this.hint = h("div.hint", { hidden: true }, empty("No turtles here", "To start turtlesim, and to drive a turtle with the arrow keys:",
      command("pyros1 run turtlesim turtlesim_node"), command("pyros1 run turtlesim turtle_teleop_key")));
    place.body.classList.add("turtles");
    place.body.append(this.hint, this.frame, this.status);
    this.observer = new ResizeObserver(() => this._draw());
    this.observer.observe(this.frame);
    this.stream = place.robot.stream("turtles", { node: place.settings.node || "" }, {
      data: (data, blob) => this._receive(data, blob),
      problem: (text) => place.problem(text),
    });
  }

  unmount() {
    this.stream.close();
    this.observer.disconnect();
    cancelAnimationFrame(this.pendingDrawing);
  }

  _choose(node) {
    this.place.save({ node });
    this.stream.change({ node });
  }

  async _call(name) {
    const service = `${this.facts.node.slice(0, this.facts.node.lastIndexOf("/"))}/${name}`;
    try {
      await this.place.robot.call("services.call", { service, value: {}, timeout: 5 });
      this.place.problem("");
    } catch (error) {
      this.place.problem(error.message);
    }
  }

  async _receive({ facts, turtles, drawing }, blob) {
    if (facts) {
      if (facts.node !== this.facts?.node) this.hasDrawing = false; // another node: its complete drawing follows
      this.facts = facts;
      this._state();
    }
    if (turtles) this.turtles = turtles;
    if (drawing) {
      try {
        this.hasDrawing = Boolean(await drawPicture(this.drawing, drawing, new Uint8Array(blob.buffer, blob.offset))) || this.hasDrawing;
      } catch (error) {
        this.place.problem(error.message);
      }
    }
    this.pendingDrawing ||= requestAnimationFrame(() => {
      this.pendingDrawing = 0;
      this._draw();
    });
  }

  _state() {
    const { node, nodes, there } = this.facts;
    this.hint.hidden = there;
    this.frame.hidden = this.status.hidden = !there;
    for (const button of this.buttons) button.disabled = !there || this.place.robot.about.read_only;
    const names = [...new Set([...nodes, ...(node ? [node] : [])])].sort();
    this.nodeChoice.hidden = names.length < 2;
    fill(this.nodeChoice, names.map((name) => h("option", { value: name, selected: name === node }, name)));
  }

  _draw() {
    const size = Math.floor(Math.min(this.frame.clientWidth, this.frame.clientHeight));
    if (size < 1) return;
    const sharp = window.devicePixelRatio || 1;
    this.canvas.width = this.canvas.height = Math.round(size * sharp);
    this.canvas.style.width = this.canvas.style.height = `${size}px`;
    const pen = this.canvas.getContext("2d");
    const scale = this.canvas.width / SIZE;
    pen.fillStyle = BACKGROUND;
    pen.fillRect(0, 0, this.canvas.width, this.canvas.height);
    if (this.hasDrawing) pen.drawImage(this.drawing, 0, 0, this.canvas.width, this.canvas.height);
    const rows = Object.entries(this.turtles).filter(([, place]) => place);
    rows.forEach(([name, [x, y, theta]], index) => {
      pen.setTransform(scale, 0, 0, scale, x * PIXELS_PER_UNIT * scale, (SIZE - 1 - y * PIXELS_PER_UNIT) * scale);
      turtle(pen, theta, SHELLS[index % SHELLS.length], SKINS[index % SKINS.length]);
      if (rows.length > 1) label(pen, name);
    });
    pen.resetTransform();
    fill(this.status, rows.map(([name, [x, y, theta]]) => h("span", {}, `${name}  x ${x.toFixed(2)}  y ${y.toFixed(2)}  θ ${theta.toFixed(2)}`)));
  }
}

// Draw a turtle at the origin, seen from above, about 45 pixels long like the original.
function turtle(pen, theta, shell, skin) {
  pen.save();
  pen.rotate(-theta);
  pen.lineWidth = 1.5;
  pen.strokeStyle = "#1b1f24";
  const oval = (x, y, across, down, colour) => {
    pen.fillStyle = colour;
    pen.beginPath();
    pen.ellipse(x, y, across, down, 0, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
  };
  oval(-16, 0, 6, 2, skin);
  for (const [x, y] of [[10, 12], [10, -12], [-10, 12], [-10, -12]]) oval(x, y, 5, 4.5, skin);
  oval(18, 0, 6.5, 5, skin);
  oval(0, 0, 15, 12.5, shell);
  pen.fillStyle = "#1b1f24";
  for (const y of [-2.2, 2.2]) pen.fillRect(20, y - 1, 2, 2);
  pen.beginPath();
  for (const angle of [0, 1, 2, 3, 4, 5].map((part) => part * Math.PI / 3)) pen.lineTo(7 * Math.cos(angle), 6 * Math.sin(angle));
  pen.closePath();
  pen.stroke();
  pen.restore();
}

function label(pen, name) {
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.lineWidth = 3;
  pen.strokeStyle = "#ffffffcc";
  pen.strokeText(name, 0, 34);
  pen.fillStyle = "#1b1f24";
  pen.fillText(name, 0, 34);
}
