// The row that is asked for: moving about, playing, and having its picture and boxes loaded.

/** @import { Viewer } from "./viewer.js" */
import { ICONS, svg } from "../controls/elements.js";
import { showPosition } from "../controls/readout.js";
import { REQUESTS } from "../data/pictures.js";
import { countUpTo } from "../data/recording.js";
import { PREFETCH, rowsPerPicture } from "./playback.js";

export const SETTLE_MS = 150;
export const LOADING_TEXT_MS = 400;

// What `Viewer` does without painting anything.
export class Player {
  // ---- moving about

  /** @this {Viewer} */
  goTo(row, isFromPython = false) {
    const { recording } = this;
    if (!recording || recording.nRows === 0) return;
    this.card.hide();
    this.direction = row < this.row && !this.playing ? -1 : 1;
    this.row = recording.clamp(row);
    this.isSpokenEarly = false;
    if (this.playing) this.startClock();
    this.load();
    showPosition(this, this.row);
    this.wake();
    clearTimeout(this.settleTimer);
    if (isFromPython) this.settled = { recording: this.sent.recording, row: this.row, nonce: this.sent.seek[1] };
    if (!this.playing) this.settleTimer = setTimeout(() => this.settle(), SETTLE_MS);
    clearTimeout(this.loadingTimer);
    this.loadingTimer = setTimeout(() => this.wake(), LOADING_TEXT_MS);
    this.requestedAt = performance.now();
  }

  /** @this {Viewer} */
  goToMiss(direction) {
    const { misses } = this.strip;
    const next = countUpTo(misses, this.row);
    let index = next;
    if (direction < 0) index = next > 0 && misses[next - 1] === this.row ? next - 2 : next - 1;
    if (index >= 0 && index < misses.length) this.goTo(misses[index]);
    else this.say(direction > 0 ? "No later miss" : "No earlier miss");
  }

  /** @this {Viewer} */
  settle() {
    if (this.playing || this.isDragging) return;
    const now = { recording: this.sent.recording, row: this.row, nonce: this.sent.seek[1] };
    this.speak();
    const known = this.settled;
    if (known && known.row === now.row && known.recording === now.recording && known.nonce === now.nonce) return;
    this.settled = now;
    this.report(now);
  }

  /** @this {Viewer} */
  playPause() {
    if (this.playing) {
      this.pause(true);
      return;
    }
    const { recording } = this;
    if (this.row >= recording.lastRow) this.goTo(recording.firstRow);
    clearTimeout(this.settleTimer);
    this.startClock();
    this.direction = 1;
    this.showPlaying();
    this.wake();
  }

  /** @this {Viewer} */
  startClock() {
    this.playing = { position: this.recording.clock[this.row], from: this.row, at: null };
  }

  /** @this {Viewer} */
  pause(isReported) {
    if (!this.playing) return;
    this.playing = null;
    this.showPlaying();
    if (isReported) this.goTo(this.shownRow);
  }

  // the end of the recording
  /** @this {Viewer} */
  stopAt(row) {
    this.pause(false);
    this.goTo(row);
  }

  /** @this {Viewer} */
  showPlaying() {
    const { play } = this.parts;
    play.replaceChildren(svg(ICONS[this.playing ? "pause" : "play"]));
    play.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    this.root.dataset.playing = String(Boolean(this.playing));
  }

  // ---- loading

  /** @this {Viewer} */
  isReady(row) {
    const { look, recording } = this;
    const hasOwn = !look.needsOwn || !recording.hasPicture(row) || this.pictures.get(row) !== undefined;
    const hasVisible = !look.needsVisible || !look.hasVisible(row) || this.visible.get(row) !== undefined;
    return hasOwn && hasVisible && this.boxes.isReady(row);
  }

  /** @this {Viewer} */
  load() {
    const { recording, look } = this;
    if (!recording || recording.nRows === 0) return;
    this.boxes.want(this.row);
    const rows = [this.row];
    const stride = this.playing ? rowsPerPicture(this) : 1;
    const ahead = this.isDragging ? 0 : PREFETCH;
    // clamped: long strides must not step over the last row, where playing ends
    for (let step = 1; step <= ahead; step += 1) rows.push(recording.clamp(this.row + this.direction * stride * step));
    const limit = this.isDragging ? 1 : REQUESTS;
    const wanted = [...new Set(rows)];
    if (look.needsOwn) this.pictures.want(wanted.filter((row) => recording.hasPicture(row)), limit);
    if (look.needsVisible) this.visible.want(wanted.filter((row) => look.hasVisible(row)), limit);
  }

  /** @this {Viewer} */
  onPicture(row) {
    if (row === this.row || this.playing) this.wake();
    else if (this.isDragging && this.isReady(row)) this.wake(row);
  }

  /** @this {Viewer} */
  onBoxes(start, stop) {
    if (this.shown && this.shown.row >= start && this.shown.row < stop) this.isStale = true;
    this.wake();
  }
}
