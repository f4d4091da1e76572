// Fields of forms. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { readNumber, readTime, timeText } from "../../../src/pyros1/web/page/parts/form.js";

test("reads every ROS time and duration that it writes", () => {
  for (const nsecs of [0, 1, 5e8, 999999999]) {
    for (const secs of [0, 1, 2 ** 31 - 1, 2 ** 31, 2 ** 32 - 1]) assert.deepEqual(readTime(timeText({ secs, nsecs }), "time"), { value: { secs, nsecs } });
    for (const secs of [0, -1, -2, 2 ** 31 - 1, -(2 ** 31)]) assert.deepEqual(readTime(timeText({ secs, nsecs }), "duration"), { value: { secs, nsecs } });
  }
});

test("rejects other times and durations", () => {
  for (const [text, kind] of [["4294967296", "time"], ["-1", "time"], ["2147483648", "duration"], ["-2147483648.1", "duration"], ["now", "duration"], ["1e3", "time"], ["", "time"]]) {
    assert.ok(readTime(text, kind).problem, `${text} as ${kind}`);
  }
});

test("reads numbers, and explains what is wrong with other input", () => {
  for (const [text, kind, value] of [["1.5e3", "float64", 1500], ["nan", "float32", "NaN"], ["-inf", "float64", "-Infinity"], ["-128", "int8", -128], ["255", "uint8", 255]]) {
    assert.deepEqual(readNumber(text, kind), { value });
  }
  for (const [text, kind, said] of [["1e400", "float64", /too large/], ["1,5", "float64", /not a number/], ["", "float32", /not a number/], ["1.5", "int32", /whole/], ["256", "uint8", /0 to 255/]]) {
    assert.match(readNumber(text, kind).problem, said);
  }
});
