// The columns from which the browser computes: which of several answers counts.

import assert from "node:assert/strict";
import test from "node:test";

const NAMES = ["offsets", "score", "match", "centre", "size"];

// A comparison without frames, as the route sends it, that is known by its width.
function packed(width) {
  const columns = { gap: [], fps: [], first: [0], width: [width], encounter_recording: [] };
  for (const of of ["truth", "x", "y"]) {
    for (const name of NAMES) columns[`${of}_${name}`] = name === "offsets" ? [0] : [];
  }
  const values = Object.values(columns).flat();
  let place = 0;
  const header = JSON.stringify(Object.entries(columns).map(([name, own]) => {
    const entry = [name, "f", place, own.length];
    place += 8 * own.length;
    return entry;
  }));
  const padded = header.padEnd(8 * Math.ceil((4 + header.length) / 8) - 4);
  return Buffer.concat([
    Buffer.from(Uint32Array.of(padded.length).buffer), Buffer.from(padded), Buffer.from(Float64Array.from(values).buffer),
  ]);
}

// The script in a page of its own: `show` draws the part for a comparison (null: none is open),
// `answer` answers the oldest question about it.
async function open(page) {
  const asked = [];
  Object.assign(globalThis, {
    window: {}, document: { querySelector: () => null, addEventListener() {} },
    MutationObserver: class { observe() {} },
    requestIdleCallback: (act) => act(),
    fetch: (url) => new Promise((done) => asked.push({ url, done })),
  });
  const { default: draw } = await import(`../../ui/shell/live/sliders.js?${page}`);
  const rules = { point: "as-set", proximity: "none" };
  const live = (url) => ({ url, is_small: true, names: [], settings: {}, rules, recording: 0, counts: [], moves: {}, still: {} });
  return {
    show: (url) => draw({ data: { labels: {}, drawn: {}, answered: 0, live: url && live(url) }, setTriggerValue() {} }),
    async answer(url, content) {
      const at = asked.findIndex((question) => question.url === url);
      const arrayBuffer = async () => Uint8Array.from(content).buffer;
      asked.splice(at, 1)[0].done({ status: content ? 200 : 503, arrayBuffer });
      await new Promise((done) => setTimeout(done));
    },
    get width() {
      return window.nvcoreLive.compare()?.columns.width[0];
    },
  };
}

test("the columns of the open comparison are fetched and used", async () => {
  const page = await open("used");
  page.show("a");
  assert.equal(page.width, undefined);
  await page.answer("a", packed(100));
  assert.equal(page.width, 100);
});

test("columns of a comparison that is no longer open are not used, whenever they come", async () => {
  const page = await open("late");
  page.show("a");
  page.show("b");
  await page.answer("b", packed(200));
  await page.answer("a", packed(100));
  assert.equal(page.width, 200);
});

test("a failure for a comparison that is no longer open leaves the newer question alone", async () => {
  const page = await open("failed");
  page.show("a");
  page.show("b");
  await page.answer("a", null);
  await page.answer("b", packed(200));
  assert.equal(page.width, 200);
});

test("a comparison that was closed while its columns came gets them when it is open again", async () => {
  const page = await open("again");
  page.show("a");
  page.show(null);
  await page.answer("a", packed(100));
  page.show("a");
  await page.answer("a", packed(100));
  assert.equal(page.width, 100);
});
