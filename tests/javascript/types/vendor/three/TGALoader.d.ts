export * from "three/examples/jsm/loaders/TGALoader.js";
