"""Evidence frames: which moments decide the comparison, and their pictures with boxes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import cv2
import numpy as np
import pandas as pd

from nvcore.comparison import Result, SystemResult
from nvcore.dataset import Dataset
from nvcore.errors import MediaError
from nvcore.inputs.session import Session
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.similarity import salient_detection
from nvcore.overlay.annotate import drawn_boxes, frame_picture
from nvcore.overlay.draw import ON_DARK, ON_LIGHT, Canvas, Inks, canvas_size, draw_boxes
from nvcore.pictures.base import Pictures
from nvcore.pictures.index import picture_index
from nvcore.pictures.open import open_pictures
from nvcore.pictures.stretch import jpeg
from nvcore.report.html.blocks import Photo
from nvcore.schema import Category, MissClass
from nvcore.tables.moments import encounter_box, worst_moments
from nvcore.wording import one_line

MOST: Final = 12
"""Frames of a report."""
EXCLUSIVE: Final = 4
"""Encounters that only X detects, and as many that only Y detects."""
APART_S: Final = 2.0
"""Frames of one recording in which the same system does badly are one scene if they are closer."""
LEAST_LEAD: Final = 0.05
"""Difference in similarity from which one system is shown to be better."""
WIDTH_PX: Final = 880
SHOWN_PX: Final = 530
"""Of a picture, in the file and on the page."""
WIDE: Final = 1.9
"""Width to height from which a picture takes a row of its own."""
MOST_HEIGHT_PX: Final = 800
QUALITIES: Final = (72, 60, 45, 30)
MOST_BYTES: Final = 100_000
"""Of a picture; the first quality that is below it is taken, so that the report stays small."""
STRETCH: Final = (0.5, 99.8)
"""Percentiles of the grey levels that are spread: pictures at night are dim."""
KINDS: Final = {
    "x": "A worst moment of X",
    "y": "A worst moment of Y",
    "x_better": "X better than Y",
    "y_better": "Y better than X",
}
MOST_OF: Final = dict.fromkeys(KINDS.values(), 2)
"""Moments of each of these kinds."""
LOSER: Final = {"x": "x", "y": "y", "x_better": "y", "y_better": "x"}
"""The system that a kind of moment speaks against."""


@dataclass(frozen=True)
class RecordingPictures:
    """Pictures by recording (row of the recordings table).

    Attributes
    ----------
    sources
        A recording without pictures is absent.
    indices
        Picture of each frame of a recording, -1 none; int64, shape (n_frames_of_recording,).
    stretch
        Percentiles of the grey levels (`nvcore.pictures.stretch`).
    troubles
        Why a recording's pictures cannot be opened.
    """

    sources: Mapping[int, Pictures] = field(default_factory=dict)
    indices: Mapping[int, np.ndarray] = field(default_factory=dict)
    stretch: tuple[float, float] = STRETCH
    troubles: tuple[str, ...] = ()

    def close(self) -> None:
        """Let go of files and memory."""
        for one in self.sources.values():
            one.close()


def session_pictures(
    session: Session, dataset: Dataset, recordings: Collection[int] | None = None
) -> RecordingPictures:
    """Open the pictures that a session names; what cannot be opened is told in `troubles`.

    Parameters
    ----------
    recordings
        Rows of the recordings table whose pictures are wanted; None: of all.
    """
    facts = {one.name: one for one in session.recordings}
    frames = dataset.frame_columns
    sources: dict[int, Pictures] = {}
    indices: dict[int, np.ndarray] = {}
    troubles = []
    for number, name in enumerate(dataset.recordings["name"].astype(str)):
        fact = facts.get(name)
        is_wanted = recordings is None or number in recordings
        if fact is None or fact.pictures is None or not is_wanted:
            continue
        try:
            sources[number] = open_pictures(session.folder / fact.pictures)
        except MediaError as error:
            troubles.append(f"{one_line(name)}: {one_line(error.message)}")
            continue
        listed = frames.frame[frames.first[number] : frames.first[number + 1]]
        indices[number] = picture_index(listed, sources[number], fact.first_picture)[0]
    return RecordingPictures(sources, indices, troubles=tuple(troubles))


class Moment(NamedTuple):
    """A frame that is shown.

    Attributes
    ----------
    row
        Of the frames table.
    title, text
        Why it is shown, and what happens there.
    encounter
        The encounter that it is about, -1 none: the detections of `loser`.
    loser
        The system that it speaks against, "x" or "y".
    """

    row: int
    title: str
    text: str
    encounter: int
    loser: str


def decisive_moments(result: Result) -> list[Moment]:
    """The frames of the report, `MOST` at most, each scene once.

    Encounters that only one system detects, those in which similarity differs most; then the worst
    moments of each system and those in which they differ most. Of frames of one recording that
    speak against the same system within `APART_S`, the first of these is taken.
    """
    # the worst of each kind before the second worst of any
    ranked = worst_moments(result, n=MOST)
    ranked = ranked.assign(rank=ranked.groupby("kind").cumcount())
    worst = [
        moment
        for one in ranked.sort_values("rank", kind="stable").to_dict("records")
        if (moment := _worst(result, one)) is not None
    ]
    found: list[Moment] = []
    shown: dict[str, int] = {}
    for one in (
        *_exclusive(result, Category.X_ONLY, "X", result.x, "Y", result.y),
        *_exclusive(result, Category.Y_ONLY, "Y", result.y, "X", result.x),
        *worst,
    ):
        kind = one.title.partition(" (")[0]
        if shown.get(kind, 0) < MOST_OF.get(kind, MOST) and not _is_shown(result, one, found):
            found.append(one)
            shown[kind] = shown.get(kind, 0) + 1
    return found[:MOST]


def _worst(result: Result, moment: Mapping[Any, Any]) -> Moment | None:
    """A worst moment, in a frame that shows what it is about; None: too small a difference."""
    kind, encounter = moment["kind"], _about(result, moment)
    loser = LOSER[kind]
    row = _telling_row(result, moment, encounter, loser)
    losing, other = (result.x, result.y) if loser == "x" else (result.y, result.x)
    lower, higher = float(losing.similarity[row]), float(other.similarity[row])
    title = KINDS[kind]
    if kind.endswith("better"):
        if higher - lower < LEAST_LEAD:
            return None
        title = f"{title} ({higher:.2f} to {lower:.2f})"
    return Moment(row, title, str(moment["reason"]), encounter, loser)


def _telling_row(result: Result, moment: Mapping[Any, Any], encounter: int, loser: str) -> int:
    """The frame of a moment in which its pedestrian is missed and similarity is worst."""
    if encounter < 0:
        return int(moment["row"])
    encounters, frames = result.encounters, result.dataset.frame_columns
    recording = int(moment["recording_index"])
    begin, end = frames.first[recording : recording + 2]
    ends = [moment["first_frame"], moment["last_frame"]]
    first, last = begin + np.searchsorted(frames.frame[begin:end], ends)
    start, stop = encounters.offsets[encounter : encounter + 2]
    at, boxes = encounters.frame_index[start:stop], encounters.order[start:stop]
    losing, other = (result.x, result.y) if loser == "x" else (result.y, result.x)
    is_missed = ~losing.matches.is_matched[boxes] & (at >= first) & (at <= last)
    if not is_missed.any():
        return int(moment["row"])
    cost = losing.similarity[at]
    if moment["kind"].endswith("better"):
        cost = cost - other.similarity[at]
    return int(at[np.argmin(np.where(is_missed, cost, np.inf))])


def _is_shown(result: Result, moment: Moment, found: Sequence[Moment]) -> bool:
    """Whether the frame, or its scene, is there already."""
    recording = result.dataset.frame_columns.recording
    time_s = result.dataset.frames["time_s"].to_numpy()
    return any(
        one.row == moment.row
        or (
            one.loser == moment.loser
            and recording[one.row] == recording[moment.row]
            and abs(time_s[one.row] - time_s[moment.row]) < APART_S
        )
        for one in found
    )


def _about(result: Result, moment: Mapping[Any, Any]) -> int:
    """The encounter that a moment names, -1 none."""
    if pd.isna(moment["track"]):
        return -1
    encounters = result.encounters
    is_it = (encounters.recording == moment["recording_index"]) & (
        encounters.track == int(moment["track"])
    )
    return int(np.argmax(is_it)) if is_it.any() else -1


def _exclusive(
    result: Result, category: Category, winner: str, found_by: SystemResult, loser: str,
    missed_by: SystemResult,
) -> list[Moment]:  # fmt: skip
    encounters = result.encounters
    rows, at = encounters.order, encounters.frame_index
    of = np.repeat(np.arange(len(encounters)), np.diff(encounters.offsets))
    tells = (result.category == category.value)[of] & (result.k_truth.k[rows] >= RELEVANT_K)
    tells &= found_by.matches.is_matched[rows] & ~missed_by.matches.is_matched[rows]
    of, at = of[tells], at[tells]
    lead = found_by.similarity[at] - missed_by.similarity[at]
    order = np.argsort(-lead, kind="stable")
    _, first = np.unique(of[order], return_index=True)
    order = order[np.sort(first)]  # the clearest frame of each encounter
    recording = result.dataset.frame_columns.recording[at]
    time_s = result.dataset.frames["time_s"].to_numpy()[at]
    chosen: list[int] = []
    while len(order) and len(chosen) < EXCLUSIVE:
        place = int(order[0])
        chosen.append(place)
        is_same_scene = (recording[order] == recording[place]) & (
            np.abs(time_s[order] - time_s[place]) < APART_S
        )
        order = order[~is_same_scene]
    return [
        Moment(
            int(at[place]), f"Only {winner} detects",
            _told(result, int(of[place]), winner, found_by, loser, missed_by), int(of[place]),
            loser.lower(),
        )
        for place in chosen
    ]  # fmt: skip


def _told(
    result: Result, one: int, winner: str, found_by: SystemResult, loser: str,
    missed_by: SystemResult,
) -> str:  # fmt: skip
    coverage = [float(of.encounters["coverage"].iloc[one]) for of in (found_by, missed_by)]
    kind = MissClass(missed_by.encounters["miss_class"].iloc[one])
    said = "" if kind is MissClass.NONE else f" ({kind.value.replace('_', ' ')})"
    return (
        f"Pedestrian {result.encounters.track[one]}: {winner} matches {coverage[0]:.0%} of the "
        f"relevant frames, {loser} {coverage[1]:.0%}{said}."
    )


def photo(result: Result, moment: Moment, pictures: RecordingPictures) -> Photo:
    """The frame of a moment with all boxes; on a light blank where there is no picture."""
    frames, row = result.dataset.frame_columns, moment.row
    recording = int(frames.recording[row])
    source, index = pictures.sources.get(recording), -1
    if source is not None:
        index = int(pictures.indices[recording][row - frames.first[recording]])
    picture, why_none = frame_picture(source, index, *pictures.stretch)
    width, height = float(frames.width[recording]), float(frames.height[recording])
    is_wide = width > WIDE * height
    inks = ON_LIGHT if picture is None else ON_DARK
    n_columns = 2 if is_wide else 1
    unit = max(1, round(canvas_size(width, height)[0] / (n_columns * SHOWN_PX)))
    boxes = drawn_boxes(result, row, labels=True)
    ground = draw_boxes(picture, width, height, inks=inks)
    about = _box_about(result, moment)
    if about is not None:  # below the boxes and their labels
        _encircle(ground, about, width, inks, unit)
    drawn = draw_boxes(
        ground, width, height, truth=boxes.truth, x=boxes.x, y=boxes.y, inks=inks, unit=unit
    )
    name = one_line(str(result.dataset.recordings["name"].iloc[recording]))
    time_s = float(result.dataset.frames["time_s"].iloc[row])
    return Photo(
        title=moment.title,
        place=f"{name}, frame {int(frames.frame[row])}, {time_s:.2f} s",
        text=moment.text,
        figures=f"similarity of this frame: X {result.x.similarity[row]:.2f}, "
        f"Y {result.y.similarity[row]:.2f}",
        jpeg=_small_jpeg(drawn, n_columns * WIDTH_PX),
        is_wide=is_wide,
        why_blank=why_none,
    )


def _small_jpeg(drawn: Canvas, width: int) -> bytes:
    """At most so wide, `MOST_HEIGHT_PX` high, and of `MOST_BYTES`, by less quality if need be."""
    scale = min(1.0, width / drawn.shape[1], MOST_HEIGHT_PX / drawn.shape[0])
    shrunk = cv2.resize(drawn, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    made = b""
    for quality in QUALITIES:
        made = jpeg(np.asarray(shrunk, dtype=np.uint8), quality=quality)
        if len(made) <= MOST_BYTES:
            break
    return made


def _box_about(result: Result, moment: Moment) -> np.ndarray | None:
    """x, y, w, h of what the moment is about: a pedestrian, or the false alarm that counts most."""
    if moment.encounter >= 0:
        try:
            return encounter_box(result, moment.encounter, moment.row)
        except ValueError:  # not annotated in just this frame
            return None
    system = result.x if moment.loser == "x" else result.y
    boxes = result.dataset.system(system.name)
    worst = salient_detection(
        boxes, system.weights.k, system.matches.is_false_alarm, system.nearest,
        result.dataset.frame_columns, moment.row, edge_weight=result.params.edge_weight,
    )  # fmt: skip
    if worst < 0:
        return None
    return np.array([boxes.x[worst], boxes.y[worst], boxes.w[worst], boxes.h[worst]])


def _encircle(canvas: Canvas, box: np.ndarray, width: float, inks: Inks, unit: int) -> None:
    """An ellipse around a box."""
    x, y, w, h = box * (canvas.shape[1] / width)
    middle = (round(x + w / 2), round(y + h / 2))
    axes = (round(w * 0.7 + 20 * unit), round(h * 0.7 + 24 * unit))
    cv2.ellipse(canvas, middle, axes, 0, 0, 360, inks.truth, 2 * unit, cv2.LINE_AA)
