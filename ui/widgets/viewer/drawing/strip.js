// Similarity of both systems over the recording: a lane each, low intervals, misses, the cursor.

import { unpack } from "../data/recording.js";

const STRIP_LANE_PX = 34;
const STRIP_MISSES_PX = 9;
const STRIP_LEFT_PX = 20;

// Runs of values below a limit, as pairs of the first row and one past the last.
function lowSpans(values, low) {
  const spans = [];
  for (let row = 0; row <= values.length; row += 1) {
    const isLow = row < values.length && values[row] < low;
    if (isLow !== (spans.length % 2 === 1)) spans.push(row);
  }
  return spans;
}

export class Strip {
  constructor(canvas) {
    this.canvas = canvas;
    this.ground = document.createElement("canvas");
    this.isStale = true;
  }

  get height() {
    return 2 * STRIP_LANE_PX + STRIP_MISSES_PX;
  }

  set(sent, palette) {
    this.palette = palette;
    this.nRows = sent.n_rows;
    this.low = sent.low;
    this.bucketRows = sent.bucket_rows;
    this.traces = { x: unpack(sent.traces.x, Float32Array), y: unpack(sent.traces.y, Float32Array) };
    this.intervals = { x: unpack(sent.intervals.x, Int32Array), y: unpack(sent.intervals.y, Int32Array) };
    this.misses = unpack(sent.misses, Int32Array);
    // both lanes have one scale, from a little below the lowest value to 1
    const values = [...this.traces.x, ...this.traces.y].filter((value) => !Number.isNaN(value));
    this.floor = Math.max(0, values.reduce((least, value) => Math.min(least, value), this.low) - 0.05);
    this.isStale = true;
  }

  // Similarity of every row, computed in the browser while a slider moves; the next `set` ends it.
  follow(similarity) {
    for (const system of ["x", "y"]) {
      const values = similarity[system];
      const least = (_, bucket) => values.subarray(bucket * this.bucketRows, (bucket + 1) * this.bucketRows).reduce((a, b) => Math.min(a, b), 1);
      this.traces[system] = Float32Array.from({ length: Math.ceil(values.length / this.bucketRows) }, least);
      this.intervals[system] = lowSpans(values, this.low);
    }
    this.isStale = true;
  }

  resize(width, ratio) {
    if (width === this.width && ratio === this.ratio) return;
    this.width = width;
    this.ratio = ratio;
    for (const canvas of [this.canvas, this.ground]) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(this.height * ratio);
    }
    this.isStale = true;
  }

  xOf(row) {
    return STRIP_LEFT_PX + ((row + 0.5) / this.nRows) * (this.width - STRIP_LEFT_PX - 4);
  }

  rowAt(x) {
    const share = (x - STRIP_LEFT_PX) / (this.width - STRIP_LEFT_PX - 4);
    return Math.max(0, Math.min(this.nRows - 1, Math.floor(share * this.nRows)));
  }

  // Similarity at a row in words; of a long recording, the lowest near it.
  valuesText(row) {
    const bucket = Math.floor(row / this.bucketRows);
    const of = (system) => {
      const value = this.traces[system][bucket];
      return `${system.toUpperCase()} ${Number.isNaN(value) ? "–" : value.toFixed(2)}`;
    };
    return `similarity ${of("x")}, ${of("y")}`;
  }

  draw(row, hoverRow) {
    if (!this.width) return;
    if (this.isStale) this.drawGround();
    const ctx = this.canvas.getContext("2d");
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.drawImage(this.ground, 0, 0);
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    if (hoverRow !== null) {
      ctx.fillStyle = "rgba(255, 255, 255, 0.35)";
      ctx.fillRect(Math.round(this.xOf(hoverRow)), 0, 1, this.height);
    }
    const x = Math.round(this.xOf(row));
    ctx.fillStyle = "#0B0E13";
    ctx.fillRect(x - 2, 0, 5, this.height);
    ctx.fillStyle = "#FFFFFF";
    ctx.fillRect(x - 1, 0, 3, this.height);
    ctx.beginPath();
    ctx.moveTo(x - 5.5, 0);
    ctx.lineTo(x + 6.5, 0);
    ctx.lineTo(x + 0.5, 7);
    ctx.fill();
  }

  drawGround() {
    this.isStale = false;
    const ctx = this.ground.getContext("2d");
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    ctx.fillStyle = "#12161D";
    ctx.fillRect(0, 0, this.width, this.height);
    this.drawLane(ctx, "x", 0);
    this.drawLane(ctx, "y", STRIP_LANE_PX);
    ctx.fillStyle = "rgba(255, 255, 255, 0.12)";
    ctx.fillRect(0, STRIP_LANE_PX, this.width, 1);
    ctx.fillRect(0, 2 * STRIP_LANE_PX, this.width, 1);
    ctx.fillStyle = this.palette.truth;
    let before = -9;
    for (const row of this.misses) {
      const x = Math.round(this.xOf(row));
      if (x - before < 3) continue; // more ticks than there is room for
      before = x;
      ctx.fillRect(x, 2 * STRIP_LANE_PX + 2, 1.5, STRIP_MISSES_PX - 3);
    }
  }

  drawLane(ctx, system, top) {
    const bottom = top + STRIP_LANE_PX - 3;
    const scale = (STRIP_LANE_PX - 8) / Math.max(0.01, 1 - this.floor);
    const yOf = (value) => bottom - (value - this.floor) * scale;
    const colour = this.palette[system];
    const spans = this.intervals[system];
    ctx.fillStyle = colour;
    ctx.globalAlpha = 0.28;
    for (let i = 0; i < spans.length; i += 2) {
      const x = this.xOf(spans[i] - 0.5);
      ctx.fillRect(x, top + 1, Math.max(1, this.xOf(spans[i + 1] - 0.5) - x), STRIP_LANE_PX - 1);
    }
    ctx.globalAlpha = 1;
    ctx.strokeStyle = "rgba(255, 255, 255, 0.28)";
    ctx.lineWidth = 1;
    ctx.setLineDash([1, 3]);
    ctx.beginPath();
    ctx.moveTo(STRIP_LEFT_PX, Math.round(yOf(this.low)) + 0.5);
    ctx.lineTo(this.width, Math.round(yOf(this.low)) + 0.5);
    ctx.stroke();
    ctx.setLineDash(this.palette.dash[system]);
    ctx.strokeStyle = colour;
    ctx.lineWidth = 1.25;
    ctx.beginPath();
    let isOpen = false;
    this.traces[system].forEach((value, bucket) => {
      if (Number.isNaN(value)) {
        isOpen = false;
        return;
      }
      const x = this.xOf(Math.min(this.nRows - 1, (bucket + 0.5) * this.bucketRows - 0.5));
      if (isOpen) ctx.lineTo(x, yOf(value));
      else ctx.moveTo(x, yOf(value));
      isOpen = true;
    });
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.font = '700 12px "Source Sans", "Source Sans Pro", sans-serif';
    ctx.textBaseline = "middle";
    ctx.fillStyle = colour;
    ctx.fillText(system.toUpperCase(), 6, top + STRIP_LANE_PX / 2);
  }
}
