"""Readings written as plain CSV, Parquet, COCO or MOTChallenge text, for ``nvcore convert``."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
import tomli_w

from nvcore.errors import InputError, UnknownFormatError
from nvcore.file_kinds import suffix_of
from nvcore.inputs.evaluated_frames import own_frames
from nvcore.inputs.readers.base import Reading, Role, image_list
from nvcore.output.csv_text import to_csv_bytes
from nvcore.output.files import write_whole
from nvcore.output.packing import packed_as
from nvcore.output.parquet import to_parquet_bytes
from nvcore.schema import NO_TRACK, UNKNOWN_OCCLUSION

FORMATS: Final = ("csv", "parquet", "coco", "mot")
"""What `write` can write."""

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
    """The format to write that the ending of a file's name asks for.

    Raises
    ------
    UnknownFormatError
        If it asks for none.
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
    images: pd.DataFrame | None = None,
    inputs: Sequence[Path] = (),
    force: bool = False,
) -> list[Path]:
    """Write a reading to disk.

    Parameters
    ----------
    reading
        What is written; its boxes are in the convention of docs/formats.md.
    format_name
        ``csv`` and ``parquet`` keep all but the list of evaluated frames and the sizes. ``coco``
        keeps those of the truth, too; boxes without coordinates it cannot hold. ``mot`` has no
        distances and no frame list.
    path
        File to write, packed if its name ends so; for ``mot`` with several recordings a folder of
        one file per recording.
    role
        Whether the reading is truth or detections.
    images
        The truth's image list (recording, frame, image_id), for COCO results: detections then
        name their image by its id. Without it by recording and frame, as a file name.
    inputs
        Files that are never written over.
    force
        Whether other files that exist are replaced.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    UnknownFormatError
        If no writer has the name.
    InputError
        If a file cannot be written or exists, or the format cannot hold what is to be written.
    """
    if format_name == "csv":
        contents = {path: to_csv_bytes(_table(reading, role), digits=None)}
    elif format_name == "parquet":
        contents = {path: to_parquet_bytes(_table(reading, role))}
    elif format_name == "coco":
        contents = {path: _coco(reading, role, images)}
    elif format_name == "mot":
        contents = _mot(reading, path, role)
    else:
        raise UnknownFormatError(
            f"{format_name!r} cannot be written; the formats to write are {', '.join(FORMATS)}"
        )
    packed = {target: packed_as(target.name, content) for target, content in contents.items()}
    return _write_files(packed, inputs, force)


