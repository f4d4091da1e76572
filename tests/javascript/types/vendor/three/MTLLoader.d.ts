export * from "three/examples/jsm/loaders/MTLLoader.js";
