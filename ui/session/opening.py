"""Turns the choices on the Data page into a `Session`.

Paths in a session name files of the machine, so visitors must not control them. The paths of an
uploaded session file are looked up by name among the files sent with it. Those of a session under
the local root are checked to stay there.
"""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from typing import Final, TypeVar

from nvcore.common.errors import InputError, SessionError
from nvcore.common.file_kinds import composed
from nvcore.common.findings import Finding
from nvcore.dataset import Dataset
from nvcore.inputs.facts import FRAME_RANGE, is_frame_range, with_paths_in
from nvcore.inputs.files.find import NAME_PARTS
from nvcore.inputs.readers.meaning.names import recording_of
from nvcore.inputs.session import RecordingEntry, RecordingsFile, Session, Source, SystemSource
from ui.access.files import safe_name
from ui.confined.reading import (
    load_confined,
    read_confined,
    session_confined,
    with_recordings_confined,
)
from ui.session.uploads import ANNOTATION_FOLDERS
from ui.session.workspace import Workspace, opened_by_others
from ui.settings.limits import limits_of_environment

_OF_UPLOADS: Final = re.compile(
    r"(?<![\w.-])(?:(?:\.\./)*upload-\d+/)?(?:\d+-\w+/)?" + re.escape(f"{ANNOTATION_FOLDERS}/")
)
"""Upload folders in front of a file's name."""
SHOWN_FOLDERS: Final = NAME_PARTS - 1
"""Largest number of folders that readers show in front of a file's name."""

AnySource = TypeVar("AnySource", Source, SystemSource)


def checked_frames(text: str) -> str | None:
    """Return a form's frame list, or None if it is empty.

    Raises
    ------
    SessionError
        If it is not a range. A form must not name files of the machine.
    """
    if not text.strip():
        return None
    if not is_frame_range(text):
        raise SessionError(f"evaluated frames: expected {FRAME_RANGE}, got {text!r}")
    return text.strip()


def recording_names(session: Session) -> list[str]:
    """Read the ground truth and return the names of its recordings.

    Raises
    ------
    InputError
        If the ground truth cannot be used.
    """
    truth = read_confined(
        session.truth,
        role="truth",
        folder=session.folder,
        size=session.common_size,
        objects=session.objects,
    )
    names: list[str] = truth.recordings["name"].tolist()
    return names


def names_in_files(session: Session, whole: Dataset) -> dict[str, str]:
    """Return the names of recordings in the files, by their names on the pages."""
    names = whole.recordings["name"].tolist()
    entries = session.entries(names)
    return {name: entries[name].name if name in entries else name for name in names}


def load_for(space: Workspace, session: Session) -> Dataset:
    """Load a session within the server's limits.

    Raises
    ------
    NvcoreError
        If it cannot be read, or exceeds a limit.
    """
    dataset = load_confined(session)
    most = limits_of_environment().max_frames_of_all
    n_others = sum(len(other.whole.frames) for other in opened_by_others(space))
    if n_others + len(dataset.frames) > most:
        raise InputError(
            f"all visitors together may have {most:,} frames open; close what you do not need in "
            "other tabs, or try again later"
        )
    return dataset


def uploaded_session(
    content: bytes, folder: Path, files: Sequence[str], pictures: Sequence[Path]
) -> Session:
    """Return the session of an uploaded session file, using the files sent with it.

    The paths in `files` are relative to `folder`. A recording whose pictures were not sent has none
    (see `with_uploaded_recordings`).

    Raises
    ------
    SessionError
        If it cannot be read, or names a file that was not sent.
    """
    place = folder / "session.toml"
    place.write_bytes(content)
    try:
        session = session_confined(place)
    finally:
        place.unlink()  # already read, and not counted against the quota
    sent = _Sent(folder, files)
    table = session.recordings_file
    session = with_recordings_confined(
        replace(
            session,
            folder=folder,
            truth=sent.matches(session.truth),
            systems=tuple(map(sent.matches, session.systems)),
            recordings_file=table and RecordingsFile(sent.file(table.path)),
        )
    )
    shown = [_uploaded_pictures(entry.pictures, pictures, folder) for entry in session.recordings]
    bare = [
        replace(entry, pictures=None, visible=None, visible_map=None)
        for entry in session.recordings
    ]
    session = replace(session, recordings=tuple(bare)).with_paths(sent.file, folder=folder)
    entries = zip(session.recordings, shown, strict=True)
    return replace(
        session, recordings=tuple(replace(entry, pictures=path) for entry, path in entries)
    )


