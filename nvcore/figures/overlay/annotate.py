"""Draw one frame of a result: its picture, boxes, and a caption that explains them."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from nvcore import __version__
from nvcore.common.errors import MediaError
from nvcore.common.palette import Shade
from nvcore.common.wording import one_line, shortened
from nvcore.comparison.compare import Result
from nvcore.dataset.schema import NO_TRACK, TruthState
from nvcore.figures.overlay.brush import (
    BLANK_RGB,
    TRUTH_RGB,
    Canvas,
    Colour,
    Inks,
    inks_for,
    put_text,
    text_width,
)
from nvcore.figures.overlay.draw import DrawnDetections, DrawnTruth, TruthMark, draw_boxes
from nvcore.pictures.base import Picture, PictureReader
from nvcore.pictures.stretch import png, stretch
from nvcore.tables.boxes.states import DetectedBoxes, TruthBoxes, gather_boxes

LAYERS: Final = ("truth", "x", "y")
_DIM_RGB: Final[Colour] = (150, 158, 168)
_LONGEST_NAME: Final = 40


def annotate(
    result: Result,
    pictures: PictureReader | None,
    index: int,
    row: int,
    *,
    lo: float = 0.0,
    hi: float = 100.0,
    layers: Sequence[str] = LAYERS,
    labels: bool = False,
    caption: bool = True,
) -> Canvas:
    """Draw the boxes of a frame on its picture, with a caption below.

    Parameters
    ----------
    pictures
        Pictures of the frame's recording. None: boxes on a dark blank.
    index
        Index of the frame's picture (`nvcore.pictures.map_frames`), or -1.
    row
        Row of the frames table.
    lo, hi
        See `nvcore.pictures.stretch`.
    layers
        Sources to draw: some of "truth", "x", "y". With one system alone, the other one's misses
        are not marked either.
    labels
        Whether to write track ids and scores beside the boxes.
    caption
        Whether to write recording, frame, time, similarity, settings and version below.

    Returns
    -------
    numpy.ndarray
        RGB, uint8, (h, w, 3), with even h and w.

    Raises
    ------
    ParameterError
        If `lo` and `hi` are not percentiles.
    """
    frames = result.dataset.frame_columns
    recording = frames.recording[row]
    picture, why_none = frame_picture(pictures, index, lo, hi)
    boxes = drawn_boxes(result, row, layers=layers, labels=labels)
    width, height = float(frames.width[recording]), float(frames.height[recording])
    inks = inks_of(result, "dark")
    canvas = draw_boxes(picture, width, height, **boxes._asdict(), inks=inks)
    if picture is None:
        put_text(canvas, why_none, (12, 24), 0.45, _DIM_RGB)
    return np.concatenate([canvas, _caption(result, row, canvas.shape[1])]) if caption else canvas


def inks_of(result: Result, shade: Shade) -> Inks:
    """Return the colours of the session's systems."""
    return inks_for(result.scheme(shade))


def frame_picture(
    pictures: PictureReader | None, index: int, lo: float, hi: float
) -> tuple[Picture | None, str]:
    """Return the picture of an index in 8 bit, or None and the reason for having none."""
    if pictures is None or index < 0:
        return None, "no picture for this frame"
    try:
        return stretch(pictures.read(index), lo, hi), ""
    except MediaError:
        return None, "the picture of this frame cannot be decoded"


class DrawnFrame(NamedTuple):
    """Boxes of truth, X and Y to draw in a frame, None for sources that are not drawn."""

    truth: DrawnTruth | None
    x: DrawnDetections | None
    y: DrawnDetections | None


def drawn_boxes(
    result: Result, row: int, *, layers: Sequence[str] = LAYERS, labels: bool = False
) -> DrawnFrame:
    """Return the boxes of the given layers in a frame."""
    boxes = gather_boxes(result, row, row + 1)
    hidden = [letter for letter in "xy" if letter not in layers]
    return DrawnFrame(
        truth=_drawn_truth(boxes.truth, hidden, labels=labels) if "truth" in layers else None,
        x=_drawn_detections(boxes.x, labels=labels) if "x" in layers else None,
        y=_drawn_detections(boxes.y, labels=labels) if "y" in layers else None,
    )


def _drawn_truth(boxes: TruthBoxes, hidden: Sequence[str], *, labels: bool) -> DrawnTruth:
    """Return the truth to draw, without the misses of a system that is hidden beside the other."""
    if len(hidden) == 1:
        state = f"state_{hidden[0]}"
        of_all = getattr(boxes, state)
        shown = np.where(of_all == TruthState.MISSED, TruthState.MATCHED, of_all)
        boxes = replace(boxes, **{state: shown})
    # a loop over the boxes of one frame, which are drawn one by one
    marks = [
        TruthMark(TruthState(state_x), TruthState(state_y), *flags)
        for state_x, state_y, *flags in zip(
            boxes.state_x.tolist(),
            boxes.state_y.tolist(),
            boxes.is_relevant.tolist(),
            boxes.is_salient_x.tolist(),
            boxes.is_salient_y.tolist(),
            strict=True,
        )
    ]
    tracks = boxes.track.tolist() if labels else []
    names = ["" if track == NO_TRACK else f"{track}" for track in tracks]
    return DrawnTruth(boxes.xywh.astype(np.float64), marks, names)


