// Which of a recording's two pictures are seen, its own or that of visible light, and how.

import { countUpTo, unpack } from "./recording.js";

const CLOCK = "clock"; // in place of seconds: those of the recording
const SAME_S = 1e-6; // times closer than this differ by rounding alone
export const LOOKS = [["own", "Own pictures"], ["visible", "Visible light"], ["blended", "Blended"], ["both", "Side by side"]];

export class Look {
  constructor() {
    this.picture = "own";
    this.blend = 0.5; // share of visible light where both are blended
    this.isAdapting = false; // whether visible light is shown as eyes see it that adapt
    this.sinceS = 0.5; // seconds since the light has changed
    this.isByHand = false; // whether `sinceS` holds also where the recording's own times are known
    this.changeAt = null; // time of a simulated change of light, s; null: none
    this.visible = null; // what Python sends of it; null: the recording has none
    this.spans = new Int32Array(0);
    this.periods = new Float32Array(0); // seconds since the light has changed, by row; see `ownSeconds`
    this.changes = new Float64Array(0); // times at which it really became dark, s, ascending
    this.simulated = new Int32Array(0); // spans of rows whose seconds are of a change that never was
  }

  take({ picture, blend, seen_s: seenS }) {
    this.picture = picture;
    this.blend = blend;
    this.isAdapting = seenS !== null;
    this.isByHand = typeof seenS === "number";
    if (this.isByHand) this.sinceS = seenS;
  }

  set(visible) {
    this.visible = visible;
    this.spans = visible ? unpack(visible.spans, Int32Array) : new Int32Array(0);
    this.simulated = visible ? unpack(visible.simulated, Int32Array) : new Int32Array(0);
    this.periods = visible?.seen_s ? unpack(visible.seen_s, Float32Array) : new Float32Array(0);
    this.changes = visible ? unpack(visible.changes, Float64Array) : new Float64Array(0);
  }

  // Whether it is known how long ago the light has changed in this recording.
  get hasClock() {
    return this.periods.length > 0;
  }

  get followsClock() {
    return this.hasClock && !this.isByHand;
  }

  // What is kept by the page.
  get choice() {
    const seenS = this.isByHand ? this.sinceS : CLOCK; // also where it is not known here
    return { picture: this.picture, blend: this.blend, seen_s: this.isAdapting ? seenS : null };
  }

  get mode() {
    return this.visible ? this.picture : "own";
  }

  get needsOwn() {
    return this.mode !== "visible";
  }

  get needsVisible() {
    return this.mode !== "own";
  }

  hasVisible(row) {
    return countUpTo(this.spans, row) % 2 === 1;
  }

  // Seconds since the recording's own change of light; Infinity: the eyes are adapted; NaN: not known.
  ownSeconds(row) {
    return this.followsClock ? this.periods[row] : NaN;
  }

  // Time of the next real change of light after the simulated one, also where no row shows it, s.
  get realAt() {
    return this.changes.find((at) => at > this.changeAt + SAME_S) ?? Infinity;
  }

  // Seconds since the change that is simulated here, at the end of a row; null: a real one came later, or none is.
  sinceChange(row, endS) {
    const seconds = this.changeAt === null ? 0 : endS - this.changeAt;
    const isOver = this.followsClock && endS > this.realAt + SAME_S;
    return seconds > SAME_S && !isOver ? seconds : null;
  }

  isSimulatedAt(row, endS) {
    return this.sinceChange(row, endS) !== null || (this.followsClock && countUpTo(this.simulated, row) % 2 === 1);
  }

  // Seconds since the light has changed, at the end of a row; null: the picture is seen as it is.
  seenAt(row, endS) {
    if (!this.isAdapting) return null;
    const simulated = this.sinceChange(row, endS);
    if (simulated !== null) return simulated;
    if (this.changeAt === null && !this.followsClock) return this.sinceS;
    const seconds = this.ownSeconds(row);
    return Number.isFinite(seconds) ? seconds : null;
  }

  get nPanes() {
    return this.mode === "both" ? 2 : 1;
  }

  // What a pane shows at most, in the recording's pixels.
  areaOf({ width, height }) {
    const own = { x: 0, y: 0, w: width, h: height };
    return this.mode === "visible" ? this.visibleArea : own;
  }

  get visibleArea() {
    const [x, y, w, h] = this.visible.area;
    return { x, y, w, h };
  }

  next() {
    const at = LOOKS.findIndex(([name]) => name === this.picture);
    this.picture = LOOKS[(at + 1) % LOOKS.length][0];
  }

  // Pictures of each pane, the lower one first: {bitmap, area, alpha}.
  panes(recording, own, visible) {
    const area = { x: 0, y: 0, w: recording.width, h: recording.height };
    const lower = own?.bitmap ? [{ bitmap: own.bitmap, area, alpha: 1 }] : [];
    const upper = this.visible && visible?.bitmap
      ? [{ bitmap: visible.bitmap, area: this.visibleArea, alpha: 1 }] : [];
    if (this.mode === "own") return [lower];
    if (this.mode === "visible") return [upper];
    if (this.mode === "both") return [lower, upper];
    // one alone stays whole
    return [[...lower, ...upper.map((picture) => ({ ...picture, alpha: lower.length ? this.blend : 1 }))]];
  }
}

// Where a point of the canvas lies in its pane.
export function inPane({ view }, point) {
  return point && view.width > 0 ? { x: point.x % view.width, y: point.y } : point;
}