def with_uploaded_recordings(session: Session, pictures: Sequence[Path]) -> Session:
    """Read the session's table of recordings, and keep only pictures that were uploaded.

    All other files that it names for recordings were not sent, and are left out.

    Parameters
    ----------
    pictures
        Uploaded pictures. The first one wins if several have the same name.

    Raises
    ------
    InputError
        If the table cannot be used.
    """
    session = with_recordings_confined(session)
    entries = tuple(
        replace(
            with_paths_in(entry, lambda _: None),
            pictures=_uploaded_pictures(entry.pictures, pictures, session.folder),
            visible_map=None,
        )
        for entry in session.recordings
    )
    return replace(session, recordings=entries)


class _Sent:
    """Finds the files that a session names among those uploaded with it."""

    def __init__(self, folder: Path, files: Sequence[str]):
        self.paths: list[PurePosixPath] = []
        for name in files:
            path = folder / name
            inside = sorted(path.rglob("*")) if path.is_dir() else []
            self.paths += [
                PurePosixPath(file.relative_to(folder).as_posix()) for file in (path, *inside)
            ]

    def matches(self, source: AnySource) -> AnySource:
        """Return the source with its globs replaced by files."""
        paths = [str(path) for text in source.path for path in self.find(text)]
        return replace(source, path=tuple(paths))

    def file(self, text: str) -> str:
        return str(self.find(text)[0])

    def find(self, text: str) -> list[PurePosixPath]:
        """Return the path that shares the longest ending with `text`, or all matches of a glob."""
        target = PurePosixPath(text.replace("\\", "/"))
        if target in self.paths:
            return [target]
        shared = {path: _shared_end(path, target) for path in self.paths}
        most = max(shared.values(), default=0)
        matches = [path for path, n_parts in shared.items() if n_parts == most] if most else []
        if not matches and glob.has_magic(target.name):
            pattern = safe_name(target.name, keep="*?")
            return [p for p in self.paths if fnmatchcase(p.name, pattern)] or self._none(target)
        if len(matches) > 1:
            raise SessionError(
                f"names {target.name!r}, and {len(matches)} of the files sent have that name; send "
                "them as a ZIP archive with their folders"
            )
        return matches or self._none(target)

    def _none(self, target: PurePosixPath) -> list[PurePosixPath]:
        raise SessionError(
            f"names {target.name!r}, which was not sent; choose it together with the session file"
        )


def _shared_end(sent: PurePosixPath, path: PurePosixPath) -> int:
    """Count the common trailing path parts. A part of `sent` may be the safe form of a name."""
    n_parts = 0
    for stored, wanted in zip(reversed(sent.parts), reversed(path.parts), strict=False):
        if stored not in (wanted, safe_name(wanted)):
            break
        n_parts += 1
    return n_parts


def _uploaded_pictures(text: str | None, pictures: Sequence[Path], folder: Path) -> str | None:
    name = "" if text is None else PurePosixPath(text.replace("\\", "/")).name
    sent = (path for path in pictures if name and path.name == safe_name(name))
    return next((relative_path(path, folder) for path in sent), None)


def relative_path(path: Path, folder: Path) -> str:
    """Return the path relative to the folder of a session."""
    return Path(os.path.relpath(path, folder)).as_posix()


