// The page's connection to the server. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

// A browser whose clock and sockets belong to the test.
let now = 0;
let number = 0;
const timers = new Map();
function start(call, after, every) {
  number += 1;
  timers.set(number, { at: now + after, call, every });
  return number;
}
Object.assign(globalThis, {
  setTimeout: (call, after) => start(call, after, 0),
  setInterval: (call, every) => start(call, every, every),
  clearTimeout: (id) => timers.delete(id),
  clearInterval: (id) => timers.delete(id),
});
function tick(time) {
  const end = now + time;
  for (;;) {
    const [id, next] = [...timers].sort(([, one], [, other]) => one.at - other.at)[0] || [];
    if (!next || next.at > end) break;
    now = next.at;
    if (next.every) next.at += next.every;
    else timers.delete(id);
    next.call();
  }
  now = end;
}
const sockets = [];
class Socket {
  static OPEN = 1;
  constructor() {
    this.readyState = 0;
    this.sent = [];
    sockets.push(this);
  }
  open() { this.readyState = 1; this.onopen(); }
  say(message) { this.onmessage?.({ data: JSON.stringify(message) }); }
  send(text) { this.sent.push(JSON.parse(text)); }
  close() { this.readyState = 3; }
}
Object.assign(globalThis, { WebSocket: Socket, location: { protocol: "http:", host: "robot" }, addEventListener: () => {}, requestAnimationFrame: () => 0 });
Object.defineProperty(globalThis, "performance", { value: { now: () => now }, configurable: true });
const { Robot } = await import(new URL("../../../src/pyros1/web/page/lib/robot.js", import.meta.url));

const ABOUT = { version: "1", master: "http://m", read_only: false, trouble: "" };
const settled = () => new Promise((resolve) => setImmediate(resolve));

// Let time pass in steps; a server that lives answers each question.
async function pass(seconds, about = null) {
  for (let step = 0; step < seconds; step += 1) {
    tick(1000);
    if (about) answer(sockets.at(-1), about);
    await settled();
  }
}

function answer(socket, about) {
  for (const { call, id } of socket.sent.splice(0)) if (call) socket.say({ id, result: about });
}

async function connected(t) {
  timers.clear();
  const robot = new Robot("x");
  sockets.at(-1).open();
  answer(sockets.at(-1), ABOUT);
  await settled();
  t.after(() => sockets.at(-1).onclose?.());
  return robot;
}

test("gives up on a server that falls silent, and reconnects", async (t) => {
  const robot = await connected(t);
  const [first] = sockets.slice(-1);
  robot.stream("system", {}, {});
  await pass(30, ABOUT);
  assert.equal(robot.state, "connected");
  await pass(20);
  assert.equal(robot.state, "connecting");
  assert.match(robot.trouble, /does not answer/);
  assert.notEqual(sockets.at(-1), first);
  first.say({ id: 1, result: {} }); // too late
  sockets.at(-1).open();
  assert.equal(robot.state, "connected");
  assert.deepEqual(sockets.at(-1).sent[0].open, "system");
});

test("tries again if a connection attempt gets no answer", async (t) => {
  await connected(t);
  sockets.at(-1).onclose();
  await pass(1);
  const count = sockets.length;
  await pass(20); // no answer, neither yes nor no
  assert.ok(sockets.length > count);
});

test("reports once that the master is gone, and once that it is back", async (t) => {
  const robot = await connected(t);
  const told = [];
  robot.addEventListener("master", () => told.push(robot.masterProblem));
  await pass(10, { ...ABOUT, trouble: "gone" });
  await pass(10, ABOUT);
  assert.deepEqual(told, ["gone", ""]);
});

test("a stream that resumes clears only its own problem, and only once", () => {
  const robot = new Robot("token");
  const socket = sockets.at(-1);
  socket.open();
  const told = [];
  robot.stream("console", {}, { data() {}, problem: (text) => told.push(text) });
  const id = socket.sent.find(({ open }) => open === "console").stream;
  socket.say({ stream: id, data: 1 });
  assert.deepEqual(told, []); // a panel may say something itself
  socket.say({ stream: id, error: "no master" });
  socket.say({ stream: id, data: 2 });
  socket.say({ stream: id, data: 3 });
  assert.deepEqual(told, ["no master", ""]);
});
