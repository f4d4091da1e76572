// Convert a gamepad's state to sensor_msgs/Joy, in the order of joy_node on Linux, so that existing settings can be used.
//
// Browsers number the axes and buttons of all common gamepads in the same way, the "standard" mapping of
// https://www.w3.org/TR/gamepad/#remapping; Linux numbers them differently for each kind of gamepad.

// Names of the standard mapping, by the buttons of an Xbox gamepad. Cross, circle, square, triangle are A, B, X, Y.
const STANDARD_AXES = ["left stick x", "left stick y", "right stick x", "right stick y"];
const STANDARD_BUTTONS = [
  "A", "B", "X", "Y", "LB", "RB", "LT", "RT", "back", "start", "left stick", "right stick", "up", "down", "left", "right", "guide",
];

const XBOX_AXES = ["left stick x", "left stick y", "LT", "right stick x", "right stick y", "RT", "D-pad x", "D-pad y"];

// Linux drivers: the names of axes and buttons in their order. "browser" leaves all in the browser's order.
export const ORDERS = {
  xbox: {
    title: "as an Xbox gamepad on Linux",
    axes: XBOX_AXES,
    buttons: ["A", "B", "X", "Y", "LB", "RB", "back", "start", "guide", "left stick", "right stick"],
  },
  ps4: {
    title: "as a PlayStation 4 gamepad on Linux",
    axes: XBOX_AXES,
    buttons: ["A", "B", "Y", "X", "LB", "RB", "LT", "RT", "back", "start", "guide", "left stick", "right stick"],
  },
  ps3: {
    title: "as a PlayStation 3 gamepad on Linux",
    axes: STANDARD_AXES,
    buttons: [
      "back", "left stick", "right stick", "start", "up", "right", "down", "left", "LT", "RT", "LB", "RB", "Y", "B", "A", "X", "guide",
    ],
  },
  browser: { title: "as the browser numbers them", axes: STANDARD_AXES, buttons: STANDARD_BUTTONS },
};

const MAX_DEADZONE = 0.9;

// Return the axes (right and down are positive, as in the browser and in Linux) and buttons of a pad, in the given order.
export function arrangeInputs(pad, order) {
  const pressed = (name) => Number(pad.buttons[STANDARD_BUTTONS.indexOf(name)]?.value ?? 0);
  if (order === "browser" || pad.mapping !== "standard") {
    return { axes: [...pad.axes], buttons: pad.buttons.map((button) => Number(button.pressed)) };
  }
  const axis = (name) => {
    if (name === "LT" || name === "RT") return 2 * pressed(name) - 1;
    if (name === "D-pad x") return pressed("right") - pressed("left");
    if (name === "D-pad y") return pressed("down") - pressed("up");
    return pad.axes[STANDARD_AXES.indexOf(name)] ?? 0;
  };
  const button = (name) => Number(pad.buttons[STANDARD_BUTTONS.indexOf(name)]?.pressed ?? false);
  return { axes: ORDERS[order].axes.map(axis), buttons: ORDERS[order].buttons.map(button) };
}

// Return the names of a pad's axes and buttons, in the given order.
export function inputNames(pad, order) {
  if (pad.mapping !== "standard") return { axes: [], buttons: [] };
  return { axes: ORDERS[order].axes, buttons: ORDERS[order].buttons };
}

// An axis of Joy, from -1 to 1: left and up are positive. Within the dead zone it is 0, and it grows from there, as in joy_node.
export function joyAxis(value, deadzone) {
  const zone = Math.min(Math.max(deadzone, 0), MAX_DEADZONE);
  const size = Math.min(1, Math.max(0, Math.abs(value) - zone) / (1 - zone));
  return Number.isFinite(size) && size > 0 ? -Math.sign(value) * size : 0;
}

// One gamepad. As in joy_node, an axis is 0 until it first moves; after that, a trigger that is not pressed is at 1.
export class JoyReader {
  constructor(order) {
    this.order = order;
    this.first = [];
    this.moved = [];
  }

  // Return {axes, buttons} of Joy.
  read(pad, deadzone) {
    const { axes, buttons } = arrangeInputs(pad, this.order);
    return {
      axes: axes.map((value, index) => {
        this.first[index] ??= value;
        this.moved[index] ||= value !== this.first[index];
        return this.moved[index] ? joyAxis(value, deadzone) : 0;
      }),
      buttons,
    };
  }
}

// Decides when a state is sent to the server: at once if it is new, otherwise every KEEP_ALIVE milliseconds, since the
// server stops the robot when no more states arrive. The release of the gamepad is sent once, as null.
const KEEP_ALIVE = 100;

export class Sender {
  constructor(send) {
    this.send = send;
    this.last = "null";
    this.sentAt = -Infinity;
  }

  update(state, now) {
    const text = JSON.stringify(state);
    if (text === this.last && (state === null || now - this.sentAt < KEEP_ALIVE)) return;
    this.last = text;
    this.sentAt = now;
    this.send(state);
  }
}
