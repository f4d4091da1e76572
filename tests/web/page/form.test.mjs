// Forms of messages. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { readNumber } from "../../../src/pyros1/web/page/parts/form.js";

test("numbers are read, and what is wrong with others is said", () => {
  for (const [text, kind, value] of [["1.5e3", "float64", 1500], ["nan", "float32", "NaN"], ["-inf", "float64", "-Infinity"], ["-128", "int8", -128], ["255", "uint8", 255]]) {
    assert.deepEqual(readNumber(text, kind), { value });
  }
  for (const [text, kind, said] of [["1e400", "float64", /too large/], ["1,5", "float64", /not a number/], ["", "float32", /not a number/], ["1.5", "int32", /whole/], ["256", "uint8", /0 to 255/]]) {
    assert.match(readNumber(text, kind).problem, said);
  }
});
