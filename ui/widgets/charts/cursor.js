// The frame that the viewer shows, as a line in the figures over time. Python names the axis of
// time; a figure stays as it is drawn while the line moves.

import { partOf } from "./figure.js";

export function drawCursor(plot) {
  const full = plot._fullLayout;
  if (!full?._size || !plot.layout.meta[2]) return;
  const line = partOf(plot, "nv-cursor");
  const isUpright = plot.layout.meta[2] === "y";
  const axis = isUpright ? full.yaxis : full.xaxis;
  const place = axis.d2p(document.nvcoreTime);
  line.hidden = !(place >= 0 && place <= axis._length);
  if (line.hidden) return;
  const { l: left, t: top, w: width, h: height } = full._size;
  const [x, y] = isUpright ? [left, top + place] : [left + place, top];
  line.style.transform = `translate(${x}px, ${y}px)`;
  line.style.width = isUpright ? `${width}px` : "";
  line.style.height = isUpright ? "" : `${height}px`;
}
