import assert from "node:assert/strict";
import test from "node:test";

import { Recording, countUpTo } from "../../../ui/widgets/viewer/data/recording.js";
import { pack, recordingOf } from "./sent.js";

test("of sorted values those up to a value are counted, equal ones with them", () => {
  assert.equal(countUpTo([], 1), 0);
  assert.deepEqual([0, 1, 2, 3, 9].map((value) => countUpTo([1, 2, 2, 4], value)), [0, 1, 3, 3, 4]);
});

test("frame numbers come as runs of a constant step", () => {
  const frames = {
    starts: pack(Int32Array, [0, 3]), firsts: pack(Float64Array, [10, 100]), steps: pack(Float64Array, [5, -1]),
  };
  const recording = new Recording(recordingOf([0, 1, 2, 3, 4], { frames }));
  assert.deepEqual([...recording.frames], [10, 15, 20, 100, 99]);
});

test("without times of their own rows have those of their frames", () => {
  const { times, frameS } = new Recording(recordingOf([0, 0, 0], { times: { offset: 2 } }));
  assert.deepEqual([...times], [2, 2.1, 2.2]);
  assert.equal(frameS, 0.1);
});

test("played is real time, but a gap lasts no longer than a quarter of a second, and none is empty", () => {
  const { clock } = new Recording(recordingOf([5, 5.125, 7.125, 7.125]));
  assert.deepEqual([...clock], [0, 0.125, 0.375, 0.376]);
});

test("a row has a picture inside the spans: from the start, up to the stop", () => {
  const recording = new Recording(recordingOf([0, 1, 2, 3, 4, 5], { picture_spans: pack(Int32Array, [1, 3, 5, 6]) }));
  assert.deepEqual([0, 1, 2, 3, 4, 5].map((row) => recording.hasPicture(row)), [false, true, true, false, false, true]);
  assert.equal(recording.hasPictures, true);
  assert.equal(new Recording(recordingOf([0])).hasPictures, false);
});

test("a second on is the last row that is no later, and at least the next row", () => {
  const recording = new Recording(recordingOf([0, 0.5, 1, 3, 4]));
  assert.deepEqual([0, 1, 2, 3, 4].map((row) => recording.rowAfter(row, 1)), [2, 2, 3, 4, 4]);
});

test("a second back is the last row that is no later, and at least the row before", () => {
  const recording = new Recording(recordingOf([0, 0.5, 1, 3, 4]));
  assert.deepEqual([0, 1, 2, 3, 4].map((row) => recording.rowAfter(row, -1)), [0, 0, 0, 2, 3]);
});

test("times are seconds, from a minute on minutes and seconds", () => {
  const recording = new Recording(recordingOf([0, 59.25, 60, 61.5, 3600, -90.5]));
  assert.deepEqual(
    [0, 1, 2, 3, 4, 5].map((row) => recording.timeText(row)),
    ["0.00 s", "59.25 s", "1:00.00 min", "1:01.50 min", "60:00.00 min", "-1:30.50 min"],
  );
});

test("no time has sixty seconds", () => {
  const recording = new Recording(recordingOf([59.999, 119.999]));
  assert.deepEqual([0, 1].map((row) => recording.timeText(row)), ["1:00.00 min", "2:00.00 min"]);
});
