// The choice of the view, the followed frame, and the axis for views from a frame. Only the user's choices are stored: the
// name of the view, and its position after the user has moved it.

import { fill, h } from "../dom.js";

const VIEWS = { orbit: "orbit", ground: "ground", third: "behind", frame: "in frame", walk: "walk", top: "top", side: "side", flat: "flat" };
const AXES = ["x", "-x", "y", "-y", "z", "-z"];

export class ViewChoice {
  // kept: {view, target}, perhaps from a link. host: {changed(): store it, robot() -> the object to fit into the view, if any}.
  constructor({ view, target }, host) {
    this.stored = view && typeof view === "object" ? view : null;
    this.target = String(target || ""); // the followed frame
    this.host = host;
    this.frames = h("select.mono", { "aria-label": "followed frame", title: "the frame that the view follows", onchange: (event) => this._goWith(event.target.value) });
    this.views = h("select", { "aria-label": "view", title: "viewpoint; ground: moves on the ground; behind, in frame: turn with the followed frame; walk: mouse, wheel and W, A, S, D; flat: from above, without perspective", onchange: (event) => this._look(event.target.value) },
      Object.entries(VIEWS).map(([name, text]) => h("option", { value: name }, text)));
    this.axes = h("select.mono", { hidden: true, "aria-label": "axis", title: "the axis of the frame along which the view looks", onchange: (event) => this._axis(event.target.value) },
      ["", ...AXES].map((name) => h("option", { value: name, disabled: !name }, name ? name.replace("-", "−") : "turned")));
  }

  // Called when the stage exists, and the frames with their poses.
  begin(stage, poses) {
    this.stage = stage;
    this.poses = poses;
    if (this.stored) stage.place = this.stored;
    stage.onMove = () => this._moved();
    this._show();
  }

  offer(names) {
    fill(this.frames, h("option", { value: "" }, "no frame"), names.map((name) => h("option", { value: name, selected: name === this.target }, name)));
  }

  // Follow the frame. Without one, views from a frame use the fixed frame.
  follow() {
    const name = this.target || (this.stage.isInFrame ? this.poses.fixed : "");
    const pose = name && this.poses.pose(name);
    if (pose) this.stage.follow(pose);
    this.stage.draw();
  }

  // Keep a robot without other displays in view, until the user moves the view. again: its look has changed.
  fitRobot(again) {
    if (this.stored?.position || this.stage.isInFrame) return;
    const robot = this.host.robot();
    if (robot && (again || (!this.target && !this.stage.shows(robot)))) this.stage.fit(robot);
  }

  // Reset to the initial view.
  reset() {
    if (this.stage) this._begun([0, 0, 0]);
  }

  // Fit all displays into the view, except for the grid.
  fit(entries) {
    const shown = entries.filter(({ kind, display }) => kind !== "Grid" && display.object?.visible).map(({ display }) => display.object);
    if (!this.stage || this.stage.isInFrame || !this.stage.fit(...shown)) return;
    this._moved();
  }

  _look(name) {
    if (!this.stage) return;
    const { camera, controls, isInFrame } = this.stage;
    const eye = camera.isPerspectiveCamera ? camera.position.toArray() : null;
    this._begun(isInFrame ? [0, 0, 0] : controls.target.toArray(), eye, name);
    this.stage.canvas.focus({ preventScroll: true });
  }

  _begun(target, eye = null, name = this.stage.name) {
    this.stage.view(name, target, eye);
    this.stage.followed = null;
    this.stored = { name };
    this.fitRobot(true);
    this.follow();
    this._show();
    this.host.changed();
  }

  _axis(name) {
    this.stage.frameView.look(name);
    this._moved();
    this.stage.canvas.focus({ preventScroll: true });
  }

  _goWith(name) {
    this.target = name;
    if (this.stage) {
      this.stage.followed = null;
      this.follow();
    }
    this.host.changed();
  }

  // The user has moved the view.
  _moved() {
    this.stored = this.stage.place;
    this._show();
    this.host.changed();
  }

  _show() {
    this.views.value = this.stage.name;
    this.axes.hidden = !this.stage.isInFrame;
    if (!this.stage.isInFrame) return;
    const { axis, along } = this.stage.frameView.place;
    this.axes.value = along ? axis : "";
  }
}
