"""Values beside the boxes: occlusion, distance, attributes, tracks, sizes; ``seqinfo.ini``."""

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

from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import Lines, Role, SourceFile, recordings_table, rows_finding
from nvcore.inputs.readers.parse.text import MAX_INTEGER, read_text
from nvcore.schema import CLASS_SEPARATOR, NO_TRACK, UNKNOWN_OCCLUSION, names_as_categories

PARTIAL_OCCLUSION: Final = 0.35
"""Occluded share up to which an occlusion is partial (Caltech's limit)."""


def levels_of_visible_share(visible: np.ndarray) -> np.ndarray:
    """Levels from the visible share in [0, 1]; UNKNOWN_OCCLUSION where it is NaN or outside."""
    occluded = 1 - visible
    level = np.where(occluded <= 0, 0, np.where(occluded <= PARTIAL_OCCLUSION + 1e-9, 1, 2))
    is_known = (visible >= 0) & (visible <= 1)
    return np.where(is_known, level, UNKNOWN_OCCLUSION).astype(np.int8)


def levels_of_numbers(values: np.ndarray) -> np.ndarray:
    """Levels 0, 1, 2 kept; UNKNOWN_OCCLUSION for everything else, NaN too."""
    is_known = np.isin(values, (0.0, 1.0, 2.0))
    return np.where(is_known, values, UNKNOWN_OCCLUSION).astype(np.int8)


def level_of_words(words: str) -> int:
    """Level of JAAD's words (none, part, full) and FLIR's (``no_(fully_visible)``, ...).

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
    """Finding about numbers that are no level: neither 0, 1, 2, nor -1 or NaN for unknown."""
    return lines.finding(
        ~(np.isin(values, (0.0, 1.0, 2.0, -1.0)) | np.isnan(values)),
        "unknown-occlusion",
        "Levels of occlusion other than 0 (none), 1 (partial), 2 (heavy) are taken as unknown.",
        "Write the level as 0, 1 or 2, or leave it empty.",
        role=role,
        example=lambda row: f"{values[row]:g}",
    )


def known_distances(metres: np.ndarray) -> np.ndarray:
    """The distances in metres; NaN where the files say 0, -1, -1000 or the like; shape (n,)."""
    return np.where(metres > 0, metres, np.nan)


def odd_distances(metres: np.ndarray, lines: Lines, role: Role) -> list[Finding]:
    """A note on distances that are not above 0."""
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
    """The values of a column, each from 0 to `high` or NaN; infinity is none.

    Raises
    ------
    FormatError
        With the line of the first that is outside.
    """
    is_good = np.isnan(values) | ((values >= 0) & (values <= high) & ~np.isinf(values))
    expected = f"from 0 to {high:g}" if np.isfinite(high) else "of 0 or more"
    lines.refuse(~is_good, lambda row: f"expected a {name} {expected}, found {values[row]:g}")
    return values


YES: Final = frozenset({"true", "yes"})
NOTHING: Final = frozenset(
    {"", "false", "no", "none", "nan", "n/a", "unknown", "undefined", "__undefined__"}
)
"""Values of an attribute that say nothing of a pedestrian."""
NO_CLASSES: Final = frozenset(
    {
        *("ignore", "ignored", "iscrowd", "is_crowd", "crowd", "difficult", "dontcare"),
        *("don't care", "score", "confidence", "conf", "occluded", "occlusion", "truncated"),
        *("visibility", "vis_ratio", "rotation", "keyframe", "outside", "source", "id"),
        *("track_id", "target_id", "instance_id", "tracking_id", "distance", "distance_m"),
        "detectability",
    }
)
"""Attributes that are about the box, and what readers use otherwise."""


def class_of(name: str, value: str) -> str:
    """Class that an attribute of an annotator stands for; empty: none.

    A switched-on one is called as the attribute, a choice as what was chosen; numbers are none.

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
    """The classes of one box as one text, each once."""
    return CLASS_SEPARATOR.join(dict.fromkeys(name for name in classes if name))


