"""Reads from the viewer's canvas which frame its picture and its boxes belong to."""

from __future__ import annotations

import viewer_scene as scene

# In the page: reads the frame number and X's walking box from the canvas's pixels.
SIZES = f"[{scene.WIDTH}, {scene.HEIGHT}, {scene.BITS}, {scene.SQUARE}]"
READER = (
    "viewer => { const [W, H, BITS, SQUARE] = "
    + SIZES
    + """;
  const canvas = viewer.querySelector("canvas.picture");
  const ctx = canvas.getContext("2d");
  const scale = Math.min(canvas.width / W, canvas.height / H);
  const left = (canvas.width - W * scale) / 2, top = (canvas.height - H * scale) / 2;
  const column = (x, y) => ctx.getImageData(left + x * scale, top + y * scale, 1, 1).data;
  let frame = 0;
  for (let bit = 0; bit < BITS; bit += 1) {
    if (column((bit + 0.5) * SQUARE, SQUARE / 2)[0] > 127) frame |= 1 << bit;
  }
  const line = ctx.getImageData(left, top + 222 * scale, W * scale, 1).data;
  let box = null;
  for (let i = 0; i < line.length && box === null; i += 4) {
    if (line[i + 2] - line[i] > 90) box = (i / 4 + 1) / scale;
  }
  return { frame, box, shown: Number(viewer.dataset.shownRow), row: Number(viewer.dataset.row) };
}
"""
)

# Collects one reading per painted row while the viewer plays, until a row from `low` up to but
# without `high` is painted or playback has ended.
RECORDER = (
    "async (viewer, [low, high, patience]) => { const read = "
    + READER
    + """;
  const seen = [];
  let limit = 0;
  const late = new Promise((_, fail) => {
    limit = setTimeout(() => fail(new Error(JSON.stringify(viewer.dataset))), patience);
  });
  const isOver = () => viewer.dataset.playing !== "true"
    || (seen.length > 0 && seen.at(-1).shown >= low && seen.at(-1).shown < high);
  try {
    while (!isOver()) {
      await Promise.race([new Promise(requestAnimationFrame), late]);
      const now = read(viewer);
      if (!seen.length || seen.at(-1).shown !== now.shown) seen.push(now);
    }
  } finally {
    clearTimeout(limit);
  }
  return seen;
}"""
)


def is_whole(reading: dict[str, float]) -> bool:
    """Whether picture and boxes on the canvas are those of the row that the viewer names."""
    row = int(reading["shown"])
    if reading["frame"] != scene.FIRST_FRAME + row:
        return False
    is_missed = row in scene.MISSED_BY_X or row in scene.MISSED_BY_BOTH
    return is_missed or abs(reading["box"] - scene.x_of(row)) < 2.5
