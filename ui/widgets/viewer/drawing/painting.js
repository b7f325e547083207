// One row on the canvas: the pictures, what lies over them, and the boxes.

import { drawInset, drawMap, findTrack, markChosen, markListed } from "./inset.js";
import { drawPictures } from "./light.js";

// entry, visible: of the stores of pictures; found: of the boxes' store. Each may be missing.
export function paintRow(viewer, row, { entry, visible, found }) {
  const { recording, view, look } = viewer;
  if (viewer.isFollowing) followChosen(viewer, found);
  const ctx = viewer.parts.picture.getContext("2d");
  const { width, height } = view;
  look.panes(recording, entry, visible).forEach((pictures, pane) => {
    ctx.save();
    ctx.setTransform(viewer.ratio, 0, 0, viewer.ratio, viewer.ratio * pane * width, 0);
    ctx.clearRect(0, 0, width, height);
    ctx.beginPath();
    ctx.rect(0, 0, width, height);
    ctx.clip();
    paintPane(viewer, ctx, row, pictures, found);
    ctx.restore();
  });
}

function paintPane(viewer, ctx, row, pictures, found) {
  const { recording, view } = viewer;
  const { place, seen } = view;
  ctx.fillStyle = "#171C25";
  ctx.fillRect(seen.x, seen.y, seen.w, seen.h);
  ctx.save();
  ctx.beginPath();
  ctx.rect(seen.x, seen.y, seen.w, seen.h); // visible light may reach beyond the recording's own
  ctx.clip();
  drawPictures(viewer, ctx, pictures, place);
  ctx.restore();
  const frame = { x: place.x, y: place.y, w: recording.width * place.scale, h: recording.height * place.scale };
  if (viewer.layers.cost) viewer.cost.draw(ctx, frame, seen);
  const { listed } = viewer.sent;
  if (listed?.box && listed.row === row) markListed(viewer, ctx, listed.box); // labels stand over it
  viewer.drawFound(ctx, found, row);
  drawMap(viewer, ctx, pictures);
  const box = findTrack(found, viewer.chosen);
  if (!box) return;
  markChosen(viewer, ctx, box);
  if (viewer.isFollowing) drawInset(viewer, ctx, found, pictures, box);
}

// The picture moves so that the chosen pedestrian stays in its middle; without that pedestrian it
// stays where it is.
function followChosen({ view, chosen }, found) {
  const box = findTrack(found, chosen);
  if (box) view.centreOnBox(box);
}
