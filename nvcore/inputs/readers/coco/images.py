"""COCO's image list: recording and frame of every image, and which image a result belongs to."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

import numpy as np
import pandas as pd

from nvcore.errors import FormatError
from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import SourceFile, recording_row, rows_finding
from nvcore.inputs.readers.meaning.names import recording_and_frame_of, recording_of
from nvcore.inputs.readers.parse.json import Records
from nvcore.inputs.readers.parse.text import whole_numbers

NAME_KEYS = ("file_name", "im_name", "filename", "image_name", "image_filepath")
FRAME_KEYS = ("frame_index", "frame_id", "frame_number", "frame")
VIDEO_KEYS = ("video_id", "recording_id", "recordings_id")
_FLIR = re.compile(r"(?:^|.*/)video-(?P<video>[^/]+?)-frame-(?P<frame>\d+)(?:[-.][^/]*)?$")


@dataclass(frozen=True)
class ImageList:
    """The images of one COCO file.

    Attributes
    ----------
    table
        Columns recording, frame, image_id, file_name (empty where not given), in file order.
    recordings
        `recording_row`s.
    conversion
        Where recordings and frame numbers come from, in words.
    findings
        Recoverable oddities.
    """

    table: pd.DataFrame
    recordings: tuple[dict[str, object], ...]
    conversion: str
    findings: tuple[Finding, ...]


def place_of_picture(name: str, known: tuple[str, ...] = ()) -> tuple[str, int] | None:
    """Recording and frame number from a picture's name; None without a number.

    Examples
    --------
    >>> place_of_picture("data/video-BzZs-frame-000123-Xk9.jpg")
    ('BzZs', 123)
    >>> place_of_picture("set06/V000/I00019")
    ('set06/V000', 19)
    """
    name = name.replace("\\", "/")
    flir = _FLIR.match(name)
    if flir is not None:
        return flir["video"], int(flir["frame"])
    return recording_and_frame_of(name, known)


def read_images(document: dict[str, object], file: SourceFile) -> ImageList:
    """The image list of a COCO document.

    Raises
    ------
    FormatError
        If there is none, or one of its entries cannot be understood.
    """
    images = Records(document.get("images"), file, "image", "images")
    ids = image_ids(images)
    keep, findings = _first_of_each_id(images, ids)
    recording, frame, conversion, oddities = _places(images, document, file)
    table = pd.DataFrame(
        {
            "recording": pd.Series(recording, dtype=object),
            "frame": frame,
            "image_id": ids,
            "file_name": pd.Series(_names(images), dtype=object),
            "width": _sizes(images, "width"),
            "height": _sizes(images, "height"),
        }
    )
    table = table[keep].reset_index(drop=True)
    double = table.duplicated(["recording", "frame"])
    if double.any():
        first = table[double].iloc[0]
        raise FormatError(
            f"two images are frame {first['frame']} of recording {first['recording']!r} (the "
            f"second has id {first['image_id']}); expected one image per frame",
            file=file.name,
        )
    rows, sizes = _recordings(table, document, file)
    return ImageList(
        table=table[["recording", "frame", "image_id", "file_name"]],
        recordings=rows,
        conversion=conversion,
        findings=tuple(findings + oddities + sizes),
    )


def image_ids(records: Records, *keys: str) -> pd.Series:
    """Image ids as int64 where all are whole numbers, else as text (object).

    Raises
    ------
    FormatError
        With the first record that has none or one that is neither number nor text.
    """
    values = records.required(*(keys or ("id",)))
    kinds = set(map(type, values))
    if not kinds <= {int, float, str}:
        first = next(i for i, value in enumerate(values) if type(value) not in {int, float, str})
        raise records.error(first, "expected a number or text as image id")
    if kinds <= {int, float} and all(-(2**53) < value < 2**53 for value in values):  # type: ignore[operator]
        numbers = np.array(values, dtype=float)
        if not np.any(numbers % 1):
            return pd.Series(numbers.astype(np.int64))
    return pd.Series([id_text(value) for value in values], dtype=object)


def id_text(value: object) -> str:
    """An image id as text; 3.0 is 3."""
    return str(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


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
    values = images.values(*NAME_KEYS)
    if values is None:
        return [""] * len(images)
    names = []
    for index, value in enumerate(values):  # text: value by value
        if not isinstance(value, (str, type(None))):
            raise images.error(index, "expected text as file_name")
        names.append(value or "")
    return names


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
    images: Records, document: dict[str, object], file: SourceFile
) -> tuple[list[str], np.ndarray, str, list[Finding]]:
    """Recording and frame number of every image, and in words where they come from."""
    whole = recording_of(file.name)
    places = [place_of_picture(name) for name in _names(images)]  # text: one by one
    videos = _videos(images, document)
    numbers = images.numbers(*FRAME_KEYS)
    has_numbers = numbers is not None and bool(len(numbers)) and not np.isnan(numbers).any()
    if videos is not None:
        recording, source = videos, "recordings from the video of each image"
    elif all(place is not None for place in places):
        recording = [_or_whole(place[0], whole) for place in places if place is not None]
        source = "recordings from the file names"
    else:
        recording, source = _folders(images, whole), "recordings from the folders"
    if has_numbers:
        assert numbers is not None
        frame = whole_numbers(numbers, file, np.arange(1, len(numbers) + 1), "frame number")
        if videos is None and _is_scattered(recording):
            recording, source = _folders(images, whole), "recordings from the folders"
        return recording, frame, f"{source}, frame numbers from the images' fields", []
    if all(place is not None for place in places) and not _is_scattered(recording):
        frame = np.array([place[1] for place in places if place is not None], dtype=np.int64)
        names = pd.DataFrame({"recording": recording, "frame": frame, "name": _names(images)})
        names = names.drop_duplicates()
        if not names.duplicated(["recording", "frame"]).any():
            return recording, frame, f"{source}, frame numbers from the file names", []
    if videos is None:
        recording, source = _folders(images, whole), "recordings from the folders"
    frame = pd.Series(recording, dtype=object).groupby(recording).cumcount().to_numpy(np.int64)
    finding = Finding(
        severity=Severity.WARNING,
        code="frames-by-order",
        subject="truth",
        count=len(images),
        message="Neither fields nor file names of the images tell the frame number; they are "
        "numbered 0, 1, 2, ... in the order of the list.",
        advice="Check that the list is in the order of time.",
        file=file.name,
        example=next(iter(_names(images)), ""),
    )
    return recording, frame, f"{source}, frame numbers from the order of the list", [finding]


def _or_whole(recording: str, whole: str) -> str:
    """`naming` says "recording" where a name has no folder: then the file is one recording."""
    return whole if recording == "recording" else recording


def _is_scattered(recording: Sequence[str]) -> bool:
    """Whether the names give almost every image a recording of its own, as hashes do."""
    return len(recording) >= 4 and len(set(recording)) > len(recording) / 2


def _folders(images: Records, whole: str) -> list[str]:
    parents = [PurePosixPath(name.replace("\\", "/")).parent for name in _names(images)]
    # a made-up frame number lets the rules of `naming` for folders apply
    places = [recording_and_frame_of(str(parent / "0")) for parent in parents]
    return [_or_whole(place[0], whole) if place else whole for place in places]


def _videos(images: Records, document: dict[str, object]) -> list[str] | None:
    """Name of each image's video; None unless every image has one."""
    ids = images.values(*VIDEO_KEYS)
    if not ids or None in ids or not set(map(type, ids)) <= {int, float, str}:
        return None
    names = {}
    if document.get("videos") is not None:
        videos = Records(document["videos"], images.file, "video", "videos")
        if len(videos):
            titles = videos.values("name", "file_name") or [None] * len(videos)
            for key, title in zip(videos.required("id"), titles, strict=True):
                names[id_text(key)] = title if isinstance(title, str) and title else id_text(key)
    return [names.get(id_text(key), id_text(key)) for key in ids]


