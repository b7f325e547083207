"""Access rules for the server's files, and names of files from a browser.

Visitors cannot reach the server's own files, except those below one optional folder, given by
``nvcore app --local-root DIR`` (``streamlit run app.py -- --local-root DIR``) or
``NVCORE_LOCAL_ROOT=DIR``.
"""

from __future__ import annotations

import glob
import os
import re
import unicodedata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import islice, takewhile
from pathlib import Path, PurePosixPath
from typing import Final

from nvcore.common.errors import InputError, SessionError
from nvcore.common.file_kinds import as_stored, composed, suffix_of, unpacked_name
from nvcore.common.wording import one_line
from nvcore.inputs.files.find import ANNOTATION_ENDINGS
from nvcore.inputs.files.patterns import matching
from nvcore.inputs.session import Session
from nvcore.pictures.open import is_below
from ui.settings.start import argument

ENVIRONMENT: Final = "NVCORE_LOCAL_ROOT"
FLAG: Final = "--local-root"
MOST_ENTRIES: Final = 2000
"""Largest number of entries listed of a folder."""
MOST_COMPARED: Final = 50
"""Largest number of subfolders in which files of the same kind are looked for."""
MAX_NAME_BYTES: Final = 120
_UNSAFE = re.compile(r'[<>:"/\\|?*\x00-\x1f\x7f]')


def safe_name(name: str, *, keep: str = "") -> str:
    """Return the base name without characters that are special to a file system.

    Examples
    --------
    >>> safe_name("../../etc/passwd")
    'passwd'
    >>> safe_name("..")
    'file'
    """
    base = re.split(r"[/\\]", name)[-1]
    base = unicodedata.normalize("NFC", base.encode("utf-8", "replace").decode())
    base = _UNSAFE.sub(lambda sign: sign[0] if sign[0] in keep else "_", base)
    base = "".join(sign if sign.isprintable() else "_" for sign in base)
    base = base.strip(" .")  # a leading dot would hide it
    stem, dot, suffix = base.rpartition(".")
    if not dot or len(suffix) > 10:
        stem, dot, suffix = base, "", ""
    room = MAX_NAME_BYTES - len((dot + suffix).encode())
    stem = stem.encode()[:room].decode("utf-8", "ignore").strip(" .")
    return f"{stem}{dot}{suffix}" if stem else "file"


def free_name(name: str, names_in_use: Iterable[str]) -> str:
    """Return the name, with the first free number if it is taken: ``gt-2.txt.gz``."""
    in_use = {other.casefold() for other in names_in_use}
    stem = PurePosixPath(unpacked_name(name)).stem
    suffix = name[len(stem) :]
    number, free = 1, name
    while free.casefold() in in_use:
        number += 1
        free = f"{stem}-{number}{suffix}"
    return free


@dataclass(frozen=True)
class Entry:
    """File or folder. Its path is relative to the root, with ``/`` between its parts."""

    path: str
    is_folder: bool


