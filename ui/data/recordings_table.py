"""Data page: a table of the recordings (CSV) with what the other files do not say of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Final

import streamlit as st

from nvcore.inputs.recordings import no_such_recording
from nvcore.inputs.session import RecordingEntry, RecordingsFile
from nvcore.wording import MOST_NAMED, count_text, listed
from ui.access.files import safe_name
from ui.confined.reading import recordings_confined
from ui.data.file_check import read_unless_known
from ui.widgets.text import plain

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
"""What a table says, by a column of it."""


@dataclass(frozen=True)
class RecordingsTable:
    """A table of recordings, by its path as a session names it, and its rows by recording.

    Without a path there is none, or it cannot be used for the reason that `trouble` gives.
    """

    path: str | None = None
    entries: Mapping[str, RecordingEntry] = field(default_factory=dict)
    trouble: str = ""
    line_of: Mapping[str, int] = field(default_factory=dict)

    @property
    def stops(self) -> str:
        """Why nothing is opened yet; empty: no reason."""
        if not self.trouble:
            return ""
        return "The table of recordings cannot be used: the reason stands at its field."

    @property
    def file(self) -> RecordingsFile | None:
        """As a session holds it."""
        return None if self.path is None else RecordingsFile(self.path)

    def known(self, recordings: Iterable[str]) -> set[str]:
        """Which of ``size`` and ``fps`` it says of all recordings."""
        names = list(recordings) or list(self.entries)
        rows = [self.entries.get(name, RecordingEntry(name)) for name in names]
        if len(names) == len(self.entries) == 1:  # whatever it is called
            rows = list(self.entries.values())
        is_known = {
            "size": all(row.width is not None and row.height is not None for row in rows),
            "fps": all(row.fps is not None for row in rows),
        }
        return {fact for fact in is_known if is_known[fact] and rows}


def check_recordings(path: str, folder: Path) -> RecordingsTable:
    """Read a table that a session in `folder` names, unless it was read and has not changed."""
    file = folder / path

    def read() -> RecordingsTable:
        rows = recordings_confined(file, path)
        entries = {name: entry for name, (_, entry) in rows.items()}
        return RecordingsTable(path, entries, line_of={name: n for name, (n, _) in rows.items()})

    return read_unless_known(
        "recordings_table",
        file,
        read,
        lambda trouble: RecordingsTable(trouble=trouble),
        expected="a CSV file with a line for each recording",
    )


def draw_recordings(
    table: RecordingsTable, recordings: Sequence[str] = (), pictures: Iterable[str] | None = None
) -> RecordingsTable:
    """What the table says, or why it cannot be used.

    Parameters
    ----------
    recordings
        Of the ground truth, if it is known: the table may have no others.
    pictures
        Names of the pictures that were sent: the table may name others in vain; None: any.
    """
    others = [name for name in table.line_of if recordings and name not in recordings]
    if others and not table.trouble:
        reason = no_such_recording(others[0], recordings)
        where = f"{Path(table.path or '').name}, line {table.line_of[others[0]]}"
        table = RecordingsTable(trouble=f"{where}: {reason}")
    if table.trouble:
        st.error(plain(table.trouble), icon=":material/error:")
    elif table.path is not None:
        parts = [
            words
            for column, words in _PARTS.items()
            if any(getattr(entry, column) not in (None, ()) for entry in table.entries.values())
        ]
        content = f": {listed(parts)}" if parts else ""
        st.caption(f"Read as {count_text(len(table.entries), 'recording')}{content}.")
        _draw_missing(table, pictures)
    return table


def _draw_missing(table: RecordingsTable, pictures: Iterable[str] | None) -> None:
    """Which pictures of the table were not sent."""
    if pictures is None:
        return
    names = {
        PurePosixPath(entry.pictures).name for entry in table.entries.values() if entry.pictures
    }
    sent = {*pictures}  # under safe names
    missing = sorted(name for name in names if not {name, safe_name(name)} & sent)
    if missing:
        st.warning(
            "The table names pictures that were not sent: "
            f"{plain(listed(missing, most=MOST_NAMED))}. Send them under “Pictures”; the "
            "numbers need none.",
            icon=":material/warning:",
        )
