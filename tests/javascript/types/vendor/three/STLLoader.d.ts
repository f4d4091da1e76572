export * from "three/examples/jsm/loaders/STLLoader.js";
