// What the console keeps. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { LogBuffer } from "../../../src/pyros1/web/page/lib/log_buffer.js";

test("keeps only the newest entries", () => {
  const kept = new LogBuffer(100, 1e6);
  for (let number = 1; number <= 120; number += 1) kept.push([number, "text", ["topic"]]);
  assert.equal(kept.trim(), false);
  kept.push([121, "text", []]);
  assert.equal(kept.trim(), true);
  assert.deepEqual([kept.entries.length, kept.entries[0][0], kept.size], [100, 22, 99 * 9 + 4]);
});

test("keeps fewer entries if they are long", () => {
  const kept = new LogBuffer(100, 5000);
  for (let number = 1; number <= 50; number += 1) {
    kept.push([number, "x".repeat(1000), ["y".repeat(200)]]);
    kept.trim();
    assert.ok(kept.size <= 6000 && kept.entries.length <= 5);
  }
  assert.equal(kept.entries.at(-1)[0], 50);
  kept.push([51, "z".repeat(10000), []]);
  kept.trim();
  assert.deepEqual([kept.entries, kept.size], [[], 0]);
  kept.push([52, "a", []]);
  kept.clear();
  assert.deepEqual([kept.entries.length, kept.size], [0, 0]);
});
