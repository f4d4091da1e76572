// A dialog to choose a bag or a folder on the server.

import { command, empty, fill, h } from "../../lib/dom.js";
import { bytes } from "../../lib/format.js";

const FILTER_FROM = 12; // maximum number of files for which no filter is shown

// on: {open(path), problem(text), folder(path, writable)}; folders: choose a folder instead of a file.
export class FileChooser {
  constructor(robot, on, folder = "", folders = false) {
    this.robot = robot;
    this.on = on;
    this.folders = folders;
    this.filter = "";
    this.element = h("div.files");
    this.go(folder);
  }

  async go(folder, fallback = true) {
    const requestNumber = this.requestNumber = {};
    try {
      const listing = await this.robot.call("bags.files", { folder });
      if (requestNumber !== this.requestNumber) return;
      this.listing = listing;
      this.filter = "";
      this.on.problem?.("");
      this.on.folder?.(this.listing.folder, this.listing.writable);
      this._draw();
    } catch (error) {
      if (requestNumber !== this.requestNumber) return;
      if (folder && fallback) this.go("", false); // the stored folder does not exist on this server
      else if (this.robot.state !== "connected") this.robot.addEventListener("about", () => this.go(folder, fallback), { once: true });
      else this.on.problem?.(error.message);
    }
  }

  _draw() {
    const { folder, up, folders, files, more } = this.listing;
    const shown = files.filter(({ name }) => name.toLowerCase().includes(this.filter.toLowerCase()));
    const list = h("div.entries");
    const entry = (kind, name, note, act) => h(`button.entry.${kind}`, { type: "button", title: name, onclick: act }, h("i.sign", {}, kind === "file" ? "▤" : "▸"), h("span.title", {}, name), note);
    fill(list,
      up !== null && entry("folder", "..", null, () => this.go(up)),
      folders.map(({ name, path }) => entry("folder", name, null, () => this.go(path))),
      !this.folders && shown.map(({ name, path, size, time }) => entry("file", name, [h("span.muted.size", {}, bytes(size)), h("span.muted.date", {}, new Date(time * 1000).toLocaleString([], { dateStyle: "medium", timeStyle: "short" }))], () => this.on.open(path))),
      more && h("p.muted.hint", {}, "This folder has more than can be shown."));
    const filter = !this.folders && files.length > FILTER_FROM && h("input", { placeholder: "filter", "aria-label": "filter", value: this.filter, oninput: (event) => { this.filter = event.target.value; this._filterChanged(); } });
    const nothing = !this.folders && !files.length && (folders.length
      ? h("p.muted.hint", {}, "There are no bags in this folder; its subfolders may have some. Record one with ● Record, or show another folder: ", command("pyros1 web --bags FOLDER"))
      : empty("No bags here", "Record one with ● Record above, or in a terminal:", command("pyros1 bag record -a"), "To show bags in another folder:", command("pyros1 web --bags FOLDER")));
    const none = !folder && !folders.length;
    fill(this.element, h("div.place-name.mono", {}, h("span", {}, folder || (none ? "" : "folders of this server")), h("span.gap"), filter),
      none ? empty("No folder with bags", "Tell the server which folder to show:", command("pyros1 web --bags FOLDER")) : [list, nothing]);
  }

  _filterChanged() {
    this._draw();
    const input = this.element.querySelector("input");
    input.focus();
    input.setSelectionRange(this.filter.length, this.filter.length);
  }
}
