"""The reading of rows whose classes are sorted, in whichever format they stand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from nvcore.findings import Finding
from nvcore.inputs.readers.base import (
    Lines,
    NamedPictures,
    Reading,
    ReadOptions,
    conversion_text,
    object_array,
    recordings_table,
)
from nvcore.inputs.readers.meaning.classes import (
    CategoryChoice,
    ClassChoice,
    NumberedRows,
    labelled,
)


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
    """The reading of the rows that stay.

    Parameters
    ----------
    lines, box
        Where the rows stand; x, y, w, h, each of shape (n,), px.
    places
        The picture of each file, or the recording of each.
    facts, findings
        Of the conversion, and what is odd beside the classes.
    kind
        Class of each row, object, shape (n,), where it says the label; empty: none.
    layout
        See `Reading`.
    **columns
        See `Lines.boxes`; of files of one recording each at least `frame`.
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
    """What becomes of each row, from what becomes of its number."""
    ignore = numbered.among(choice.ignored)
    keep = ignore | numbered.among(choice.counted)
    return ClassChoice(keep, ignore, choice.conversion, choice.findings, choice.left_out)
