// The buttons of the mouse tools: select, measure, and those that publish.

import { h } from "../dom.js";

const TOOLS = {
  select: ["Select", "show what an object is, and the values of points"],
  measure: ["Measure", "measure distances"],
  goal: ["Nav goal", "rviz's 2D Nav Goal: tell the robot where to go"],
  estimate: ["Pose estimate", "rviz's 2D Pose Estimate: tell the robot where it is"],
  point: ["Point", "rviz's Publish Point"],
};
const DEFAULT_TOPICS = { goal: "/move_base_simple/goal", estimate: "/initialpose", point: "/clicked_point" }; // tools that publish, and their default topics
const HINTS = { point: "click the point to publish", goal: "press at the position, and release in the direction", estimate: "press at the position, and release in the direction" };

export class Toolbox {
  // scene: the panel; this class uses its stage, lib, view, displays, mouse, place, say(text), updateStream(entry), saveSettings() and fixedFrame().
  // topics: other topics for tools that publish; links are untrusted input.
  constructor(scene, topics) {
    this.scene = scene;
    this.activeTool = "";
    this.topics = Object.fromEntries(Object.keys(DEFAULT_TOPICS).filter((name) => typeof topics?.[name] === "string").map((name) => [name, topics[name]]));
    this.buttons = new Map(Object.entries(TOOLS).map(([name, [text, title]]) => [name, h("button", { "aria-pressed": "false", title, onclick: () => this.use(name) }, text)]));
    this.field = h("input.mono", { hidden: true, "aria-label": "topic of the tool", title: "where this tool publishes; empty: the usual topic", spellcheck: false, size: 20, maxLength: 200, onchange: () => this._publishOn(this.field.value.trim()) });
    this.elements = [...this.buttons.values(), this.field];
    const escape = ({ key }) => { if (key === "Escape" && this.activeTool) this.use(this.activeTool); };
    for (const each of [scene.place.body, scene.place.tools]) each.addEventListener("keydown", escape);
  }

  close() {
    this.tool?.close();
  }

  // Activate a tool, or deactivate it if it is active.
  use(name) {
    const { scene, activeTool: before } = this;
    this.tool?.close();
    this.tool = null;
    this.activeTool = "";
    scene.say("");
    if (name !== before && scene.stage) {
      this.activeTool = name;
      const { ArrowTool, MeasureTool, PointTool, SelectTool } = scene.lib;
      if (name === "select") this.tool = new SelectTool(scene.stage, scene.view, () => [...scene.displays.values()]);
      else if (name === "measure") this.tool = new MeasureTool(scene.stage, (text) => scene.say(text));
      else if (name === "point") this.tool = new PointTool(scene.stage, (point) => this._publish(name, point.toArray()));
      else this.tool = new ArrowTool(scene.stage, name === "goal" ? 0xae3ec9 : 0x2f9e44, (x, y, yaw) => this._publish(name, [x, y, 0], yaw));
      if (HINTS[name]) scene.say(`${HINTS[name]}; Escape ends it`);
    }
    this._showTopic();
    this.updatePermissions();
    if ("select" === before || "select" === this.activeTool) this._inspect();
    for (const [each, button] of this.buttons) button.setAttribute("aria-pressed", String(each === this.activeTool));
  }

  // Tools that publish, and interactive markers, are disabled if the server is read-only.
  updatePermissions() {
    const { mouse, place } = this.scene;
    const { read_only: readOnly } = place.robot.about;
    for (const name of Object.keys(DEFAULT_TOPICS)) this.buttons.get(name).hidden = readOnly;
    if (mouse) mouse.enabled = !this.activeTool && !readOnly;
  }

  // While the selection tool is active, the server also sends the values of points.
  _inspect() {
    for (const entry of this.scene.displays.values()) {
      const args = JSON.stringify(entry.display.args);
      entry.display.inspect?.(this.activeTool === "select");
      if (entry.topic && JSON.stringify(entry.display.args) !== args) this.scene.updateStream(entry);
    }
  }

  _showTopic() {
    this.field.hidden = !(this.activeTool in DEFAULT_TOPICS);
    this.field.value = this.topics[this.activeTool] || DEFAULT_TOPICS[this.activeTool] || "";
  }

  _publishOn(topic) {
    const name = this.activeTool;
    delete this.topics[name];
    if (topic && topic !== DEFAULT_TOPICS[name]) this.topics[name] = topic.replace(/^\/?/, "/");
    this._showTopic();
    this.scene.saveSettings();
  }

  async _publish(name, [x, y, z], yaw = 0) {
    const { scene } = this;
    const pose = { position: { x, y, z }, orientation: { x: 0, y: 0, z: Math.sin(yaw / 2), w: Math.cos(yaw / 2) } };
    const [type, value] = scene.lib.MESSAGES[name](pose, scene.fixedFrame());
    const topic = this.topics[name] || DEFAULT_TOPICS[name];
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
