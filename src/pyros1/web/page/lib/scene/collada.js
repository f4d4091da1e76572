// Rewrite Collada files for three.js's loader, which knows polygons only as polylists, numbers only with points, and
// materials only if they are bound.

const UNBOUND = "unbound"; // symbol of a material that does not exist: the loader uses its default

// Return a file's text as the loader expects it. Throws an Error if the file is invalid.
export function normaliseCollada(text) {
  const document = new DOMParser().parseFromString(text, "application/xml");
  if (document.querySelector("parsererror")) throw new Error("it is not XML");
  if (!document.querySelector("scene > instance_visual_scene")) throw new Error("it has no scene");
  const counts = [convertPolygons(document), replaceCommas(document), bindMaterials(document)];
  return counts.some((count) => count > 0) ? new XMLSerializer().serializeToString(document) : text;
}

// Convert polygons, fans and strips to polylists. Holes in polygons are filled.
function convertPolygons(document) {
  const found = [...document.querySelectorAll("polygons, trifans, tristrips")];
  for (const part of found) {
    const inputs = children(part, "input");
    const size = 1 + Math.max(0, ...inputs.map((input) => Number(input.getAttribute("offset"))));
    const lists = children(part, "p", "ph").map((list) => cornersOf(list.localName === "ph" ? list.querySelector("p") : list, size));
    const faces = lists.flatMap((corners) => POLYGON_KINDS[part.localName](corners));
    const list = document.createElementNS(part.namespaceURI, "polylist");
    list.setAttribute("count", faces.length);
    list.setAttribute("material", part.getAttribute("material") || UNBOUND);
    const [counts, places] = ["vcount", "p"].map((name) => document.createElementNS(part.namespaceURI, name));
    counts.textContent = faces.map((corners) => corners.length).join(" ");
    places.textContent = faces.flat().join(" ");
    list.append(...inputs, counts, places);
    part.replaceWith(list);
  }
  return found.length;
}

const POLYGON_KINDS = {
  polygons: (corners) => [corners],
  trifans: (corners) => corners.slice(2).map((corner, index) => [corners[0], corners[index + 1], corner]),
  tristrips: (corners) => corners.slice(2).map((corner, index) => (index % 2 ? [corners[index + 1], corners[index], corner] : [corners[index], corners[index + 1], corner])),
};

function children(part, ...names) {
  return [...part.children].filter(({ localName }) => names.includes(localName));
}

// Split a list of indices into corners, each with one index per input: "0 0 1 0" -> ["0 0", "1 0"].
function cornersOf(list, size) {
  const numbers = list?.textContent.trim().split(/\s+/).filter(Boolean) || [];
  return Array.from({ length: Math.floor(numbers.length / size) }, (_, index) => numbers.slice(size * index, size * (index + 1)).join(" "));
}

// Replace decimal commas, which programs write in some locales.
function replaceCommas(document) {
  const found = [...document.querySelectorAll("float_array, matrix, translate, rotate, scale, color")].filter(({ textContent }) => /\d,\d/.test(textContent));
  for (const numbers of found) numbers.textContent = numbers.textContent.replaceAll(",", ".");
  return found.length;
}

// Like rviz: bind a node's unbound materials to the materials of the same name, or to the first one.
function bindMaterials(document) {
  let count = 0;
  for (const part of document.querySelectorAll("triangles:not([material]), polylist:not([material])")) {
    part.setAttribute("material", UNBOUND);
    count += 1;
  }
  const known = new Set([...document.querySelectorAll("library_materials > material")].map((material) => material.id));
  for (const node of document.querySelectorAll("instance_geometry")) {
    const bound = new Set([...node.querySelectorAll("instance_material")].map((material) => material.getAttribute("symbol")));
    const shape = document.getElementById((node.getAttribute("url") || "").replace(/^#/, ""));
    for (const name of new Set([...(shape?.querySelectorAll("[material]") || [])].map((part) => part.getAttribute("material")))) {
      if (bound.has(name) || !known.size) continue;
      const make = (tag) => document.createElementNS(node.namespaceURI, tag);
      const [outer, inner, material] = [make("bind_material"), make("technique_common"), make("instance_material")];
      material.setAttribute("symbol", name);
      material.setAttribute("target", `#${known.has(name) ? name : [...known].sort()[0]}`);
      inner.append(material);
      outer.append(inner);
      const place = node.querySelector("bind_material > technique_common");
      if (place) place.append(material);
      else node.append(outer);
      count += 1;
    }
  }
  return count;
}
