"""Which recording and which frame a file belongs to, by its name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from pathlib import PurePosixPath

import numpy as np
import pandas as pd

from nvcore.errors import InputError
from nvcore.file_kinds import unpacked_name
from nvcore.inputs.readers.base import ReadOptions, SourceFile


def listed_frames(files: Sequence[SourceFile], options: ReadOptions) -> pd.DataFrame:
    """Recording and frame of each file, from its name; files without boxes are frames, too.

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
        place = recording_and_frame_of(file.name, options.recordings)
        if place is None:
            raise InputError(
                "expected one file per frame with the frame number at the end of its name, as in "
                "I00019.txt or 000019.txt; found no number: rename the file or leave it out",
                file=file.name,
            )
        recordings.append(place[0])
        frames.append(place[1])
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


NEUTRAL = {
    *("gt", "truth", "det", "dets", "detections", "results", "result", "res"),
    *("labels", "label", "label_2", "label_02", "annotations", "annotation"),
    *("data", "images", "image_2", "img1", "xml", "txt"),
}
_FRAME = re.compile(
    r"^(?P<prefix>.*?)(?:(?<![A-Za-z])(?:I|img|image|im|frame|f)[_\-. ]?)?(?P<digits>[0-9]+)$",
    re.IGNORECASE,
)
_MAX_DIGITS = 15
"""Frame numbers are exact in every table up to here; a longer number is no frame number."""


def recording_of(name: str, known: tuple[str, ...] = ()) -> str:
    """Recording that a file with one whole recording belongs to.

    The part of the path nearest to the file that names a known recording, or the parts that do so
    together; with none found, the nearest part that is not a neutral word such as ``gt``.

    Examples
    --------
    >>> recording_of("mot15/TUD-Campus/gt/gt.txt")
    'TUD-Campus'
    >>> recording_of("mot15/TUD-Campus/det_frcnn/det.txt", known=("TUD-Campus",))
    'TUD-Campus'
    >>> recording_of("MBNet/set06/V000.txt", known=("set06/V000", "set07/V000"))
    'set06/V000'
    """
    path = PurePosixPath(unpacked_name(name))
    parts = (*path.parts[:-1], path.stem)
    recording = known_recording(parts, known)
    if recording is not None:
        return recording
    for part in reversed(parts):
        if part.lower() not in NEUTRAL and part not in ("", "/", ".", ".."):
            return part
    return path.stem


@lru_cache(maxsize=4096)
def known_recording(parts: tuple[str, ...], known: tuple[str, ...]) -> str | None:
    """The known recording that parts of a path name, alone or together; None if they name none.

    The parts nearest to the end win, and of those the longest run. A recording ``set06/V000`` is
    also found under the name ``set06_V000``.
    """
    spellings = {name.replace("/", "_"): name for name in known} | {name: name for name in known}
    for end in range(len(parts), 0, -1):
        for start in range(end):
            recording = spellings.get("/".join(parts[start:end]))
            if recording is not None:
                return recording
    return None


def recordings_of(
    names: Sequence[str],
    known: tuple[str, ...] = (),
    *,
    stated: Sequence[str | None] | None = None,
) -> tuple[list[str], list[str]]:
    """Recording of each of several files that hold one whole recording each.

    A known recording in the path comes first, then the name that the data state. A single file is
    taken for the recording, where only one is known and the data do not state another.

    Parameters
    ----------
    names
        File names as in `SourceFile.name`.
    known
        Recordings of the ground truth, if this is not the ground truth.
    stated
        The recording that the data themselves state for each file, or None.

    Returns
    -------
    tuple of list of str
        The recordings, one per file, and what was assumed, in words for the conversion text.

    Raises
    ------
    InputError
        If two files are of one recording.
    """
    recordings, facts = [], []
    for name, own in zip(names, stated or [None] * len(names), strict=True):
        recording = recording_of(name, known)
        if recording not in known and own is not None:
            recording = own
        elif recording not in known and len(names) == len(known) == 1:
            recording = known[0]
            facts.append(f"the only file taken for the only recording, {recording!r}")
        recordings.append(recording)
    first: dict[str, str] = {}
    for name, recording in zip(names, recordings, strict=True):
        if recording in first:
            raise InputError(
                f"holds recording {recording!r}, as {first[recording]} does; expected one file "
                "per recording: name the files or their folders by the recordings, or give one "
                "of the two",
                file=name,
            )
        first[recording] = name
    return recordings, facts


def recording_and_frame_of(name: str, known: tuple[str, ...] = ()) -> tuple[str, int] | None:
    """Recording and frame number of a file that holds one frame; None without a number.

    The number at the end of the file's stem is the frame; the folders and what stands before the
    number are the recording, or the known recording that they name. Neutral folders (``labels``,
    ``annotations``) do not count.

    Examples
    --------
    >>> recording_and_frame_of("set06/V000/I00019.txt")
    ('set06/V000', 19)
    >>> recording_and_frame_of("labels/0016_000007.png")
    ('0016', 7)
    >>> recording_and_frame_of("out/yolo/set06_V000_I00019.txt", known=("set06/V000",))
    ('set06/V000', 19)
    """
    path = PurePosixPath(unpacked_name(name))
    match = _FRAME.match(path.stem)
    if match is None or len(match["digits"].lstrip("0")) > _MAX_DIGITS:
        return None
    prefix = match["prefix"].rstrip("_-. ")
    every = (*path.parts[:-1], prefix) if prefix else path.parts[:-1]
    recording = known_recording(every, known)
    if recording is None:
        parts = [*(part for part in path.parts[:-1] if part.lower() not in NEUTRAL), prefix]
        recording = "/".join(part for part in parts if part not in ("", "/", ".", ".."))
    return recording or "recording", int(match["digits"])
