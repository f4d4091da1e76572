// Text that faces the camera.

import * as THREE from "../../vendor/three/three.module.min.js";

const SIZE = 48; // pixels of the letters in their picture
const MOST = 300; // letters

export function label(text, { height = 0.15, color = [1, 1, 1, 1], background = null, outline = "", onTop = false } = {}) {
  const lines = String(text).slice(0, MOST).split("\n").slice(0, 12);
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  const font = `${SIZE}px system-ui, "DejaVu Sans", sans-serif`;
  context.font = font;
  const width = Math.max(1, ...lines.map((line) => context.measureText(line).width));
  canvas.width = Math.min(4096, Math.ceil(width) + 16);
  canvas.height = Math.ceil(lines.length * SIZE * 1.25) + 8;
  context.font = font;
  context.textBaseline = "middle";
  context.textAlign = "center";
  if (background) {
    context.fillStyle = background;
    context.fillRect(0, 0, canvas.width, canvas.height);
  }
  if (outline) {
    Object.assign(context, { strokeStyle: outline, lineWidth: 9, lineJoin: "round" });
    lines.forEach((line, index) => context.strokeText(line, canvas.width / 2, (index + 0.5) * SIZE * 1.25 + 4));
  }
  const [red, green, blue, alpha] = color;
  context.fillStyle = `rgba(${Math.round(255 * red)}, ${Math.round(255 * green)}, ${Math.round(255 * blue)}, ${alpha})`;
  lines.forEach((line, index) => context.fillText(line, canvas.width / 2, (index + 0.5) * SIZE * 1.25 + 4));
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: texture, depthTest: !onTop, transparent: true }));
  const scale = height / SIZE;
  sprite.scale.set(canvas.width * scale, canvas.height * scale, 1);
  return sprite;
}
