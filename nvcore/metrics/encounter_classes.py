"""Classes of encounters from attributes in the truth, from box geometry, and from codes.

The derived classes are our choice (docs/metrics.md, classes of encounters). All classes depend only
on the truth and on the coded intervals, not on any parameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.dataset.schema import CLASS_SEPARATOR, SAME_S
from nvcore.metrics.encounters import Encounters, encounters_of
from nvcore.settings.codes import NO_CODE

CROSSING: Final = "crossing"
IN_ROAD: Final = "in_road"
GROUP: Final = "group"
CHILD: Final = "child"
DERIVED: Final = (CROSSING, IN_ROAD, GROUP, CHILD)

CROSSING_REACH: Final = 0.1
"""Least distance of a crossing pedestrian from the middle, once on each side, as a share of W/2."""
STATURE_M: Final = 1.7
"""Assumed height of a person, which converts pixels to metres at their distance."""
LANE_M: Final = 3.5
"""Largest distance from the camera's axis of a pedestrian in the road, in half of the frames."""
COMPANY_M: Final = 1.5
"""Largest lateral distance between members of a group, in at least half of the frames."""
ALIKE: Final = 1.25
"""Largest ratio of heights of group members, so that they are about equally far away."""
CHILD_SHARE: Final = 0.75
"""Largest height of a child as a share of the median pedestrian's (1.7 m: 1.28 m)."""
LEAST_COMPARED: Final = 5
"""Fewest encounters whose median may stand for an adult."""
LEAST_DEPTH_PX: Final = 5.0
"""Least depth of a foot point below the horizon for deriving a stature."""


@dataclass(frozen=True)
class EncounterClasses:
    """Classes that each encounter belongs to.

    Attributes
    ----------
    attributes
        Most frequent text of the truth's column `attributes` over the encounter's frames (the first
        one on a tie, empty if there is none); object, shape (n,).
    members
        Encounters of each class, by class name; bool, shape (n,). Order: classes of the truth by
        name, codes by name, `NO_CODE`, `DERIVED`. If two sources name the same class, it has the
        encounters of both. Classes without encounters are left out.
    named
        Classes that the truth names.
    coded
        The codes and `NO_CODE`; empty without coded intervals.
    """

    attributes: np.ndarray
    members: dict[str, np.ndarray]
    named: tuple[str, ...]
    coded: tuple[str, ...] = ()

    @cached_property
    def texts(self) -> np.ndarray:
        """Names of each encounter's classes, joined by `CLASS_SEPARATOR`, object, shape (n,).

        Classes named by the truth come first, in an order that does not depend on other encounters.
        """
        texts = np.full(len(self.attributes), "", dtype=object)
        own = classes_named(self.attributes)
        others = ((name, of & ~own.get(name, np.False_)) for name, of in self.members.items())
        for name, is_member in (*own.items(), *others):  # a loop over classes
            texts[is_member] += CLASS_SEPARATOR + name
        return np.array([text.removeprefix(CLASS_SEPARATOR) for text in texts], dtype=object)


def classes_of(dataset: Dataset) -> EncounterClasses:
    """Return the classes of a dataset's encounters. The result is cached: no setting changes it."""
    key = "encounter_classes", dataset.objects, dataset.settings.codes
    if key not in dataset.derived:
        _, encounters = encounters_of(dataset)
        truth, frames = dataset.truth, dataset.frame_columns
        attributes = attributes_of(encounters, texts_of_truth(dataset))
        named = classes_named(attributes)
        derived = {
            CROSSING: find_crossing(encounters, truth, frames),
            IN_ROAD: find_in_road(encounters, truth, frames),
            GROUP: find_groups(encounters, truth),
        }
        if not dataset.each_alone:
            derived[CHILD] = find_children(encounters, truth, frames)
        if not dataset.objects.are_pedestrians:  # the rules are about people who walk
            derived = {}
        members, coded = dict(named), find_coded(encounters, dataset)
        for name, is_member in (*coded.items(), *derived.items()):
            members[name] = members.get(name, np.zeros(len(encounters), dtype=bool)) | is_member
        dataset.derived[key] = EncounterClasses(
            attributes,
            {name: is_member for name, is_member in members.items() if is_member.any()},
            tuple(named),
            tuple(coded),
        )
    classes: EncounterClasses = dataset.derived[key]
    return classes


def texts_of_truth(dataset: Dataset) -> Any:
    """Return the text in `Dataset.attributes` for each truth row, missing if it has none."""
    table, n_truth = dataset.attributes, len(dataset.truth)
    texts = pd.Categorical(table["attributes"])
    codes = np.full(n_truth, -1, np.int64)
    if len(table):
        key = _place(table["file"].to_numpy(), table["line"].to_numpy())
        by_key = np.argsort(key, kind="stable")
        rows = dataset.boxes[["file", "line"]].iloc[:n_truth]
        of_row = _place(rows["file"].to_numpy(), rows["line"].to_numpy())
        at = np.minimum(np.searchsorted(key[by_key], of_row), len(key) - 1)
        is_there = key[by_key][at] == of_row
        codes[is_there] = texts.codes[by_key[at[is_there]]]
    return pd.Categorical.from_codes(codes, dtype=texts.dtype)


