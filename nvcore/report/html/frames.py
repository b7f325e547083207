"""Evidence frames: pictures with boxes at the moments that decide the comparison."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import cv2
import numpy as np

from nvcore.common.wording import UNDEFINED, one_line
from nvcore.comparison.compare import Result
from nvcore.figures.overlay.annotate import drawn_boxes, frame_picture, inks_of
from nvcore.figures.overlay.brush import Canvas, Inks
from nvcore.figures.overlay.draw import canvas_size, draw_boxes
from nvcore.metrics.proximity import in_use
from nvcore.metrics.similarity import salient_detection
from nvcore.pictures.recordings import RecordingPictures
from nvcore.pictures.stretch import jpeg
from nvcore.report.decisive_moments import Moment
from nvcore.report.section import Photo, Table, table
from nvcore.tables.frame import PEDESTRIAN_WORDS, frame_summary
from nvcore.tables.moments import encounter_box

WIDTH_PX: Final = 880
SHOWN_PX: Final = 530
"""Width of a picture in the file, and on the page."""
WIDE: Final = 1.9
"""Ratio of width to height from which a picture fills a row of its own."""
MOST_HEIGHT_PX: Final = 800
QUALITIES: Final = (72, 60, 45, 30)
MOST_BYTES: Final = 100_000
"""Size limit of a picture: the first quality that meets it is used, to keep the report small."""
MOST_PEDESTRIANS: Final = 5
"""Maximum number of pedestrians listed below a picture, those with the largest terms."""


def _share(value: float) -> str:
    return f"{value:.2f}"


def _px(value: float) -> str:
    return f"{value:.0f}" if np.isfinite(value) else UNDEFINED


SHOWN_AS: Final[dict[str, Callable[[Any], str]]] = {
    "track": str,
    "term_x": _share,
    "term_y": _share,
    "cost": _share,
    "missed_by": str,
    "k": _share,
    "border_px": _px,
    "nearest_px_x": _px,
    "nearest_px_y": _px,
}
"""Columns of the table below a picture, with the formatting of their values."""


def photo(result: Result, moment: Moment, pictures: RecordingPictures) -> Photo:
    """Draw all boxes on a moment's frame, on a light background if there is no picture."""
    frames, row = result.dataset.frame_columns, moment.row
    recording = int(frames.recording[row])
    source, index = pictures.sources.get(recording), -1
    if source is not None:
        index = int(pictures.indices[recording][row - frames.first[recording]])
    picture, why_none = frame_picture(source, index, *pictures.stretch)
    width, height = float(frames.width[recording]), float(frames.height[recording])
    is_wide = width > WIDE * height
    inks = inks_of(result, "light" if picture is None else "dark")
    n_columns = 2 if is_wide else 1
    unit = max(1, round(canvas_size(width, height)[0] / (n_columns * SHOWN_PX)))
    boxes = drawn_boxes(result, row, labels=True)
    ground = draw_boxes(picture, width, height, inks=inks)
    about = _box_about(result, moment)
    if about is not None:  # beneath the boxes and their labels
        _encircle(ground, about, width, inks, unit)
    canvas = draw_boxes(ground, width, height, **boxes._asdict(), inks=inks, unit=unit)
    name = one_line(str(result.dataset.recordings["name"].iloc[recording]))
    time_s = float(result.dataset.frames["time_s"].iloc[row])
    return Photo(
        title=moment.title,
        place=f"{name}, frame {int(frames.frame[row])}, {time_s:.2f} s",
        text=moment.text,
        measures=_measures(result, row),
        jpeg=_small_jpeg(canvas, n_columns * WIDTH_PX),
        is_wide=is_wide,
        why_blank=why_none,
        boxes=_pedestrians(result, row),
    )


def _measures(result: Result, row: int) -> str:
    """Return the similarity of both systems in a frame, and the causes of lost similarity."""
    texts = [
        f"{letter.upper()} {system.similarity[row]:.2f} (lost to misses "
        f"{system.loss_miss[row]:.3f}, to false alarms {system.loss_false[row]:.3f})"
        for letter, system in result.sides
    ]
    return f"similarity of this frame: {', '.join(texts)}"


def _pedestrians(result: Result, row: int) -> Table | None:
    """Return a table of the costliest pedestrians in a frame, or None if nobody is annotated."""
    pedestrians = frame_summary(result, row).pedestrians
    if pedestrians.empty:
        return None
    rows = [
        [SHOWN_AS[name](values[name]) for name in SHOWN_AS]
        for values in pedestrians.head(MOST_PEDESTRIANS).to_dict("records")
    ]
    left_out = len(pedestrians) - len(rows)
    notes = [f"The {len(rows)} with the largest terms, {left_out} left out."] if left_out else []
    say = result.objects.say
    head = [say(PEDESTRIAN_WORDS[name].label) for name in SHOWN_AS]
    title = say("{Many} of the frame, the largest term first")
    is_number = [number for number, name in enumerate(SHOWN_AS) if SHOWN_AS[name] is not str]
    return table(title, head, rows, right=is_number, notes=notes)


def _small_jpeg(canvas: Canvas, width: int) -> bytes:
    """Encode a JPEG, limiting its size to `width`, `MOST_HEIGHT_PX` and `MOST_BYTES`.

    Tries lower qualities until the file is small enough. The last one is used in any case.
    """
    scale = min(1.0, width / canvas.shape[1], MOST_HEIGHT_PX / canvas.shape[0])
    shrunk = cv2.resize(canvas, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    content = b""
    for quality in QUALITIES:
        content = jpeg(np.asarray(shrunk, dtype=np.uint8), quality=quality)
        if len(content) <= MOST_BYTES:
            break
    return content


def _box_about(result: Result, moment: Moment) -> np.ndarray | None:
    """Return the box (x, y, w, h) of the moment's pedestrian or most salient false alarm.

    None if there is no such box in the frame.
    """
    if moment.encounter >= 0:
        try:
            return encounter_box(result, moment.encounter, moment.row)
        except ValueError:  # not annotated in this frame
            return None
    system = result.system(moment.loser)
    boxes = result.dataset.system(system.name)
    worst = salient_detection(
        boxes,
        system.weights.k,
        system.matches.is_false_alarm,
        system.nearest,
        result.dataset.frame_columns,
        moment.row,
        edge_weight=in_use(result.params, "edge_weight", result.dataset.frame_columns),
    )
    if worst < 0:
        return None
    return np.array([boxes.x[worst], boxes.y[worst], boxes.w[worst], boxes.h[worst]])


def _encircle(canvas: Canvas, box: np.ndarray, width: float, inks: Inks, unit: int) -> None:
    """Draw an ellipse around a box."""
    x, y, w, h = box * (canvas.shape[1] / width)
    middle = (round(x + w / 2), round(y + h / 2))
    axes = (round(w * 0.7 + 20 * unit), round(h * 0.7 + 24 * unit))
    cv2.ellipse(canvas, middle, axes, 0, 0, 360, inks.truth, 2 * unit, cv2.LINE_AA)
