import assert from "node:assert/strict";
import test from "node:test";

import { Look, inPane } from "../../../ui/widgets/viewer/data/look.js";
import { pack } from "./sent.js";

// Rows end at 1, 2, ... s. It became dark at 2 s: rows 2 and 3 know since when.
function lookOf(changes = {}) {
  const look = new Look();
  look.set({
    area: [-10, 0, 120, 50], spans: pack(Int32Array, [1, 3]), simulated: "",
    seen_s: pack(Float32Array, [Infinity, Infinity, 1, 2]), changes: pack(Float64Array, [2]),
  });
  return Object.assign(look, { isAdapting: true }, changes);
}

const seen = (look) => [0, 1, 2, 3].map((row) => look.seenAt(row, row + 1));

test("eyes adapt from the recording's own change of light; before it they are adapted", () => {
  assert.deepEqual(seen(lookOf()), [null, null, 1, 2]);
});

test("by hand the slider's seconds hold in every row", () => {
  assert.deepEqual(seen(lookOf({ isByHand: true, sinceS: 0.25 })), [0.25, 0.25, 0.25, 0.25]);
});

test("a simulated change holds from its time until a real one comes", () => {
  assert.deepEqual(seen(lookOf({ changeAt: 0.5 })), [0.5, 1.5, 1, 2]);
});

test("by hand no real change ends a simulated one", () => {
  assert.deepEqual(seen(lookOf({ isByHand: true, changeAt: 1 })), [null, 1, 2, 3]);
});

test("who does not adapt sees the picture as it is", () => {
  assert.deepEqual(seen(lookOf({ isAdapting: false, changeAt: 0.5 })), [null, null, null, null]);
});

test("pictures of visible light may be wider than the recording", () => {
  const recording = { width: 100, height: 50 };
  assert.deepEqual(lookOf({ picture: "visible" }).areaOf(recording), { x: -10, y: 0, w: 120, h: 50 });
  assert.deepEqual(lookOf({ picture: "both" }).areaOf(recording), { x: 0, y: 0, w: 100, h: 50 });
});

test("blended, visible light lies over the own picture by its share, and alone it is whole", () => {
  const look = lookOf({ picture: "blended", blend: 0.3 });
  const alphas = (own, visible) => look.panes({ width: 100, height: 50 }, own, visible)
    .map((pane) => pane.map(({ bitmap, alpha }) => [bitmap, alpha]));
  const [own, visible] = [{ bitmap: "own" }, { bitmap: "visible" }];
  assert.deepEqual(alphas(own, visible), [[["own", 1], ["visible", 0.3]]]);
  assert.deepEqual(alphas(null, visible), [[["visible", 1]]]);
});

test("without pictures of visible light there is the recording's own, whatever was chosen", () => {
  const look = Object.assign(new Look(), { picture: "both" });
  assert.deepEqual([look.mode, look.nPanes, look.needsOwn, look.needsVisible], ["own", 1, true, false]);
});

test("the right pane's points are counted from its own left edge", () => {
  assert.deepEqual(inPane({ view: { width: 200 } }, { x: 250, y: 7 }), { x: 50, y: 7 });
  assert.equal(inPane({ view: { width: 200 } }, null), null);
});