def _sizes(images: Records, key: str) -> np.ndarray:
    values = images.numbers(key)
    if values is None:
        return np.full(len(images), np.nan)
    return np.where((values > 0) & np.isfinite(values), values, np.nan)


def _recordings(
    table: pd.DataFrame, document: dict[str, object], file: SourceFile
) -> tuple[tuple[dict[str, object], ...], list[Finding]]:
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
    rows, odd, example = [], 0, ""
    # a loop over recordings: there are few
    for name, group in table.groupby("recording", sort=False):
        sizes = group[["width", "height"]].value_counts(sort=True)
        width, height = sizes.index[0] if len(sizes) else (np.nan, np.nan)
        differs = group["width"].notna() & ~(group["width"].eq(width) & group["height"].eq(height))
        if differs.any() and not odd:
            first = group[differs].iloc[0]
            example = (
                f"image id {first['image_id']} is {first['width']:g}x{first['height']:g}, "
                f"most of {name} is {width:g}x{height:g}"
            )
        odd += int(differs.sum())
        rows.append(
            recording_row(str(name), width=width, height=height, fps=fps.get(str(name), np.nan))
        )
    findings = []
    if odd:
        findings.append(
            Finding(
                severity=Severity.WARNING,
                code="picture-size",
                subject="truth",
                count=odd,
                message="Pictures of one recording differ in size; the commonest size is taken.",
                advice="Give each size a recording of its own, or scale the boxes to one size.",
                file=file.name,
                example=example,
            )
        )
    return tuple(rows), findings