def _place(file: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Combine file and line number into one unique number."""
    places: np.ndarray = file.astype(np.int64) << 32 | line.astype(np.int64)
    return places


def attributes_of(encounters: Encounters, texts: Any) -> np.ndarray:
    """Return each encounter's most frequent text, object, shape (n_encounters,).

    Parameters
    ----------
    texts
        Text of each truth row as `pandas.Categorical`, missing if it has none; shape (n_truth,).
    """
    attributes = np.full(len(encounters), "", dtype=object)
    encounter, code = encounters.encounter_of, texts.codes.astype(np.int64)
    rows = np.flatnonzero((encounter >= 0) & (code >= 0))
    if not len(rows):
        return attributes
    n_texts = len(texts.categories)
    pair, first, count = np.unique(
        encounter[rows] * n_texts + code[rows], return_index=True, return_counts=True
    )
    of_pair = pair // n_texts
    ranked = np.lexsort((first, -count, of_pair))  # the best of each encounter is its first
    best = ranked[np.unique(of_pair[ranked], return_index=True)[1]]
    names = texts.categories.to_numpy(dtype=object)
    attributes[of_pair[best]] = names[pair[best] % n_texts]
    return attributes


def shown_class(name: str) -> str:
    """Return the name of a class as shown to users: "in road" for ``in_road``."""
    return name.replace("_", " ") if name in (*DERIVED, NO_CODE) else name


def classes_named(attributes: np.ndarray) -> dict[str, np.ndarray]:
    """Split the texts into class names, and return which encounters belong to each class.

    Examples
    --------
    >>> sorted(classes_named(np.array(["child; with dog", "", "child"], dtype=object)))
    ['child', 'with dog']
    """
    codes, texts = pd.factorize(attributes)
    members: dict[str, np.ndarray] = {}
    for code, text in enumerate(texts):  # a loop over different texts
        for name in dict.fromkeys(part.strip() for part in str(text).split(CLASS_SEPARATOR)):
            if name:
                members[name] = members.get(name, False) | (codes == code)
    return {name: members[name] for name in sorted(members)}


def find_coded(encounters: Encounters, dataset: Dataset) -> dict[str, np.ndarray]:
    """Find the encounters that overlap in time with an interval of each code, bool.

    `NO_CODE` holds the other encounters of recordings with at least one interval. Recordings
    without any may not have been coded at all. The result is empty without coded intervals.
    """
    codes = dataset.settings.codes
    time_s = dataset.frames["time_s"].to_numpy()
    first_s, last_s = time_s[encounters.first_row], time_s[encounters.last_row]
    row_of = {name: row for row, name in enumerate(dataset.recordings["name"])}
    members = {
        code: np.zeros(len(encounters), dtype=bool) for code in sorted({of.code for of in codes})
    }
    for of in codes:  # a loop over what people marked: hundreds
        is_there = encounters.recording == row_of.get(of.recording, -1)
        is_there &= (first_s <= of.end_s + SAME_S) & (last_s >= of.start_s - SAME_S)
        members[of.code] |= is_there
    if not members:
        return {}
    coded = [row_of[name] for name in {of.recording for of in codes} & row_of.keys()]
    is_coded = np.isin(encounters.recording, coded)
    return {**members, NO_CODE: is_coded & ~np.any([*members.values()], axis=0)}


def find_crossing(encounters: Encounters, truth: BoxColumns, frames: FrameColumns) -> np.ndarray:
    """Return which pedestrians cross from one side of the picture to the other, bool.

    They are at least `CROSSING_REACH` left of the middle in one frame and right of it in another.
    """
    side = _signed_offset(encounters, truth, frames)
    starts = encounters.offsets[:-1]
    if not len(starts):
        return np.zeros(0, dtype=bool)
    left, right = np.minimum.reduceat(side, starts), np.maximum.reduceat(side, starts)
    is_crossing: np.ndarray = (left <= -CROSSING_REACH) & (right >= CROSSING_REACH)
    return is_crossing


def find_in_road(encounters: Encounters, truth: BoxColumns, frames: FrameColumns) -> np.ndarray:
    """Return which pedestrians are within `LANE_M` of the car's axis in half of the frames or more.

    The result is bool. The lateral distance in metres follows from the box height and `STATURE_M`.
    """
    rows, half = encounters.order, frames.half_width[encounters.frame_index]
    aside_px = np.abs(_signed_offset(encounters, truth, frames)) * half
    is_near_axis = aside_px <= truth.h[rows] * (LANE_M / STATURE_M)
    return _in_half_of_frames(encounters, is_near_axis)


def find_groups(encounters: Encounters, truth: BoxColumns) -> np.ndarray:
    """Return which pedestrians have another one beside them in at least half of the frames, bool.

    Beside means at most `COMPANY_M` to the side, scaled by the taller one's height, with heights
    that differ by a factor of at most `ALIKE`.
    """
    has_company = np.zeros(len(truth), dtype=bool)
    rows = np.flatnonzero(~truth.ignore)
    frame, height = truth.frame_index[rows], truth.h[rows]
    centre, encounter = truth.x[rows] + 0.5 * truth.w[rows], encounters.encounter_of[rows]
    first = np.arange(len(rows))
    shift = 1
    while True:  # a loop over places within a frame, as many as the fullest frame has boxes
        first = first[first + shift < len(rows)]
        first = first[frame[first] == frame[first + shift]]
        if not len(first):
            return _in_half_of_frames(encounters, has_company[encounters.order])
        other = first + shift
        taller = np.maximum(height[first], height[other])
        is_alike = taller <= ALIKE * np.minimum(height[first], height[other])
        is_beside = np.abs(centre[first] - centre[other]) <= taller * (COMPANY_M / STATURE_M)
        is_pair = is_alike & is_beside & (encounter[first] != encounter[other])
        has_company[rows[first[is_pair]]] = True
        has_company[rows[other[is_pair]]] = True
        shift += 1


def find_children(encounters: Encounters, truth: BoxColumns, frames: FrameColumns) -> np.ndarray:
    """Return which pedestrians are small for their distance, bool.

    Stature is height times distance, or else height over the foot point's depth below the horizon.
    It is compared with the median of all encounters whose stature is known in the same way (at
    least `LEAST_COMPARED`, from one and the same camera). Boxes cut by the picture's edge have
    none.
    """
    rows = encounters.order
    x, y, w, h = (side[rows] for side in truth.xywh)
    recording = frames.recording[encounters.frame_index]
    width, height = frames.width[recording], frames.height[recording]
    is_whole = (x > 1) & (y > 1) & (x + w < width - 1) & (y + h < height - 1)
    depth = y + h - frames.horizon[recording]
    with np.errstate(invalid="ignore", divide="ignore"):
        by_distance = np.where(is_whole, h / height * truth.distance_m[rows], np.nan)
        by_horizon = np.where(is_whole & (depth >= LEAST_DEPTH_PX), h / depth, np.nan)
    is_child = np.zeros(len(encounters), dtype=bool)
    is_open = np.ones(len(encounters), dtype=bool)
    for stature in (by_distance, by_horizon):
        of_encounter = _medians(encounters, stature)
        known = np.flatnonzero(is_open & np.isfinite(of_encounter))
        if len(known) >= LEAST_COMPARED:
            stature_known = of_encounter[known]
            is_child[known] = stature_known <= CHILD_SHARE * np.median(stature_known)
            is_open[known] = False
    return is_child


def _signed_offset(encounters: Encounters, truth: BoxColumns, frames: FrameColumns) -> np.ndarray:
    """Return each box's lateral position in the order of `encounters.order`.

    -1 is the left edge of the picture, 0 its middle, 1 its right edge.
    """
    rows, half = encounters.order, frames.half_width[encounters.frame_index]
    offset: np.ndarray = (np.clip(truth.x[rows] + 0.5 * truth.w[rows], 0, 2 * half) - half) / half
    return offset


def _in_half_of_frames(encounters: Encounters, holds: np.ndarray) -> np.ndarray:
    """Return which encounters meet a condition in at least half of their boxes, bool.

    Parameters
    ----------
    holds
        Whether each row of `encounters.order` meets the condition.
    """
    starts = encounters.offsets[:-1]
    if not len(starts):
        return np.zeros(0, dtype=bool)
    n_held = np.add.reduceat(holds.astype(np.int64), starts)
    is_half: np.ndarray = 2 * n_held >= np.diff(encounters.offsets)
    return is_half


def _medians(encounters: Encounters, values: np.ndarray) -> np.ndarray:
    """Return the median of each encounter's known values, NaN if fewer than half are known."""
    n = len(encounters)
    counts = np.diff(encounters.offsets)
    encounter = np.repeat(np.arange(n), counts)
    is_known = np.isfinite(values)
    n_known = np.bincount(encounter[is_known], minlength=n)
    medians = pd.Series(values[is_known]).groupby(encounter[is_known]).median()
    of_encounter = medians.reindex(np.arange(n)).to_numpy(dtype=float, copy=True)
    of_encounter[2 * n_known < counts] = np.nan
    return of_encounter
