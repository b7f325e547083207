"""Values other than boxes: occlusion, distance, attributes, tracks, sizes, ``seqinfo.ini``."""

from __future__ import annotations

import configparser
import math
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
from pandas.api.types import union_categoricals

from nvcore.common.findings import Finding, Severity
from nvcore.dataset.schema import CLASS_SEPARATOR, NO_TRACK, UNKNOWN_OCCLUSION, names_as_categories
from nvcore.inputs.readers.base import Lines, Role, SourceFile, recordings_table, rows_finding
from nvcore.inputs.readers.parse.text import MAX_INTEGER, read_text

PARTIAL_OCCLUSION: Final = 0.35
"""Occluded share up to which an occlusion is partial (Caltech's limit)."""


def levels_of_visible_share(visible: np.ndarray) -> np.ndarray:
    """Convert visible shares to levels, UNKNOWN_OCCLUSION if NaN or outside [0, 1]."""
    occluded = 1 - visible
    level = np.where(occluded <= 0, 0, np.where(occluded <= PARTIAL_OCCLUSION + 1e-9, 1, 2))
    is_known = (visible >= 0) & (visible <= 1)
    return np.where(is_known, level, UNKNOWN_OCCLUSION).astype(np.int8)


def levels_of_numbers(values: np.ndarray) -> np.ndarray:
    """Keep levels 0, 1, 2, and replace other values by UNKNOWN_OCCLUSION."""
    is_known = np.isin(values, (0.0, 1.0, 2.0))
    return np.where(is_known, values, UNKNOWN_OCCLUSION).astype(np.int8)


def level_of_words(words: str) -> int:
    """Convert words of JAAD (none, part, full) and FLIR (``no_(fully_visible)``) to a level.

    Examples
    --------
    >>> [*map(level_of_words, ["none", "partially_occluded", "full", "no_(fully_visible)", "?"])]
    [0, 1, 2, 0, -1]
    """
    lowered = words.strip().lower().replace(" ", "_")
    if lowered in ("0", "1", "2"):
        return int(lowered)
    if lowered.startswith("no") or "fully_visible" in lowered:
        return 0
    if "part" in lowered:
        return 1
    is_heavy = any(word in lowered for word in ("difficult", "heav", "full", "complete"))
    return 2 if is_heavy else UNKNOWN_OCCLUSION


def odd_levels(values: np.ndarray, lines: Lines, role: Role) -> list[Finding]:
    """Report numbers that are not a level: neither 0, 1, 2, nor -1 or NaN for unknown."""
    return lines.finding(
        ~(np.isin(values, (0.0, 1.0, 2.0, -1.0)) | np.isnan(values)),
        "unknown-occlusion",
        "Levels of occlusion other than 0 (none), 1 (partial), 2 (heavy) are taken as unknown.",
        "Write the level as 0, 1 or 2, or leave it empty.",
        role=role,
        example=lambda row: f"{values[row]:g}",
    )


def known_distances(metres: np.ndarray) -> np.ndarray:
    """Replace distances that are not positive (0, -1, -1000) by NaN, shape (n,)."""
    return np.where(metres > 0, metres, np.nan)


def odd_distances(metres: np.ndarray, lines: Lines, role: Role) -> list[Finding]:
    """Report distances that are not above 0, as a note."""
    return lines.finding(
        metres <= 0,
        "unknown-distance",
        "Distances of 0 or less are taken as unknown.",
        "Leave distances empty that are not known.",
        role=role,
        example=lambda row: f"{metres[row]:g} m",
        severity=Severity.NOTE,
    )


def checked_numbers(
    values: np.ndarray, lines: Lines, name: str, *, high: float = np.inf
) -> np.ndarray:
    """Return the values of a column after checking that they are NaN or finite in [0, high].

    Raises
    ------
    FormatError
        If a value is outside, with the line.
    """
    is_good = np.isnan(values) | ((values >= 0) & (values <= high) & ~np.isinf(values))
    expected = f"from 0 to {high:g}" if np.isfinite(high) else "of 0 or more"
    lines.refuse(~is_good, lambda row: f"expected a {name} {expected}, found {values[row]:g}")
    return values