class LocalRoot:
    """Folder that may be browsed. Nothing outside it is listed or read, even through links."""

    def __init__(self, folder: Path):
        """Open a folder for browsing.

        Raises
        ------
        InputError
            If there is no such folder.
        """
        self.folder = Path(os.path.realpath(folder))
        if not self.folder.is_dir():
            raise InputError(f"{FLAG}: there is no such folder", file=folder.name)

    def find(self, path: str) -> Path:
        """Resolve a path below the root.

        Raises
        ------
        InputError
            If it leaves the root, or does not exist.
        """
        text = path.replace("\0", "")
        target = Path(os.path.realpath(self.folder / text.lstrip("/")))
        if not target.is_relative_to(self.folder) or not target.exists():
            # one message for both: it must not reveal what is outside
            raise InputError("there is no such file or folder", file=one_line(path))
        return target

    def matches(self, path: str) -> list[str]:
        """Return a path below the root, or those below it that match a pattern, without ``**``.

        Raises
        ------
        InputError
            If there is none.
        """
        try:
            self.find(path)
        except InputError:
            if not glob.has_magic(path) or {"..", "**", "/"} & {*PurePosixPath(path).parts}:
                raise
            names = matching(path, self.folder)
            if names := [name for name in names if is_below(self.folder / name, self.folder)]:
                return names
            raise
        return [path]

    def entries(self, path: str = "") -> list[Entry]:
        """Return the entries of a folder below the root, folders first, without hidden ones.

        Raises
        ------
        InputError
            If there is no such folder, or it cannot be read.
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

    def patterns(self, path: str = "") -> tuple[list[str], list[str]]:
        """Return patterns of what subfolders of a folder share, such as one for each recording.

        The first are of annotation files (``night/*/gt/gt.txt``), the second of folders with other
        files (``night/*/img1``). Only the first `MOST_COMPARED` subfolders are compared.
        """
        shared: dict[tuple[str, str], list[list[str]]] = {}
        for top in [entry.path for entry in self.entries(path) if entry.is_folder][:MOST_COMPARED]:
            for place in ("", *_inside(self.folder / top, are_folders=True)):
                by_ending: dict[str, list[str]] = {}
                for name in _inside(self.folder / top / place, are_folders=False):
                    is_text = suffix_of(PurePosixPath(name)) in ANNOTATION_ENDINGS
                    stem = PurePosixPath(unpacked_name(name)).stem
                    by_ending.setdefault(name[len(stem) :] if is_text else "", []).append(name)
                for ending, names in by_ending.items():
                    shared.setdefault((place, ending), []).append(names)
        patterns: tuple[list[str], list[str]] = [], []
        for (place, ending), names_of in shared.items():
            is_same = len(names_of[0]) == 1 and names_of.count(names_of[0]) == len(names_of)
            if len(names_of) > 1 and (place or (is_same and ending)):
                last = (names_of[0][0] if is_same else f"*{ending}") if ending else ""
                parts = (glob.escape(path), "*", glob.escape(place), last)
                patterns[not ending].append("/".join(filter(None, parts)))
        return patterns

    def walk(self, most: int) -> Iterator[tuple[str, list[str]]]:
        """Yield at most `most` folders, nearest first, each with the paths of its files.

        Folders that cannot be read are skipped.
        """
        folders = [""]
        for folder in islice(folders, most):  # the list grows in the loop
            try:
                entries = self.entries(folder)
            except InputError:
                continue
            folders += [entry.path for entry in entries if entry.is_folder]
            yield folder, [entry.path for entry in entries if not entry.is_folder]


def _inside(folder: Path, *, are_folders: bool) -> list[str]:
    """Return the names of files, or of folders that are no links. None if it is unreadable."""
    try:
        with os.scandir(folder) as found:
            return sorted(
                entry.name
                for entry in found
                if entry.is_dir(follow_symlinks=False) == are_folders
                and not entry.name.startswith(".")
                and _is_utf8(entry.name)
            )
    except OSError:
        return []


def _is_utf8(name: str) -> bool:
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def check_confined(session: Session, root: Path) -> None:
    """Refuse a session that would read outside a folder, even through links.

    Raises
    ------
    SessionError
        If one of its paths leaves the folder.
    """
    real_root = os.path.realpath(root)
    for text in session.paths():
        path = as_stored(session.folder / text)
        # os.path: Path.exists raises for names that are too long; they are refused when opened
        if glob.has_magic(text) and not os.path.exists(path):  # noqa: PTH110
            start = as_stored(Path(*takewhile(lambda part: not glob.has_magic(part), path.parts)))
            # checked first: matching a pattern outside would already reveal files
            is_inside = Path(os.path.realpath(start)).is_relative_to(real_root) and all(
                is_below(session.folder / name, root) for name in matching(text, session.folder)
            )
            if is_inside and start == path.parent and start.is_dir():
                # pictures also match with accents composed differently
                is_inside = all(
                    is_below(file, root)
                    for file in start.iterdir()
                    if fnmatchcase(composed(file.name), composed(path.name))
                )
        else:
            is_inside = is_below(path, root)
        if not is_inside:
            raise SessionError(
                f"names {PurePosixPath(text).name!r}, which lies outside the folder that the app "
                "may read; put it there, or start the app with a folder that holds all files"
            )


def local_root() -> LocalRoot | None:
    """Return the folder given at start, or None if the server's files are out of reach.

    Raises
    ------
    InputError
        If there is no such folder.
    """
    folder = argument(FLAG, ENVIRONMENT)
    return LocalRoot(Path(folder)) if folder else None
