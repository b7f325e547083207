"""Table of the pictures that show the first, a middle and the last frame of each recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from nvcore.common.wording import one_line
from nvcore.dataset import Dataset

if TYPE_CHECKING:  # the light core has no pictures
    from nvcore.pictures import RecordingPictures


def pictures_table(dataset: Dataset, opened: RecordingPictures) -> pd.DataFrame:
    """Tabulate the pictures of three frames of each recording that has some, for checking.

    Returns
    -------
    One row per recording with open pictures. Columns: recording, pictures (their container),
    n_pictures, n_frames (evaluated), n_without (evaluated frames without a picture), and for the
    first, middle and last one ``first_frame`` and ``first_picture`` and so on: the frame, and the
    file name of its picture or "picture 30" (counted from 0); "none" without.
    """
    frames = dataset.frame_columns
    rows = []
    for number, source in opened.sources.items():  # a loop over recordings: at most hundreds
        own, index = frames.frame[frames.rows_of(number)], opened.indices[number]
        if not len(own):
            continue
        places = [0, len(own) // 2, len(own) - 1]
        shown = [int(index[place]) for place in places]
        names = source.file_names([i for i in shown if i >= 0])
        file_names = iter(names or ())
        row: dict[str, object] = {
            "recording": str(dataset.recordings["name"].iloc[number]),
            "pictures": source.name,
            "n_pictures": source.n,
            "n_frames": len(own),
            "n_without": int(np.count_nonzero(index < 0)),
        }
        for which, place, i in zip(("first", "middle", "last"), places, shown, strict=True):
            if i < 0:
                text = "none"
            else:
                text = f"picture {i}" if names is None else one_line(next(file_names))
            row |= {f"{which}_frame": int(own[place]), f"{which}_picture": text}
        rows.append(row)
    columns = ["recording", "pictures", "n_pictures", "n_frames", "n_without"]
    columns += [f"{w}_{what}" for w in ("first", "middle", "last") for what in ("frame", "picture")]
    return pd.DataFrame(rows, columns=columns)
