"""Track ids as integers, whatever the file calls them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from nvcore.inputs.readers.parse.text import MAX_INTEGER
from nvcore.schema import NO_TRACK, names_as_categories

TEXT_IDS = "track ids that are no whole numbers were numbered by first appearance in the recording"
"""What to report as conversion where `track_numbers` had to number text."""


def track_numbers(texts: pd.Series, recording: Any) -> tuple[np.ndarray, bool]:
    """Track ids as int64, and whether some were text.

    Whole numbers keep their value (negative ones and empty: NO_TRACK). Other text is numbered in
    the order of first appearance in its recording, after the recording's largest whole number.

    Parameters
    ----------
    texts
        Ids as text or missing, or whole numbers as int64 or float64 with NaN, shape (n,).
    recording
        Name of each row's recording, shape (n,), or the name of all.
    """
    if texts.dtype.kind in "fi":
        ids = texts.to_numpy()
        ids = ids if (ids >= 0).all() else np.where(ids >= 0, ids, NO_TRACK)
        return ids.astype(np.int64, copy=False), False
    coded = names_as_categories(texts, len(texts))  # each text once, however often it stands there
    distinct = pd.Series(coded.categories, dtype="str").str.strip()
    number = pd.to_numeric(distinct, errors="coerce").to_numpy(dtype=float)
    with np.errstate(invalid="ignore"):
        is_whole = (np.abs(number) < MAX_INTEGER) & (number == np.floor(number))
    is_missing = distinct.str.lower().isin(["", "nan", "none", "null"]).to_numpy(dtype=bool)
    numbers = np.where(is_whole & (number >= 0), number, NO_TRACK).astype(np.int64)
    # the last of them is for rows without a text, whose code is -1
    track = np.append(numbers, NO_TRACK)[coded.codes]
    is_text = np.append(~is_missing & ~is_whole, False)[coded.codes]
    if not is_text.any():
        return track, False
    names = names_as_categories(recording, len(texts))
    codes = names.codes
    largest = np.full(len(names.categories), -1, dtype=np.int64)
    np.maximum.at(largest, codes, track)
    text_code = pd.factorize(distinct)[0][coded.codes[is_text]]
    text_ids = pd.DataFrame({"recording": codes[is_text], "text": text_code})
    first = text_ids.drop_duplicates()
    order = first.groupby("recording").cumcount().to_numpy()
    first = first.assign(track=largest[first["recording"].to_numpy()] + 1 + order)
    track[is_text] = text_ids.merge(first, how="left", on=["recording", "text"])["track"].to_numpy()
    return track, True
