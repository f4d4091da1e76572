export * from "three/examples/jsm/loaders/OBJLoader.js";
