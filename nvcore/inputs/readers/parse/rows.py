"""Make readings of rows with sorted classes, and join readings of several files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from nvcore.common.findings import Finding
from nvcore.inputs.readers.base import (
    Lines,
    NamedPictures,
    Reading,
    ReadOptions,
    concat_boxes,
    conversion_text,
    object_array,
    recordings_table,
)
from nvcore.inputs.readers.meaning.classes import (
    CategoryChoice,
    ClassChoice,
    NumberedRows,
    classes_left_out,
    labelled,
)
from nvcore.inputs.readers.meaning.frame_names import joined_named
from nvcore.inputs.readers.meaning.values import joined_attributes


def rows_reading(
    lines: Lines,
    box: Iterable[object],
    choice: ClassChoice,
    places: NamedPictures | Sequence[str],
    options: ReadOptions,
    facts: Iterable[str],
    *,
    findings: Iterable[Finding] = (),
    kind: np.ndarray | None = None,
    layout: str = "sizes",
    **columns: object,
) -> Reading:
    """Make a reading of the rows to keep.

    Parameters
    ----------
    lines, box
        Lines of the rows, and x, y, w, h, each of shape (n,), px.
    places
        Picture or recording of each file.
    facts, findings
        Facts of the conversion, and findings other than those about classes.
    kind
        Class of each row, object, shape (n,), if it determines the label. Empty: none.
    layout
        See `Reading`.
    **columns
        See `Lines.boxes`. With recordings as `places`, `frame` is required.
    """
    recordings = places.recording if isinstance(places, NamedPictures) else object_array(places)
    columns = {"recording": recordings[lines.file], "ignore": choice.ignore} | columns
    named = places if isinstance(places, NamedPictures) else None
    if named is not None:
        columns["frame"] = named.frame[lines.file]
    labels: tuple[str, ...] = ()
    if kind is not None:
        is_counted = choice.keep & ~choice.ignore & (kind != "")
        columns["label"], labels = labelled(kind, is_counted, options.objects)
    return Reading(
        boxes=lines.boxes(box, keep=choice.keep, **columns),
        recordings=recordings_table(recordings),
        conversion=conversion_text(facts),
        images=None if named is None else named.images,
        named=named,
        findings=(*findings, *choice.findings),
        labels=labels,
        left_out=choice.left_out,
        layout=layout,
    )


def choice_of_rows(numbered: NumberedRows, choice: CategoryChoice) -> ClassChoice:
    """Convert a choice of class numbers to a choice of rows."""
    ignore = numbered.among(choice.ignored)
    keep = ignore | numbered.among(choice.counted)
    return ClassChoice(keep, ignore, choice.conversion, choice.findings, choice.left_out)


class FilePart(NamedTuple):
    """Reading of one file, with facts in place of its conversion text.

    Attributes
    ----------
    kind
        Class of each box, as in the file.
    """

    reading: Reading
    facts: Sequence[str]
    kind: Any = None


def joined_parts(parts: Sequence[FilePart], facts: Iterable[str] = ()) -> Reading:
    """Join the readings of several files, with categories and classes of the first.

    Parameters
    ----------
    facts
        Facts of the conversion that precede those of the files.
    """
    readings = [part.reading for part in parts]
    left_out: Counter[str] = Counter()
    for reading in readings:
        left_out.update({item.name: item.count for item in reading.left_out})
    recordings = readings[0].recordings
    if len(readings) > 1:
        recordings = pd.concat([reading.recordings for reading in readings])
        recordings = recordings.drop_duplicates("name", ignore_index=True)
    annotated = [part.annotated for part in readings if part.annotated is not None]
    return Reading(
        boxes=concat_boxes([reading.boxes for reading in readings]),
        recordings=recordings,
        conversion=conversion_text(chain(facts, *(part.facts for part in parts))),
        annotated=pd.concat(annotated, ignore_index=True) if annotated else None,
        findings=tuple(chain(*(reading.findings for reading in readings))),
        attributes=joined_attributes([reading.attributes for reading in readings]),
        categories=next((part.categories for part in readings if part.categories), {}),
        classes=next((part.classes for part in readings if part.classes), ()),
        left_out=classes_left_out(left_out),
        named=joined_named([part.named for part in readings if part.named is not None]),
    )
