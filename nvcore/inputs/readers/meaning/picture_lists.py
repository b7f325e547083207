"""Pictures without a label file, by the folder of pictures or the list beside the label files."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Final

import numpy as np

from nvcore.errors import InputError
from nvcore.file_kinds import IMAGE_SUFFIXES
from nvcore.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.inputs.readers.base import NamedPictures, SourceFile
from nvcore.inputs.readers.meaning.names import DIGITS
from nvcore.inputs.readers.parse.text import read_text
from nvcore.wording import count_text

LABEL_FOLDERS: Final = ("labels", "annotations", "annotation", "label_2", "label_02", "xml", "txt")
IMAGE_FOLDERS: Final = (
    *("images", "image", "imgs", "img", "img1", "JPEGImages", "image_2", "image_02"),
    *("frames", "pictures"),
)
"""Folders of pictures, which lie where those of the label files do."""
LISTS: Final = ("train", "val", "valid", "validation", "trainval", "test", "images")
"""Lists of pictures: ``train.txt``."""
MAX_LIST_BYTES: Final = 64 << 20
MAX_YAML_BYTES: Final = 1 << 20
_SPLIT: Final = re.compile(r"^(?:train|val|test):[ \t]*['\"]?([^\s'\"#\[]+)", re.MULTILINE)
"""Pictures of a data set in its YAML file: ``train: images/train``."""
MIN_FOUND: Final = 0.9
"""Share of the label files whose pictures a folder or list has to hold."""
MIN_REGULAR: Final = 4
"""Pictures from which on it is no chance that they follow each other in equal steps."""


def pictures_without_file(files: Sequence[SourceFile], folders: Sequence[Path] = ()) -> list[str]:
    """Return the names of listed pictures that have no label file, with the folders of the files.

    Parameters
    ----------
    files
        Label files, one per picture.
    folders
        Further folders that may hold the pictures.
    """
    stems_in: dict[tuple[Path, str], set[str]] = defaultdict(set)
    for file in files:
        shown, _, name = file.name.rpartition("/")
        stems_in[file.path.absolute().parent, shown].add(PurePosixPath(name).stem)
    every = set().union(*stems_in.values())
    texts = {DIGITS.sub("", stem) for stem in every}
    return [
        f"{shown}/{stem}".removeprefix("/")
        for (folder, shown), own in stems_in.items()
        for stem in sorted(_first_that_holds(own, folder, folders) - every)
        if DIGITS.sub("", stem) in texts and stem not in texts
    ]


def _first_that_holds(own: set[str], folder: Path, folders: Sequence[Path]) -> set[str]:
    """Return the stems of the first folder or list that holds those of the label files."""
    for listed in _listed(folder, folders):
        if len(own & listed) >= MIN_FOUND * len(own):
            return listed
    return set()


def _listed(folder: Path, folders: Sequence[Path]) -> Iterator[set[str]]:
    """Yield the stems of pictures in each place where those of label files in a folder may be."""
    places = [folder, *(folder.parent / name for name in IMAGE_FOLDERS)]
    for at, part in enumerate(folder.parts):
        if part.casefold() in LABEL_FOLDERS:
            start, rest = Path(*folder.parts[:at]), folder.parts[at + 1 :]
            places += [start.joinpath(name, *rest) for name in IMAGE_FOLDERS]
    above = (folder, *folder.parents[:3])
    named = [place / value for place in above for value in _named_in_yaml(place)]
    for place in dict.fromkeys([*places, *folders, *named]):
        with suppress(OSError):
            names = [PurePosixPath(entry.name) for entry in place.iterdir()]
            yield {name.stem for name in names if name.suffix.casefold() in IMAGE_SUFFIXES}
    for place in (*above[:3], above[1] / "ImageSets" / "Main"):
        paths = [*(place / f"{name}.txt" for name in LISTS), *named]
        lists = [_stems_in(path, folder.name) for path in paths]
        yield from [*filter(None, lists), set().union(*lists)]


def _named_in_yaml(place: Path) -> list[str]:
    """Return the folders and lists of pictures that YAML files of data sets in a folder name."""
    texts = []
    with suppress(InputError, OSError):
        files = [SourceFile(path, path.name) for path in sorted(place.glob("*.y*ml"))]
        texts = [read_text(file) for file in files if not file.is_larger_than(MAX_YAML_BYTES)]
    return [value for text in texts for value in _SPLIT.findall(text)]


def _stems_in(path: Path, folder: str) -> set[str]:
    """Return the stems of listed pictures: those in a folder of this name, if there are any."""
    file = SourceFile(path, path.name)
    try:
        if not path.is_file() or file.is_larger_than(MAX_LIST_BYTES):
            return set()
        names = [PurePosixPath(line.strip()) for line in read_text(file).splitlines()]
    except (InputError, OSError):
        return set()
    names = [name for name in names if name.suffix.casefold() in {"", *IMAGE_SUFFIXES}]
    inside = [name for name in names if name.parent.name == folder]
    return {name.stem for name in inside or names}


def with_empty_pictures(named: NamedPictures, n_files: int) -> NamedPictures:
    """Separate the pictures without a label file, which stand last, as `NamedPictures.empty`.

    Where most have none, or those with or without one follow each other in equal steps, only
    some may have been annotated: then none is taken, and a warning asks.
    """
    of_files, empty = named.table.iloc[:n_files], named.table.iloc[n_files:]
    parts = named.table.assign(is_empty=np.arange(len(named.table)) >= n_files)
    parts = parts.sort_values(["recording", "frame"])
    in_steps = any(
        _is_regular(np.flatnonzero(part["is_empty"] == is_empty))
        for _, part in parts.groupby("recording")
        for is_empty in (False, True)
    )
    is_part = in_steps or 2 * len(empty) >= len(parts)
    steps = [Step(Remedy.FRAMES)] * is_part
    if is_part and parts["recording"].nunique() == 1:
        first, last = parts["frame"].iloc[[0, -1]]
        steps = [Step(Remedy.FRAMES, f"{first}:{last}")]
        frames = np.unique(of_files["frame"])
        if len({*np.diff(frames)}) == 1:
            steps.append(Step(Remedy.FRAMES, f"{frames[0]}:{frames[-1]}:{frames[1] - frames[0]}"))
    have = count_text(len(empty), "picture has", "pictures have")
    finding = Finding(
        Severity.WARNING if is_part else Severity.NOTE,
        "pictures-not-annotated" if is_part else "pictures-without-label-file",
        TRUTH_NAME,
        len(empty),
        f"{have} no label file"
        + (", as if only some were annotated: they are not evaluated." if is_part else "."),
        "If nobody is there, evaluate them, too; nothing to do if only some were annotated."
        if is_part
        else "Nobody is there then: every detection in them is a false alarm.",
        example=f"picture {empty['name'].iloc[0]}",
        steps=tuple(steps),
    )
    return replace(named, table=of_files, empty=None if is_part else empty, findings=(finding,))


def _is_regular(rows: np.ndarray) -> bool:
    steps = {*np.diff(rows).tolist()}
    return len(rows) >= MIN_REGULAR and len(steps) == 1 and steps != {1}
