// Meshes and textures of packages: STL, OBJ and DAE (Collada). An invalid file is an Error, never half a mesh.

import * as THREE from "../../vendor/three/three.module.min.js";

import { normaliseCollada } from "./collada.js";
import { repairNormals } from "./normals.js";

const MAX_TEXT_BYTES = 48 << 20; // bytes of a text mesh: parsing it blocks the page for a while
const MAX_FILES = 300; // cached, within a limit on their total size
const MAX_BYTES = 256 << 20;
const DEFAULT_COLOUR = "#999999"; // rviz's colour of files without materials, except STL
const LOADERS = { stl: "STLLoader", obj: "OBJLoader", dae: "ColladaLoader" };
const cache = new Map(); // URI -> promise of an object
const sizes = new Map(); // URI -> bytes of its file

// Return the URL of a package's file.
export function fileUrl(uri, token) {
  return `package_file?token=${encodeURIComponent(token)}&uri=${encodeURIComponent(uri)}`;
}

// Return a copy of the mesh in a file. Its materials are its own if object.userData.painted, otherwise rviz's defaults.
export async function meshOf(uri, token) {
  let found = cache.get(uri);
  if (!found) {
    found = loadMesh(uri, token);
    cache.set(uri, found);
    found.catch(() => dropFromCache(uri)); // the next request tries again
  }
  return (await found).clone();
}

function dropFromCache(uri) {
  cache.delete(uri);
  sizes.delete(uri);
}

function addToCache(uri, size) {
  sizes.set(uri, size);
  let all = [...sizes.values()].reduce((sum, each) => sum + each, 0);
  for (const [oldest, bytes] of sizes) {
    if (sizes.size <= MAX_FILES && all <= MAX_BYTES) break;
    all -= bytes;
    dropFromCache(oldest);
  }
}

// Load a texture.
export async function textureOf(uri, token) {
  const answer = await fetchFile(uri, token);
  const url = URL.createObjectURL(await answer.blob());
  try {
    const texture = await new THREE.TextureLoader().loadAsync(url);
    texture.colorSpace = THREE.SRGBColorSpace;
    texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
    return texture;
  } catch {
    throw new Error(`${shortUri(uri)} is not an image that a browser can show`);
  } finally {
    URL.revokeObjectURL(url);
  }
}

