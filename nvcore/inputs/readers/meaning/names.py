"""Which recording and which frame a file belongs to, by its name."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from pathlib import PurePosixPath
from typing import Final

from nvcore.errors import InputError
from nvcore.file_kinds import unpacked_name

NEUTRAL = {
    *("gt", "truth", "det", "dets", "detections", "results", "result", "res"),
    *("labels", "label", "label_2", "label_02", "annotations", "annotation"),
    *("data", "images", "image_2", "img1", "xml", "txt"),
}
_FRAME = re.compile(
    r"^(?P<prefix>.*?)(?:(?<![A-Za-z])(?:I|img|image|im|frame|f)[_\-. ]?)?(?P<digits>[0-9]+)$",
    re.IGNORECASE,
)
ONLY: Final = "recording"
"""Name of a recording that nothing names."""
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
    return place_of_stem(path.parts[:-1], path.stem, known)


def place_of_stem(
    folders: Sequence[str], stem: str, known: tuple[str, ...] = ()
) -> tuple[str, int] | None:
    """As `recording_and_frame_of`, from the folders and the name without its ending."""
    match = _FRAME.match(stem)
    if match is None or len(match["digits"].lstrip("0")) > _MAX_DIGITS:
        return None
    return recording_before(folders, match["prefix"], known), int(match["digits"])


def recording_before(folders: Sequence[str], prefix: str, known: tuple[str, ...] = ()) -> str:
    """The recording that folders and what stands before a frame's number or time name."""
    prefix = prefix.rstrip("_-. ")
    every = (*folders, prefix) if prefix else tuple(folders)
    recording = known_recording(every, known)
    if recording is None:
        parts = [*(part for part in folders if part.lower() not in NEUTRAL), prefix]
        recording = "/".join(part for part in parts if part not in ("", "/", ".", ".."))
    return recording or ONLY
