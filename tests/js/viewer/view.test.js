import assert from "node:assert/strict";
import test from "node:test";

import { View } from "../../../ui/widgets/viewer/drawing/view.js";

// A recording of 100 x 50 pixels on a canvas of 400 x 400: fitted, it is four times as large.
function viewOf(zoom = 1) {
  const view = new View();
  view.set({ x: 0, y: 0, w: 100, h: 50 }, 400, 400);
  view.zoomTo(zoom);
  return view;
}

// The recording's pixel that lies in this place of the canvas.
function pixelAt(view, { x, y }) {
  const { place } = view;
  return { x: (x - place.x) / place.scale, y: (y - place.y) / place.scale };
}

test("a picture that is fitted lies in the middle of the canvas", () => {
  const view = viewOf();
  assert.deepEqual(view.place, { scale: 4, x: 0, y: 100, size: { width: 400, height: 400 } });
  assert.deepEqual(view.seen, { x: 0, y: 100, w: 400, h: 200 });
});

test("an area that does not begin at the recording's corner is fitted as a whole", () => {
  const view = new View();
  view.set({ x: -50, y: 0, w: 200, h: 50 }, 400, 100);
  assert.deepEqual(view.place, { scale: 2, x: 100, y: 0, size: { width: 400, height: 100 } });
});

test("the place of the pointer stays where it is when the wheel zooms in", () => {
  const view = viewOf(4);
  const point = { x: 100, y: 150 };
  const before = pixelAt(view, point);
  view.zoomTo(8, point);
  assert.deepEqual(pixelAt(view, point), before);
  assert.equal(view.place.scale, 32);
});

test("zoom goes from the whole picture to sixteen times", () => {
  assert.equal(viewOf(0.2).zoom, 1);
  assert.equal(viewOf(99).zoom, 16);
});

test("buttons step from any zoom to the next of theirs", () => {
  assert.deepEqual([1, 1.2, 4, 16].map((zoom) => viewOf(zoom).nextZoom(1)), [1.5, 1.5, 6, 16]);
  assert.deepEqual([1, 1.2, 4, 16].map((zoom) => viewOf(zoom).nextZoom(-1)), [1, 1, 3, 12]);
});

test("a picture cannot be moved beyond its edge", () => {
  const view = viewOf(4);
  view.moveBy(9999, 9999);
  assert.deepEqual(pixelAt(view, { x: 0, y: 0 }), { x: 0, y: 0 });
  view.moveBy(-9999, -9999);
  assert.deepEqual(pixelAt(view, { x: 400, y: 400 }), { x: 100, y: 50 });
});

test("it moves by as many pixels of the canvas as the mouse", () => {
  const view = viewOf(4);
  const before = view.place;
  view.moveBy(16, -32);
  assert.deepEqual([view.place.x - before.x, view.place.y - before.y], [16, -32]);
});

test("a box comes into the middle as far as the edges allow", () => {
  const view = viewOf(4);
  view.centreOnBox({ x: 40, y: 20, w: 4, h: 10 });
  assert.deepEqual(pixelAt(view, { x: 200, y: 200 }), { x: 42, y: 25 });
  view.centreOnBox({ x: 0, y: 0, w: 4, h: 10 });
  assert.deepEqual(pixelAt(view, { x: 0, y: 0 }), { x: 0, y: 0 });
});
