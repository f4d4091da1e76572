export * from "three/examples/jsm/loaders/ColladaLoader.js";
