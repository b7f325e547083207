"""Write readings as plain CSV, Parquet, COCO or MOTChallenge text, for ``nvcore convert``."""

from __future__ import annotations

import lzma
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import pyarrow as pa
import tomli_w

from nvcore.common.errors import InputError, UnknownFormatError
from nvcore.common.file_kinds import suffix_of
from nvcore.common.findings import Remedy, Step
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import write_whole
from nvcore.common.output.parquet import to_parquet_bytes
from nvcore.dataset.schema import NO_TRACK, UNKNOWN_OCCLUSION
from nvcore.inputs.readers.base import Reading, Role
from nvcore.inputs.writers.coco import attribute_texts, class_names, coco_bytes
from nvcore.settings.objects import PEDESTRIAN, Objects

_CODECS: Final = {".gz": "gzip", ".bz2": "bz2", ".zst": "zstd"}
FORMATS: Final = ("csv", "parquet", "coco", "mot")
"""Formats that `write` supports."""

_BY_SUFFIX: Final = {
    ".csv": "csv",
    ".parquet": "parquet",
    ".pq": "parquet",
    ".json": "coco",
    ".txt": "mot",
}

CSV_COLUMNS: Final = (
    *("recording", "frame", "x", "y", "w", "h"),
    *("score", "track", "ignore", "distance_m", "occlusion"),
)
VISIBLE_SHARE: Final = {0: 1.0, 1: 0.8, 2: 0.4, UNKNOWN_OCCLUSION: -1.0}
"""MOTChallenge's visibility for each level of occlusion, read back as the same level."""


def format_by_name(path: Path) -> str:
    """Return the format for the ending of a file's name.

    Raises
    ------
    UnknownFormatError
        If no format has this ending.
    """
    suffix = suffix_of(path)
    if suffix not in _BY_SUFFIX:
        raise UnknownFormatError(
            f"the name does not tell the format to write (its ending is none of "
            f"{', '.join(_BY_SUFFIX)}); name it: {', '.join(FORMATS)}",
            file=path,
        )
    return _BY_SUFFIX[suffix]


def write(
    reading: Reading,
    format_name: str,
    path: Path,
    *,
    role: Role,
    truth: Reading | None = None,
    objects: Objects = PEDESTRIAN,
    inputs: Sequence[Path] = (),
    force: bool = False,
) -> list[Path]:
    """Write a reading to disk.

    Parameters
    ----------
    reading
        Reading to write, with boxes in the convention of docs/formats.md.
    format_name
        ``csv`` and ``parquet`` keep all but the list of evaluated frames and the sizes. ``coco``
        also keeps these for the truth, but cannot hold boxes without coordinates. ``mot`` has no
        classes, no distances and no frame list.
    path
        File to write, compressed if its ending says so. For ``mot`` with several recordings, a
        folder with one file per recording.
    role
        Truth or detections.
    truth
        Ground truth whose ids COCO results use for their images and categories. Without it, they
        name images by recording and frame, and may have only one class.
    objects
        Kind of the objects. Several classes are named so that they are read as the same ones.
    inputs
        Files that are never overwritten.
    force
        Whether to overwrite other existing files.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    UnknownFormatError
        If no writer has the name.
    InputError
        If a file cannot be written or exists, or the format cannot hold the reading.
    """
    writers: dict[str, Callable[[], dict[Path, bytes]]] = {
        "csv": lambda: {path: to_csv_bytes(_table(reading, role, objects), digits=None)},
        "parquet": lambda: {path: to_parquet_bytes(_table(reading, role, objects))},
        "coco": lambda: {path: coco_bytes(reading, role, truth, objects)},
        "mot": lambda: _mot_files(reading, path, role),
    }
    if format_name not in writers:
        raise UnknownFormatError(
            f"{format_name!r} cannot be written; the formats to write are {', '.join(FORMATS)}"
        )
    contents = writers[format_name]().items()
    packed = {target: packed_as(target.name, content) for target, content in contents}
    return _write_files(packed, inputs, force)


