import assert from "node:assert/strict";
import test from "node:test";

import { advance, rowsPerPicture } from "../../../ui/widgets/viewer/player/playback.js";
import { Recording } from "../../../ui/widgets/viewer/data/recording.js";
import { recordingOf } from "./sent.js";

const TENTHS = Array.from({ length: 31 }, (_, row) => row / 8);

globalThis.document = new EventTarget(); // hears of the time that is shown

// A viewer that plays from row 0, eight rows a second; rows up to `complete` have come.
function playerOf({ complete = 99, speed = 1 } = {}) {
  const element = { dataset: {}, setAttribute() {}, children: [{}, {}, {}] };
  return {
    recording: new Recording(recordingOf(TENTHS)), speed, row: 0, shownRow: 0, stoppedAt: null,
    playing: { position: 0, from: 0, at: null },
    parts: { readout: element, strip: element }, root: element,
    isReady: (row) => row <= complete,
    load() {},
    stopAt(row) { this.stoppedAt = row; },
  };
}

function play(viewer, ...times) {
  return times.map((now) => (viewer.shownRow = advance(viewer, now)));
}

test("the row is shown whose time has come", () => {
  assert.deepEqual(play(playerOf(), 1000, 1100, 1125, 1300, 1500), [0, 0, 1, 2, 4]);
});

test("at twice the speed it is twice as far", () => {
  assert.deepEqual(play(playerOf({ speed: 2 }), 1000, 1125, 1500), [0, 2, 8]);
});

test("a row that has not come is left out, and never shown before it has", () => {
  const viewer = playerOf({ complete: 2 });
  assert.deepEqual(play(viewer, 0, 250, 375, 500), [0, 2, 2, 2]);
  viewer.isReady = () => true;
  assert.deepEqual(play(viewer, 625), [5]);
});

test("what is late is waited for: playback is at most half a second ahead of the picture", () => {
  const viewer = playerOf({ complete: 2 });
  play(viewer, 0, 250, 3000);
  viewer.isReady = () => true;
  assert.deepEqual(play(viewer, 3000), [6]);
});

test("it stops at the last row", () => {
  const viewer = playerOf();
  const rows = [];
  for (let now = 0; now <= 4000; now += 125) rows.push(...play(viewer, now));
  assert.equal(rows.at(-1), 30);
  assert.equal(viewer.stoppedAt, 30);
});

test("a stretch is played from its first row to its last", () => {
  const viewer = playerOf();
  viewer.recording = new Recording(recordingOf(TENTHS, { rows: [8, 16] }));
  assert.deepEqual([0, 12, 30].map((row) => viewer.recording.clamp(row)), [8, 12, 16]);
  Object.assign(viewer, { row: 8, shownRow: 8, playing: { position: viewer.recording.clock[8], from: 8, at: null } });
  assert.deepEqual(play(viewer, 0, 500, 1000, 1500), [8, 12, 16, 16]);
  assert.equal(viewer.stoppedAt, 16);
});

function strideOf(secondsPerPicture, speed = 1) {
  return rowsPerPicture({
    recording: new Recording(recordingOf(TENTHS)), row: 0, speed,
    pictures: { secondsPerPicture }, visible: { secondsPerPicture: 9 }, look: { needsOwn: true, needsVisible: false },
  });
}

test("every row has its picture while they come as fast as they are due", () => {
  assert.equal(strideOf(0.125), 1);
});

test("pictures that take three times as long are asked for every third row", () => {
  assert.equal(strideOf(0.375), 3);
});

test("the next picture is never farther ahead than playback may be", () => {
  assert.equal(strideOf(60), 4); // half a second
});
