"""Data page: a table of the recordings (CSV) with what the other files do not say of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.inputs.recordings_file import read_recordings_file
from nvcore.inputs.session import RecordingEntry, RecordingsFile
from nvcore.wording import count_text, listed
from ui.data.file_check import read_unless_known
from ui.widgets.text import plain

RECORDINGS_LABEL: Final = "Recordings (table, one line each)"
RECORDINGS_HELP: Final = (
    "A CSV file with the columns recording, width, height, fps, context, tags and pictures; all "
    "but the first may be missing. Context is that of the traffic: urban, rural, or a number from "
    "0 to 1. Tags are separated by semicolons; pictures are names of files or folders."
)
_PARTS: Final = {
    "width": "sizes",
    "fps": "frame rates",
    "context": "traffic context",
    "tags": "tags",
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
        rows = read_recordings_file(file, path)
        return RecordingsTable(path, {name: entry for name, (_, entry) in rows.items()})

    return read_unless_known(
        "recordings_table",
        file,
        read,
        lambda trouble: RecordingsTable(trouble=trouble),
        expected="a CSV file with a line for each recording",
    )


def draw_recordings(table: RecordingsTable) -> RecordingsTable:
    """What the table says, or why it cannot be used."""
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
    return table