YES: Final = frozenset({"true", "yes"})
NOTHING: Final = frozenset(
    {"", "false", "no", "none", "nan", "n/a", "unknown", "undefined", "__undefined__"}
)
"""Values of an attribute that carry no information about a pedestrian."""
NO_CLASSES: Final = frozenset(
    {
        *("ignore", "ignored", "iscrowd", "is_crowd", "crowd", "difficult", "dontcare"),
        *("don't care", "score", "confidence", "conf", "occluded", "occlusion", "truncated"),
        *("visibility", "vis_ratio", "rotation", "keyframe", "outside", "source", "id"),
        *("track_id", "target_id", "instance_id", "tracking_id", "distance", "distance_m"),
        "detectability",
    }
)
"""Attributes about the box, and attributes that readers use in other ways."""


def class_of(name: str, value: str) -> str:
    """Convert an annotator's attribute to a class, or an empty text.

    The class of a checked attribute is the attribute's name, that of a choice is the chosen value.
    Numbers are no classes.

    Examples
    --------
    >>> class_of("with_dog", "true"), class_of("age", "child"), class_of("shirt", "17")
    ('with_dog', 'child', '')
    """
    name, value = name.strip(), value.strip()
    lowered = value.casefold()
    if name.casefold() in NO_CLASSES or lowered in NOTHING:
        return ""
    if lowered in YES:
        return name
    try:
        float(value)
    except ValueError:
        return value
    return ""


def joined_classes(classes: Iterable[str]) -> str:
    """Join the classes of one box to one text, each once."""
    return CLASS_SEPARATOR.join(dict.fromkeys(name for name in classes if name))


def attributes_of_boxes(
    boxes: pd.DataFrame, texts: Any, missing: Collection[str] = ("",)
) -> pd.DataFrame | None:
    """Make a table of attributes (`ATTRIBUTE_DTYPES`) with one row per line that has any.

    Parameters
    ----------
    boxes
        Boxes of a reading.
    texts
        Attributes of each box.
    missing
        Texts that mean no attributes.
    """
    names = names_as_categories(texts, len(texts))
    is_given = ~names.isin(list(missing)) & ~names.isna()
    if not is_given.any():
        return None
    given = names[is_given].remove_unused_categories()
    table = boxes.loc[is_given, ["file", "line"]].assign(attributes=given)
    return table.drop_duplicates(["file", "line"], ignore_index=True)


def joined_attributes(tables: Sequence[pd.DataFrame | None]) -> pd.DataFrame | None:
    """Concatenate the attributes of all files, or return None if there are none."""
    filled = [table for table in tables if table is not None]
    if not filled:
        return None
    texts = union_categoricals([table["attributes"] for table in filled])
    return pd.concat(filled, ignore_index=True).assign(attributes=texts)


def is_ambiguous(file: np.ndarray, line: np.ndarray, texts: np.ndarray) -> np.ndarray:
    """Mark rows whose line has boxes with different texts. Bool, shape (n,).

    Parameters
    ----------
    file, line
        File and line of each row, int64, shape (n,).
    texts
        Text of each row, object, shape (n,), empty if it has none.
    """
    place = pd.Series(pd.factorize(texts)[0]).groupby([file, line])
    differs: np.ndarray = (place.transform("min") != place.transform("max")).to_numpy()
    return differs


TEXT_IDS = "track ids that are no whole numbers were numbered by first appearance in the recording"
"""Conversion text if `track_numbers` had to number ids that are text."""


def track_numbers(texts: pd.Series, recording: Any) -> tuple[np.ndarray, bool]:
    """Convert track ids to int64, and return whether some were text.

    Whole numbers are kept (negative ones and empty: NO_TRACK). Other text is numbered in
    the order of first appearance in its recording, after the recording's largest whole number.

    Parameters
    ----------
    texts
        Ids as text or missing, or whole numbers as int64 or float64 with NaN, shape (n,).
    recording
        Recording of each row, shape (n,), or of all rows.
    """
    if texts.dtype.kind in "fi":
        ids = texts.to_numpy()
        ids = ids if (ids >= 0).all() else np.where(ids >= 0, ids, NO_TRACK)
        return ids.astype(np.int64, copy=False), False
    coded = names_as_categories(texts, len(texts))  # parse each distinct text once
    distinct = pd.Series(coded.categories, dtype="str").str.strip()
    number = pd.to_numeric(distinct, errors="coerce").to_numpy(dtype=float)
    is_whole = (np.abs(number) < MAX_INTEGER) & (number == np.floor(number))
    is_missing = distinct.str.lower().isin(["", "nan", "none", "null"]).to_numpy(dtype=bool)
    numbers = np.where(is_whole & (number >= 0), number, NO_TRACK).astype(np.int64)
    # the last one is for rows without a text, whose code is -1
    track = np.append(numbers, NO_TRACK)[coded.codes]
    is_text = np.append(~is_missing & ~is_whole, False)[coded.codes]
    if not is_text.any():
        return track, False
    names = names_as_categories(recording, len(texts))
    codes = names.codes
    largest = np.full(len(names.categories), -1, dtype=np.int64)
    np.maximum.at(largest, codes, track)
    text_code = pd.factorize(distinct)[0][coded.codes[is_text]]
    text_ids = pd.DataFrame({"recording": codes[is_text], "text": text_code})
    first = text_ids.drop_duplicates()
    order = first.groupby("recording").cumcount().to_numpy()
    first = first.assign(track=largest[first["recording"].to_numpy()] + 1 + order)
    track[is_text] = text_ids.merge(first, how="left", on=["recording", "text"])["track"].to_numpy()
    return track, True


