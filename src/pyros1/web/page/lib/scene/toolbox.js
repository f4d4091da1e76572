// The buttons of the mouse's tools: select, measure, and those that publish.

import { h } from "../dom.js";

const TOOLS = { select: "Select", measure: "Measure", goal: "Nav goal", estimate: "Pose estimate", point: "Point" };
const WRITING = ["goal", "estimate", "point"]; // tools that publish

export class Toolbox {
  // scene: the panel; of it are used stage, lib, view, displays, mouse, place, say(text), again(entry) and fixedFrame().
  constructor(scene) {
    this.scene = scene;
    this.using = "";
    this.buttons = new Map(Object.entries(TOOLS).map(([name, text]) => [name, h("button", { "aria-pressed": "false", onclick: () => this.use(name) }, text)]));
  }

  close() {
    this.tool?.close();
  }

  // Take a tool in hand, or put it away if it is.
  use(name) {
    const { scene, using: before } = this;
    this.tool?.close();
    this.tool = null;
    this.using = "";
    scene.say("");
    if (name !== before && scene.stage) {
      this.using = name;
      const { ArrowTool, MeasureTool, PointTool, SelectTool } = scene.lib;
      if (name === "select") this.tool = new SelectTool(scene.stage, scene.view, () => [...scene.displays.values()]);
      else if (name === "measure") this.tool = new MeasureTool(scene.stage, (text) => scene.say(text));
      else if (name === "point") this.tool = new PointTool(scene.stage, (point) => this._publish(name, point.toArray()));
      else this.tool = new ArrowTool(scene.stage, name === "goal" ? 0xae3ec9 : 0x2f9e44, (x, y, yaw) => this._publish(name, [x, y, 0], yaw));
      if (name === "point") scene.say("click the place that is published");
      else if (name === "goal" || name === "estimate") scene.say("press at the place, and release in the direction");
    }
    this.mayWrite();
    if ("select" === before || "select" === this.using) this._inspect();
    for (const [each, button] of this.buttons) button.setAttribute("aria-pressed", String(each === this.using));
  }

  // Tools that publish, and interactive markers, are of no use if the server is read-only.
  mayWrite() {
    const { mouse, place } = this.scene;
    const { read_only: readOnly } = place.robot.about;
    for (const name of WRITING) this.buttons.get(name).hidden = readOnly;
    if (mouse) mouse.enabled = !this.using && !readOnly;
  }

  // While one selects, the server sends the numbers behind the points, too.
  _inspect() {
    for (const entry of this.scene.displays.values()) {
      const args = JSON.stringify(entry.display.args);
      entry.display.inspect?.(this.using === "select");
      if (entry.topic && JSON.stringify(entry.display.args) !== args) this.scene.again(entry);
    }
  }

  async _publish(name, [x, y, z], yaw = 0) {
    const { scene } = this;
    const pose = { position: { x, y, z }, orientation: { x: 0, y: 0, z: Math.sin(yaw / 2), w: Math.cos(yaw / 2) } };
    const [topic, type, value] = scene.lib.MESSAGES[name](pose, scene.fixedFrame());
    this.use(name);
    try {
      const { subscribers } = await scene.place.robot.call("topics.publish", { topic, type, value });
      const place = name === "point" ? `(${x.toFixed(2)}, ${y.toFixed(2)}, ${z.toFixed(2)})` : `(${x.toFixed(2)}, ${y.toFixed(2)}), ${(yaw * 180 / Math.PI).toFixed(0)}°`;
      scene.say(`${topic}: ${place}, to ${subscribers} subscriber${subscribers === 1 ? "" : "s"}`);
    } catch (error) {
      scene.say(error.message);
    }
  }
}
