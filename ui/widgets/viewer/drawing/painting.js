// One row on the canvas: the picture, what lies over it, and the boxes.

// entry: of the picture's store; found: of the boxes' store. Either may be missing.
function paintRow(viewer, row, entry, found) {
  const { recording, view } = viewer;
  if (viewer.isFollowing) followChosen(viewer, found);
  const { place } = view;
  const ctx = viewer.parts.picture.getContext("2d");
  ctx.setTransform(viewer.ratio, 0, 0, viewer.ratio, 0, 0);
  ctx.clearRect(0, 0, place.size.width, place.size.height);
  const frame = { x: place.x, y: place.y, w: recording.width * place.scale, h: recording.height * place.scale };
  if (entry?.bitmap) {
    ctx.imageSmoothingEnabled = place.scale < 4;
    viewer.light.begin(ctx);
    ctx.drawImage(entry.bitmap, frame.x, frame.y, frame.w, frame.h);
    viewer.light.end(ctx);
  } else {
    ctx.fillStyle = "#171C25";
    ctx.fillRect(frame.x, frame.y, frame.w, frame.h);
  }
  if (viewer.layers.cost) viewer.cost.draw(ctx, frame, view.seen);
  const { listed } = viewer.sent;
  if (listed?.box && listed.row === row) markListed(viewer, ctx, listed.box); // labels stand over it
  viewer.drawFound(ctx, found);
  drawMap(viewer, ctx, entry);
  const box = findTrack(found, viewer.chosen);
  if (!box) return;
  markChosen(viewer, ctx, box);
  if (viewer.isFollowing) drawInset(viewer, ctx, found, entry, box);
}

// The picture moves so that the chosen pedestrian stays in its middle; without that pedestrian it
// stays where it is.
function followChosen({ view, recording, chosen }, found) {
  const box = findTrack(found, chosen);
  if (box) view.centreOn((box.x + box.w / 2) / recording.width, (box.y + box.h / 2) / recording.height);
}