def recordings_with_sizes(
    pictures: pd.DataFrame, role: Role, place: Callable[[int], tuple[str, str]]
) -> tuple[pd.DataFrame, list[Finding]]:
    """Make a table of recordings with the size of the first picture, and report other sizes.

    Parameters
    ----------
    pictures
        Columns recording, width, height; one row per picture, NaN where not given.
    role
        Role of the files.
    place
        Function from a row to the name of its file, and the text before its size in the example.
    """
    sides = ["width", "height"]
    sizes = pictures.groupby("recording", sort=False)[sides]
    differs = (pictures[sides] != sizes.transform("first")) & pictures[sides].notna()

    def example(row: int) -> tuple[str, str]:
        file, where = place(row)
        width, height = pictures[sides].iloc[row]
        return file, f"{where}{width:g} x {height:g}"

    first = sizes.first()
    recordings = recordings_table(
        first.index, width=first["width"].to_numpy(), height=first["height"].to_numpy()
    )
    return recordings, rows_finding(
        differs.any(axis=1).to_numpy(),
        "picture-size",
        "Pictures differ in size from the first of their recording, whose size is taken.",
        "Give each size a recording of its own, or scale the boxes to one size.",
        role=role,
        place=example,
    )


MAX_FRAMES = 10_000_000
"""Most frames of a recording: four days at 30 frames per second."""


@dataclass(frozen=True)
class SequenceInfo:
    """Facts in ``seqinfo.ini``, NaN or None if they or the file are missing.

    Attributes
    ----------
    name
        Name of the recording.
    width, height
        Size of the pictures in pixels.
    fps
        Frames per second.
    n_frames
        Number of frames, which are 1 to `n_frames`.
    """

    name: str | None = None
    width: float = math.nan
    height: float = math.nan
    fps: float = math.nan
    n_frames: int | None = None


def sequence_info(file: SourceFile) -> SequenceInfo:
    """Read ``seqinfo.ini`` beside the file or in one of the two folders above.

    Raises
    ------
    FormatError
        If it has no section [Sequence], or a value is not a positive number.
    """
    folder = file.path.parent.resolve()
    paths = [place / "seqinfo.ini" for place in (folder, folder.parent, folder.parent.parent)]
    path = next(filter(Path.is_file, paths), None)
    if path is None:
        return SequenceInfo()
    source = SourceFile(path, f"seqinfo.ini of {file.name}")
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(read_text(source))
    except configparser.Error as error:
        text = str(error).replace("\n", " ").replace("'<string>'", "").strip()
        raise source.fault(f"expected [Sequence] and lines such as frameRate=30: {text}") from error
    if not parser.has_section("Sequence"):
        raise source.fault("expected a section [Sequence], found none")
    values = parser["Sequence"]
    length = _positive(values, "seqLength", source)
    if length > MAX_FRAMES or length % 1 > 0:
        raise source.fault(
            f"expected seqLength as a whole number up to {MAX_FRAMES}, found {length:g}"
        )
    return SequenceInfo(
        name=values.get("name", "").strip() or None,
        width=_positive(values, "imWidth", source),
        height=_positive(values, "imHeight", source),
        fps=_positive(values, "frameRate", source),
        n_frames=None if math.isnan(length) else int(length),
    )


def _positive(values: configparser.SectionProxy, key: str, file: SourceFile) -> float:
    """Return the value of a key, NaN if it is missing."""
    text = values.get(key)
    if text is None:
        return math.nan
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise file.fault(
            f"expected {key} as a positive number, found {text!r}; correct it or leave it out"
        )
    return value
