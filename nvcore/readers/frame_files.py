"""Formats with one file per frame: which frames a set of files lists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from nvcore.errors import InputError
from nvcore.readers.base import ReadOptions, SourceFile
from nvcore.readers.naming import recording_and_frame_of


def listed_frames(files: Sequence[SourceFile], options: ReadOptions) -> pd.DataFrame:
    """Recording and frame of each file, told from its name; files without boxes are frames, too.

    Returns
    -------
    DataFrame
        Columns recording, frame, image_id; one row per file, in the order of the files. The
        image_id is the 1-based position in the order of recording and frame, which is how results
        of Caltech and KAIST number the images.

    Raises
    ------
    InputError
        If a file name has no frame number, or two files are of one frame.
    """
    recordings, frames = [], []
    # a loop over files, each of which has a name of its own
    for file in files:
        found = recording_and_frame_of(file.name, options.recordings)
        if found is None:
            raise InputError(
                "expected one file per frame with the frame number at the end of its name, as in "
                "I00019.txt or 000019.txt; found no number: rename the file or leave it out",
                file=file.name,
            )
        recordings.append(found[0])
        frames.append(found[1])
    # one known recording and one read: the same one, whatever the folders are called
    if len(options.recordings) == 1 and len(set(recordings)) == 1:
        recordings = list(options.recordings) * len(recordings)
    table = pd.DataFrame(
        {
            "recording": np.array(recordings, dtype=object),
            "frame": np.array(frames, dtype=np.int64),
        }
    )
    double = table.duplicated(["recording", "frame"]).to_numpy()
    if double.any():
        second = int(np.argmax(double))
        recording, frame = recordings[second], frames[second]
        first = next(i for i in range(second) if (recordings[i], frames[i]) == (recording, frame))
        raise InputError(
            f"is frame {frame} of recording {recording!r}, as is {files[first].name}; expected "
            "one file per frame: name the files or their folders by the recordings",
            file=files[second].name,
        )
    order = table.sort_values(["recording", "frame"]).index
    image_id = np.empty(len(table), dtype=np.int64)
    image_id[order] = np.arange(1, len(table) + 1)
    return table.assign(image_id=image_id)
