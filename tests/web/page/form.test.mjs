// Fields of forms. Run by tests/web/test_page_modules.py, or with: node --test tests/web/page

import assert from "node:assert/strict";
import test from "node:test";

import { readTime, timeText } from "../../../src/pyros1/web/page/parts/form.js";

test("each time and duration of ROS can be written and read", () => {
  for (const nsecs of [0, 1, 5e8, 999999999]) {
    for (const secs of [0, 1, 2 ** 31 - 1, 2 ** 31, 2 ** 32 - 1]) assert.deepEqual(readTime(timeText({ secs, nsecs }), "time"), { value: { secs, nsecs } });
    for (const secs of [0, -1, -2, 2 ** 31 - 1, -(2 ** 31)]) assert.deepEqual(readTime(timeText({ secs, nsecs }), "duration"), { value: { secs, nsecs } });
  }
});

test("others cannot", () => {
  for (const [text, kind] of [["4294967296", "time"], ["-1", "time"], ["2147483648", "duration"], ["-2147483648.1", "duration"], ["now", "duration"], ["1e3", "time"], ["", "time"]]) {
    assert.ok(readTime(text, kind).problem, `${text} as ${kind}`);
  }
});