def _drawn_detections(boxes: DetectedBoxes, *, labels: bool) -> DrawnDetections:
    scores = boxes.score.tolist() if labels else []
    texts = ["" if np.isnan(score) else f"{score:.2f}" for score in scores]
    return DrawnDetections(boxes.xywh.astype(np.float64), boxes.state, texts)


def _caption(result: Result, row: int, width: int) -> NDArray[np.uint8]:
    unit = max(1.0, width / 960)
    size, step = 0.45 * unit, 20 * unit
    frames = result.dataset.frames.iloc[row]
    name = _short(str(result.dataset.recordings["name"].iloc[int(frames["recording"])]))
    similarity = [float(system.similarity[row]) for system in (result.x, result.y)]
    inks, scheme = inks_of(result, "dark"), result.scheme("dark")
    lines: list[list[tuple[str, Colour]]] = [
        [
            (f"{name}   frame {int(frames['frame'])}   {frames['time_s']:.2f} s", TRUTH_RGB),
            (f"similarity X {_number(similarity[0])}", inks.x),
            (f"Y {_number(similarity[1])}", inks.y),
        ],
        [
            ("thin: truth", TRUTH_RGB),
            (f"{scheme.style('x').line}: X = {_short(result.x.name)}", inks.x),
            (f"{scheme.style('y').line}: Y = {_short(result.y.name)}", inks.y),
            ("corners: missed, cross: false alarm", _DIM_RGB),
        ],
        [(settings_text(result), _DIM_RGB)],
    ]
    wrapped = [line for parts in lines for line in _wrap(parts, width - 16 * unit, size)]
    height = round((step * len(wrapped) + 10 * unit) / 2) * 2
    bar = np.full((height, width, 3), BLANK_RGB, np.uint8)
    for number, line in enumerate(wrapped):
        left = 8 * unit
        for text, colour in line:
            put_text(bar, text, (left, (number + 0.8) * step), size, colour)
            left += text_width(text, size) + 18 * unit
    return bar


def _wrap(
    parts: Sequence[tuple[str, Colour]], width: float, size: float
) -> list[list[tuple[str, Colour]]]:
    """Fill lines with parts, breaking parts that are too long for a line at their spaces."""
    lines: list[list[tuple[str, Colour]]] = [[]]
    gap, used = 40 * size, 0.0
    for text, colour in parts:
        if text_width(text, size) <= width:
            pieces = [text]
        else:
            pieces = [""]
            for word in text.split(" "):
                longer = f"{pieces[-1]} {word}".strip()
                if text_width(longer, size) <= width or not pieces[-1]:
                    pieces[-1] = longer
                else:
                    pieces.append(word)
        for piece in pieces:
            needed = text_width(piece, size)
            if lines[-1] and used + gap + needed > width:
                lines.append([])
                used = 0.0
            lines[-1].append((piece, colour))
            used += needed + gap
    return lines


def settings_text(result: Result) -> str:
    """Return the version and the settings that are not the default, as one line."""
    params = result.params
    changed = [
        f"{spec.name}={_value(getattr(params, spec.name))}"
        for spec in fields(params)
        if getattr(params, spec.name) != spec.default
    ]
    return f"nvcore {__version__}   settings: {', '.join(changed) or 'defaults'}"


def provenance(result: Result) -> str:
    """Return version, fingerprint, systems and all settings as JSON, for the metadata of files."""
    return json.dumps(
        {
            "program": f"nvcore {__version__}",
            "fingerprint": result.dataset.fingerprint,
            "x": result.x.name,
            "y": result.y.name,
            "parameters": result.params.given(),
        }
    )


def frame_png(picture: Canvas, result: Result) -> bytes:
    """Encode the annotated frame as PNG with `provenance` inside (text chunk ``Comment``)."""
    content = png(picture)
    chunk = b"tEXtComment\0" + provenance(result).encode("ascii")
    added = struct.pack(">L", len(chunk) - 4) + chunk + struct.pack(">L", zlib.crc32(chunk))
    first = 8 + 25  # the signature and the header, which comes first
    return content[:first] + added + content[first:]


def _value(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _number(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.2f}"


def _short(name: str) -> str:
    return shortened(one_line(name), _LONGEST_NAME, mark="...")
