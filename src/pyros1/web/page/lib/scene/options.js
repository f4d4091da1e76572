// The options of displays: {key: {text, kind: "number" | "check" | "choice" | "colour" | "text", defaultValue,
// least, most, step, choices, none}}. Defaults are rviz's, except that small points are drawn as pixels.

import { COLOUR_SCHEMES } from "./map.js";
import { STYLES } from "./points.js";

/**
 * @typedef {object} Control
 * @property {string} text
 * @property {"number" | "check" | "choice" | "colour" | "text"} kind
 * @property {any} defaultValue
 * @property {number} [least]
 * @property {number} [most]
 * @property {number} [step]
 * @property {string[]} [choices]
 * @property {string} [none]
 */

const number = (text, defaultValue, least, most, step) => ({ text, kind: "number", defaultValue, least, most, step });
const metres = (text, defaultValue) => number(text, defaultValue, 0, 1000, 0.01);
const check = (text, defaultValue) => ({ text, kind: "check", defaultValue });
const colour = (text, defaultValue) => ({ text, kind: "colour", defaultValue });
const choice = (text, defaultValue, choices) => ({ text, kind: "choice", defaultValue, choices });
const opacity = (defaultValue = 1, text = "opacity") => number(text, defaultValue, 0, 1, 0.05);
const keep = (defaultValue = 1) => ({ keep: number("keep", defaultValue, 1, 1000, 1) });

export const TINT_CONTROL = colour("colour", ""); // the display's own
export const MAX_POINTS_CONTROL = number("maximum points", 1500000, 1000, 1500000, 1000);
const COLOUR_BY_CONTROL = choice("colour by", "", [""]);
const looks = (pixels) => ({
  style: choice("style", STYLES[0], STYLES), size: number("size in pixels", pixels, 1, 30, 1), metres: number("size in metres", 0.01, 0.0001, 100, 0.01),
  flat: check("single colour", false), tint: TINT_CONTROL, alpha: opacity(),
  auto: check("automatic range", true), low: number("minimum value", 0, -1e9, 1e9, 0.1), high: number("maximum value", 1, -1e9, 1e9, 0.1),
  rainbow: check("rainbow", true), inverted: check("inverted rainbow", false), first: colour("minimum colour", "#000000"), last: colour("maximum colour", "#ffffff"),
  local: check("axes of its own frame", false), decay: number("seconds to keep", 0, 0, 3600, 1),
});
const CLOUD = { most: MAX_POINTS_CONTROL, by: COLOUR_BY_CONTROL, ...looks(2) };
const SCREW = {
  scale: number("length per unit", 2, 0.001, 1000, 0.1), scaleAround: number("length per unit, angular", 2, 0.001, 1000, 0.1), width: metres("width", 0.5),
  tint: colour("colour", "#cc3333"), tintAround: colour("colour, angular", "#cccc33"), alpha: opacity(), small: check("hide small values", true), ...keep(),
};
const AXES = check("as axes", false);
const ARROW = { shaft: metres("length of the shaft", 1), shaftWidth: metres("its width", 0.05), head: metres("length of the head", 0.3), headWidth: metres("its width", 0.1) };
const CROSS = { axes: AXES, axesLength: metres("length of the axes", 1), axesWidth: metres("their width", 0.1) };
const COVARIANCE = {
  covariance: check("covariance", true), place: check("of the position", true), placeTint: colour("its colour", "#cc33cc"), placeAlpha: opacity(0.3, "its opacity"), placeScale: number("scale", 1, 0, 1000, 0.1),
  turn: check("of the orientation", true), turnTint: colour("its colour", "#ffff7f"), turnAlpha: opacity(0.5, "its opacity"),
};
const POSE = { tint: TINT_CONTROL, alpha: opacity(), ...ARROW, ...CROSS };

export const OPTIONS = {
  DepthCloud: { colour: { ...choice("colours of", ""), none: "no image" }, info: { text: "CameraInfo", kind: "text", defaultValue: "", none: "next to the image" }, most: MAX_POINTS_CONTROL, ...looks(2), local: check("axes of its own frame", true) },
  AccelStamped: SCREW, TwistStamped: SCREW, WrenchStamped: SCREW,
  LaserScan: { by: COLOUR_BY_CONTROL, ...looks(3) }, PointCloud: CLOUD, PointCloud2: CLOUD,
  Map: { scheme: choice("colours", "map", COLOUR_SCHEMES), alpha: opacity(0.7), behind: check("behind everything", false) },
  GridCells: { tint: TINT_CONTROL, alpha: opacity() },
  Imu: { tint: TINT_CONTROL },
  Path: {
    tint: TINT_CONTROL, alpha: opacity(), ...keep(), line: choice("line", "pixel", ["pixel", "metres"]), width: metres("its width", 0.03),
    poses: choice("poses", "none", ["none", "arrows", "axes"]), poseTint: colour("their colour", "#ff55ff"),
    shaft: metres("length of the shaft", 0.1), shaftWidth: metres("its width", 0.1), head: metres("length of the head", 0.2), headWidth: metres("its width", 0.3),
    axesLength: metres("length of the axes", 0.3), axesWidth: metres("their width", 0.03),
    ...Object.fromEntries(["x", "y", "z"].map((axis) => [axis, number(`offset ${axis}`, 0, -1e6, 1e6, 0.1)])),
  },
  PointStamped: { tint: TINT_CONTROL, alpha: opacity(), radius: metres("radius", 0.2), ...keep() },
  Polygon: { tint: TINT_CONTROL, alpha: opacity() },
  Range: { tint: TINT_CONTROL, alpha: opacity(0.5), ...keep() },
  Odometry: { ...POSE, ...COVARIANCE, keep: number("keep", 100, 1, 1000, 1), step: metres("minimum distance in metres", 0.1), angle: number("minimum angle in radians", 0.1, 0, 7, 0.01) },
  Pose: POSE,
  PoseArray: { tint: TINT_CONTROL, alpha: opacity(), lines: check("flat arrows", true), arrow: metres("their length", 0.3), ...ARROW, shaft: metres("length of the shaft", 0.23), shaftWidth: metres("its width", 0.01), head: metres("length of the head", 0.07), headWidth: metres("its width", 0.03), ...CROSS, axesLength: metres("length of the axes", 0.3), axesWidth: metres("their width", 0.01) },
  PoseWithCovariance: { ...POSE, ...COVARIANCE },
};