async function fetchFile(uri, token) {
  if (!uri) throw new Error("a mesh or a texture without a name");
  if (!/^(package|file):\/\//.test(uri)) throw new Error(`${shortUri(uri)}: only package:// and file:// are supported`);
  const answer = await fetch(fileUrl(uri, token));
  if (!answer.ok) throw new Error((await answer.text()).trim().slice(0, 300));
  return answer;
}

async function loadMesh(uri, token) {
  const kind = uri.split(".").pop().toLowerCase();
  if (uri && !LOADERS[kind]) throw new Error(`${shortUri(uri)}: STL, OBJ and DAE are supported, not ${kind.slice(0, 20)}`);
  const answer = await fetchFile(uri, token);
  const bytes = await answer.arrayBuffer();
  addToCache(uri, bytes.byteLength);
  let object;
  try {
    const module = await import(`../../vendor/three/${LOADERS[kind]}.js`);
    const manager = new THREE.LoadingManager();
    const loader = new module[LOADERS[kind]](manager);
    const settled = texturesOf(manager, uri, token);
    object = await { stl, obj, dae }[kind](loader, bytes, uri, token, manager);
    await settled();
  } catch (error) {
    throw new Error(`${shortUri(uri)} cannot be read: ${error.message}`);
  }
  return keepDrawable(object, uri);
}

// Load the textures of a mesh from its package as well. Returns a function that waits until all have loaded or failed.
function texturesOf(manager, uri, token) {
  manager.setURLModifier((url) => (/^(blob|data):/.test(url) ? url : fileUrl(resolveUri(uri, url.replace(uri, "")), token)));
  const settled = new Promise((resolve) => { manager.onLoad = resolve; });
  manager.itemStart("");
  return () => {
    manager.itemEnd("");
    return settled;
  };
}

// Resolve a URI relative to another one: "package://arm/meshes/a.dae", "../textures/b.png" -> "package://arm/textures/b.png".
export function resolveUri(uri, name) {
  const reference = name.replaceAll("\\", "/");
  const absolute = reference.match(/(?:package|file):\/\/.*$/);
  if (absolute) return absolute[0];
  const [, start, path] = uri.match(/^(\w+:\/\/[^/]*\/)(.*)$/) || ["", "", uri];
  const parts = path.split("/").slice(0, -1);
  for (const part of reference.replace(/^file:\/*/, "").split("/")) {
    if (part === "..") parts.pop();
    else if (part && part !== ".") parts.push(part);
  }
  return start + parts.join("/");
}

function stl(loader, bytes) {
  const begin = new TextDecoder().decode(bytes.slice(0, 1024));
  const faces = bytes.byteLength < 84 ? -1 : new DataView(bytes).getUint32(80, true);
  const fits = 84 + 50 * faces === bytes.byteLength; // some headers of binary files look like text
  let content = bytes;
  if (!fits && /^\s*solid\b/i.test(begin) && /\bfacet\b|\bendsolid\b/i.test(begin)) content = asText(decode(bytes));
  else if (faces < 0) throw new Error("it is too short");
  else {
    if (84 + 50 * faces > bytes.byteLength) throw new Error(`it claims to have ${faces} triangles, but has ${bytes.byteLength} bytes`);
  }
  const geometry = withoutConsole(() => loader.parse(content));
  const colours = geometry.hasColors;
  const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ roughness: 0.8, vertexColors: Boolean(colours), side: THREE.DoubleSide }));
  mesh.userData.bare = true; // white: only the tint is visible, as in rviz
  return mesh;
}

// Normalise a text file for the loader. It would replace an invalid normal by the previous triangle's, draw wrong
// triangles if a corner is missing, and draw nothing if the end is missing.
function asText(content) {
  const text = /\bFACET\b/.test(content) ? content.toLowerCase() : content;
  const [facets, corners] = [/\bfacet\b/g, /\bvertex\b/g].map((status) => (text.match(status) || []).length);
  if (corners !== 3 * facets) throw new Error(`it has ${facets} triangles, but ${corners} corners`);
  const whole = /\bendsolid\b/.test(text) ? text : `${text}\nendsolid`;
  return whole.replace(/\bnormal\s+(\S+)\s+(\S+)\s+(\S+)/g, (whole, ...parts) => (
    parts.slice(0, 3).every((part) => Number.isFinite(Number(part))) ? whole : "normal 0 0 0"
  ));
}

async function obj(loader, bytes, uri, token, manager) {
  const text = decode(bytes);
  const names = [...text.matchAll(/^mtllib[ \t]+(.+?)[ \t\r]*$/gm)].slice(0, 20).map(([, name]) => name);
  for (const name of names) {
    const { MTLLoader } = await import("../../vendor/three/MTLLoader.js");
    try {
      const materials = new MTLLoader(manager).parse(decode(await (await fetchFile(resolveUri(uri, name), token)).arrayBuffer()), "");
      materials.preload();
      loader.setMaterials(materials);
    } catch {
      continue; // same as without materials
    }
  }
  const object = withoutConsole(() => loader.parse(text.replace(/^[ \t]*[lp][ \t].*$/gm, ""))); // if a file also has lines, the loader draws only the lines
  object.userData.painted = Boolean(loader.materials);
  if (!loader.materials) object.traverse((each) => { for (const material of [each.material || []].flat()) if (!material.vertexColors) material.color.set(DEFAULT_COLOUR); });
  return object;
}

function dae(loader, bytes) {
  // Like rviz: z is up whatever the file says, since a robot's description rotates its meshes as needed.
  const text = normaliseCollada(decode(bytes).replace(/<up_axis>\s*[XZ]_UP\s*<\/up_axis>/, "<up_axis>Y_UP</up_axis>"));
  const found = withoutConsole(() => loader.parse(text, ""));
  if (!found?.scene) throw new Error("it has no scene");
  const outer = new THREE.Group(); // the scene's scale is that of the file's unit
  outer.add(found.scene);
  outer.traverse((each) => {
    if (each instanceof THREE.Mesh) each.material = Array.isArray(each.material) ? each.material.map(visibleMaterial) : visibleMaterial(each.material);
  });
  outer.userData.painted = true;
  return outer;
}

// A Collada material like rviz's: grey if there is none, and never fully transparent, though some programs write that.
function visibleMaterial(material) {
  if (material.name === THREE.Loader.DEFAULT_MATERIAL_NAME) return new THREE.MeshLambertMaterial({ color: DEFAULT_COLOUR, side: THREE.DoubleSide });
  if (material.opacity === 0) Object.assign(material, { opacity: 1, transparent: false });
  return material;
}

// The loaders log every oddity to the console; errors are shown on the page instead.
function withoutConsole(work) {
  const before = { warn: console.warn, error: console.error, log: console.log, debug: console.debug };
  for (const name of Object.keys(before)) console[name] = () => {};
  try {
    return work();
  } finally {
    Object.assign(console, before);
  }
}

function decode(bytes) {
  if (bytes.byteLength > MAX_TEXT_BYTES) throw new Error(`${bytes.byteLength >> 20} MB of text; ${MAX_TEXT_BYTES >> 20} MB can be read`);
  return new TextDecoder().decode(bytes);
}

// Keep only what can be drawn, and check that there is something.
function keepDrawable(object, uri) {
  let corners = 0;
  const others = [];
  object.traverse((each) => {
    if (each.isLight || each.isCamera || each.isLine || each.isPoints) others.push(each);
    if (!each.isMesh) return;
    const places = each.geometry.getAttribute("position");
    corners += places?.count || 0;
    if (places && !places.array.every(Number.isFinite)) throw new Error(`${shortUri(uri)} has positions that are not numbers`);
    const normals = places && repairNormals(places.array, each.geometry.getAttribute("normal")?.array, each.geometry.index?.array);
    if (normals) each.geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3));
    for (const material of [each.material].flat()) {
      if (material.map && !material.map.image) material.map = null; // it has not loaded: the plain colour is better than black
    }
  });
  for (const each of others) each.removeFromParent();
  if (!corners) throw new Error(`${shortUri(uri)} has no triangles`);
  return object;
}

function shortUri(uri) {
  return uri.length > 120 ? `… ${uri.slice(-110)}` : uri;
}
