// Recording: a button, a dialog to choose what to record, and the progress.

import { fill, h } from "../../lib/dom.js";
import { bytes, plural, rate } from "../../lib/format.js";
import { FileChooser } from "./file_chooser.js";
import { formatElapsed } from "./times.js";

const MAX_LISTED = 300; // maximum number of topics in the list

// on: {open(path), problem(text)}
export class Recorder {
  constructor(robot, on) {
    this.robot = robot;
    this.on = on;
    this.now = null;
    this.dismissed = "";
    this.button = h("button.record", { title: "record topics into a bag", onclick: () => this._openDialog() }, h("i.dot"), "Record");
    this.strip = h("div.recording", { hidden: true });
    this.dialog = h("dialog.record-dialog", { "aria-label": "record" });
    this.dialog.addEventListener("close", () => { this.topics?.close(); this.topics = null; });
    this.stream = robot.stream("bag_recording", {}, { data: ({ recording }) => { this.now = recording; this._draw(); } });
    this.onAbout = () => { this.button.disabled = robot.about.read_only; };
    robot.addEventListener("about", this.onAbout);
    this.onAbout();
    this.shownRecording = null; // a recording that ended earlier is shown only if it failed
  }

  close() {
    this.stream.close();
    this.topics?.close();
    this.dialog.remove();
    this.robot.removeEventListener("about", this.onAbout);
  }

  _draw() {
    const now = this.now;
    const running = Boolean(now?.running);
    if (running) this.shownRecording = now.path;
    this.button.setAttribute("aria-pressed", String(running));
    this.strip.hidden = !now || (!running && ((this.shownRecording !== now.path && !now.error) || this.dismissed === now.path));
    if (this.strip.hidden) return;
    const name = now.path.split("/").at(-1);
    const open = this.strip.querySelector("details")?.open;
    const figures = [formatElapsed(now.seconds, 0.1), bytes(now.bytes), plural(now.messages, "message")].join(" · ");
    const dropped = now.topics.reduce((sum, topic) => sum + topic.dropped, 0);
    const active = /** @type {HTMLElement | null} */ (document.activeElement);
    const focused = active && this.strip.contains(active) ? active.dataset.what : "";
    fill(this.strip,
      h("div.line", {}, h(running ? "i.dot.live" : "i.dot"), h("span", {}, running ? "Recording" : "Recorded"), h("b.mono", { title: now.path }, name), h("span.muted", {}, figures),
        dropped > 0 && h("span.wrong", {}, `${dropped} dropped`), h("span.gap"),
        running
          ? h("button.danger", { dataset: { what: "stop" }, onclick: () => this._stop() }, "Stop")
          : [h("button", { onclick: () => { this.dismissed = now.path; this._draw(); this.on.open(now.path); } }, "Open"),
            h("button.quiet", { "aria-label": "dismiss", onclick: () => { this.dismissed = now.path; this._draw(); } }, "✕")]),
      (now.error || now.warning) && h("p.wrong", {}, now.error || now.warning),
      now.topics.length
        ? h("details", { open: Boolean(open) }, h("summary", {}, plural(now.topics.length + now.more, "topic")), h("div.rates", {}, now.topics.map((topic) => [
          h("span.mono", {}, topic.name), h("span", {}, `${topic.messages}`), h("span", {}, running ? rate(topic.hz) : ""), h("span", {}, !running ? bytes(topic.bytes) : topic.rate === null ? "" : `${bytes(topic.rate)}/s`)])))
        : running && h("p.muted", {}, "Waiting for topics with publishers …"));
    if (focused) this.strip.querySelector(`[data-what=${focused}]`)?.focus();
  }

  async _stop() {
    try {
      this.now = await this.robot.call("bags.stop");
      this._draw();
    } catch (error) {
      this.on.problem(error.message);
    }
  }

  _openDialog() {
    if (this.now?.running) return;
    if (!this.dialog.isConnected) document.body.append(this.dialog);
    let folder = "";
    const chosen = new Set();
    const problem = h("p.wrong", { hidden: true, role: "alert" });
    const say = (text) => { problem.hidden = !text; fill(problem, text); };
    const begin = h("button.primary", { disabled: true }, "Record");
    const files = new FileChooser(this.robot, { folder: (path, writable) => {
      folder = path;
      begin.disabled = !path || !writable;
      say(path && !writable ? "this server may not write to this folder: choose another one, or restart it with: pyros1 web --bags FOLDER" : "");
    }, problem: (text) => { if (text) say(text); } }, this.folder || "", true);
    const prefix = h("input", { placeholder: "name", "aria-label": "name", title: "file name prefix, before the date", maxLength: 100, value: this.prefix || "" });
    const compression = h("select", { "aria-label": "compression" }, ["none", "lz4", "bz2"].map((each) => h("option", { selected: each === (this.compression || "none") }, each)));
    const list = h("div.topics", { hidden: true });
    const all = h("input", { type: "radio", name: "what", checked: true, onchange: () => { list.hidden = true; } });
    const some = h("input", { type: "radio", name: "what", onchange: () => { list.hidden = false; } });
    const count = h("span.muted");
    this.topics?.close();
    this.topics = this.robot.stream("system", {}, { data: ({ topics }) => {
      const names = Object.keys(topics);
      const known = names.join();
      fill(count, `(${names.length} now)`);
      if (known === list.known) return;
      list.known = known;
      fill(list, names.slice(0, MAX_LISTED).map((name) => h("label.check", {}, h("input", { type: "checkbox", checked: chosen.has(name), onchange: (event) => (event.target.checked ? chosen.add(name) : chosen.delete(name)) }), h("span.mono", {}, name), h("span.muted", {}, topics[name].type))),
        names.length > MAX_LISTED && h("p.muted", {}, `and ${names.length - MAX_LISTED} more`));
    }, problem: say });
    fill(this.dialog, h("h3", {}, "Record"), h("form", { method: "dialog", onsubmit: async (event) => {
      event.preventDefault();
      this.folder = folder;
      this.prefix = prefix.value;
      this.compression = compression.value;
      try {
        await this.robot.call("bags.record", { folder, prefix: prefix.value.trim(), compression: compression.value, topics: all.checked ? null : [...chosen] });
        this.dialog.close();
      } catch (error) {
        say(error.message);
      }
    } },
    h("fieldset", {}, h("legend", {}, "what"), h("label.check", {}, all, "all topics, including new ones ", count), h("label.check", {}, some, "some"), list),
    h("fieldset", {}, h("legend", {}, "where"), files.element),
    h("div.row", {}, prefix, h("label.check", { title: "lz4 is fast; bz2 is smaller, but slow" }, "compression", compression)), problem,
    h("div.row", {}, h("span.gap"), h("button", { type: "button", onclick: () => this.dialog.close() }, "Cancel"), begin)));
    this.dialog.showModal();
  }
}
