"""Find the files that the paths of a session name."""

from __future__ import annotations

import glob
import hashlib
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, takewhile
from pathlib import Path
from typing import Final

from nvcore.common.errors import InputError
from nvcore.common.file_kinds import PACKED_ENDINGS, suffix_of, unpacked_name
from nvcore.common.findings import Remedy, Step
from nvcore.common.wording import MOST_NAMED, listed
from nvcore.inputs.files.patterns import matching
from nvcore.inputs.readers import NOTHING, detect_format, format_named, holds_nothing
from nvcore.inputs.readers.base import Format, Role, SourceFile
from nvcore.inputs.readers.meaning.names import NEUTRAL
from nvcore.inputs.session import Session, Source

NAME_PARTS = 3
"""Number of path parts that are shown, enough for recording/gt/gt.txt."""

ANNOTATION_ENDINGS: Final = (".txt", ".csv", ".json", ".xml", ".tsv", ".parquet", ".pq")
"""Endings of the files of a folder that may be annotations, apart from those of compression."""
EMPTY_TRUTH: Final = (
    "the file is empty; expected ground truth with at least one box: is it the right file?"
)
EMPTY_DOCUMENT: Final = (
    "the file is empty; expected detections. A system that detected nothing has an empty text or "
    "CSV file, or an empty list ([]) in a JSON file"
)

HEAD_BYTES: Final = 4096
"""Bytes of a file that are read to recognise a list of frames."""


def find_files(source: Source, folder: Path, role: Role) -> tuple[list[SourceFile], Format]:
    """Find the files of a source and detect their format.

    A path is a file, a pipe, a glob, or a folder. A folder with MOTChallenge's layout gives
    ``*/gt/gt.txt`` (truth) or ``*/det/det.txt`` (detections), compressed or not. Any other folder
    gives all files below it with an ending of the format. If all detection files are empty, the
    system detected nothing, and the format is `NOTHING` whatever format is named.

    Raises
    ------
    InputError
        If there are no files, the ground truth is empty, or none of a path's files is of the
        format.
    UnknownFormatError
        If the format cannot be recognised.
    """
    declared = None if source.format is None else format_named(source.format)
    by_path = {text: _expand(text, folder, role, declared) for text in source.path}
    expanded = list(chain(*by_path.values()))
    for file in expanded:
        _check_name(file.path)
    files = list({file.path: file for file in expanded}.values())
    # a seqinfo.ini among the files holds facts about the recording beside it
    files = [file for file in files if file.path.name.lower() != "seqinfo.ini"] or files
    if declared is not None and role not in declared.roles:
        advice = "" if role == "detections" else "; they hold detections"
        raise InputError(f"{declared.title} files hold no {role}{advice}", file=source.path[0])
    if holds_nothing(files):
        if role == "truth":
            raise InputError(EMPTY_TRUTH, file=files[0].name)
        if suffix_of(files[0].path) in (".json", ".xml"):
            raise InputError(EMPTY_DOCUMENT, file=files[0].name)
        return files, NOTHING
    if declared is None and _is_frame_list(files):
        expected = "ground truth" if role == "truth" else "the detections of a system"
        raise InputError(
            f"expected {expected}, found a whole number on every line, as in a list of evaluated "
            "frames",
            file=files[0].name,
            steps=(Step(Remedy.FRAME_LIST),),
        )
    file_format = declared if declared is not None else detect_format(files, role)
    # a file that is named explicitly is always read, whatever folders or globs add
    stated = {folder / text for text in source.path}
    readable = [
        file
        for file in files
        if file.path in stated or suffix_of(file.path) in file_format.suffixes
    ]
    read = {file.path for file in readable}
    for text, of_path in by_path.items():
        paths = {file.path for file in of_path} & {file.path for file in files}
        if read and paths and not read & paths:
            raise InputError(
                f"no file is read: the others are {file_format.title}, and files of one source "
                "have one format",
                file=text,
            )
    return readable or files, file_format


def find_all(session: Session) -> None:
    """Look for all files that a session names.

    Raises
    ------
    InputError
        If a file does not exist.
    """
    for source, role in session.sources:
        find_files(source, session.folder, role)


def _is_frame_list(files: Sequence[SourceFile]) -> bool:
    """Whether the only file begins with lines of one whole number each."""
    if len(files) != 1:
        return False
    try:
        with files[0].open() as stream:
            head = stream.read(HEAD_BYTES)
    except InputError:  # reported when it is read
        return False
    lines = head.removeprefix(b"\xef\xbb\xbf").splitlines()
    if len(head) == HEAD_BYTES:
        lines.pop()  # cut off
    numbers = [line for line in lines if line.strip()]
    return bool(numbers) and all(re.fullmatch(rb"\s*-?\d{1,15}\s*", line) for line in numbers)