def write_frame_lists(
    frames: Mapping[str, np.ndarray],
    path: Path,
    *,
    inputs: Sequence[Path] = (),
    force: bool = False,
) -> list[Path]:
    """Write evaluated frames as the text files that ``--frames`` reads: one number a line.

    Parameters
    ----------
    frames
        Frame numbers by recording.
    path
        File to write, if all recordings have the same frames. Else a folder of one file per
        recording and ``recordings.toml``, the part of a session file that names them.
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
    """Write all of them, or none if one must not be written over."""
    for target in contents:
        if not target.is_file():
            continue
        if any(path.is_file() and target.samefile(path) for path in inputs):
            raise InputError("is the input; give another file to write", file=target)
        if not force:
            raise InputError("exists; give another file to write, or --force", file=target)
    for target, content in contents.items():
        write_whole(target, content)
    return list(contents)


def _table(reading: Reading, role: Role) -> pd.DataFrame:
    """The boxes with the columns of plain CSV; what is unknown is missing."""
    left_aside = "score" if role == "truth" else "ignore"
    table = reading.boxes[[name for name in CSV_COLUMNS if name != left_aside]]
    table = table.assign(
        track=table["track"].astype("Int64").mask(table["track"] == NO_TRACK),
        occlusion=table["occlusion"].astype("Int64").mask(table["occlusion"] == UNKNOWN_OCCLUSION),
    )
    if role == "truth" and reading.boxes["detectability"].notna().any():
        table = table.assign(detectability=reading.boxes["detectability"])
    if reading.attributes is None:
        return table
    return table.assign(attributes=_attribute_texts(reading))


def _attribute_texts(reading: Reading) -> np.ndarray:
    """Attributes of each box, missing where it has none; object, shape (n,)."""
    places = reading.boxes[["file", "line"]]
    if reading.attributes is None:
        return np.full(len(places), np.nan, dtype=object)
    texts = places.merge(reading.attributes, how="left", on=["file", "line"])["attributes"]
    return texts.to_numpy(dtype=object)


def _coco(reading: Reading, role: Role, images: pd.DataFrame | None) -> bytes:
    boxes = reading.boxes
    sides = boxes[["x", "y", "w", "h"]].to_numpy()
    has_gap = ~np.isfinite(sides).all(axis=1)
    if has_gap.any():
        first = boxes[has_gap].iloc[0]
        raise InputError(
            f"COCO cannot hold boxes without finite coordinates; there are {int(has_gap.sum())}, "
            f"the first in frame {first['frame']} of {first['recording']} (line {first['line']}); "
            "mend them, or write csv"
        )
    if role == "truth":
        document: object = _coco_truth(reading, sides)
    else:
        document = _coco_results(reading, sides, images)
    return (json.dumps(document, allow_nan=False) + "\n").encode()


def _coco_truth(reading: Reading, sides: np.ndarray) -> dict[str, object]:
    boxes = reading.boxes
    images = _image_list(reading)
    videos = {name: number for number, name in enumerate(images["recording"].unique(), 1)}
    facts = reading.recordings.set_index("name")
    sizes = {name: _known(facts, name, ("width", "height")) for name in videos}
    entries = []
    for recording, frame, image_id in images[["recording", "frame", "image_id"]].itertuples(
        index=False, name=None
    ):
        entry = {
            "id": image_id,
            "file_name": _file_name(recording, frame),
            "video_id": videos[recording],
            "frame_index": frame,
        }
        entries.append(entry | sizes[recording])
    ids = _ids(boxes, images)
    rows = []
    # one object a box is what JSON wants: a loop
    for number, (image_id, box, ignore, track, distance, occlusion, seen, attributes) in enumerate(
        zip(
            ids,
            sides.tolist(),
            boxes["ignore"].tolist(),
            boxes["track"].tolist(),
            boxes["distance_m"].tolist(),
            boxes["occlusion"].tolist(),
            boxes["detectability"].tolist(),
            _attribute_texts(reading),
            strict=True,
        ),
        1,  # id 0 counts as "no match" in COCO's own evaluation
    ):
        row = {
            "id": number,
            "image_id": image_id,
            "category_id": 1,
            "bbox": box,
            "area": box[2] * box[3],
            "iscrowd": 0,
            "ignore": int(ignore),
        }
        if track != NO_TRACK:
            row["track_id"] = track
        if np.isfinite(distance):
            row["distance_m"] = distance
        if occlusion != UNKNOWN_OCCLUSION:
            row["occlusion"] = occlusion
        if np.isfinite(seen):
            row["detectability"] = seen
        if isinstance(attributes, str):
            row["attributes"] = attributes
        rows.append(row)
    return {
        "videos": [
            {"id": number, "name": name} | _known(facts, name, ("width", "height", "fps"))
            for name, number in videos.items()
        ],
        "images": entries,
        "annotations": rows,
        "categories": [{"id": 1, "name": "person"}],
    }


def _coco_results(
    reading: Reading, sides: np.ndarray, images: pd.DataFrame | None
) -> list[dict[str, object]]:
    boxes = reading.boxes
    if images is not None:
        key, places = "image_id", _ids(boxes, images)
    else:
        key = "image_filepath"
        names = zip(boxes["recording"].tolist(), boxes["frame"].tolist(), strict=True)
        places = [_file_name(recording, frame) for recording, frame in names]
    rows = []
    # one object a box is what JSON wants: a loop
    for place, box, score, track in zip(
        places, sides.tolist(), boxes["score"].tolist(), boxes["track"].tolist(), strict=True
    ):
        row: dict[str, object] = {key: place, "category_id": 1, "bbox": box}
        if np.isfinite(score):
            row["score"] = score
        if track != NO_TRACK:
            row["track_id"] = track
        rows.append(row)
    return rows


def _image_list(reading: Reading) -> pd.DataFrame:
    """The evaluated images, numbered from 1 where the reading has no numbers of its own."""
    images = reading.images
    if images is None:
        listed_frames = own_frames(reading, reading.recordings["name"])
        images = image_list([*listed_frames], [frames for frames, _ in listed_frames.values()])
    elif not images["image_id"].duplicated().any():
        return images
    return images.assign(image_id=np.arange(1, len(images) + 1))


def _ids(boxes: pd.DataFrame, images: pd.DataFrame) -> list[object]:
    """Image id of every box."""
    keys = ["recording", "frame"]
    listed = images[[*keys, "image_id"]]
    image_id = boxes[keys].merge(listed.astype({"image_id": object}), how="left", on=keys)[
        "image_id"
    ]
    unknown = image_id.isna().to_numpy()
    if unknown.any():
        first = boxes[unknown].iloc[0]
        raise InputError(
            f"{int(unknown.sum())} boxes are in frames that the image list does not have, the "
            f"first in frame {first['frame']} of {first['recording']}; give the truth "
            "that they belong to"
        )
    return image_id.tolist()


def _file_name(recording: str, frame: int) -> str:
    return f"{recording}/{frame:06d}.png"


def _known(facts: pd.DataFrame, recording: str, names: tuple[str, ...]) -> dict[str, object]:
    """What is known of a recording, whole numbers as such."""
    if recording not in facts.index:
        return {}
    values = facts.loc[recording, list(names)].to_numpy(dtype=float).tolist()
    return {
        name: int(value) if value.is_integer() else value
        for name, value in zip(names, values, strict=True)
        if np.isfinite(value)
    }


def _mot(reading: Reading, path: Path, role: Role) -> dict[Path, bytes]:
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
    """File names of recordings: no folders, no hidden files, no two the same."""
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
