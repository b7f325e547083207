"""Evidence frames: the moments that decide the comparison, and their pictures with boxes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, NamedTuple

import cv2
import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.proximity import in_use
from nvcore.metrics.similarity import salient_detection
from nvcore.overlay.annotate import drawn_boxes, frame_picture, inks_of
from nvcore.overlay.brush import Canvas, Inks
from nvcore.overlay.draw import canvas_size, draw_boxes
from nvcore.pictures.recordings import RecordingPictures
from nvcore.pictures.stretch import jpeg
from nvcore.report.html.blocks import Photo, Table, table
from nvcore.schema import Category, MissClass
from nvcore.scoring import SystemResult
from nvcore.tables.frame import PEDESTRIAN_WORDS, frame_summary
from nvcore.tables.moments import encounter_box, worst_moments
from nvcore.wording import UNDEFINED, one_line, percent

MOST: Final = 12
"""Most frames of a report."""
EXCLUSIVE: Final = 4
"""Most encounters that only X detects, and most that only Y detects."""
APART_S: Final = 2.0
"""Frames of one recording in which the same system does badly are one scene if closer than this."""
LEAST_LEAD: Final = 0.05
"""Least difference in similarity for a moment in which one system is better."""
WIDTH_PX: Final = 880
SHOWN_PX: Final = 530
"""Width of a picture in the file, and on the page."""
WIDE: Final = 1.9
"""Ratio of width to height from which a picture fills a row of its own."""
MOST_HEIGHT_PX: Final = 800
QUALITIES: Final = (72, 60, 45, 30)
MOST_BYTES: Final = 100_000
"""Size limit of a picture: the first quality that meets it is used, to keep the report small."""
KINDS: Final = {
    "x": "A worst moment of X",
    "y": "A worst moment of Y",
    "x_better": "X better than Y",
    "y_better": "Y better than X",
}
MOST_OF: Final = dict.fromkeys(KINDS.values(), 2)
"""Most moments of each of these kinds."""
MOST_PEDESTRIANS: Final = 5
"""Pedestrians listed below a picture, those with the largest terms."""
LOSER: Final = {"x": "x", "y": "y", "x_better": "y", "y_better": "x"}
"""The system that does badly in each kind of moment."""


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
"""Columns of the table below a picture, and how their values are written."""


class Moment(NamedTuple):
    """A frame of the report.

    Attributes
    ----------
    row
        Row of the frames table.
    title, text
        Why it is shown, and what happens there.
    encounter
        The encounter that it is about; -1: it is about the detections of `loser`.
    loser
        The system that does badly, "x" or "y".
    """

    row: int
    title: str
    text: str
    encounter: int
    loser: str


def decisive_moments(result: Result) -> list[Moment]:
    """The frames of the report, at most `MOST`, each scene once.

    First encounters that only one system detects, those whose failure weighs most (severity), each
    at the frame in which similarity differs most; then the worst moments of each system and those
    in which they differ most. Of the frames of a recording in which the same system does badly
    within `APART_S`, the first in this order is taken.
    """
    # the worst of each kind before the second worst of any
    ranked = worst_moments(result, n=MOST)
    ranked = ranked.assign(rank=ranked.groupby("kind").cumcount())
    worst = [
        moment
        for row in ranked.sort_values("rank", kind="stable").to_dict("records")
        if (moment := _worst(result, row)) is not None
    ]
    moments: list[Moment] = []
    n_of: dict[str, int] = {}
    for moment in (
        *_exclusive(result, Category.X_ONLY, "X", result.x, "Y", result.y),
        *_exclusive(result, Category.Y_ONLY, "Y", result.y, "X", result.x),
        *worst,
    ):
        kind = moment.title.partition(" (")[0]
        if n_of.get(kind, 0) < MOST_OF.get(kind, MOST) and not _is_shown(result, moment, moments):
            moments.append(moment)
            n_of[kind] = n_of.get(kind, 0) + 1
    return moments[:MOST]


def _worst(result: Result, moment: Mapping[Any, Any]) -> Moment | None:
    """A worst moment, in a frame that shows its subject; None: too small a difference."""
    kind, encounter = moment["kind"], _about(result, moment)
    loser = LOSER[kind]
    row = _clearest_row(result, moment, encounter, loser)
    losing, other = (result.x, result.y) if loser == "x" else (result.y, result.x)
    lower, higher = float(losing.similarity[row]), float(other.similarity[row])
    title = KINDS[kind]
    if kind.endswith("better"):
        if higher - lower < LEAST_LEAD:
            return None
        title = f"{title} ({higher:.2f} to {lower:.2f})"
    return Moment(row, title, str(moment["reason"]), encounter, loser)


def _clearest_row(result: Result, moment: Mapping[Any, Any], encounter: int, loser: str) -> int:
    """The frame of a moment that misses its pedestrian and has the worst similarity."""
    if encounter < 0:
        return int(moment["row"])
    encounters, frames = result.encounters, result.dataset.frame_columns
    recording = int(moment["recording_index"])
    begin, end = frames.first[recording : recording + 2]
    ends = [moment["first_frame"], moment["last_frame"]]
    first, last = begin + np.searchsorted(frames.frame[begin:end], ends)
    start, stop = encounters.offsets[encounter : encounter + 2]
    frame_rows, boxes = encounters.frame_index[start:stop], encounters.order[start:stop]
    losing, other = (result.x, result.y) if loser == "x" else (result.y, result.x)
    is_missed = ~losing.matches.is_matched[boxes] & (frame_rows >= first) & (frame_rows <= last)
    if not is_missed.any():
        return int(moment["row"])
    cost = losing.similarity[frame_rows]
    if moment["kind"].endswith("better"):
        cost = cost - other.similarity[frame_rows]
    return int(frame_rows[np.argmin(np.where(is_missed, cost, np.inf))])


def _is_shown(result: Result, moment: Moment, moments: Sequence[Moment]) -> bool:
    """Whether the frame, or its scene, is among the moments already."""
    recording = result.dataset.frame_columns.recording
    time_s = result.dataset.frames["time_s"].to_numpy()
    return any(
        previous.row == moment.row
        or (
            previous.loser == moment.loser
            and recording[previous.row] == recording[moment.row]
            and abs(time_s[previous.row] - time_s[moment.row]) < APART_S
        )
        for previous in moments
    )


def _about(result: Result, moment: Mapping[Any, Any]) -> int:
    """The encounter that a moment names, -1 none."""
    if pd.isna(moment["track"]):
        return -1
    encounters = result.encounters
    is_encounter = (encounters.recording == moment["recording_index"]) & (
        encounters.track == int(moment["track"])
    )
    return int(np.argmax(is_encounter)) if is_encounter.any() else -1


def _exclusive(
    result: Result,
    category: Category,
    winner: str,
    detected_by: SystemResult,
    loser: str,
    missed_by: SystemResult,
) -> list[Moment]:
    encounters = result.encounters
    rows, frame_rows = encounters.order, encounters.frame_index
    of = np.repeat(np.arange(len(encounters)), np.diff(encounters.offsets))
    is_decisive = (result.category == category.value)[of] & (result.k_truth.k[rows] >= RELEVANT_K)
    is_decisive &= detected_by.matches.is_matched[rows] & ~missed_by.matches.is_matched[rows]
    of, frame_rows = of[is_decisive], frame_rows[is_decisive]
    lead = detected_by.similarity[frame_rows] - missed_by.similarity[frame_rows]
    order = np.argsort(-lead, kind="stable")
    _, first = np.unique(of[order], return_index=True)
    order = order[np.sort(first)]  # the clearest frame of each encounter
    # an encounter that the other nearly detects, too, says little, whatever a single frame shows
    missed_s, detected_s = (
        system.failures["severity_s"].to_numpy() for system in (missed_by, detected_by)
    )
    order = order[np.argsort((detected_s - missed_s)[of[order]], kind="stable")]
    recording = result.dataset.frame_columns.recording[frame_rows]
    time_s = result.dataset.frames["time_s"].to_numpy()[frame_rows]
    clearest: list[int] = []
    while len(order) and len(clearest) < EXCLUSIVE:
        index = int(order[0])
        clearest.append(index)
        is_same_scene = (recording[order] == recording[index]) & (
            np.abs(time_s[order] - time_s[index]) < APART_S
        )
        order = order[~is_same_scene]
    return [
        Moment(
            row=int(frame_rows[index]),
            title=f"Only {winner} detects",
            text=_coverage_text(result, int(of[index]), winner, detected_by, loser, missed_by),
            encounter=int(of[index]),
            loser=loser.lower(),
        )
        for index in clearest
    ]


def _coverage_text(
    result: Result,
    encounter: int,
    winner: str,
    detected_by: SystemResult,
    loser: str,
    missed_by: SystemResult,
) -> str:
    coverage = [
        float(system.encounters["coverage"].iloc[encounter]) for system in (detected_by, missed_by)
    ]
    kind = MissClass(missed_by.encounters["miss_class"].iloc[encounter])
    failure = "" if kind is MissClass.NONE else f" ({kind.value.replace('_', ' ')})"
    who = result.objects.say("{One}")
    return (
        f"{who} {result.encounters.track[encounter]}: {winner} matches {percent(coverage[0])} of "
        f"the frames that count, {loser} {percent(coverage[1])}{failure}."
    )


def photo(result: Result, moment: Moment, pictures: RecordingPictures) -> Photo:
    """The frame of a moment with all boxes, on a light background if there is no picture."""
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
    canvas = draw_boxes(
        ground, width, height, truth=boxes.truth, x=boxes.x, y=boxes.y, inks=inks, unit=unit
    )
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
    """Similarity of both systems in a frame, and what it is lost to."""
    texts = [
        f"{letter.upper()} {system.similarity[row]:.2f} (lost to misses "
        f"{system.loss_miss[row]:.3f}, to false alarms {system.loss_false[row]:.3f})"
        for letter, system in result.sides
    ]
    return f"similarity of this frame: {', '.join(texts)}"


def _pedestrians(result: Result, row: int) -> Table | None:
    """Who costs most in a frame; None: nobody is annotated."""
    pedestrians = frame_summary(result, row).pedestrians
    if pedestrians.empty:
        return None
    rows = [
        [SHOWN_AS[name](values[name]) for name in SHOWN_AS]
        for values in pedestrians.head(MOST_PEDESTRIANS).to_dict("records")
    ]
    left_out = len(pedestrians) - len(rows)
    note = f"The {len(rows)} with the largest terms, {left_out} left out." if left_out else ""
    say = result.objects.say
    head = [say(PEDESTRIAN_WORDS[name].label) for name in SHOWN_AS]
    title = say("{Many} of the frame, the largest term first")
    is_number = [number for number, name in enumerate(SHOWN_AS) if SHOWN_AS[name] is not str]
    return table(title, head, rows, right=is_number, note=note)


def _small_jpeg(canvas: Canvas, width: int) -> bytes:
    """At most `width` wide, `MOST_HEIGHT_PX` high and `MOST_BYTES` large; quality gives way."""
    scale = min(1.0, width / canvas.shape[1], MOST_HEIGHT_PX / canvas.shape[0])
    shrunk = cv2.resize(canvas, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    content = b""
    for quality in QUALITIES:
        content = jpeg(np.asarray(shrunk, dtype=np.uint8), quality=quality)
        if len(content) <= MOST_BYTES:
            break
    return content


def _box_about(result: Result, moment: Moment) -> np.ndarray | None:
    """x, y, w, h of the moment's subject: a pedestrian, or the false alarm that counts most."""
    if moment.encounter >= 0:
        try:
            return encounter_box(result, moment.encounter, moment.row)
        except ValueError:  # not annotated in just this frame
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