def write_frame_lists(
    frames: Mapping[str, np.ndarray],
    path: Path,
    *,
    inputs: Sequence[Path] = (),
    force: bool = False,
) -> list[Path]:
    """Write evaluated frames as text files for ``--frames``, with one number per line.

    Parameters
    ----------
    frames
        Frame numbers by recording.
    path
        File to write, if all recordings have the same frames. Otherwise a folder with one file per
        recording and ``recordings.toml``, the part of a session file that names the files.
    inputs, force
        See `write`.

    Returns
    -------
    list of Path
        The files that were written, ``recordings.toml`` last.

    Raises
    ------
    InputError
        If a file cannot be written or exists, or there is no frame.
    """
    if not frames:
        raise InputError("there is no frame to list: the ground truth holds no box", file=path)
    texts = {name: "".join(f"{number}\n" for number in listed) for name, listed in frames.items()}
    if len(set(texts.values())) == 1:
        return _write_files({path: next(iter(texts.values())).encode()}, inputs, force)
    contents, tables = {}, []
    for name, file_name in zip(texts, safe_names(list(texts)), strict=True):
        contents[path / f"{file_name}.txt"] = texts[name].encode()
        facts = tomli_w.dumps({"name": name, "frames": f"{file_name}.txt"})
        tables.append(f"[[recording]]\n{facts}")
    contents[path / "recordings.toml"] = "\n".join(tables).encode()
    return _write_files(contents, inputs, force)


def _write_files(contents: dict[Path, bytes], inputs: Sequence[Path], force: bool) -> list[Path]:
    """Write all files, or none if one must not be overwritten."""
    for target in contents:
        exists = target.is_file()
        if exists and any(path.is_file() and target.samefile(path) for path in inputs):
            raise InputError("is the input; give another file to write", file=target)
        if exists and not force:
            steps = (Step(Remedy.OPTION, "", "force"),)
            raise InputError("exists; give another file to write", file=target, steps=steps)
    for target, content in contents.items():
        write_whole(target, content)
    return list(contents)


def _table(reading: Reading, role: Role, objects: Objects) -> pd.DataFrame:
    """Convert boxes to the columns of plain CSV, with unknown values missing."""
    left_aside = "score" if role == "truth" else "ignore"
    table = reading.boxes[[name for name in CSV_COLUMNS if name != left_aside]]
    table = table.assign(
        track=table["track"].astype("Int64").mask(table["track"] == NO_TRACK),
        occlusion=table["occlusion"].astype("Int64").mask(table["occlusion"] == UNKNOWN_OCCLUSION),
    )
    seen = reading.boxes["detectability"]
    more: dict[str, Any] = {
        "class": class_names(reading, objects),
        "detectability": seen if role == "truth" and seen.notna().any() else None,
        "attributes": None if reading.attributes is None else attribute_texts(reading),
    }
    return table.assign(**{name: column for name, column in more.items() if column is not None})


def _mot_files(reading: Reading, path: Path, role: Role) -> dict[Path, bytes]:
    """Serialize a reading as one file, or as one per recording in the folder `path`."""
    boxes = reading.boxes
    columns: dict[str, object] = {
        "frame": boxes["frame"],
        "id": boxes["track"],
        "left": boxes["x"] + 1,
        "top": boxes["y"] + 1,
        "width": boxes["w"],
        "height": boxes["h"],
    }
    if role == "truth":
        columns["conf"] = (~boxes["ignore"]).astype(np.int64)
        columns["class"] = 1
        columns["visibility"] = boxes["occlusion"].map(VISIBLE_SHARE)
    else:
        has_scores = bool(boxes["score"].notna().any())
        columns["conf"] = boxes["score"] if has_scores else -1
        columns |= {"x": -1, "y": -1, "z": -1}
    table = pd.DataFrame(columns, index=boxes.index)
    names = reading.recordings["name"].tolist()
    parts = {path: table}
    if len(names) > 1:
        parts = {
            path / f"{file_name}.txt": table[(boxes["recording"] == name).to_numpy()]
            for name, file_name in zip(names, safe_names(names), strict=True)
        }
    return {
        target: to_csv_bytes(part, digits=None, header=False, missing="nan")
        for target, part in parts.items()
    }


def safe_names(names: list[str]) -> list[str]:
    """Make unique file names of recordings, without folders and hidden files."""
    names_in_use: set[str] = set()
    safe = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9._-]+", "_", name).lstrip(".") or "recording"
        candidate, number = plain, 2
        while candidate.lower() in names_in_use:
            candidate, number = f"{plain}_{number}", number + 1
        names_in_use.add(candidate.lower())
        safe.append(candidate)
    return safe


def packed_as(name: str, content: bytes) -> bytes:
    """Compress the content by gzip, bzip2, xz or Zstandard if the ending of the name says so."""
    ending = name[name.rfind(".") :].lower()
    if ending == ".xz":
        return lzma.compress(content)
    if ending not in _CODECS:
        return content
    packed = pa.BufferOutputStream()
    with pa.CompressedOutputStream(packed, _CODECS[ending]) as stream:
        stream.write(content)
    result: bytes = packed.getvalue().to_pybytes()
    return result
