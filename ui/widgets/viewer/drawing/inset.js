// Beside the whole picture: the chosen pedestrian four times as large, and, where the picture is
// magnified, which part of it is seen.

import { SOURCE } from "../data/boxes.js";
import { HALO, drawBoxes } from "./drawing.js";
import { LABEL_FONT, LABEL_GROUND, LABEL_HEIGHT } from "./labels.js";
import { drawPictures } from "./light.js";

const INSET_SCALE = 4;
const INSET_SHARE = 0.32; // of the canvas's width, and of its height a little more
const INSET_MARGIN = 8;
const MAP_PX = 110;
const INSET_LINE = "#FFFFFF";
const LISTED_LINE = "#FFD84D"; // of the map's part as well; no system's colour

// Where the chosen pedestrian stands in these boxes, in the recording's pixels; null: nowhere.
export function findTrack(found, track) {
  if (!found || track === null) return null;
  const { boxes } = found;
  for (let i = found.start; i < found.stop; i += 1) {
    if (boxes.source[i] === SOURCE.truth && boxes.track[i] === track) {
      return { x: boxes.x[i], y: boxes.y[i], w: boxes.w[i], h: boxes.h[i] };
    }
  }
  return null;
}

// The corner that is farthest from what is followed.
function insetArea(size, centre) {
  const w = Math.round(INSET_SHARE * size.width);
  const h = Math.round(Math.min(INSET_SHARE * 1.3 * size.height, w));
  const isLeft = centre.x > size.width / 2;
  return { x: isLeft ? INSET_MARGIN : size.width - w - INSET_MARGIN, y: INSET_MARGIN, w, h };
}

function frameOf(ctx, area, text) {
  ctx.lineWidth = 3;
  ctx.strokeStyle = HALO;
  ctx.strokeRect(area.x, area.y, area.w, area.h);
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = INSET_LINE;
  ctx.strokeRect(area.x, area.y, area.w, area.h);
  if (!text) return;
  ctx.font = LABEL_FONT;
  ctx.textBaseline = "middle";
  ctx.textAlign = "left";
  const width = ctx.measureText(text).width + 8;
  ctx.fillStyle = LABEL_GROUND;
  ctx.fillRect(area.x, area.y, width, LABEL_HEIGHT + 2);
  ctx.fillStyle = INSET_LINE;
  ctx.fillText(text, area.x + 4, area.y + LABEL_HEIGHT / 2 + 1);
}

// The pedestrian of `box` with the boxes of truth, X and Y, larger than in the whole picture.
export function drawInset(viewer, ctx, found, pictures, box) {
  const { place } = viewer.view;
  const centre = { x: box.x + box.w / 2, y: box.y + box.h / 2 };
  const area = insetArea(place.size, { x: place.x + centre.x * place.scale, y: place.y + centre.y * place.scale });
  if (area.w < 60 || area.h < 60) return;
  // a pedestrian that would not fit is drawn as large as fits
  const fits = Math.min((0.8 * area.h) / box.h, (0.8 * area.w) / box.w);
  const scale = Math.min(INSET_SCALE * viewer.view.fitScale, fits);
  const inner = {
    scale, x: area.x + area.w / 2 - centre.x * scale, y: area.y + area.h / 2 - centre.y * scale, size: place.size,
  };
  ctx.save();
  ctx.beginPath();
  ctx.rect(area.x, area.y, area.w, area.h);
  ctx.clip();
  ctx.fillStyle = "#171C25";
  ctx.fillRect(area.x, area.y, area.w, area.h);
  drawPictures(viewer, ctx, pictures, inner);
  drawBoxes(ctx, found, inner, { ...viewer.layers, labels: false }, viewer.sent.colours.picture, area);
  ctx.restore();
  const times = scale / viewer.view.fitScale;
  frameOf(ctx, area, `#${viewer.chosen}, ${times.toFixed(times < 2 ? 1 : 0)}×`);
}

// Which part of the picture is seen, as a small map of it.
export function drawMap(viewer, ctx, pictures) {
  const { view } = viewer;
  if (view.zoom === 1) return;
  const { scale, x, y, size } = view.place;
  const { area: whole, seen } = view;
  const w = Math.min(MAP_PX, 0.25 * size.width);
  const h = (w * whole.h) / whole.w;
  const area = { x: size.width - w - INSET_MARGIN, y: size.height - h - INSET_MARGIN, w, h };
  ctx.fillStyle = "#171C25";
  ctx.fillRect(area.x, area.y, w, h);
  const share = w / whole.w;
  const inMap = { scale: share, x: area.x - whole.x * share, y: area.y - whole.y * share };
  ctx.save();
  ctx.beginPath();
  ctx.rect(area.x, area.y, w, h);
  ctx.clip();
  drawPictures(viewer, ctx, pictures, inMap);
  ctx.restore();
  frameOf(ctx, area, "");
  const [left, top] = [inMap.x + ((seen.x - x) / scale) * share, inMap.y + ((seen.y - y) / scale) * share];
  ctx.strokeStyle = LISTED_LINE;
  ctx.lineWidth = 2;
  ctx.strokeRect(left, top, (seen.w / scale) * share, (seen.h / scale) * share);
}

// Marks the chosen pedestrian in the whole picture.
export function markChosen(viewer, ctx, box) {
  outline(viewer, ctx, box, { by: 7, width: 2, colour: INSET_LINE });
}

// Marks the box that an entry of a list speaks of, also where none is drawn: [x, y, w, h] in the
// recording's pixels.
export function markListed(viewer, ctx, [x, y, w, h]) {
  outline(viewer, ctx, { x, y, w, h }, { by: 12, width: 3, colour: LISTED_LINE });
}

// A rounded frame around a box, `by` pixels away from it.
function outline(viewer, ctx, box, { by, width, colour }) {
  const { scale, x, y } = viewer.view.place;
  ctx.setLineDash([]);
  const around = [x + box.x * scale - by, y + box.y * scale - by, box.w * scale + 2 * by, box.h * scale + 2 * by];
  for (const [lineWidth, strokeStyle] of [[width + 2, HALO], [width, colour]]) {
    Object.assign(ctx, { lineWidth, strokeStyle });
    ctx.beginPath();
    ctx.roundRect(...around, 6);
    ctx.stroke();
  }
}
