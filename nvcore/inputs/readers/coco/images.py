"""COCO's image list: recording and frame of every image, and which image a result belongs to."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from nvcore.errors import InputError
from nvcore.file_kinds import unpacked_name
from nvcore.findings import Finding, Remedy, Step
from nvcore.inputs.readers.base import (
    NO_FRAME,
    Lines,
    NamedPictures,
    ReadOptions,
    SourceFile,
    rows_finding,
    warning,
)
from nvcore.inputs.readers.meaning.frame_names import (
    NO_NAMES,
    in_file,
    named_pictures,
    times_as_frames,
)
from nvcore.inputs.readers.meaning.names import recording_and_frame_of, recording_of
from nvcore.inputs.readers.parse.json import Records, first_other
from nvcore.inputs.readers.parse.text import whole_numbers

NAME_KEYS = ("file_name", "im_name", "filename", "image_name", "image_filepath")
FRAME_KEYS = ("frame_index", "frame_id", "frame_number", "frame")
VIDEO_KEYS = ("video_id", "recording_id", "recordings_id")
_TASKS = ("instances", "person_keypoints", "stuff", "panoptic", "captions", "labels", "image_info")
"""Beginnings of names, ``instances_val2017.json``: the same pictures for another task each."""
_TASK_FILE = re.compile(rf"(?P<folder>(?:.*/)?)(?P<task>{'|'.join(_TASKS)})_(?P<subset>.+)")


def files_of_one_task(files: Sequence[SourceFile]) -> tuple[list[tuple[int, SourceFile]], str]:
    """Files with their places in the list, of each subset those of one task, and that in words."""
    matches = [_TASK_FILE.fullmatch(unpacked_name(file.name)) for file in files]
    ranks = [_TASKS.index(match["task"]) if match else 0 for match in matches]
    subsets = [
        (match["folder"], match["subset"]) if match else (file.name, "")
        for file, match in zip(files, matches, strict=True)
    ]
    # of equal keys the last one stays, the lowest rank
    best = dict(sorted(zip(subsets, ranks, strict=True), key=lambda pair: -pair[1]))
    is_used = [rank == best[subset] for subset, rank in zip(subsets, ranks, strict=True)]
    used = [(number, file) for number, file in enumerate(files) if is_used[number]]
    others = ", ".join(file.name for number, file in enumerate(files) if not is_used[number])
    return used, f"the same pictures for other tasks passed over: {others}" if others else ""


@dataclass(frozen=True)
class ImageList:
    """The images of one COCO file.

    Attributes
    ----------
    table
        Columns recording, frame, image_id, file_name (empty where not given), in file order.
    recordings
        Columns name, width, height, fps; one row per recording.
    conversion
        Where recordings and frame numbers come from, in words.
    findings
        Recoverable oddities.
    named
        The pictures by name.
    """

    table: pd.DataFrame
    recordings: pd.DataFrame
    conversion: str
    findings: tuple[Finding, ...]
    named: NamedPictures


def read_images(document: dict[str, object], file: SourceFile, options: ReadOptions) -> ImageList:
    """The image list of a COCO document.

    Raises
    ------
    FormatError
        If there is none, or one of its entries cannot be understood.
    """
    images = Records(document.get("images"), file, "image", "images")
    ids = image_ids(images)
    keep, findings = _first_of_each_id(images, ids)
    names = _names(images)
    with in_file(file):
        recording, frame, conversion, oddities, named = _places(images, names, document, options)
    table = pd.DataFrame(
        {
            "recording": pd.Series(recording, dtype=object),
            "frame": frame,
            "image_id": ids,
            "file_name": pd.Series(names, dtype=object),
            "width": _sizes(images, "width"),
            "height": _sizes(images, "height"),
        }
    )
    table = table[keep].reset_index(drop=True)
    double = table.duplicated(["recording", "frame"]) & (table["frame"] != NO_FRAME)
    if double.any():
        first = table[double].iloc[0]
        raise file.fault(
            f"two images are frame {first['frame']} of recording {first['recording']!r} (the "
            f"second has id {first['image_id']}); expected one image per frame"
        )
    recordings, sizes = _recordings(table, document, file)
    renamed = zip(named.recording, recording, strict=True) if named.rates else ()
    rates = {new: named.rates[old] for old, new in renamed if old in named.rates}
    listed = table[["recording", "frame", "file_name"]].rename(columns={"file_name": "name"})
    return ImageList(
        table=table[["recording", "frame", "image_id", "file_name"]],
        recordings=recordings,
        conversion=conversion,
        findings=tuple(findings + oddities + sizes),
        named=replace(named, table=listed, rates=rates, strange=-1),
    )


def image_ids(records: Records, *keys: str) -> pd.Series:
    """Image ids as int64 where all are whole numbers, else as text (object).

    Raises
    ------
    FormatError
        With the first record that has none or one that is neither number nor text.
    """
    values = records.required(*(keys or ("id",)))
    records.check_types(values, {int, float, str}, "a number or text as image id")
    has_text = first_other(values, {int, float}) is not None
    if not has_text and all(-(2**53) < value < 2**53 for value in values):  # type: ignore[operator]
        numbers = np.array(values, dtype=float)
        if not np.any(numbers % 1):
            return pd.Series(numbers.astype(np.int64))
    return pd.Series([id_text(value) for value in values], dtype=object)


def id_text(value: object) -> str:
    """An image id as text; 3.0 is 3."""
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def id_texts(records: Records, what: str, *keys: str) -> pd.Series | None:
    """Ids of a field (see `Records.values`) as text, missing where a record has none.

    Raises
    ------
    FormatError
        With the first record whose id is neither number nor text.
    """
    values = records.values(*keys)
    if values is None:
        return None
    records.check_types(values, {int, float, str, type(None)}, f"a number or text as {what}")
    texts = [None if value is None else id_text(value) for value in values]
    return pd.Series(texts, dtype="str")


def rows_by_id(ids: pd.Series, listed: pd.Series) -> np.ndarray:
    """Row of the image list that has each id, -1 where none has; 12 and "12" are one id."""
    if not (ids.dtype == listed.dtype and pd.api.types.is_integer_dtype(ids.dtype)):
        ids, listed = (part.map(id_text).astype(object) for part in (ids, listed))
    return np.asarray(pd.Index(listed).get_indexer(pd.Index(ids)))


def places_of_rows(
    images: pd.DataFrame, row: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Recording and frame of rows of the image list, and whether they are known; -1: not."""
    if images.empty:
        return np.full(len(row), "", dtype=object), np.zeros(len(row), np.int64), row >= 0
    recording = images["recording"].to_numpy(dtype=object)[row]
    return recording, images["frame"].to_numpy(dtype=np.int64)[row], row >= 0


