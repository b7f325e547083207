import assert from "node:assert/strict";
import test from "node:test";

import { Strip } from "../../../ui/widgets/viewer/drawing/strip.js";
import { pack } from "./sent.js";

globalThis.document = { createElement: () => ({}) };

// Ten rows in buckets of two, on a strip of 124 pixels: the names take 20, the right margin 4.
function stripOf() {
  const strip = new Strip({});
  const none = pack(Int32Array, []);
  const trace = pack(Float32Array, [1, 0.5, NaN, 1, 1]);
  strip.set({
    n_rows: 10, low: 0.75, bucket_rows: 2, traces: { x: trace, y: trace }, intervals: { x: none, y: none }, misses: none,
  }, {});
  strip.resize(124, 2);
  return strip;
}

test("every row has its place on the strip, and each place its row", () => {
  const strip = stripOf();
  assert.deepEqual([0, 4, 9].map((row) => strip.xOf(row)), [25, 65, 115]);
  assert.deepEqual([25, 65, 115].map((x) => strip.rowAt(x)), [0, 4, 9]);
});

test("beside the strip is its first or last row", () => {
  assert.deepEqual([-50, 0, 999].map((x) => stripOf().rowAt(x)), [0, 0, 9]);
});

test("the scale begins a little below the lowest value", () => {
  assert.equal(stripOf().floor, 0.45);
});

test("similarity is told by the row's bucket, as a dash where there is none", () => {
  assert.deepEqual([3, 4].map((row) => stripOf().valuesText(row)), [
    "similarity X 0.50, Y 0.50", "similarity X –, Y –",
  ]);
});

test("what follows a slider is drawn by the least of each bucket, with the runs below the limit", () => {
  const strip = stripOf();
  const x = Float64Array.of(1, 1, 0.5, 0.75, 0.625, 0.625, 1, 1, 1, 0.25);
  strip.follow({ x, y: new Float64Array(10).fill(1) });
  assert.deepEqual([...strip.traces.x], [1, 0.5, 0.625, 1, 0.25]);
  assert.deepEqual(strip.intervals, { x: [2, 3, 4, 6, 9, 10], y: [] });
});
