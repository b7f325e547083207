// A clip for somebody who rates it: the picture and the boxes of one system, from the first row to
// the last without a halt. Nothing tells which system it is, nor what is right.

import { ICONS, make, svg } from "../controls/elements.js";
import { SOURCE } from "../data/boxes.js";
import { strokeRect } from "../drawing/drawing.js";
import { Viewer } from "./viewer.js";

const CLIP_COLOUR = "#F2E205"; // neither that of X nor of Y
const SIGN_COLOUR = "#D5121E";
const CLIP_TEXT = "A clip of a drive, with boxes drawn by a detection system";

// As a road sign warns: a triangle with a red rim, its tip here.
function drawSign(ctx, x, y, side) {
  ctx.save();
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(x + side / 2, y + 0.87 * side);
  ctx.lineTo(x - side / 2, y + 0.87 * side);
  ctx.closePath();
  ctx.lineWidth = 0.14 * side;
  ctx.lineJoin = "round";
  ctx.strokeStyle = SIGN_COLOUR;
  ctx.stroke();
  ctx.fillStyle = "#FFFFFF";
  ctx.fill();
  ctx.fillStyle = "#000000";
  ctx.font = `bold ${0.6 * side}px sans-serif`;
  ctx.textAlign = "center";
  ctx.fillText("!", x, y + 0.78 * side);
  ctx.restore();
}

export class ClipViewer extends Viewer {
  constructor() {
    super();
    const { root, parts } = this;
    root.classList.add("clip");
    root.removeAttribute("tabindex");
    root.setAttribute("aria-label", CLIP_TEXT);
    parts.picture.setAttribute("aria-label", CLIP_TEXT);
    for (const part of [parts.legend, parts.sources.root, parts.dock, parts.stripHolder, parts.bar, parts.keys]) part.remove();
    this.starter = make("button", { type: "button", class: "starter" });
    this.starter.addEventListener("click", () => this.playPause());
    parts.stage.append(this.starter);
    root.dataset.ended = "false";
    this.nPlays = 0;
    this.showPlaying();
  }

  get isSteered() {
    return false;
  }

  playPause() {
    if (!this.playing) super.playPause();
  }

  stopAt(row) {
    this.root.dataset.ended = "true";
    this.nPlays += 1;
    this.settled = null; // every end is told
    super.stopAt(row);
  }

  update(sent, report) {
    super.update(sent, (now) => report({ ...now, n_plays: this.nPlays }));
  }

  showPlaying() {
    super.showPlaying();
    const text = this.root.dataset.ended === "true" ? "Play again" : "Play the clip";
    this.starter.replaceChildren(svg(ICONS.play, 40), make("span", { text }));
    this.starter.hidden = Boolean(this.playing);
  }

  setNames() {}

  setHeight() {
    super.setHeight();
    // title, progress and the buttons of the scale stay in sight
    this.parts.stage.style.maxHeight = `min(${this.sent.height_px}px, max(240px, calc(100vh - 21rem)))`;
  }

  drawFound(ctx, found, row) {
    const { scale, x, y } = this.view.place;
    const { x: signs } = this.strip.intervals; // first row, and one past the last, of each
    if (signs.some((first, i) => i % 2 === 0 && first <= row && row < signs[i + 1])) {
      const { width, height } = this.recording;
      drawSign(ctx, x + 0.5 * scale * width, y + 0.05 * scale * height, 0.16 * scale * height);
    }
    if (!found) return;
    const { boxes } = found;
    for (let i = found.start; i < found.stop; i += 1) {
      if (boxes.source[i] !== SOURCE[this.sent.only]) continue;
      const box = {
        x: x + scale * boxes.x[i], y: y + scale * boxes.y[i], w: scale * boxes.w[i], h: scale * boxes.h[i],
      };
      strokeRect(ctx, box, { colour: CLIP_COLOUR });
    }
  }

  speak() {}
}
