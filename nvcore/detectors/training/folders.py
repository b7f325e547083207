"""Shots of folders: crops of objects, and pictures without any."""

from __future__ import annotations

import csv
import hashlib
import math
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import TrainedOn
from nvcore.detectors.icf import IcfSettings
from nvcore.detectors.icf.windows import NO_BOXES
from nvcore.detectors.training.shots import Shot, TrainingData
from nvcore.detectors.training.split import by_group
from nvcore.errors import FormatError, InputError, MediaError, ParameterError
from nvcore.file_kinds import IMAGE_SUFFIXES
from nvcore.pictures.header import image_size
from nvcore.pictures.images import decode_image, file_bytes
from nvcore.wording import count_text, one_line

BOXES_FILE: Final = "boxes.csv"
"""In a folder of crops: columns file, x, y, w, h (px), and class if there are several."""
_COLUMNS: Final = ("file", "x", "y", "w", "h")
_CLASS: Final = "class"
_MOST_BYTES: Final = 1 << 28


def folder_shots(
    crops: Path | None,
    background: Path | None,
    settings: IcfSettings,
    *,
    crop_share: float | None = None,
    share: float = 0.1,
    seed: int = 0,
) -> TrainingData:
    """Collect the pictures of folders and of their subfolders, without hidden ones.

    Parameters
    ----------
    crops
        Each picture shows an object in its middle, or those that ``boxes.csv`` lists. Pictures
        with the same folder and the same name up to the last ``_`` show one physical object, which
        is learned or held out as a whole.
    background
        Pictures without an object.
    crop_share
        Share of a crop's height that its object takes; None: as in the window.
    share, seed
        Of the physical objects held out, and which.

    Raises
    ------
    InputError
        If a folder has no pictures, all crops are named as of one physical object, or
        ``boxes.csv`` cannot be read.
    ParameterError
        If `crop_share` is not above 0 and at most 1.
    """
    if crop_share is None:
        crop_share = settings.object_height / settings.window_height
    if not 0 < crop_share <= 1:
        raise ParameterError(f"crop_share: expected more than 0 and at most 1, got {crop_share:g}")
    shots: list[Shot] = []
    trained_on = []
    held_out = ""
    if crops is not None:
        paths = _pictures_in(crops)
        groups = _physical_objects(crops, paths)
        boxes, labels = _boxes(crops, paths, crop_share, settings.aspect)
        is_out = by_group(groups, share, seed)
        for path, own, names, out in zip(paths, boxes, labels, is_out, strict=True):
            shots.append(
                Shot(
                    partial(_read, path),
                    source=f"crops {crops}",
                    learned=NO_BOXES if out else own,
                    held_out=own if out else NO_BOXES,
                    has_background=False,
                    labels=() if out else names,
                )
            )
        n_out = len({group for group, out in zip(groups, is_out, strict=True) if out})
        held_out = f"{n_out} of {count_text(len(set(groups)), 'physical object')} in crops"
        trained_on.append(_fingerprint(paths, boxes, labels))
    if background is not None:
        paths = _pictures_in(background)
        shots += [Shot(partial(_read, path), f"background {background}") for path in paths]
        trained_on.append(_fingerprint(paths, []))
    return TrainingData(shots, tuple(trained_on), held_out=held_out)


def _pictures_in(folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise InputError("there is no such folder", file=folder)
    paths = sorted(
        path
        for path in folder.rglob("*")
        if path.suffix.lower() in IMAGE_SUFFIXES
        and not any(part.startswith(".") for part in path.relative_to(folder).parts)
        and path.is_file()
    )
    if not paths:
        raise InputError("there are no pictures in it (PNG, JPEG, TIFF, BMP)", file=folder)
    return paths


def _physical_objects(folder: Path, paths: Sequence[Path]) -> list[tuple[Path, str]]:
    """Return the object that each crop shows, by folder and name. Raise if all show the same."""
    groups = [(path.parent, path.stem.rpartition("_")[0] or path.stem) for path in paths]
    if len(paths) > 1 and len(set(groups)) == 1:
        raise InputError(
            f"all {len(paths)} pictures are named as of one physical object, "
            f"{one_line(groups[0][1])!r}: what stands before the last _ of a name (or the folder) "
            "must differ from object to object, since part of the objects is held out; use names "
            "such as sign12_0001.png, or without _",
            file=folder,
        )
    return groups


def _read(path: Path) -> NDArray[np.generic]:
    picture: NDArray[np.generic] = decode_image(file_bytes(path), one_line(path.name))
    return picture


def _fingerprint(
    paths: Sequence[Path],
    boxes: Sequence[NDArray[np.float64]],
    labels: Sequence[tuple[str, ...]] = (),
) -> TrainedOn:
    """sha256 over the files' contents, their boxes, and the classes of these if there are any."""
    digest = hashlib.sha256()
    for path in paths:
        try:
            digest.update(hashlib.sha256(file_bytes(path)).digest())
        except MediaError as error:  # it is left out when it is read
            digest.update(error.message.encode())
    for own in boxes:
        digest.update(own.tobytes())
    if any(map(any, labels)):
        digest.update(repr(labels).encode())
    return TrainedOn(digest.hexdigest())


def _boxes(
    folder: Path, paths: Sequence[Path], share: float, aspect: float
) -> tuple[list[NDArray[np.float64]], list[tuple[str, ...]]]:
    """Boxes of each crop, (n, 4), and their classes, "" where the table names none."""
    table = folder / BOXES_FILE
    if not table.is_file():
        return [_in_the_middle(path, share, aspect) for path in paths], [()] * len(paths)
    names = [path.relative_to(folder).as_posix() for path in paths]
    by_name: dict[str, list[tuple[float, ...]]] = {name: [] for name in names}
    classes: dict[str, list[str]] = {name: [] for name in names}
    for line, name, box, label in _listed(table):
        if name not in by_name:
            raise FormatError(f"there is no picture {one_line(name)!r}", file=table, line=line)
        by_name[name].append(box)
        classes[name].append(label)
    boxes = [np.array(by_name[name], float).reshape(-1, 4) for name in names]
    return boxes, [tuple(classes[name]) for name in names]


def _in_the_middle(path: Path, share: float, aspect: float) -> NDArray[np.float64]:
    try:
        width, height = image_size(file_bytes(path), one_line(path.name))
    except MediaError:  # it is left out when it is read
        return np.empty((0, 4))
    h = share * height
    w = h * aspect
    return np.array([[(width - w) / 2, (height - h) / 2, w, h]])


def _listed(table: Path) -> Iterator[tuple[int, str, tuple[float, ...], str]]:
    """Line, name, box and class of each row of the table."""
    try:
        if table.stat().st_size > _MOST_BYTES:
            raise FormatError(f"is larger than {_MOST_BYTES >> 20} MiB", file=table)
        text = table.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError("is not UTF-8 text", file=table) from error
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=table) from error
    rows = csv.DictReader(text.splitlines())
    if rows.fieldnames is None or not set(_COLUMNS) <= set(rows.fieldnames):
        raise FormatError(f"expected the columns {', '.join(_COLUMNS)}", file=table, line=1)
    try:
        for row in rows:
            box = tuple(float(row[side] or "nan") for side in _COLUMNS[1:])
            if not all(map(math.isfinite, box)) or min(box[2:]) <= 0:
                raise ValueError
            yield rows.line_num, row["file"], box, (row.get(_CLASS) or "").strip()
    except (ValueError, csv.Error) as error:
        raise FormatError(
            "expected a file name, x, y, and w and h above 0", file=table, line=rows.line_num
        ) from error