def attributes_of_boxes(
    boxes: pd.DataFrame, texts: Any, missing: Collection[str] = ("",)
) -> pd.DataFrame | None:
    """The attributes of those boxes that have any; columns of `ATTRIBUTE_DTYPES`, each place once.

    Parameters
    ----------
    boxes
        Of a reading.
    texts
        One for each box.
    missing
        Texts that stand for none.
    """
    names = names_as_categories(texts, len(texts))
    is_given = ~names.isin(list(missing)) & ~names.isna()
    if not is_given.any():
        return None
    given = names[is_given].remove_unused_categories()
    table = boxes.loc[is_given, ["file", "line"]].assign(attributes=given)
    return table.drop_duplicates(["file", "line"], ignore_index=True)


def joined_attributes(tables: Sequence[pd.DataFrame | None]) -> pd.DataFrame | None:
    """The attributes of all files; None where none has any."""
    filled = [table for table in tables if table is not None]
    if not filled:
        return None
    texts = union_categoricals([table["attributes"] for table in filled])
    return pd.concat(filled, ignore_index=True).assign(attributes=texts)


def is_ambiguous(file: np.ndarray, line: np.ndarray, texts: np.ndarray) -> np.ndarray:
    """Rows whose line has boxes of different texts, so that a text is of nobody; bool, (n,).

    Parameters
    ----------
    file, line
        Of each row, int64, shape (n,).
    texts
        Object, shape (n,); empty where there is none.
    """
    place = pd.Series(pd.factorize(texts)[0]).groupby([file, line])
    differs: np.ndarray = (place.transform("min") != place.transform("max")).to_numpy()
    return differs


TEXT_IDS = "track ids that are no whole numbers were numbered by first appearance in the recording"
"""Conversion text if `track_numbers` had to number ids that are text."""


def track_numbers(texts: pd.Series, recording: Any) -> tuple[np.ndarray, bool]:
    """Track ids as int64, and whether some were text.

    Whole numbers keep their value (negative ones and empty: NO_TRACK). Other text is numbered in
    the order of first appearance in its recording, after the recording's largest whole number.

    Parameters
    ----------
    texts
        Ids as text or missing, or whole numbers as int64 or float64 with NaN, shape (n,).
    recording
        Name of each row's recording, shape (n,), or the name of all.
    """
    if texts.dtype.kind in "fi":
        ids = texts.to_numpy()
        ids = ids if (ids >= 0).all() else np.where(ids >= 0, ids, NO_TRACK)
        return ids.astype(np.int64, copy=False), False
    coded = names_as_categories(texts, len(texts))  # each text once, however often it stands there
    distinct = pd.Series(coded.categories, dtype="str").str.strip()
    number = pd.to_numeric(distinct, errors="coerce").to_numpy(dtype=float)
    is_whole = (np.abs(number) < MAX_INTEGER) & (number == np.floor(number))
    is_missing = distinct.str.lower().isin(["", "nan", "none", "null"]).to_numpy(dtype=bool)
    numbers = np.where(is_whole & (number >= 0), number, NO_TRACK).astype(np.int64)
    # the last of them is for rows without a text, whose code is -1
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
    """Recordings with the size of their first picture, and pictures of another size.

    Parameters
    ----------
    pictures
        Columns recording, width, height; one row per picture, NaN where not given.
    role
        What the files hold.
    place
        Row -> name of its file, and what to write before its size in the example.
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
"""Longer than any recording: four days at 30 frames per second."""


@dataclass(frozen=True)
class SequenceInfo:
    """What ``seqinfo.ini`` says; NaN or None where it does not, or where there is none.

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
    """Facts of ``seqinfo.ini`` beside the file or in one of the two folders above.

    Raises
    ------
    FormatError
        If it has no section [Sequence], or a value that is no positive number.
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
    """The value, NaN where the key is missing."""
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
