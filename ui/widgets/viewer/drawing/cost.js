// What missing a pedestrian would cost, over the picture: the weight of each foot row times the
// border of each lateral position, in bands whose edges are lines of equal cost.

import { unpack } from "../data/recording.js";

const COST_STEP = 0.1;
const COST_COLOUR = [190, 70, 255]; // neither of X nor of Y
const COST_LEAST = 0.05; // of the first band; nothing is drawn below
const COST_OPACITY = 0.48; // of a cost of 1
const COST_SAMPLES = [0.1, 0.3, 0.5, 0.7, 0.9];

// The value between two neighbours of a row of numbers; a gap beside it makes a gap.
function between(values, place) {
  const clamped = Math.max(0, Math.min(values.length - 1, place));
  const low = Math.floor(clamped);
  const high = Math.min(values.length - 1, low + 1);
  return values[low] + (clamped - low) * (values[high] - values[low]);
}

function costOpacity(cost) {
  return Number.isNaN(cost) || cost < COST_LEAST ? 0 : COST_OPACITY * (Math.round(cost / COST_STEP) * COST_STEP);
}

export class CostLayer {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.text = "";
  }

  get isKnown() {
    return this.text !== "";
  }

  // sent: {k, border, text}, or null where there is none
  set(sent) {
    this.text = sent?.text ?? "";
    this.isStale = true;
    if (!sent) return;
    this.k = unpack(sent.k, Float32Array);
    this.border = unpack(sent.border, Float32Array);
  }

  // Cost in a place of the picture, given as shares of its width and height; NaN: nobody stands there.
  at(across, down) {
    return between(this.k, down * this.k.length - 0.5) * between(this.border, across * this.border.length - 0.5);
  }

  drawGrid() {
    const { canvas } = this;
    canvas.width = 4 * this.border.length;
    canvas.height = 4 * this.k.length;
    const ctx = canvas.getContext("2d");
    const image = ctx.createImageData(canvas.width, canvas.height);
    let at = 0;
    for (let y = 0; y < canvas.height; y += 1) {
      for (let x = 0; x < canvas.width; x += 1) {
        const cost = this.at((x + 0.5) / canvas.width, (y + 0.5) / canvas.height);
        image.data.set(COST_COLOUR, at);
        image.data[at + 3] = Math.round(255 * costOpacity(cost));
        at += 4;
      }
    }
    ctx.putImageData(image, 0, 0);
    this.isStale = false;
  }

  // frame: where the picture lies on the canvas; seen: the part of the canvas that shows it
  draw(ctx, frame, seen) {
    if (!this.isKnown) return;
    if (this.isStale) this.drawGrid();
    ctx.imageSmoothingEnabled = true;
    ctx.drawImage(this.canvas, frame.x, frame.y, frame.w, frame.h);
    this.drawScale(ctx, seen);
  }

  drawScale(ctx, seen) {
    const [size, gap, row] = [11, 40, 18];
    ctx.font = "12px sans-serif";
    ctx.textBaseline = "middle";
    ctx.textAlign = "left";
    const title = "cost of a miss";
    const titleWidth = ctx.measureText(title).width + 12;
    const width = Math.min(seen.w - 12, 16 + Math.max(titleWidth + gap * COST_SAMPLES.length, ctx.measureText(this.text).width));
    const x = seen.x + 6, y = seen.y + seen.h - 2 * row - 10;
    ctx.fillStyle = "rgba(8, 11, 16, 0.8)";
    ctx.fillRect(x, y, width, 2 * row + 4);
    ctx.fillStyle = "#E6EAF0";
    ctx.fillText(title, x + 8, y + 2 + row / 2);
    COST_SAMPLES.forEach((cost, i) => {
      const left = x + 8 + titleWidth + gap * i;
      ctx.fillStyle = "#7A7F87"; // as grey as a picture
      ctx.fillRect(left, y + 2 + (row - size) / 2, size, size);
      ctx.fillStyle = `rgb(${COST_COLOUR.join(" ")} / ${costOpacity(cost)})`;
      ctx.fillRect(left, y + 2 + (row - size) / 2, size, size);
      ctx.fillStyle = "#E6EAF0";
      ctx.fillText(cost.toFixed(1), left + size + 4, y + 2 + row / 2);
    });
    ctx.fillText(this.text, x + 8, y + 2 + 1.5 * row, width - 16);
  }
}
