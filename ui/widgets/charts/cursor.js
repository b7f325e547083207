// The frame that the viewer shows, as a line in the figures over time. Python names the axis of
// time; a figure stays as it is drawn while the line moves.

function placeCursor(plot, line) {
  const full = plot._fullLayout;
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

export function drawCursor(plot) {
  if (!plot._fullLayout?._size || !plot.layout.meta[2]) return;
  let line = plot.querySelector(".nv-cursor");
  if (!line) {
    line = document.createElement("div");
    line.className = "nv-cursor";
    plot.append(line);
  }
  placeCursor(plot, line);
}
