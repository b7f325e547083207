"""Data page: the table of recordings, the list of evaluated frames, and pictures of a form."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np
import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.common.wording import MOST_NAMED, count_text, listed
from nvcore.inputs.recordings import no_such_recording
from nvcore.inputs.session import RecordingEntry, RecordingsFile
from ui.access.files import safe_name
from ui.confined.reading import frames_confined, recordings_confined
from ui.session import state
from ui.session.opening import guess_pictures
from ui.shell.messages import error_text
from ui.views.data.missing_inputs import check_pictures
from ui.widgets.text import plain

if TYPE_CHECKING:
    from ui.views.data.form_session import Chosen

RECORDINGS_LABEL: Final = "Recordings (table, one line each)"
RECORDINGS_HELP: Final = (
    "A CSV file with the columns recording, width, height, fps, context, speed_kmh, horizon, tags, "
    "unit, pictures, first_picture and title; all but the first may be missing. Context: urban, "
    "rural, or a number from 0 to 1. Speed: of the car. Horizon: its row in the picture. Tags are "
    "separated by semicolons; a unit is what several recordings are part of; pictures are names of "
    "files or folders."
)
_PARTS: Final = {
    "width": "sizes",
    "fps": "frame rates",
    "context": "traffic context",
    "speed_kmh": "speeds",
    "horizon": "horizon",
    "tags": "tags",
    "unit": "units",
    "pictures": "pictures",
}
"""Contents of a table, by a column of it."""
FRAMES_LABEL: Final = "Evaluated frames (list, one number a line)"
FRAMES_HELP: Final = (
    "Only for a single recording of which some frames were annotated, and where the ground truth "
    "does not tell which: a text file with the numbers of these frames. Without it every frame "
    "from the first to the last annotated one is evaluated, or every n-th where they lie regularly."
)
MOST_BYTES: Final = 100 << 20
"""Size limit of a list: ten million frames with numbers of eight digits."""
T = TypeVar("T")


@dataclass(frozen=True)
class RecordingsTable:
    """Table of recordings: its path as a session names it, and its rows by recording.

    The path is None if there is no table, or if it cannot be used. `trouble` is the reason.
    """

    path: str | None = None
    entries: Mapping[str, RecordingEntry] = field(default_factory=dict)
    trouble: str = ""
    line_of: Mapping[str, int] = field(default_factory=dict)

    @property
    def file(self) -> RecordingsFile | None:
        """Table as a session names it."""
        return None if self.path is None else RecordingsFile(self.path)

    def known(self, recordings: Iterable[str]) -> set[str]:
        """Return the facts (``size``, ``fps``) that the table states for all recordings."""
        names = list(recordings) or list(self.entries)
        rows = [self.entries.get(name, RecordingEntry(name)) for name in names]
        if len(names) == len(self.entries) == 1:  # whatever its name
            rows = list(self.entries.values())
        is_known = {
            "size": all(row.width is not None and row.height is not None for row in rows),
            "fps": all(row.fps is not None for row in rows),
        }
        return {fact for fact in is_known if is_known[fact] and rows}


@dataclass(frozen=True)
class ChosenPictures:
    """Pictures of a form that can be opened, by label, and why nothing is opened yet."""

    usable: Mapping[str, Path]
    stops: str = ""


def _read(
    chosen: Chosen, read: Callable[[str], T], expected: str, most_bytes: float = np.inf
) -> T | str:
    """Read a small file, cached until it changes. Return a text if it cannot be used.

    Parameters
    ----------
    expected
        Expectation to report if it is not a file, or is larger than `most_bytes`.
    """
    if chosen.trouble:
        return chosen.trouble
    path = chosen.paths[0]
    file = chosen.folder / path
    try:
        status = file.stat()
    except OSError as error:
        return f"cannot be opened ({error.strerror})"
    if not file.is_file() or status.st_size > most_bytes:
        return f"expected {expected}"

    def read_or_refuse() -> T | str:
        try:
            return read(path)
        except NvcoreError as error:
            return error_text(error)

    key = (str(file), status.st_mtime_ns, status.st_size)
    return state.workspace().cached(expected, key, read_or_refuse)


def draw_recordings(
    chosen: Chosen, recordings: Sequence[str] = (), pictures: Collection[str] = ()
) -> RecordingsTable:
    """Read a table of recordings and show its content, or why it cannot be used.

    Parameters
    ----------
    recordings
        Recordings of the ground truth, if known. The table may not have others.
    pictures
        Names of the pictures that were chosen.
    """
    if chosen.is_empty:
        return RecordingsTable()

    def read(path: str) -> RecordingsTable:
        rows = recordings_confined(chosen.folder / path, path)
        entries = {name: entry for name, (_, entry) in rows.items()}
        return RecordingsTable(path, entries, line_of={name: n for name, (n, _) in rows.items()})

    found = _read(chosen, read, "a CSV file with a line for each recording")
    table = RecordingsTable(trouble=found) if isinstance(found, str) else found
    others = [name for name in table.line_of if recordings and name not in recordings]
    if others:
        reason = no_such_recording(others[0], recordings)
        where = f"{Path(table.path or '').name}, line {table.line_of[others[0]]}"
        table = RecordingsTable(trouble=f"{where}: {reason}")
    if table.trouble:
        st.error(plain(table.trouble), icon=":material/error:")
        return table
    rows = table.entries.values()
    parts = [
        words
        for column, words in _PARTS.items()
        if any(getattr(entry, column) not in (None, ()) for entry in rows)
    ]
    content = f": {listed(parts)}" if parts else ""
    st.caption(f"Read as {count_text(len(rows), 'recording')}{content}.")
    names = {PurePosixPath(entry.pictures).name for entry in rows if entry.pictures}
    missing = sorted(name for name in names if not {name, safe_name(name)} & {*pictures})
    if missing:
        st.warning(
            "The table names pictures that were not sent: "
            f"{plain(listed(missing, most=MOST_NAMED))}. Send them under “Pictures”; the "
            "numbers need none.",
            icon=":material/warning:",
        )
    return table


def draw_frame_list(chosen: Chosen, recordings: Sequence[str]) -> Chosen:
    """Read a list of frames and show its content, or why it cannot be used."""
    if chosen.is_empty:
        return chosen

    def read(path: str) -> tuple[str]:
        frames = frames_confined(path, chosen.folder)
        steps = np.diff(frames)
        summary = f"{len(frames):,} frames, {frames[0]} to {frames[-1]}"
        if len(steps) and steps[0] > 1 and (steps == steps[0]).all():
            summary += f", {steps[0]} apart"
        return (summary,)

    found = _read(chosen, read, "a text file with one frame number a line", MOST_BYTES)
    trouble = found if isinstance(found, str) else ""
    if not trouble and len(recordings) > 1:
        trouble = (
            f"is of one recording, and the ground truth has {len(recordings):,}: give the list of "
            "each recording in a session file, as frames under its [[recording]]"
        )
    if trouble:
        st.error(plain(trouble), icon=":material/error:")
        return replace(chosen, paths=(), trouble=trouble)
    st.caption(f"Read as {plain(found[0])}.")
    return chosen


def draw_pictures(
    place: str, paths: Mapping[str, Path], recordings: Sequence[str], refused: Sequence[str] = ()
) -> ChosenPictures:
    """Show why pictures cannot be used, and ask whether to go on without those.

    Files that were `refused` were not even taken.
    """
    checks = {label: check_pictures(path) for label, path in paths.items()}
    usable = {label: path for label, path in paths.items() if not checks[label].trouble}
    troubles = [
        *refused,
        *(f"{label}: {check.trouble}" for label, check in checks.items() if check.trouble),
    ]
    if recordings and usable:
        _draw_matches(usable, recordings)
    if not troubles:
        return ChosenPictures(usable)
    text = "\n".join(f"- {plain(trouble)}" for trouble in troubles)
    st.error(f"These pictures were refused:\n{text}", icon=":material/error:")
    goes_on = st.checkbox(
        "Go on without the refused pictures",
        key=f"without_{place}_{hash(tuple(troubles))}",
        help="Pictures are not needed for the numbers: boxes are then drawn on an empty frame.",
    )
    stops = (
        "Some pictures were refused; the reason stands at their field. Remove them and choose "
        "others, or tick “Go on without the refused pictures” there."
    )
    return ChosenPictures(usable, "" if goes_on else stops)


def _draw_matches(usable: Mapping[str, Path], recordings: Sequence[str]) -> None:
    """Show which pictures belong to which recording."""
    whose = guess_pictures(recordings, usable)
    if taken := [f"{label} for {name}" for name, label in whose.items() if len(recordings) > 1]:
        st.caption(f"By their names: {plain(listed(taken, most=MOST_NAMED))}.")
    left = [label for label in usable if label not in whose.values()]
    if left:
        st.caption(
            f"Of no recording by their names: {plain(', '.join(left))}. After opening, choose "
            "whose they are in the table “Recordings”."
        )
