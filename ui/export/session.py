"""The session and the findings as they may leave the machine: without its paths.

A session is written with paths that start beside the file. Where the inputs lie in folders of
their owner (the sample, the local root) those are kept. Uploads lie in a temporary folder: they
are written as bare file names, as their sender knows them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Set
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Final, TypeVar

from nvcore.findings import Finding
from nvcore.inputs.readers.meaning.names import NEUTRAL
from nvcore.inputs.session import Session, Source, SystemSource, is_frame_range
from ui.session.opening import relative_path
from ui.session.uploads import ANNOTATION_FOLDERS
from ui.session.workspace import PICTURES

BESIDE: Final = Path()
"""Folder of a session that is written with relative paths."""
OWN_FOLDER: Final = "data"
"""Folder for files that need one; the readers name no recording after it."""

AnySource = TypeVar("AnySource", Source, SystemSource)


def portable_session(
    session: Session, *, is_upload: bool, recordings: Iterable[str] = ()
) -> Session:
    """The session with paths relative to its own place.

    Parameters
    ----------
    is_upload
        Whether the inputs lie in the session's folder for uploads. Files are then named by their
        base name, in a folder ``data`` where two have the same.
    recordings
        Names of the recordings in the data. One that is named after its file, ``gt``, would be
        named after the surrounding folder elsewhere: the folder ``data`` keeps its name.
    """
    if not is_upload:
        return _renamed(session, lambda path: relative_path(session.folder / path, session.folder))
    return _renamed(session, _names_of_uploads(session, set(recordings)).__getitem__)


def inputs_beside(portable: Session) -> list[str]:
    """What has to lie beside the written session, in its words; pictures are not needed."""
    pictures = {facts.pictures for facts in portable.recordings}
    return [path for path in dict.fromkeys(portable.paths()) if path not in pictures]


def public_findings(
    findings: Iterable[Finding], public: Callable[[object], str]
) -> tuple[Finding, ...]:
    """The findings, their texts made `public`: without paths of the machine."""
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


def _renamed(session: Session, name: Callable[[str], str]) -> Session:
    def of_source(source: AnySource) -> AnySource:
        return replace(source, path=tuple(name(path) for path in source.path))

    def of_frames(frames: str | None) -> str | None:
        return frames if frames is None or is_frame_range(frames) else name(frames)

    return replace(
        session,
        folder=BESIDE,
        truth=of_source(session.truth),
        systems=tuple(of_source(system) for system in session.systems),
        recordings=tuple(
            replace(
                facts,
                frames=of_frames(facts.frames),
                pictures=None if facts.pictures is None else name(facts.pictures),
            )
            for facts in session.recordings
        ),
        frames=of_frames(session.frames),
    )


def _names_of_uploads(session: Session, recordings: Set[str]) -> Mapping[str, str]:
    """Name of each path of a session of uploads: the shortest that is its own."""
    spellings = {path: _spellings(path) for path in session.paths()}
    for path in (path for source in _sources(session) for path in source.path):
        stem = PurePosixPath(path).stem
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
    """Base name, path below the form's field, and the same in a folder of the field's own."""
    parts = PurePosixPath(path).parts
    if PICTURES in parts and parts[0] == "..":
        inside, field = parts[parts.index(PICTURES) + 1 :], PICTURES
    else:
        below = 1 + len(ANNOTATION_FOLDERS.parts)
        inside, field = parts[below:] or parts[-1:], parts[0]
    return parts[-1], "/".join(inside), "/".join((OWN_FOLDER, field, *inside))


def _sources(session: Session) -> tuple[Source, ...]:
    return session.truth, *session.systems
