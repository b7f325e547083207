"""Recordings of a reading under other names: parts of a set that was divided are joined."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

import pandas as pd

from nvcore.inputs.readers.base import NO_FRAME, Reading, ReadOptions
from nvcore.inputs.readers.meaning.names import ONLY

_SUBSET: Final = re.compile(
    r"(?:instances_|person_keypoints_|obj_)?"
    r"(?:train(?:ing|val)?|val(?:id(?:ation)?)?|minival|test(?:ing)?)"
    r"(?:_?\d{4})?(?:_data)?",
    re.IGNORECASE,
)
"""Folders and files of a divided set: ``train``, ``obj_val_data``, ``instances_val2017``."""


def with_subsets_joined(reading: Reading, options: ReadOptions) -> Reading:
    """The reading with subsets (train, val, test) joined to the recordings that they are parts of.

    Tools divide the pictures of one recording at random; as recordings of their own, with gaps,
    its encounters would be counted in each. Subsets whose frame numbers or pictures' sizes
    contradict each other are different recordings and stay so, as they do where the numbers are
    said to be those of scenes.
    """
    table = reading.recordings
    names = [name for name in table["name"] if name not in options.recordings]
    whole = {
        name: "/".join(part for part in name.split("/") if not _SUBSET.fullmatch(part)) or ONLY
        for name in names
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
    return replace(
        renamed_reading(reading, titles),
        conversion="; ".join(filter(None, (reading.conversion, fact))),
    )


def renamed_reading(reading: Reading, titles: Mapping[str, str]) -> Reading:
    """The reading with other names of some of its recordings, by the old ones."""

    def renamed(table: pd.DataFrame | None, column: str = "recording") -> Any:
        if table is None:
            return None
        names = table[column]
        if isinstance(names.dtype, pd.CategoricalDtype):
            # of names that become equal it makes text
            names = names.map(lambda name: titles.get(name, name)).astype("category")
        else:
            names = pd.Series(
                [titles.get(name, name) for name in names], index=names.index, dtype=object
            )
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
            rates={titles.get(name, name): rate for name, rate in reading.named.rates.items()},
        ),
        annotated=renamed(reading.annotated),
    )
