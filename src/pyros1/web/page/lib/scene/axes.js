// Axes like rviz's: a red, a green and a blue cylinder along x, y and z.

import * as THREE from "../../vendor/three/three.module.min.js";

const COLOURS = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];

// The three axes as one shape. length and width in metres; rviz calls the width a radius.
export function axesShape(length, width) {
  const places = [];
  const normals = [];
  const colours = [];
  const turns = [(rod) => rod.rotateZ(-Math.PI / 2), (rod) => rod, (rod) => rod.rotateX(Math.PI / 2)];
  turns.forEach((turn, axis) => {
    const rod = turn(new THREE.CylinderGeometry(width / 2, width / 2, length, 12).translate(0, length / 2, 0)).toNonIndexed();
    places.push(...rod.getAttribute("position").array);
    normals.push(...rod.getAttribute("normal").array);
    for (let count = rod.getAttribute("position").count; count > 0; count -= 1) colours.push(...COLOURS[axis]);
  });
  const shape = new THREE.BufferGeometry();
  for (const [name, values] of Object.entries({ position: places, normal: normals, color: colours })) shape.setAttribute(name, new THREE.Float32BufferAttribute(values, 3));
  return shape;
}

export function axesMaterial(alpha = 1) {
  return new THREE.MeshLambertMaterial({ vertexColors: true, opacity: alpha, transparent: alpha < 1, depthWrite: alpha >= 1 });
}

export function axesOf(length, width, alpha = 1) {
  return new THREE.Mesh(axesShape(length, width), axesMaterial(alpha));
}
