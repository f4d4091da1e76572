// Playback: moves the cursor, and publishes the messages to the robot if the user wants that.

import { fill, h } from "../../lib/dom.js";

const RATES = [0.1, 0.25, 0.5, 1, 2, 5, 10];

// on: {time(t), selected() -> topics, problem(text)}
export class Player {
  constructor(robot, on, clock) {
    this.robot = robot;
    this.on = on;
    this.facts = null;
    this.playing = false;
    this.rate = 1;
    this.loop = false;
    this.clock = clock;
    this.publish = false;
    this.onlySelected = false;
    this.time = 0;
    this.previousTime = 0; // when the cursor was last moved
    this.frame = 0; // id from requestAnimationFrame
    this.opened = 0; // how often the stream was opened
    this._build();
  }

  _build() {
    const toggle = (text, title, key) => {
      const button = h("button", { title, "aria-pressed": String(this[key]), onclick: () => {
        this[key] = !this[key];
        button.setAttribute("aria-pressed", String(this[key]));
        this._changed();
      } }, text);
      return button;
    };
    this.button = h("button.play", { title: "play or pause (space)", "aria-label": "play", onclick: () => this.toggle() }, "▶");
    const rates = h("select", { "aria-label": "rate", title: "speed", onchange: (event) => { this.rate = Number(event.target.value); this._changed(); } },
      RATES.map((rate) => h("option", { value: rate, selected: rate === 1 }, `${rate}×`)));
    const mode = h("select.mode", { "aria-label": "mode", title: "whether to publish the messages to the robot while playing", onchange: (event) => this._setMode(event.target.value) },
      h("option", { value: "look" }, "view only"), h("option", { value: "publish" }, "publish all"), h("option", { value: "some" }, "publish selected"));
    this.mode = mode;
    this.clockButton = toggle("/clock", "publish the time of the bag on /clock", "clock");
    this.clockButton.hidden = true;
    this.element = h("span.player", { hidden: true }, this.button, rates, toggle("Loop", "start again at the end", "loop"), mode, this.clockButton);
    this.onAbout = () => {
      const { read_only: only } = this.robot.about;
      for (const option of [...mode.options].slice(1)) option.disabled = only;
      mode.title = only ? "this server is read-only: playing publishes nothing" : mode.title;
    };
    this.robot.addEventListener("about", this.onAbout);
    this.onAbout();
  }

  close() {
    this.stop();
    this.robot.removeEventListener("about", this.onAbout);
  }

  show(path, facts) {
    this.stop();
    this.path = path;
    this.facts = facts;
    this.time = 0;
    this.element.hidden = !facts;
    this.hasClock = facts?.topics.some(({ name }) => name.replace(/^\//, "") === "clock");
  }

  toggle() {
    if (!this.facts) return;
    if (this.playing) this.pause();
    else this._play();
  }

  pause() {
    this.playing = false;
    this._draw();
    if (this.stream) this._send();
  }

  // Stop everything, including publishing.
  stop() {
    this.playing = false;
    this.stream?.close();
    this.stream = null;
    cancelAnimationFrame(this.frame);
    this._draw();
    this.on.problem("");
  }

  // Called when the user has moved the cursor.
  seek(time) {
    this.time = time;
    this.previousTime = performance.now();
    if (this.stream) this._send(time);
  }

  // Called when the user has selected other topics.
  selected() {
    if (this.stream && this.onlySelected) this._changed();
  }

  _setMode(mode) {
    this.publish = mode !== "look";
    this.onlySelected = mode === "some";
    this.clockButton.hidden = !this.publish || this.hasClock;
    this.element.classList.toggle("live", this.publish);
    if (!this.publish) {
      const { playing } = this;
      this.stop();
      if (playing) this._play();
    } else if (this.playing || this.stream) this._play();
  }

  _play() {
    if (this.time >= this.facts.length - 1e-9) this._showTime(0);
    if (this.publish && this.onlySelected && !this.on.selected().length) {
      this.on.problem("select the topics to publish first: click their names");
      return;
    }
    this.playing = true;
    this._draw();
    this.previousTime = performance.now();
    if (this.publish) {
      if (this.stream) this._send(this.time);
      else this._open();
    } else this._tick();
  }

  _changed() {
    if (this.stream) this._send();
  }

  _args(start) {
    return {
      path: this.path, rate: this.rate, loop: this.loop, paused: !this.playing,
      clock: this.clock && !this.hasClock, topics: this.onlySelected ? this.on.selected() : null, ...(start === undefined ? {} : { start }),
    };
  }

  _send(start) {
    this.args = this._args(start);
    this.stream.change(this.args);
  }

  _open() {
    this.args = this._args(this.time);
    this.opened = 0;
    this.stream = this.robot.stream("bag_play", this.args, {
      opened: () => {
        this.opened += 1;
        if (this.opened > 1 && this.playing) this.stop(); // after a reconnect, the user must start again
      },
      data: (status) => this._receive(status),
      problem: (text) => { if (text) this.on.problem(text); },
    });
    this._tick();
  }

  _receive(status) {
    const unplayable = Object.entries(status.unplayable).map(([topic, reason]) => `${topic} is not played: ${reason}`);
    const dropped = status.dropped ? [`${status.dropped} messages were dropped because subscribers were too slow`] : [];
    this.on.problem([status.problem, ...unplayable, ...dropped].filter(Boolean).join("; "));
    if (status.state === "ended" || status.state === "failed") {
      this.playing = false;
      this._draw();
    }
    this.state = status.state;
    if (this.playing || status.state === "ended") {
      this.previousTime = performance.now();
      this._showTime(status.time);
    }
  }

  // Between two updates of the server, the cursor continues to move.
  _tick() {
    cancelAnimationFrame(this.frame);
    this.frame = requestAnimationFrame(() => {
      if (!this.playing) return;
      const now = performance.now();
      const running = !this.publish || (this.state === "running" && this.stream);
      let time = this.time + (running ? ((now - this.previousTime) / 1000) * this.rate : 0);
      this.previousTime = now;
      if (time >= this.facts.length && !this.publish) {
        if (this.loop && this.facts.length > 0) time = 0;
        else {
          this.playing = false;
          this._draw();
        }
      }
      if (time !== this.time) this._showTime(Math.min(time, this.facts.length));
      this._tick();
    });
  }

  _showTime(time) {
    this.time = time;
    this.on.time(time);
  }

  _draw() {
    fill(this.button, this.playing ? "❚❚" : "▶");
    this.button.setAttribute("aria-label", this.playing ? "pause" : "play");
  }
}