def _expand(text: str, folder: Path, role: Role, declared: Format | None) -> list[SourceFile]:
    """List the files of one path of a source: a file, a pipe, a glob or a folder."""
    path = folder / text
    try:
        is_folder, is_file = path.is_dir(), path.is_file() or path.is_fifo()
        is_other = not is_folder and not is_file and path.exists()
    except OSError as error:  # a name that is too long, or an unreadable folder
        raise InputError(f"cannot be opened ({error.strerror})", file=text) from error
    if is_folder:
        with _folders_opened(path, text):
            return _in_folder(path, text, role, declared)
    if is_file:
        return [SourceFile(path, _shown(path))]
    if is_other:
        raise InputError("is a device or a socket; expected a file or a folder", file=text)
    if glob.has_magic(text):
        matches = [folder / name for name in matching(text, folder)]
        files = [SourceFile(match, _shown(match)) for match in matches if match.is_file()]
        if files:
            return files
        start = Path(*takewhile(lambda part: not glob.has_magic(part), Path(text).parts))
        if (folder / start).is_dir():  # glob skips unreadable folders
            with _folders_opened(folder / start, start.as_posix()):
                _ = [*(folder / start).iterdir()]
        raise InputError("no file matches this pattern", file=text)
    raise InputError("there is no such file or folder", file=text)


def _in_folder(path: Path, text: str, role: Role, declared: Format | None) -> list[SourceFile]:
    """List the files of a folder (see `find_files`)."""
    parts = ("gt", "gt.txt") if role == "truth" else ("det", "det.txt")
    matches = _mot_files(path, *parts)
    if matches and (declared is None or declared.name == "mot"):
        return [SourceFile(match, _shown(match)) for match in matches]
    if role == "detections" and (declared is None or declared.name == "mot"):
        _refuse_truth_alone(path, text)
    files = [
        SourceFile(file, file.relative_to(path).as_posix()) for file in sorted(_files_below(path))
    ]
    endings = declared.suffixes if declared is not None else ANNOTATION_ENDINGS
    files = [file for file in files if suffix_of(file.path) in endings]
    notes = ("readme", "license", "classes", "index", "label_colors", "labelmap")
    files = [file for file in files if _stem(file.path).lower() not in notes] or files
    if not files:
        raise InputError(
            f"the folder holds no file that could be {role} (endings: {', '.join(endings)})",
            file=text,
        )
    return files


def _stem(path: Path) -> str:
    """Return the name of a file without its endings of format and compression."""
    return Path(unpacked_name(path.name)).stem


def _mot_files(path: Path, folder: str, name: str) -> list[Path]:
    """List files in MOTChallenge's layout of recordings in a folder, else of the folder itself."""
    with os.scandir(path) as entries:
        recordings = sorted(Path(entry) for entry in entries if entry.is_dir())
    for places in (recordings, [path]):
        files = [_plain_or_packed(place / folder, name) for place in places]
        if any(files):
            return [file for file in files if file is not None]
    return []


def _plain_or_packed(folder: Path, name: str) -> Path | None:
    try:
        if not folder.is_dir():
            return None
    except PermissionError as error:  # of the folder around it
        raise PermissionError(error.errno, error.strerror, str(folder.parent)) from error
    files = (folder / (name + ending) for ending in ("", *PACKED_ENDINGS))
    return next((file for file in files if file.is_file()), None)


def _files_below(folder: Path) -> Iterator[Path]:
    """Yield the files in a folder and its subfolders, except hidden ones."""

    def refuse(error: OSError) -> None:
        raise error

    for place, folders, names in os.walk(folder, onerror=refuse):
        folders[:] = [name for name in folders if not name.startswith(".")]
        for name in names:
            file = Path(place, name)
            if not name.startswith(".") and file.is_file():
                yield file


@contextmanager
def _folders_opened(path: Path, text: str) -> Iterator[None]:
    """Convert OSErrors about unreadable folders to InputErrors that name the folder."""
    try:
        yield
    except OSError as error:
        place = Path(error.filename or path)
        below = place.relative_to(path) if place.is_relative_to(path) else ""
        raise InputError(
            f"cannot be opened ({error.strerror})", file=(Path(text) / below).as_posix()
        ) from error


def _refuse_truth_alone(path: Path, text: str) -> None:
    """Raise InputError for a folder in MOTChallenge's layout with ground truth alone."""
    if not any(path.glob("*/gt/gt.txt*")):
        return
    others = [file for file in sorted(path.glob("*/*/*.txt")) if file.parent.name != "gt"]
    parts = others[0].relative_to(path).parts[1:] if others else ("det", "det.txt")
    pattern = "/".join((text.rstrip("/"), "*", *parts))
    there = "a pattern that matches files here" if others else "for example"
    folders = listed(sorted({file.parent.name for file in others}), most=MOST_NAMED)
    found = f", but the folders {folders}" if others else ""
    raise InputError(
        f"holds ground truth (*/gt/gt.txt) and no detections (*/det/det.txt){found}; name the "
        f"detections of one system by a quoted pattern ({there}: '{pattern}'), or give an archive "
        "of its files alone",
        file=text,
    )


