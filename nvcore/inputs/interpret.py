"""Interpret names and numbers of a reading: times, parts of data sets, row numbers as ids."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.findings import Finding, Severity
from nvcore.dataset.schema import NO_TRACK
from nvcore.inputs.readers.base import (
    NO_FRAME,
    Lines,
    Reading,
    ReadOptions,
    SourceFile,
    conversion_text,
)
from nvcore.inputs.readers.meaning.frame_names import times_as_frames
from nvcore.inputs.readers.meaning.names import LEAST_TIME, ONLY

_SUBSET: Final = re.compile(
    r"(?:instances_|person_keypoints_|obj_)?"
    r"(?:train(?:ing|val)?|val(?:id(?:ation)?)?|minival|test(?:ing)?)"
    r"(?:_?\d{4})?(?:_data)?",
    re.IGNORECASE,
)
"""Folders and files of a divided set: ``train``, ``obj_val_data``, ``instances_val2017``."""
ONCE_SHARE: Final = 0.98
"""Share of ids with a single box from which on ids number the boxes. (Our choice.)"""
LEAST_IDS: Final = 10
"""Fewer ids than this may occur once each by chance. (Our choice.)"""


def with_names_interpreted(
    reading: Reading, options: ReadOptions, files: Sequence[SourceFile]
) -> Reading:
    """Interpret times and subsets, and add frame rates and findings from names of pictures."""
    if reading.named is None and reading.images is None:
        reading = _with_times_numbered(reading, options, files)
    reading = _with_subsets_joined(reading, options)
    if reading.named is None:
        return reading
    named = reading.named.with_empty
    table = reading.recordings
    by_times = table["name"].map(named.rates).astype(float)
    return replace(
        reading,
        named=named,
        findings=(*reading.findings, *named.findings),
        conversion=conversion_text([*named.facts, reading.conversion]),
        recordings=table.assign(fps=table["fps"].fillna(by_times)),
    )


def _with_times_numbered(
    reading: Reading, options: ReadOptions, files: Sequence[SourceFile]
) -> Reading:
    """Replace times by frame numbers, if the format has only frame numbers."""
    tables = [reading.boxes] if reading.annotated is None else [reading.boxes, reading.annotated]
    is_stated = options.frame_names == "times"
    if not len(tables[-1]) or (tables[-1]["frame"].iloc[0] < LEAST_TIME and not is_stated):
        return reading
    columns = ["recording", "frame", "file", "line"]  # line 0: unknown
    rows = pd.concat(
        [
            table.reindex(columns=columns, fill_value=0).astype({"recording": object})
            for table in tables
        ]
    )
    recording, frame, file, line = (rows[name].to_numpy() for name in columns)
    times = times_as_frames(frame, recording, options, Lines(files, file, line))
    if times is None:
        return reading
    recording, frame, named = times
    n = len(reading.boxes)
    boxes = reading.boxes.assign(recording=pd.Categorical(recording[:n]), frame=frame[:n])
    annotated = reading.annotated
    if annotated is not None:
        annotated = annotated.assign(recording=recording[n:], frame=frame[n:])
    return replace(reading, boxes=boxes, annotated=annotated, named=named)


def _with_subsets_joined(reading: Reading, options: ReadOptions) -> Reading:
    """Join subsets (train, val, test) to the recordings that they are parts of.

    Tools split the pictures of a recording at random. As separate recordings with gaps, each would
    count the same encounters. Subsets remain different recordings if their frame numbers or sizes
    of pictures contradict each other, or if the user says that the numbers are those of scenes.
    """
    table = reading.recordings
    whole = {
        name: "/".join(part for part in name.split("/") if not _SUBSET.fullmatch(part)) or ONLY
        for name in table["name"]
        if name not in options.recordings
    }
    if len(set(whole.values())) == len(whole) or options.frame_names == "scenes":
        return reading
    listed = [reading.boxes, reading.annotated, reading.images]
    listed += [None if reading.named is None else reading.named.table]
    frames = pd.concat(
        [
            part[["recording", "frame"]].astype({"recording": object}).drop_duplicates()
            for part in listed
            if part is not None
        ]
    ).drop_duplicates()
    frames = frames[frames["frame"] != NO_FRAME]
    frames = frames.assign(whole=frames["recording"].map(whole))
    double = frames.duplicated(["whole", "frame"]) & frames["whole"].notna()
    groups = table.assign(whole=table["name"].map(whole)).groupby("whole")
    sizes = groups[["width", "height", "fps"]].nunique().max(axis=1)
    apart = {*frames["whole"][double], *sizes[sizes > 1].index}
    titles = {
        name: new
        for name, new in whole.items()
        if new not in apart and len(groups.groups[new]) > 1 and name != new
    }
    if not titles:
        return reading
    fact = f"{', '.join(titles)} taken for parts of one set: no frame number is in two of them"
    return renamed_reading(reading, titles, fact)


def renamed_reading(reading: Reading, titles: Mapping[str, str], fact: str = "") -> Reading:
    """Rename recordings of a reading by `titles`, and add the reason (`fact`) if it is given."""

    def name_of(name: str) -> str:
        return titles.get(name, name)

    def renamed(table: pd.DataFrame | None, column: str = "recording") -> Any:
        if table is None:
            return None
        names = table[column]
        if isinstance(names.dtype, pd.CategoricalDtype):
            # if names become equal, map returns text
            names = names.map(name_of).astype("category")
        else:
            names = pd.Series([*map(name_of, names)], index=names.index, dtype=object)
        return table.assign(**{column: names})

    return replace(
        reading,
        boxes=renamed(reading.boxes),
        recordings=renamed(reading.recordings, "name").drop_duplicates("name", ignore_index=True),
        images=renamed(reading.images),
        named=reading.named
        and replace(
            reading.named,
            table=renamed(reading.named.table),
            rates={name_of(name): rate for name, rate in reading.named.rates.items()},
        ),
        annotated=renamed(reading.annotated),
        conversion=conversion_text([reading.conversion, fact]),
    )


def without_row_numbers(reading: Reading, options: ReadOptions) -> Reading:
    """Drop track ids that are row numbers, since nearly all of a recording occur once.

    The ids of a recording are judged by themselves if they are at least `LEAST_IDS`, and by those
    of the whole reading. A recording with boxes in a single frame proves nothing.
    """
    ids = reading.boxes.loc[reading.boxes["track"] != NO_TRACK, ["recording", "track", "frame"]]
    once = ~ids.duplicated(["recording", "track"], keep=False)
    if np.count_nonzero(once) < ONCE_SHARE * LEAST_IDS:
        return reading
    first = ~ids.duplicated(["recording", "track"])
    by_recording = ids.assign(ids=first, once=once).groupby("recording", observed=True)
    table = by_recording[["ids", "once"]].sum()
    table = table[by_recording["frame"].min() < by_recording["frame"].max()]
    n_ids, n_once = table.sum()
    if n_ids < LEAST_IDS or n_once < ONCE_SHARE * n_ids:
        is_numbered = (table["ids"] >= LEAST_IDS) & (table["once"] >= ONCE_SHARE * table["ids"])
        table = table[is_numbered]
    if table.empty:
        return reading
    n_ids, n_once = table.sum()
    is_truth, objects = options.role == "truth", options.objects
    finding = Finding(
        Severity.WARNING if is_truth else Severity.NOTE,
        "row-number-ids",
        options.role,
        int(n_ids),
        f"{n_once:,} of {n_ids:,} track ids occur once only, as row numbers do: they are no track "
        "ids, and boxes are linked by their overlap from frame to frame instead.",
        objects.say("Give all boxes of {a_one} the same id, if it is known.")
        if is_truth
        else "Nothing to do: only alerts depend on the tracks of a system.",
        example=f"recording {table.index[0]}",
    )
    track = reading.boxes["track"].mask(reading.boxes["recording"].isin(table.index), NO_TRACK)
    return replace(
        reading, boxes=reading.boxes.assign(track=track), findings=(*reading.findings, finding)
    )
