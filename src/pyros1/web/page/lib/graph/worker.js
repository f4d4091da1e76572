// Computes layouts in a worker: {number, what} -> {number, found, seconds} or {number, problem}.

import { layout } from "./layout.js";

addEventListener("message", ({ data: { number, what } }) => {
  const begin = performance.now();
  try {
    const found = layout(what);
    postMessage({ number, found, seconds: (performance.now() - begin) / 1000 });
  } catch (error) {
    postMessage({ number, problem: String(error.message || error) });
  }
});
