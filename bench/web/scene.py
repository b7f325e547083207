"""Recording with the frame number in picture and boxes, to check that they belong together.

Every picture shows its number as black and white squares, and X's box has a position given by it.
"""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np

from bench.csv_files import INPUTS

WIDTH, HEIGHT, FPS, N_FRAMES = 640, 480, 20, 400
SQUARE, BITS = 20, 9
PERIOD, STEP, LEFT_PX = 110, 5, 20
LINE = 222
"""Row of pixels to read. It crosses the two vertical edges of X's box."""

SESSION = """\
[[recording]]
name = "numbered"
width = {width}
height = {height}
fps = {fps}
frames = "0:{last}"
pictures = "numbered.mp4"
"""

# In the page: the frame number in the pixels, the left edge of X's box (px), the row that the
# viewer says it shows. Blue is X; Y's and the truth's boxes lie elsewhere.
READER = f"""viewer => {{
  const canvas = viewer.querySelector("canvas.picture"), ctx = canvas.getContext("2d");
  const scale = Math.min(canvas.width / {WIDTH}, canvas.height / {HEIGHT});
  const left = (canvas.width - {WIDTH} * scale) / 2, top = (canvas.height - {HEIGHT} * scale) / 2;
  let frame = 0;
  for (let bit = 0; bit < {BITS}; bit += 1) {{
    const at = [left + (bit + 0.5) * {SQUARE} * scale, top + {SQUARE} / 2 * scale];
    if (ctx.getImageData(...at, 1, 1).data[0] > 127) frame |= 1 << bit;
  }}
  const line = ctx.getImageData(left, top + {LINE} * scale, {WIDTH} * scale, 1).data;
  let box = null;
  for (let i = 0; i < line.length && box === null; i += 4)
    if (line[i + 2] - line[i] > 90) box = (i / 4 + 1) / scale;
  return {{ frame, box, shown: Number(viewer.dataset.shownRow) }};
}}"""


def write_scene(folder: Path) -> Path:
    """Write video, boxes and session.toml, and return the session file."""
    folder.mkdir(parents=True, exist_ok=True)
    with av.open(str(folder / "numbered.mp4"), "w") as video:
        stream = video.add_stream("libx264", rate=FPS)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for number in range(N_FRAMES):
            frame = av.VideoFrame.from_ndarray(_picture(number), format="rgb24")
            video.mux(stream.encode(frame))
        video.mux(stream.encode())
    still = "560,340,40,100"
    rows = range(N_FRAMES)
    (folder / "truth.csv").write_text(
        "frame,x,y,w,h,track\n"
        + "".join(f"{n},{x_of(n)},200,60,150,1\n{n},{still},2\n" for n in rows)
    )
    (folder / "x.csv").write_text(
        "frame,x,y,w,h,score\n"
        + "".join(f"{n},{x_of(n)},200,60,150,0.9\n{n},{still},0.8\n" for n in rows)
    )
    (folder / "y.csv").write_text(
        "frame,x,y,w,h,score\n" + "".join(f"{n},{still},0.{5 + n % 5}\n" for n in rows)
    )
    path = folder / "session.toml"
    text = SESSION.format(width=WIDTH, height=HEIGHT, fps=FPS, last=N_FRAMES - 1)
    path.write_text(f"{text}\n{INPUTS}", encoding="utf-8")
    return path


def x_of(number: int) -> int:
    """Return the left edge of X's box, px."""
    return LEFT_PX + STEP * (number % PERIOD)


def is_whole(reading: dict[str, float]) -> bool:
    """Whether picture and boxes on the canvas belong to the row that the viewer shows."""
    row = int(reading["shown"])
    box = reading["box"]
    return reading["frame"] == row and box is not None and abs(box - x_of(row)) < STEP / 2


def _picture(number: int) -> np.ndarray:
    picture = np.full((HEIGHT, WIDTH, 3), 60, np.uint8)
    for bit in range(BITS):
        value = 255 if number >> bit & 1 else 0
        picture[:SQUARE, bit * SQUARE : (bit + 1) * SQUARE] = value
    return picture
