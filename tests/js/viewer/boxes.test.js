import assert from "node:assert/strict";
import test from "node:test";

import { BoxStore, DETECTION_STATE, SOURCE, TRUTH_STATE } from "../../../ui/widgets/viewer/data/boxes.js";
import { countStates, missedBy } from "../../../ui/widgets/viewer/drawing/drawing.js";

const { ignore, matched_x: byX, matched_y: byY, relevant } = TRUTH_STATE;

function found(...boxes) {
  return {
    start: 0, stop: boxes.length,
    boxes: { source: boxes.map(([source]) => SOURCE[source]), state: boxes.map(([, state]) => state) },
  };
}

test("a pedestrian is missed by those that do not match it", () => {
  assert.deepEqual(
    [relevant, relevant | byX, relevant | byY, relevant | byX | byY].map(missedBy), ["xy", "y", "x", ""],
  );
});

test("one that is ignored or too far is missed by nobody", () => {
  assert.deepEqual([0, byX, relevant | ignore].map(missedBy), ["", "", ""]);
});

test("a frame's boxes are counted: near and far misses, false alarms, nothing that is ignored", () => {
  const counts = countStates(found(
    ["truth", relevant], ["truth", relevant | byX], ["truth", byY], ["truth", ignore],
    ["x", DETECTION_STATE.matched], ["x", DETECTION_STATE.false_alarm], ["x", DETECTION_STATE.false_alarm],
    ["y", DETECTION_STATE.absorbed], ["y", DETECTION_STATE.false_alarm],
  ));
  assert.deepEqual(counts, {
    truth: 3, relevant: 2, missed_x: 1, missed_y: 2, far_x: 1, far_y: 0, false_x: 2, false_y: 1,
  });
});

test("without boxes every count is 0", () => {
  assert.deepEqual([...new Set(Object.values(countStates(null)))], [0]);
});

// Rows with these sources of boxes, as the route sends them; a box's x is its number.
function packed(...rows) {
  const sources = rows.flat();
  const n = sources.length;
  const offsets = rows.reduce((ends, row) => [...ends, ends.at(-1) + row.length], [0]);
  const numbers = Float32Array.from(sources, (_, i) => i);
  const parts = [
    Uint32Array.of(rows.length, n), Uint32Array.from(offsets), numbers, ...Array.from({ length: 4 }, () => new Float32Array(n)),
    new Int32Array(n), Uint8Array.from(sources), new Uint8Array((4 - (n % 4)) % 4), new Uint8Array(n),
  ];
  return Buffer.concat(parts.map((part) => Buffer.from(part.buffer)));
}

test("each row finds its own boxes in what is fetched", async () => {
  globalThis.fetch = async () => new Response(packed([0, 1, 2], [], [2, 1]));
  const loaded = await new Promise((done) => {
    const store = new BoxStore(() => done(store));
    store.reset("boxes", "1", 3);
    store.want(0);
  });
  const sources = (row) => {
    const { boxes, start, stop } = loaded.ofRow(row);
    return { x: [...boxes.x.slice(start, stop)], source: [...boxes.source.slice(start, stop)] };
  };
  assert.deepEqual(sources(0), { x: [0, 1, 2], source: [0, 1, 2] });
  assert.deepEqual(sources(1), { x: [], source: [] });
  assert.deepEqual(sources(2), { x: [3, 4], source: [2, 1] });
  assert.equal(loaded.ofRow(3), null);
});

test("a refusal is said in the server's words, and the row counts as complete", async () => {
  globalThis.fetch = async () => new Response("too many boxes", { status: 413, headers: { "content-type": "text/plain" } });
  const store = await new Promise((done) => {
    const made = new BoxStore(() => done(made));
    made.reset("boxes", "1", 3);
    made.want(0);
  });
  assert.equal(store.errorAt(0), "Too many boxes");
  assert.equal(store.isReady(0), true);
  assert.equal(store.ofRow(0), null);
});
