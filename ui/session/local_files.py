"""Access to the server's own files: below one folder, and only if enabled.

Either ``nvcore app --local-root DIR`` (``streamlit run app.py -- --local-root DIR``) or
``NVCORE_LOCAL_ROOT=DIR`` names it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from nvcore.errors import InputError
from nvcore.wording import one_line
from ui.settings.start import argument

ENVIRONMENT: Final = "NVCORE_LOCAL_ROOT"
FLAG: Final = "--local-root"
MOST_ENTRIES: Final = 2000
"""Entries of one folder that are listed."""


@dataclass(frozen=True)
class Entry:
    """A file or folder; its path is relative to the root, with ``/`` between its parts."""

    path: str
    is_folder: bool


class LocalRoot:
    """The folder that may be browsed; nothing outside it is listed or read, even through links."""

    def __init__(self, folder: Path):
        """Take the folder.

        Raises
        ------
        InputError
            If there is no such folder.
        """
        self.folder = Path(os.path.realpath(folder))
        if not self.folder.is_dir():
            raise InputError(f"{FLAG}: there is no such folder", file=folder.name)

    def find(self, path: str) -> Path:
        """Where a path below the root leads.

        Raises
        ------
        InputError
            If it leaves the root, or leads nowhere.
        """
        text = path.replace("\0", "")
        target = Path(os.path.realpath(self.folder / text.lstrip("/")))
        if not target.is_relative_to(self.folder) or not target.exists():
            # one message for both: it must not reveal what is outside
            raise InputError("there is no such file or folder", file=one_line(path))
        return target

    def entries(self, path: str = "") -> list[Entry]:
        """Entries of a folder below the root, folders first, without hidden ones.

        Raises
        ------
        InputError
            If there is no such folder, or it may not be looked into.
        """
        folder = self.find(path)
        try:
            with os.scandir(folder) as files:
                names = sorted(file.name for file in files if not file.name.startswith("."))
        except OSError as error:
            raise InputError(f"cannot be opened ({error.strerror})", file=one_line(path)) from error
        listed = []
        for name in names[:MOST_ENTRIES]:
            real = Path(os.path.realpath(folder / name))
            if real.is_relative_to(self.folder) and _is_utf8(name):
                place = f"{path.strip('/')}/{name}".lstrip("/")
                listed.append(Entry(place, real.is_dir()))
        return sorted(listed, key=lambda entry: not entry.is_folder)


def _is_utf8(name: str) -> bool:
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def local_root(
    arguments: Sequence[str] | None = None, environment: Mapping[str, str] | None = None
) -> LocalRoot | None:
    """The folder given at start; None if the server's files are out of reach.

    Raises
    ------
    InputError
        If there is no such folder.
    """
    folder = argument(FLAG, ENVIRONMENT, arguments, environment)
    return LocalRoot(Path(folder)) if folder else None
