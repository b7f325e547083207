"""Training pictures from folders: crops of objects, and pictures without objects."""

from __future__ import annotations

import csv
import hashlib
import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import FormatError, InputError, MediaError, ParameterError
from nvcore.common.file_kinds import IMAGE_SUFFIXES
from nvcore.common.wording import count_text, one_line
from nvcore.dataset.provenance import TrainedOn
from nvcore.pictures.header import image_size
from nvcore.pictures.images import decode_image, file_bytes
from nvcore.subjects.detectors.calls.arguments import TrainArguments
from nvcore.subjects.detectors.icf import IcfSettings
from nvcore.subjects.detectors.training.shots import Shot, TrainingData, hold_out_groups

BOXES_FILE: Final = "boxes.csv"
"""Table in a folder of crops: columns file, x, y, w, h (px), and class if there are several."""
_COLUMNS: Final = ("file", "x", "y", "w", "h")
_CLASS: Final = "class"
_MOST_BYTES: Final = 1 << 28


def folder_shots(settings: IcfSettings, arguments: TrainArguments) -> TrainingData:
    """Collect the pictures of folders and their subfolders, except hidden ones.

    Each picture in the folder of crops shows one object in its middle, or the objects listed in
    ``boxes.csv``. Crops with the same folder and the same name up to the last ``_`` show one
    physical object, which is learned or held out as a whole.

    Raises
    ------
    InputError
        If a folder has no pictures, all crops have names of one physical object, or ``boxes.csv``
        cannot be read.
    ParameterError
        If the object's share of the height is not above 0 and at most 1.
    """
    crop_share = arguments.crop_share
    if crop_share is None:
        crop_share = settings.object_height / settings.window_height
    if not 0 < crop_share <= 1:
        raise ParameterError(f"crop_share: expected more than 0 and at most 1, got {crop_share:g}")
    shots: list[Shot] = []
    trained_on = []
    held_out = ""
    if arguments.crops is not None:
        crops = Path(arguments.crops)
        paths = _pictures_in(crops)
        groups = [(path.parent, path.stem.rpartition("_")[0] or path.stem) for path in paths]
        if len(paths) > 1 and len(set(groups)) == 1:
            raise InputError(
                f"all {len(paths)} pictures are named as of one physical object, "
                f"{one_line(groups[0][1])!r}: what stands before the last _ of a name (or the "
                "folder) must differ from object to object, since part of the objects is held "
                "out; use names such as sign12_0001.png, or without _",
                file=crops,
            )
        boxes, labels = _boxes(crops, paths, crop_share, settings.aspect)
        is_out, out = hold_out_groups(groups, arguments.share, arguments.seed)
        for path, own, names, is_held_out in zip(paths, boxes, labels, is_out, strict=True):
            side = {"held_out": own} if is_held_out else {"learned": own, "labels": names}
            read = partial(_read, path)
            shots.append(Shot(read, f"crops {crops}", has_background=False, **side))
        held_out = f"{len(out)} of {count_text(len(set(groups)), 'physical object')} in crops"
        trained_on.append(_fingerprint(paths, boxes, labels))
    if arguments.background is not None:
        background = Path(arguments.background)
        paths = _pictures_in(background)
        shots += [Shot(partial(_read, path), f"background {background}") for path in paths]
        trained_on.append(_fingerprint(paths, (), ()))
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


def _read(path: Path) -> NDArray[np.generic]:
    picture: NDArray[np.generic] = decode_image(file_bytes(path), one_line(path.name))
    return picture


def _fingerprint(
    paths: Sequence[Path], boxes: Sequence[NDArray[np.float64]], labels: Sequence[tuple[str, ...]]
) -> TrainedOn:
    """Return the sha256 over the files' contents, their boxes, and the classes, if any."""
    digest = hashlib.sha256()
    for path in paths:
        try:
            digest.update(hashlib.sha256(file_bytes(path)).digest())
        except MediaError as error:  # skipped later, when it is read
            digest.update(error.message.encode())
    for own in boxes:
        digest.update(own.tobytes())
    if any(map(any, labels)):
        digest.update(repr(labels).encode())
    return TrainedOn(digest.hexdigest())


def _boxes(
    folder: Path, paths: Sequence[Path], share: float, aspect: float
) -> tuple[list[NDArray[np.float64]], list[tuple[str, ...]]]:
    """Return the boxes of each crop, (n, 4), and their classes, "" if the table names none."""
    table = folder / BOXES_FILE
    if not table.is_file():
        return [_in_the_middle(path, share, aspect) for path in paths], [()] * len(paths)
    listed: dict[str, list[tuple[list[float], str]]]
    listed = {path.relative_to(folder).as_posix(): [] for path in paths}
    rows = csv.DictReader(_text(table).splitlines())
    if rows.fieldnames is None or not set(_COLUMNS) <= set(rows.fieldnames):
        raise FormatError(f"expected the columns {', '.join(_COLUMNS)}", file=table, line=1)
    try:
        for row in rows:
            box = [float(row[side] or "nan") for side in _COLUMNS[1:]]
            if not all(map(math.isfinite, box)) or min(box[2:]) <= 0:
                raise ValueError
            if (name := row["file"]) not in listed:
                raise FormatError(
                    f"there is no picture {one_line(name)!r}", file=table, line=rows.line_num
                )
            listed[name].append((box, (row.get(_CLASS) or "").strip()))
    except (ValueError, csv.Error) as error:
        raise FormatError(
            "expected a file name, x, y, and w and h above 0", file=table, line=rows.line_num
        ) from error
    boxes = [np.array([box for box, _ in own], float).reshape(-1, 4) for own in listed.values()]
    return boxes, [tuple(label for _, label in own) for own in listed.values()]


def _text(table: Path) -> str:
    try:
        if table.stat().st_size > _MOST_BYTES:
            raise FormatError(f"is larger than {_MOST_BYTES >> 20} MiB", file=table)
        return table.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError("is not UTF-8 text", file=table) from error
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=table) from error


def _in_the_middle(path: Path, share: float, aspect: float) -> NDArray[np.float64]:
    try:
        width, height = image_size(file_bytes(path), one_line(path.name))
    except MediaError:  # skipped later, when it is read
        return np.empty((0, 4))
    h = share * height
    w = h * aspect
    return np.array([[(width - w) / 2, (height - h) / 2, w, h]])
