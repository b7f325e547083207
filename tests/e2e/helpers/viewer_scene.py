"""A made-up scene for the viewer: the frame number is in the picture and in the boxes' place.

Frame f shows its number as 12 black or white squares, and X's box of the walking pedestrian lies
at `x_of(f)`, so that a test can read from the canvas whether picture and boxes belong together.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

import cv2
import numpy as np

WIDTH, HEIGHT = 640, 480
SQUARE = 20
BITS = 12
FPS = 20.0
N_ROWS = 400
N_LONG = 2345  # of a recording with more than one chunk of boxes
FIRST_FRAME = 1000
LOST_PICTURE = 330  # the route has no picture for this row
FIRST_WITHOUT_PICTURE = 360
SLOW_S = 0.2  # per picture of the slow recording

MISSED_BY_X = range(100, 120)
MISSED_BY_Y = range(200, 230)
MISSED_BY_BOTH = range(300, 320)
FALSE_ALARM = range(50, 130)
VISIBLE_AREA = (-80.0, -60.0, 800.0, 600.0)  # of the recording with two pictures, px
LISTED = (300.0, 100.0, 60.0, 80.0)  # x, y, w, h of an entry of a list, px


class Drawn(NamedTuple):
    x: float
    y: float
    w: float
    h: float
    score: float
    track: int
    source: int
    state: int


def x_of(row: int) -> int:
    """Left edge of the walking pedestrian, px."""
    return 20 + 5 * (row % 100)


def jpeg_of(row: int) -> bytes:
    """Grey picture with the frame number in its upper left corner."""
    shade = np.linspace(40, 110, WIDTH, dtype=np.uint8)
    picture = np.repeat(np.tile(shade, (HEIGHT, 1))[:, :, None], 3, axis=2)
    picture[330:] = picture[330:] // 2 + 20
    for bit in range(BITS):
        value = 255 if (FIRST_FRAME + row) >> bit & 1 else 0
        picture[:SQUARE, bit * SQUARE : (bit + 1) * SQUARE] = value
    x = x_of(row)
    cv2.ellipse(picture, (x + 30, 275), (20, 70), 0, 0, 360, (150, 150, 150), -1)
    cv2.circle(picture, (x + 30, 212), 14, (165, 165, 165), -1)
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()


def visible_jpeg(*, is_driver: bool) -> bytes:
    """All of it red; blue as the driver sees it."""
    picture = np.zeros((300, 400, 3), np.uint8)
    picture[:, :, 0 if is_driver else 2] = 200
    return cv2.imencode(".jpg", picture)[1].tobytes()


def boxes_of(row: int) -> list[Drawn]:
    """A walking pedestrian, a standing one whom both find, and now and then a false alarm."""
    x = x_of(row)
    by_x = row not in MISSED_BY_X and row not in MISSED_BY_BOTH
    by_y = row not in MISSED_BY_Y and row not in MISSED_BY_BOTH
    state = 8 | 2 * by_x | 4 * by_y | (0 if by_x else 16) | (0 if by_y else 32)
    boxes = [
        Drawn(x, 200, 60, 150, np.nan, 3, 0, state),
        Drawn(560, 240, 40, 100, np.nan, 4, 0, 8 | 2 | 4),
        Drawn(561, 241, 39, 99, 0.71, -1, 1, 1),
        Drawn(558, 238, 43, 102, 0.64, -1, 2, 1),
        Drawn(20, 250, 16, 36, np.nan, 5, 0, 0),
        Drawn(300, 230, 120, 40, np.nan, -1, 0, 1),
    ]
    if by_x:
        boxes.append(Drawn(x, 200, 60, 150, 0.87, -1, 1, 1))
    if by_y:
        boxes.append(Drawn(x + 6, 206, 60, 150, 0.83, -1, 2, 1))
    if row in FALSE_ALARM:
        boxes.append(Drawn(430, 60, 50, 110, 0.55, -1, 1, 2))
        boxes.append(Drawn(240, 80, 44, 100, 0.42, -1, 2, 2))
    return boxes


def reason_of(box: Drawn) -> dict[str, object]:
    """What the server says of a box, in the form of `nvcore.figures.overlay.explain.BoxReason`."""
    name = f"Pedestrian {box.track}" if box.source == 0 else f"Detection {box.score:.2f}"
    encounter = box.track if box.source == 0 and not box.state & 1 else -1
    lines = [f"{box.h:.0f} px tall"]
    return {"title": name, "lines": lines, "encounter": encounter, "track": box.track, "truth": -1}


def pack_rows(rows: range) -> bytes:
    """The boxes of these rows in the format of `ui.session.packed_comparison`."""
    per_row = [boxes_of(row) for row in rows]
    boxes = [box for found in per_row for box in found]
    offsets = np.concatenate(([0], np.cumsum([len(found) for found in per_row])))
    parts = [struct.pack("<II", len(per_row), len(boxes)), offsets.astype("<u4").tobytes()]
    types = ("<f4", "<f4", "<f4", "<f4", "<f4", "<i4", "u1", "u1")
    for position, dtype in enumerate(types):
        column = np.array([box[position] for box in boxes], dtype=dtype).tobytes()
        parts.append(column + b"\0" * (-len(column) % 4))
    return b"".join(parts)


def similarities(alpha: float, n_rows: int) -> dict[str, np.ndarray]:
    """A trace per system that is low where it misses the pedestrian."""
    wave = 0.9 + 0.04 * np.sin(np.arange(n_rows) / 7)
    traces = {"x": wave.astype(np.float32), "y": (wave - 0.05).astype(np.float32)}
    for system, spans in (("x", [MISSED_BY_X]), ("y", [MISSED_BY_Y])):
        for span in [*spans, MISSED_BY_BOTH]:
            traces[system][span.start : span.stop] = 1 - alpha
    traces["y"][FALSE_ALARM.start : FALSE_ALARM.stop] -= 0.3 * alpha
    traces["x"][10:20] = np.nan
    return traces
