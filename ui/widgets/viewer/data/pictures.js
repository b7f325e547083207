// Decoded pictures by row: few requests at a time, the most urgent first, the newest kept.

import { RETRY_MS, SESSION_ENDED, errorText, refusal } from "./boxes.js";

const PICTURE_BYTES_KEPT = 192e6;
export const REQUESTS = 3;
export const NO_PICTURE = "No picture for this frame";

export class PictureStore {
  constructor(onLoad) {
    this.onLoad = onLoad;
    this.entries = new Map(); // row -> {bitmap, error, failedAt, isOrphan}
    this.loading = new Map(); // row -> AbortController
    this.queue = [];
    this.limit = REQUESTS;
    this.pinned = null;
    this.secondsPerPicture = 0;
  }

  // urlOf(row): the picture's address; a change of recording, stretch or pictures comes here.
  reset(urlOf) {
    this.urlOf = urlOf;
    for (const abort of this.loading.values()) abort.abort();
    this.loading.clear();
    for (const entry of this.entries.values()) this.release(entry);
    this.entries.clear();
    this.queue = [];
  }

  get(row) {
    return this.entries.get(row);
  }

  // What is on the canvas stays usable even when the store has dropped it.
  pin(entry) {
    const before = this.pinned;
    this.pinned = entry;
    if (before && before !== entry && before.isOrphan) before.bitmap?.close();
  }

  release(entry) {
    if (entry === this.pinned) entry.isOrphan = true;
    else entry.bitmap?.close();
  }

  want(rows, limit = REQUESTS) {
    this.limit = limit;
    const now = performance.now();
    this.queue = rows.filter((row) => {
      const entry = this.entries.get(row);
      const isDue = !entry || (entry.isRetried && now - entry.failedAt > RETRY_MS);
      return isDue && !this.loading.has(row);
    });
    this.pump();
  }

  pump() {
    while (this.queue.length > 0 && this.loading.size < this.limit) this.load(this.queue.shift());
  }

  async load(row) {
    const abort = new AbortController();
    this.loading.set(row, abort);
    const start = performance.now();
    const entry = { bitmap: null, error: "", isRetried: false, failedAt: 0, isOrphan: false };
    try {
      const answer = await fetch(this.urlOf(row), { credentials: "same-origin", signal: abort.signal });
      const isPicture = (answer.headers.get("content-type") ?? "").startsWith("image/");
      if (answer.status === 404) entry.error = await refusal(answer, NO_PICTURE);
      else if (!answer.ok || !isPicture) throw new Error(await refusal(answer, SESSION_ENDED));
      else entry.bitmap = await createImageBitmap(await answer.blob());
    } catch (error) {
      if (abort.signal.aborted) return;
      entry.isRetried = true;
      entry.failedAt = performance.now();
      entry.error = errorText(error, "The picture could not be decoded");
    }
    if (abort.signal.aborted) {
      entry.bitmap?.close();
      return;
    }
    this.loading.delete(row);
    const seconds = (performance.now() - start) / 1000 / this.limit;
    this.secondsPerPicture += 0.2 * (seconds - this.secondsPerPicture);
    this.entries.set(row, entry);
    this.evict(entry);
    this.pump();
    this.onLoad(row);
  }

  evict(newest) {
    const bytes = newest.bitmap ? newest.bitmap.width * newest.bitmap.height * 4 : 1;
    const kept = Math.min(256, Math.max(18, Math.floor(PICTURE_BYTES_KEPT / bytes)));
    for (const [row, entry] of this.entries) {
      if (this.entries.size <= kept) break;
      this.release(entry);
      this.entries.delete(row);
    }
  }
}
