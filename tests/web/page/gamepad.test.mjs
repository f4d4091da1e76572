// A gamepad as a joystick. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { JoyReader, ORDERS, Sender, arrangeInputs, inputNames, joyAxis } from "../../../src/pyros1/web/page/lib/gamepad.js";

// A gamepad at rest, with some axes moved and some buttons pressed, by the browser's numbers.
function gamepad(axes = {}, pressed = {}, mapping = "standard") {
  return {
    mapping,
    axes: [0, 1, 2, 3].map((index) => axes[index] ?? 0),
    buttons: Array.from({ length: 17 }, (_, index) => ({ value: pressed[index] ?? 0, pressed: (pressed[index] ?? 0) > 0 })),
  };
}

// What joy_node says if something is used after the gamepad lay still.
function joy(order, axes, pressed, deadzone = 0) {
  const reader = new JoyReader(order);
  reader.read(gamepad(), deadzone);
  return reader.read(gamepad(axes, pressed), deadzone);
}

// Numbers by the kernel's drivers (xpad, hid-sony) and by https://wiki.ros.org/joy, https://wiki.ros.org/ps3joy: the browser's
// button -> the one of Joy.
const BUTTONS = {
  xbox: { 0: 0, 1: 1, 2: 2, 3: 3, 4: 4, 5: 5, 8: 6, 9: 7, 16: 8, 10: 9, 11: 10 },
  ps4: { 0: 0, 1: 1, 3: 2, 2: 3, 4: 4, 5: 5, 6: 6, 7: 7, 8: 8, 9: 9, 16: 10, 10: 11, 11: 12 },
  ps3: { 8: 0, 10: 1, 11: 2, 9: 3, 12: 4, 15: 5, 13: 6, 14: 7, 6: 8, 7: 9, 4: 10, 5: 11, 3: 12, 1: 13, 0: 14, 2: 15, 16: 16 },
  browser: Object.fromEntries(Array.from({ length: 17 }, (_, index) => [index, index])),
};

test("each button has the same number as under Linux", () => {
  assert.deepEqual(Object.keys(BUTTONS), Object.keys(ORDERS));
  for (const [order, numbers] of Object.entries(BUTTONS)) {
    const count = Object.keys(numbers).length;
    for (let button = 0; button < 17; button += 1) {
      const wanted = Array.from({ length: count }, (_, index) => Number(index === numbers[button]));
      assert.deepEqual(joy(order, {}, { [button]: 1 }).buttons, wanted, `${order}: ${button}`);
    }
  }
});

test("left and up are positive", () => {
  const left = { 0: -1, 1: -0.5, 2: 0.25, 3: 1 };
  assert.deepEqual(joy("xbox", left).axes, [1, 0.5, 0, -0.25, -1, 0, 0, 0]);
  assert.deepEqual(joy("ps4", left).axes, [1, 0.5, 0, -0.25, -1, 0, 0, 0]);
  for (const order of ["ps3", "browser"]) assert.deepEqual(joy(order, left).axes, [1, 0.5, -0.25, -1], order);
  assert.deepEqual(joy("xbox", {}, { 12: 1, 15: 1 }).axes.slice(6), [-1, 1]);
  assert.deepEqual(joy("xbox", {}, { 13: 1, 14: 1 }).axes.slice(6), [1, -1]);
});

test("a trigger goes from 1 to -1 once it has been used", () => {
  const reader = new JoyReader("xbox");
  const triggers = (left, right) => {
    const { axes } = reader.read(gamepad({}, { 6: left, 7: right }), 0);
    return [axes[2], axes[5]];
  };
  assert.deepEqual(triggers(0, 0), [0, 0]);
  assert.deepEqual(triggers(0.25, 0), [0.5, 0]);
  assert.deepEqual(triggers(1, 0.5), [-1, 0]);
  assert.deepEqual(triggers(0, 0), [1, 1]);
});

test("a stick that is held when the gamepad appears counts as centred until it moves", () => {
  const reader = new JoyReader("xbox");
  assert.equal(reader.read(gamepad({ 1: -1 }), 0.1).axes[1], 0);
  assert.equal(reader.read(gamepad({ 1: -1 }), 0.1).axes[1], 0);
  assert.ok(reader.read(gamepad({ 1: -0.9 }), 0.1).axes[1] > 0.8);
});

test("axes rise from 0 at the edge of the dead zone, and stay within -1 to 1", () => {
  for (let trial = 0; trial < 2000; trial += 1) {
    const deadzone = Math.random() * 1.2 - 0.1;
    const value = Math.random() * 2.4 - 1.2;
    const zone = Math.min(Math.max(deadzone, 0), 0.9);
    const found = joyAxis(value, deadzone);
    if (Math.abs(value) <= zone) assert.equal(found, 0);
    else if (Math.abs(value) >= 1) assert.equal(found, -Math.sign(value));
    else assert.ok(Math.abs(found * (1 - zone) + (value - Math.sign(value) * zone)) < 1e-9, `${value} ${deadzone}: ${found}`);
  }
  for (const value of [NaN, Infinity, undefined]) assert.ok(Number.isFinite(joyAxis(value, 0.1)));
  assert.ok(Object.is(joyAxis(0, 0.1), 0)); // not -0
});

test("a gamepad that the browser does not know keeps its own numbering", () => {
  const pad = gamepad({ 0: -1 }, { 3: 1 }, "");
  for (const order of Object.keys(ORDERS)) {
    assert.deepEqual(arrangeInputs(pad, order).axes, [-1, 0, 0, 0]);
    assert.equal(arrangeInputs(pad, order).buttons[3], 1);
    assert.deepEqual(inputNames(pad, order), { axes: [], buttons: [] });
  }
  const few = { mapping: "standard", axes: [1], buttons: [] }; // less than the standard has
  assert.deepEqual(joyAxis(arrangeInputs(few, "xbox").axes[0], 0), -1);
  assert.equal(arrangeInputs(few, "xbox").buttons.length, 11);
});

test("each axis and button has a name", () => {
  for (const order of Object.keys(ORDERS)) {
    const { axes, buttons } = arrangeInputs(gamepad(), order);
    assert.deepEqual([inputNames(gamepad(), order).axes.length, inputNames(gamepad(), order).buttons.length], [axes.length, buttons.length]);
  }
});

test("sends changes at once, unchanged states ten times per second, and the release once", () => {
  const sent = [];
  const sender = new Sender((state) => sent.push(state));
  const at = (state, now) => {
    const before = sent.length;
    sender.update(state, now);
    return sent.length - before;
  };
  assert.equal(at(null, 0), 0);
  assert.equal(at({ axes: [1] }, 1), 1);
  assert.equal(at({ axes: [1] }, 90), 0);
  assert.equal(at({ axes: [1] }, 101), 1);
  assert.equal(at({ axes: [0.5] }, 102), 1);
  assert.equal(at(null, 103), 1);
  assert.equal(at(null, 1000), 0);
  assert.deepEqual(sent.at(-1), null);
});
