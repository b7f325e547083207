"""Evidence frames: which moments decide the comparison, and their pictures with boxes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import cv2
import numpy as np
import pandas as pd

from nvcore.analysis import Result, SystemResult
from nvcore.box_states import RELEVANT_K
from nvcore.dataset import Dataset
from nvcore.encounter_moments import encounter_box
from nvcore.errors import MediaError, one_line
from nvcore.html_report.blocks import Photo
from nvcore.media.annotate import LAYERS, annotate
from nvcore.media.base import Pictures
from nvcore.media.draw import Canvas
from nvcore.media.index import picture_index
from nvcore.media.sources import open_pictures
from nvcore.media.stretch import jpeg
from nvcore.moments import worst_moments
from nvcore.schema import Category, MissClass
from nvcore.session import Session

MOST: Final = 12
"""Frames of a report."""
EXCLUSIVE: Final = 4
"""Encounters that only X detects, and as many that only Y detects."""
WIDTH_PX: Final = 880
"""Of a picture."""
QUALITY: Final = 72
STRETCH: Final = (0.5, 99.8)
"""Percentiles of the grey levels that are spread: pictures at night are dim."""
KINDS: Final = {
    "x": "A worst moment of X",
    "y": "A worst moment of Y",
    "x_better": "X far better than Y",
    "y_better": "Y far better than X",
}


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
        Percentiles of the grey levels (`nvcore.media.stretch`).
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


def session_pictures(session: Session, dataset: Dataset) -> RecordingPictures:
    """Open the pictures that a session names; what cannot be opened is told in `troubles`."""
    facts = {one.name: one for one in session.recordings}
    frames = dataset.frame_columns
    sources: dict[int, Pictures] = {}
    indices: dict[int, np.ndarray] = {}
    troubles = []
    for number, name in enumerate(dataset.recordings["name"].astype(str)):
        fact = facts.get(name)
        if fact is None or fact.pictures is None:
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
        The encounter that it is about, -1 none.
    """

    row: int
    title: str
    text: str
    encounter: int


def decisive_moments(result: Result) -> list[Moment]:
    """The frames of the report, `MOST` at most, each once.

    Encounters that only one system detects, those in which similarity differs most; then the worst
    moments of each system and those in which they differ most.
    """
    # the worst of each kind before the second worst of any
    ranked = worst_moments(result, n=2)
    ranked = ranked.assign(rank=ranked.groupby("kind").cumcount())
    worst = [
        Moment(int(one["row"]), KINDS[one["kind"]], str(one["reason"]), _about(result, one))
        for one in ranked.sort_values("rank", kind="stable").to_dict("records")
    ]
    found: dict[int, Moment] = {}
    for one in (
        *_exclusive(result, Category.X_ONLY, "X", result.x, "Y", result.y),
        *_exclusive(result, Category.Y_ONLY, "Y", result.y, "X", result.x),
        *worst,
    ):
        found.setdefault(one.row, one)
    return list(found.values())[:MOST]


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
    for same in (of, at):  # the clearest frame of each encounter, and no frame twice
        _, first = np.unique(same[order], return_index=True)
        order = order[np.sort(first)]
    return [
        Moment(
            int(at[place]), f"Only {winner} detects",
            _told(result, int(of[place]), winner, found_by, loser, missed_by), int(of[place]),
        )
        for place in order[:EXCLUSIVE]
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
    """The frame of a moment with all boxes; on a blank where there is no picture."""
    frames, row = result.dataset.frame_columns, moment.row
    recording = int(frames.recording[row])
    source, index = pictures.sources.get(recording), -1
    if source is not None:
        index = int(pictures.indices[recording][row - frames.first[recording]])
    lo, hi = pictures.stretch
    drawn = annotate(
        result, source, index, row, lo=lo, hi=hi, layers=LAYERS, labels=True, caption=False
    )
    _encircle(drawn, result, moment, float(frames.width[recording]))
    scale = WIDTH_PX / drawn.shape[1]
    small = cv2.resize(drawn, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    name = one_line(str(result.dataset.recordings["name"].iloc[recording]))
    time_s = float(result.dataset.frames["time_s"].iloc[row])
    return Photo(
        title=moment.title,
        place=f"{name}, frame {int(frames.frame[row])}, {time_s:.2f} s",
        text=moment.text,
        figures=f"similarity of this frame: X {result.x.similarity[row]:.2f}, "
        f"Y {result.y.similarity[row]:.2f}",
        jpeg=jpeg(small, quality=QUALITY),
    )


def _encircle(canvas: Canvas, result: Result, moment: Moment, width: float) -> None:
    """An ellipse around the pedestrian whom the moment is about."""
    if moment.encounter < 0:
        return
    try:
        x, y, w, h = encounter_box(result, moment.encounter, moment.row)
    except ValueError:  # not annotated in just this frame
        return
    scale = canvas.shape[1] / width
    middle = (round((x + w / 2) * scale), round((y + h / 2) * scale))
    axes = (round(w * scale * 0.75 + 24), round(h * scale * 0.75 + 24))
    cv2.ellipse(canvas, middle, axes, 0, 0, 360, (255, 255, 255), 3, cv2.LINE_AA)
