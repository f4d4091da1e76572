// Text labels that face the camera.

import * as THREE from "../../vendor/three/three.module.min.js";

const FONT_SIZE = 48; // font size in pixels
const SMALL_FONT = 16; // font size in pixels if there are many labels
const MAX_LENGTH = 300; // characters
const MAX_WIDTH = 2048; // pixels; longer lines get smaller letters
const MAX_TOTAL_PIXELS = 24e6; // pixels of all labels, about 100 MB; further ones are not drawn, and have userData.missing

let totalPixels = 0; // pixels

export function label(text, { height = 0.15, color = [1, 1, 1, 1], background = null, outline = "", onTop = false } = {}) {
  const lines = String(text).slice(0, MAX_LENGTH).split("\n").slice(0, 12);
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser has no canvas for texts");
  let size = totalPixels < MAX_TOTAL_PIXELS / 2 ? FONT_SIZE : SMALL_FONT;
  const font = () => `${size}px "Liberation Sans", Arial, Helvetica, "DejaVu Sans", sans-serif`;
  context.font = font();
  const wide = Math.max(1, ...lines.map((line) => context.measureText(line).width));
  const fits = Math.min(1, (MAX_WIDTH - size / 3) / wide);
  size *= fits;
  canvas.width = Math.ceil(wide * fits + size / 3);
  canvas.height = Math.ceil((lines.length * 1.25 + 1 / 6) * size);
  const pixels = canvas.width * canvas.height;
  const missing = totalPixels + pixels > MAX_TOTAL_PIXELS;
  if (missing) canvas.width = canvas.height = 1;
  else {
    totalPixels += pixels;
    context.font = font();
    context.textBaseline = "middle";
    context.textAlign = "left"; // lines are left-aligned, like rviz's
    const left = size / 6;
    if (background) {
      context.fillStyle = background;
      context.fillRect(0, 0, canvas.width, canvas.height);
    }
    const down = (index) => ((index + 0.5) * 1.25 + 1 / 12) * size;
    if (outline) {
      Object.assign(context, { strokeStyle: outline, lineWidth: size * 3 / 16, lineJoin: "round" });
      lines.forEach((line, index) => context.strokeText(line, left, down(index)));
    }
    const [red, green, blue, alpha] = color;
    context.fillStyle = `rgba(${Math.round(255 * red)}, ${Math.round(255 * green)}, ${Math.round(255 * blue)}, ${alpha})`;
    lines.forEach((line, index) => context.fillText(line, left, down(index)));
  }
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  if (!missing) texture.addEventListener("dispose", () => { totalPixels -= pixels; });
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: texture, depthTest: !onTop, transparent: true }));
  const scale = height / size;
  sprite.scale.set(canvas.width * scale, canvas.height * scale, 1);
  sprite.userData.missing = missing;
  return sprite;
}