def guess_pictures(names: Sequence[str], sources: Iterable[str]) -> dict[str, str]:
    """Guess the pictures of each recording by name.

    A source belongs to the recording with the longest name that its own name contains; ``img1`` and
    the like have the name of the folder around them. A recording with several sources gets the one
    of exactly its name, or none. If there is only one source and one recording, they belong
    together.

    Examples
    --------
    >>> guess_pictures(["night_07", "night_08"], ["night_08.mp4", "extra.mp4"])
    {'night_08': 'night_08.mp4'}
    >>> guess_pictures(["drive_1", "drive_10"], ["drive_10.mp4"])
    {'drive_10': 'drive_10.mp4'}
    >>> guess_pictures(["PETS09-S2L1"], ["vtest.avi"])
    {'PETS09-S2L1': 'vtest.avi'}
    """
    sources = list(sources)
    if len(names) == len(sources) == 1:
        return {names[0]: sources[0]}
    # composed, because macOS stores names decomposed
    stems = {source: composed(recording_of(source)).casefold() for source in sources}
    targets = {name: composed(name.replace("/", "_")).casefold() for name in names}
    matches: dict[str, list[str]] = {}
    for source, stem in stems.items():
        within = {name: len(target) for name, target in targets.items() if _is_in(target, stem)}
        best = [name for name, length in within.items() if length == max(within.values())]
        if len(best) == 1:
            matches.setdefault(best[0], []).append(source)
    guesses = {}
    for name in names:
        mine = matches.get(name, [])
        own = [source for source in mine if stems[source] == targets[name]] or mine
        if len(own) == 1:
            guesses[name] = own[0]
    return guesses


def _is_in(name: str, stem: str) -> bool:
    """Whether a file's name contains a recording's name. drive_10 does not contain drive_1."""
    start = r"(?<!\d)" if name[:1].isdigit() else ""
    end = r"(?!\d)" if name[-1:].isdigit() else ""
    return re.search(start + re.escape(name) + end, stem) is not None


def with_recordings(
    session: Session, names: Sequence[str], changes: Mapping[str, Mapping[str, object]]
) -> Session:
    """Return the session with fields of `RecordingEntry` replaced, by recording."""
    entries = session.entries(names)
    for name, change in changes.items():
        entries[name] = replace(entries.get(name, RecordingEntry(name)), **change)  # type: ignore[arg-type]
    return replace(session, recordings=tuple(entries.values()))


def recording_entry(session: Session, names: Sequence[str], name: str) -> RecordingEntry:
    """Return the session's entry for a recording."""
    return session.entries(names).get(name, RecordingEntry(name))


def corrected(session: Session, dataset: Dataset, finding: Finding) -> Session:
    """Return the session with the corrections that a finding about a system suggests."""
    systems, values = list(session.systems), dict(finding.suggestion)
    index = dataset.systems.index(finding.subject)
    system = systems[index]
    scale_x, scale_y = system.scale if "scale" not in values else (values["scale"],) * 2
    x, y = system.offset_px
    systems[index] = replace(
        system,
        frame_step=values.get("frame_step", system.frame_step),
        offset_frames=round(values.get("offset_frames", system.offset_frames)),
        scale=(values.get("scale_x", scale_x), values.get("scale_y", scale_y)),
        offset_px=(values.get("offset_x_px", x), values.get("offset_y_px", y)),
    )
    return replace(session, systems=tuple(systems))


def public_text(text: object, folders: Iterable[Path]) -> str:
    """Return a message without the server's folders. Files below these keep their names.

    Readers show only the last parts of a path, so the last parts of folders are removed as well.

    Examples
    --------
    >>> public_text("/srv/night/truth.csv, line 3: no number", [Path("/srv/night")])
    'truth.csv, line 3: no number'
    >>> public_text("srv/night/truth.csv, line 3: no number", [Path("/srv/night")])
    'truth.csv, line 3: no number'
    """
    plain_text = str(text)
    for folder in sorted(set(folders), key=lambda path: len(str(path)), reverse=True):
        parts = folder.relative_to(folder.anchor).parts
        if not parts:  # "/" and ".": every path would be below it
            continue
        whole = rf"(?<![\w.-]){re.escape(str(folder))}"
        plain_text = re.sub(rf"{whole}[/\\]+", "", plain_text)
        plain_text = re.sub(rf"{whole}(?![.+@~#%=-]*\w)", "the folder", plain_text)
        for n_parts in range(min(SHOWN_FOLDERS, len(parts)), 0, -1):
            tail = "/".join(parts[-n_parts:])
            plain_text = re.sub(rf"(?<![\w/.-]){re.escape(tail)}/", "", plain_text)
    return _OF_UPLOADS.sub("", plain_text)
