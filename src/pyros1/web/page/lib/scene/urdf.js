// Parse URDF (https://wiki.ros.org/urdf/XML): text -> links with shapes, and joints. Pure.

const MAX_LINKS = 5000;
const MAX_SHAPES = 20000;
const MAX_NUMBER = 1e30; // graphics cards compute with 32-bit floats

// Return {name, links: Map, joints: [...], roots: [names], problems: [texts]}, or throw an Error that explains what is wrong.
// A link is {name, visuals: [shape], collisions: [shape]}, a shape {xyz, rpy, geometry, material}, a geometry one of
// {kind: "box", size}, {kind: "cylinder", radius, length}, {kind: "sphere", radius}, {kind: "mesh", uri, scale}, a
// material {color: [r, g, b, a] or null, texture: URI}, a joint {name, type, parent, child, xyz, rpy, axis, effort}, where
// effort is the limit in N or N m, and 0 for unknown.
export function readUrdf(text) {
  const document = new DOMParser().parseFromString(text, "application/xml");
  const fault = document.querySelector("parsererror");
  if (fault) throw new Error(`this is not XML: ${fault.textContent.replace(/\s+/g, " ").replace(/^.*?(error on line)/, "$1").slice(0, 200)}`);
  const robot = document.documentElement;
  if (robot.nodeName !== "robot") throw new Error(`this is not URDF: it begins with <${robot.nodeName.slice(0, 50)}>, not <robot>`);
  const problems = [];
  const materials = new Map(children(robot, "material").map((each) => [each.getAttribute("name") || "", material(each)]));
  const links = new Map();
  let shapes = 0;
  for (const element of children(robot, "link").slice(0, MAX_LINKS)) {
    const name = element.getAttribute("name") || "";
    /** @type {{name: string, visuals: any[], collisions: any[]}} */
    const link = { name, visuals: [], collisions: [] };
    /** @type {Record<string, object[]>} */
    const lists = { visual: link.visuals, collision: link.collisions };
    for (const [tag, list] of Object.entries(lists)) {
      for (const each of children(element, tag)) {
        if (++shapes > MAX_SHAPES) throw new Error(`more than ${MAX_SHAPES} shapes`);
        try {
          list.push(shape(each, materials));
        } catch (error) {
          problems.push(`${tag} of ${name}: ${error.message}`);
        }
      }
    }
    const [defaults] = link.visuals.map((each) => each.material).filter(Boolean);
    if (defaults) for (const each of link.visuals) each.material ||= defaults; // like rviz: a link has one material
    links.set(name, link);
  }
  const joints = children(robot, "joint").map(joint).filter(({ parent, child }) => links.has(parent) && links.has(child));
  const led = new Set(joints.map(({ child }) => child));
  return { name: robot.getAttribute("name") || "", links, joints, roots: [...links.keys()].filter((name) => !led.has(name)), problems };
}

function children(element, tag) {
  return [...element.children].filter((each) => each.nodeName === tag);
}

function child(element, tag) {
  return children(element, tag)[0];
}

// Parse the numbers of an attribute; invalid ones are an error, a missing attribute gives the default.
function numbers(element, attribute, defaults) {
  const text = element?.getAttribute(attribute);
  if (text === null || text === undefined) return defaults;
  const found = text.trim().split(/\s+/).map(Number);
  if (found.length !== defaults.length || !found.every((value) => Math.abs(value) < MAX_NUMBER)) throw new Error(`${attribute}="${text.slice(0, 60)}" is not ${defaults.length === 1 ? "a number" : `${defaults.length} numbers`}`);
  return found;
}

function origin(element) {
  const found = child(element, "origin");
  return { xyz: numbers(found, "xyz", [0, 0, 0]), rpy: numbers(found, "rpy", [0, 0, 0]) };
}

function shape(element, materials) {
  const inner = child(element, "material");
  let found = null;
  if (inner) {
    const name = inner.getAttribute("name") || "";
    found = inner.children.length ? material(inner) : materials.get(name) || null;
    if (inner.children.length && name && !materials.has(name)) materials.set(name, found); // elements further down may refer to it
  }
  return { ...origin(element), geometry: geometry(child(element, "geometry")), material: found };
}

function geometry(element) {
  const found = element?.children[0];
  if (!found) throw new Error("it has no geometry");
  const positive = (attribute) => {
    const [value] = numbers(found, attribute, [NaN]);
    if (!(value >= 0)) throw new Error(`a ${found.nodeName} needs a ${attribute}`);
    return value;
  };
  switch (found.nodeName) {
    case "box": return { kind: "box", size: numbers(found, "size", [1, 1, 1]) };
    case "cylinder": return { kind: "cylinder", radius: positive("radius"), length: positive("length") };
    case "sphere": return { kind: "sphere", radius: positive("radius") };
    case "mesh": return { kind: "mesh", uri: found.getAttribute("filename") || "", scale: scale(found) };
    default: throw new Error(`<${found.nodeName.slice(0, 50)}> is not a URDF shape`);
  }
}

function scale(element) {
  const text = (element.getAttribute("scale") || "").trim();
  return text && !/\s/.test(text) ? new Array(3).fill(numbers(element, "scale", [1])[0]) : numbers(element, "scale", [1, 1, 1]);
}

function material(element) {
  let color = null;
  try {
    const colour = child(element, "color");
    if (colour) color = numbers(colour, "rgba", [1, 1, 1, 1]).map((value) => Math.min(1, Math.max(0, value)));
  } catch {
    // an invalid colour: use the default
  }
  return { color, texture: child(element, "texture")?.getAttribute("filename") || "" };
}

function joint(element) {
  const place = { xyz: [0, 0, 0], rpy: [0, 0, 0], axis: [1, 0, 0], effort: 0 };
  try {
    Object.assign(place, origin(element)); // an invalid origin is ignored: /tf has the link's pose
    place.axis = numbers(child(element, "axis"), "xyz", place.axis);
    [place.effort] = numbers(child(element, "limit"), "effort", [0]);
  } catch {
    // an invalid attribute: use those that were read before it
  }
  const name = (tag) => child(element, tag)?.getAttribute("link") || "";
  return { name: element.getAttribute("name") || "", type: element.getAttribute("type") || "", parent: name("parent"), child: name("child"), ...place };
}