def _names(images: Records) -> list[str]:
    """File name of each picture, empty where it has none."""
    values = images.values(*NAME_KEYS) or [None] * len(images)
    images.check_types(values, {str, type(None)}, "text as file_name")
    return [str(value or "") for value in values]


def _first_of_each_id(images: Records, ids: pd.Series) -> tuple[np.ndarray, list[Finding]]:
    """Which images to keep: one of those listed twice in the same words."""
    double = ids.duplicated().to_numpy()
    if not double.any():
        return np.ones(len(ids), dtype=bool), []
    first_row = {key: row for row, key in zip(range(len(ids) - 1, -1, -1), ids[::-1], strict=True)}
    for index in np.flatnonzero(double):  # doubles are few
        if images.rows[index] != images.rows[first_row[ids[index]]]:
            raise images.error(int(index), f"id {ids[index]} stands for two different images")
    return ~double, rows_finding(
        double,
        "duplicate-image",
        "Images are listed more than once.",
        "Nothing is lost: each is taken once; mend the list.",
        role="truth",
        place=lambda row: (images.file.name, f"image {row + 1} of the list, id {ids[row]}"),
    )


def _places(
    images: Records, names: Sequence[str], document: dict[str, object], options: ReadOptions
) -> tuple[Sequence[str], np.ndarray, str, list[Finding], NamedPictures]:
    """Recording and frame number of every image, in words where they come from, and its name."""
    file_recording = recording_of(images.file.name)
    named = NO_NAMES
    numbers = images.numbers(*FRAME_KEYS)
    has_numbers = numbers is not None and len(numbers) > 0 and not np.isnan(numbers).any()
    if names and all(names) and options.frame_names != "order":
        try:
            named = named_pictures(names, options)
        except InputError:
            if not has_numbers:
                raise
            named = named_pictures(names, replace(options, frame_names="numbers"))
    are_placed = named.strange < 0
    folders = (_folders(names, file_recording), "recordings from the folders")
    if options.role == "detections" and are_placed and named.is_joined:
        return [*named.recording], named.frame, "pictures found in the truth by name", [], named
    videos = _videos(images, document)
    recording: Sequence[str]
    if videos is not None:
        recording, source = videos, "recordings from the video of each image"
    elif are_placed:
        recording = [_or_whole(place, file_recording) for place in named.recording]
        source = "recordings from the file names"
    else:
        recording, source = folders
    if has_numbers and numbers is not None:
        if videos is None and _is_scattered(recording):
            recording, source = folders
        lines = Lines.of(images.file, np.arange(1, len(numbers) + 1))
        times = times_as_frames(numbers, recording, options, lines)
        if times is not None:
            return recording, times[1], f"{source}, times from the images' fields", [], times[2]
        frame = whole_numbers(numbers, lines, "frame number")
        text = f"{source}, frame numbers from the images' fields"
        return recording, frame, text, [], replace(named, how="fields", facts=(), rates={})
    if are_placed and not _is_scattered(recording):
        pictures = pd.DataFrame({"recording": recording, "frame": named.frame, "name": names})
        double = pictures.drop_duplicates().duplicated(["recording", "frame"])
        if double.any():
            first = pictures.loc[double[double].index[0]]
            of_frame = (pictures["recording"] == first["recording"]) & (
                pictures["frame"] == first["frame"]
            )
            raise InputError(
                f"{first['name']} is frame {first['frame']} of recording {first['recording']!r}, "
                f"as is {pictures['name'][of_frame].iloc[0]}; expected one picture a frame: leave "
                "copies out, or say that the pictures follow each other in the order of the list",
                steps=(Step(Remedy.FRAME_NAMES, "order"),),
            )
        return recording, named.frame, f"{source}, frame numbers from the file names", [], named
    if videos is None:
        recording, source = folders
    frame = pd.Series(recording, dtype=object).groupby(recording).cumcount().to_numpy(np.int64)
    text = f"{source}, frame numbers from the order of the list"
    by_order = NamedPictures(named.table, "order")
    if options.frame_names == "order":
        return recording, frame, text, [], by_order
    finding = warning(
        "frames-by-order",
        len(images),
        "Neither fields nor file names of the images tell the frame number; they are "
        "numbered 0, 1, 2, ... in the order of the list.",
        "Check that the list is in the order of time.",
        role="truth",
        file=images.file.name,
        example=next(iter(names), ""),
    )
    return recording, frame, text, [finding], by_order


