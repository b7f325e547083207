"""Session and findings without paths of this machine, for sharing.

A session is written with paths relative to its file. Inputs in folders of their owner (the sample,
the local root) keep these folders. The start session may name files anywhere, which keep as much of
their paths as distinguishes them. Uploads are in a temporary folder, and are written as bare file
names, as their sender knows them.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Iterable, Mapping, Set
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Final

from nvcore.common.file_kinds import unpacked_name
from nvcore.common.findings import Finding
from nvcore.comparison.compare import Result
from nvcore.inputs.facts import paths_in
from nvcore.inputs.readers.meaning.names import NEUTRAL
from nvcore.inputs.session import Session
from ui.session.opening import relative_path
from ui.session.uploads import ANNOTATION_FOLDERS
from ui.session.workspace import PICTURES

BESIDE: Final = Path()
"""Folder of a session that is written with relative paths."""
OWN_FOLDER: Final = "data"
"""Folder for files that need one. Readers name no recording after it."""


def portable_session(
    session: Session, *, is_upload: bool, recordings: Iterable[str] = (), root: Path | None = None
) -> Session:
    """Return the session with paths relative to its own folder.

    Parameters
    ----------
    is_upload
        Whether the inputs are in the session's folder for uploads. Files then get their base name,
        in a folder ``data`` if two have the same.
    recordings
        Names of the recordings in the data. A recording named after its file ``gt`` would elsewhere
        be named after the surrounding folder, so the folder ``data`` keeps its name.
    root
        Folder that the visitor may browse, with links resolved. Files below it keep their folders.
    """
    if not is_upload:
        names_here = _names_of_files(session, root)
        return session.with_paths(names_here.__getitem__, folder=BESIDE)
    names = _names_of_uploads(session, set(recordings))
    return session.with_paths(names.__getitem__, folder=BESIDE)


def inputs_beside(portable: Session, given: Container[str] = ()) -> list[str]:
    """Return the files that must be beside the written session, without pictures.

    Parameters
    ----------
    given
        Names of files that are delivered with it.
    """
    entries = [replace(entry, speed=None) for entry in portable.recordings]
    of_view = {path for entry in entries for path in paths_in(entry)}
    names = dict.fromkeys(portable.paths())
    return [path for path in names if path not in of_view and path not in given]


def public_findings(
    findings: Iterable[Finding], public: Callable[[object], str]
) -> tuple[Finding, ...]:
    """Return findings with `public` texts, without paths of this machine."""
    return tuple(
        replace(
            finding,
            message=public(finding.message),
            advice=public(finding.advice),
            file=public(finding.file),
            example=public(finding.example),
        )
        for finding in findings
    )


def with_public_names(result: Result, public: Callable[[object], str]) -> Result:
    """Return the result with `public` names of its input files, for tables that show them."""
    inputs = result.dataset.inputs
    inputs = inputs.assign(file=[public(name) for name in inputs["file"]])
    return replace(result, dataset=replace(result.dataset, inputs=inputs))


def _names_of_files(session: Session, root: Path | None) -> dict[str, str]:
    """Map each path to its name, relative to the session's folder if that reveals no other folder.

    An absolute path outside, and outside the local root, is named by its last parts.
    """
    start = session.folder
    names = {path: relative_path(start / path, start) for path in session.paths()}
    outside = {
        path: Path(path).parts[1:]
        for path in names
        if Path(path).is_absolute()
        and not Path(path).is_relative_to(start)
        and not (root is not None and Path(os.path.realpath(path)).is_relative_to(root))
    }
    shown = {name.casefold() for path, name in names.items() if path not in outside}
    for n_parts in range(1, 1 + max(map(len, outside.values()), default=0)):
        tails = {path: "/".join(parts[-n_parts:]) for path, parts in outside.items()}
        folded = {tail.casefold() for tail in tails.values()}
        if len(folded) == len(tails) and not folded & shown:
            break
    return names | (tails if outside else {})


def _names_of_uploads(session: Session, recordings: Set[str]) -> Mapping[str, str]:
    """Map each path in a session of uploads to its shortest unique name."""
    spellings = {path: _spellings(path) for path in session.paths()}
    for path in (path for source, _ in session.sources for path in source.path):
        stem = PurePosixPath(unpacked_name(path)).stem
        if stem in recordings and stem.lower() in NEUTRAL:
            spellings[path] = spellings[path][-1:] * 3
    name_of: dict[str, str] = {}
    for path, names in spellings.items():
        others = [theirs for other, theirs in spellings.items() if other != path]
        own = [
            name
            for level, name in enumerate(names)
            if name.casefold() not in {theirs[level].casefold() for theirs in others}
        ]
        name_of[path] = (own or names[-1:])[0]
    return name_of


def _spellings(path: str) -> tuple[str, ...]:
    """Return base name, path below the form's field, and the same in the field's folder."""
    parts = PurePosixPath(path).parts
    first, *_ = ANNOTATION_FOLDERS.parts
    if first in parts:
        place = parts.index(first)
        inside = parts[place + len(ANNOTATION_FOLDERS.parts) :] or parts[-1:]
        field = parts[place - 1].lstrip("0123456789-")
    else:
        inside, field = parts[parts.index(PICTURES) + 1 :] if PICTURES in parts else parts, PICTURES
    return parts[-1], "/".join(inside), "/".join((OWN_FOLDER, field, *inside))