def _shown(path: Path) -> str:
    """Return the last parts of a path, for display."""
    # abspath, not resolve: the target of a link may be named by its hash
    return "/".join(Path(os.path.abspath(path)).parts[-NAME_PARTS:]).replace("//", "/")  # noqa: PTH100


def paths_to_show(folder: Path, sources: Iterable[tuple[Source, Role]]) -> dict[str, str]:
    """Return paths of all files for display in a terminal, by `SourceFile.name`.

    They are relative to the current folder for files below it or named by a relative path, else
    absolute. Ambiguous names are left out. Reports use the names instead, which do not depend on
    the current folder.
    """
    working_folder = Path.cwd()
    shown: dict[str, set[str]] = {}
    for source, role in sources:
        for text in source.path:
            try:
                declared = None if source.format is None else format_named(source.format)
                files = _expand(text, folder, role, declared)
            except InputError:  # reported when the files are read
                continue
            for file in files:
                path = Path(os.path.abspath(file.path))  # noqa: PTH100  # as in _shown
                is_near = path.is_relative_to(working_folder) or not Path(text).is_absolute()
                near = os.path.relpath(path, working_folder) if is_near else str(path)
                shown.setdefault(file.name, set()).add(Path(near).as_posix())
    return {name: paths.pop() for name, paths in shown.items() if len(paths) == 1}


@contextmanager
def located(files: Sequence[SourceFile]) -> Iterator[None]:
    """Set the path on InputErrors about one of the files."""
    try:
        yield
    except InputError as error:
        error.path = next((file.path for file in files if file.name == error.file), None)
        raise


def path_to_show(path: Path) -> str:
    """Return a path for display, relative to the current folder for a file below it."""
    path = Path(os.path.abspath(path))  # noqa: PTH100  # as in _shown
    return (path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path).as_posix()


def _check_name(path: Path) -> None:
    """Raise InputError for a name that cannot be written into a report."""
    try:
        str(path).encode()
    except UnicodeEncodeError as error:
        raise InputError(
            f"the name of the file or its folder is not UTF-8: {str(path)!r}; rename it"
        ) from error


_KIND: Final = re.compile(
    r"[\s._-]+(?:results?|res|dets?|detections?|preds?|predictions?|outputs?|boxes|bbox)$",
    re.IGNORECASE,
)


def without_kind(name: str) -> str:
    """Remove the part of a name that marks it as detections.

    Examples
    --------
    >>> without_kind("MLPD_result")
    'MLPD'
    """
    return _KIND.sub("", name) or name


def system_names(sources: Sequence[Source], recordings: Sequence[str]) -> list[str]:
    """Name systems by their paths, distinctly if the paths differ.

    A name is the part nearest to the file that is neither a neutral word (``det``) nor a recording.
    Systems that would share a name (``x/out.csv`` and ``y/out.csv``) are named by the next part in
    which their paths differ.
    """
    parts = [_telling_parts(source, recordings) for source in sources]
    stems = [_stem(Path(source.path[0])) for source in sources]
    names = [own[0] if own else stem for own, stem in zip(parts, stems, strict=True)]
    clashing: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        clashing.setdefault(name, []).append(i)
    for indices in clashing.values():
        others = {name for i, name in enumerate(names) if i not in indices}
        deepest = max(len(parts[i]) for i in indices) if len(indices) > 1 else 0
        for level in range(1, deepest):
            raised = [parts[i][min(level, len(parts[i]) - 1)] for i in indices if parts[i]]
            if len({*raised}) == len(indices) and not others & {*raised}:
                for i, name in zip(indices, raised, strict=True):
                    names[i] = name
                break
    return names


def _telling_parts(source: Source, recordings: Sequence[str]) -> list[str]:
    """List path parts that are neither neutral nor a recording, nearest to the file first."""
    path = Path(source.path[0])
    return [
        part
        for part in map(without_kind, (_stem(path), *reversed(path.parts[:-1])))
        if part.lower() not in NEUTRAL
        and part not in recordings
        and part not in ("", "/", ".", "..")
        and not glob.has_magic(part)
    ]


def digest(files: Sequence[SourceFile]) -> list[str]:
    """Hash every file as it is stored, compressed or not, with SHA-256.

    Raises
    ------
    InputError
        If one cannot be opened.
    """
    digests = []
    for file in files:
        with file.open_stored() as stream:
            digests.append(hashlib.file_digest(stream, "sha256").hexdigest())
    return digests