def _or_whole(recording: str, file_recording: str) -> str:
    """A name without a folder gives "recording": then the whole file is one recording."""
    return file_recording if recording == "recording" else recording


def _is_scattered(recording: Sequence[str]) -> bool:
    """Whether the names give almost every image a recording of its own, as hashes do."""
    return len(recording) >= 4 and len(set(recording)) > len(recording) / 2


def _folders(names: Sequence[str], file_recording: str) -> list[str]:
    """Recording of each picture by its folder alone."""
    folders = [name.replace("\\", "/").rpartition("/")[0] for name in names]
    # a made-up frame number lets the rules for folders apply
    places = {folder: recording_and_frame_of(f"{folder}/0") for folder in {*folders}}
    recordings = {
        folder: _or_whole(place[0], file_recording) if place else file_recording
        for folder, place in places.items()
    }
    return [recordings[folder] for folder in folders]


def _videos(images: Records, document: dict[str, object]) -> list[str] | None:
    """Name of each image's video; None unless every image has one."""
    ids = images.values(*VIDEO_KEYS)
    if not ids or None in ids or not set(map(type, ids)) <= {int, float, str}:
        return None
    names: dict[str, str] = {}
    if document.get("videos") is not None:
        videos = Records(document["videos"], images.file, "video", "videos")
        titles = videos.values("name", "file_name") or [None] * len(videos)
        for key, title in zip(videos.required("id"), titles, strict=True):
            names[id_text(key)] = title if isinstance(title, str) and title else id_text(key)
    return [names.get(id_text(key), id_text(key)) for key in ids]


def _sizes(images: Records, key: str) -> np.ndarray:
    """Width or height of each picture; NaN where missing, or no size at all."""
    values = images.numbers(key)
    if values is None:
        return np.full(len(images), np.nan)
    return np.where((values > 0) & np.isfinite(values), values, np.nan)


def _recordings(
    table: pd.DataFrame, document: dict[str, object], file: SourceFile
) -> tuple[pd.DataFrame, list[Finding]]:
    """One row per recording with its commonest picture size, and what differs from it."""
    fps = {}
    if document.get("videos"):
        videos = Records(document["videos"], file, "video", "videos")
        rates = videos.numbers("fps", "frame_rate")
        titles = videos.values("name", "file_name")
        if rates is not None and titles is not None:
            fps = {
                str(title): rate
                for title, rate in zip(titles, rates, strict=True)
                if 0 < rate < np.inf
            }
    rows, n_odd, example = [], 0, ""
    # a loop over recordings: there are few
    for name, group in table.groupby("recording", sort=False):
        sizes = group[["width", "height"]].value_counts(sort=True)
        width, height = sizes.index[0] if len(sizes) else (np.nan, np.nan)
        differs = group["width"].notna() & ~(group["width"].eq(width) & group["height"].eq(height))
        if differs.any() and not n_odd:
            first = group[differs].iloc[0]
            example = (
                f"image id {first['image_id']} is {first['width']:g}x{first['height']:g}, "
                f"most of {name} is {width:g}x{height:g}"
            )
        n_odd += int(differs.sum())
        rows.append((str(name), width, height, fps.get(str(name), np.nan)))
    recordings = pd.DataFrame(rows, columns=["name", "width", "height", "fps"])
    recordings = recordings.astype({"name": object, "width": float, "height": float, "fps": float})
    if not n_odd:
        return recordings, []
    finding = warning(
        "picture-size",
        n_odd,
        "Pictures of one recording differ in size; the commonest size is taken.",
        "Give each size a recording of its own, or scale the boxes to one size.",
        role="truth",
        file=file.name,
        example=example,
    )
    return recordings, [finding]
