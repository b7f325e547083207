"""What a person changed in the table of recordings, as entries of the session."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.errors import InputError
from nvcore.inputs.session import RecordingEntry, Session
from nvcore.output.csv_text import to_csv_bytes
from nvcore.params.traffic import context_word, parse_context
from ui.access.files import safe_name

NO_PICTURES: Final = "no pictures"
COLUMNS: Final = (
    *("name", "width", "height", "fps", "context", "speed_kmh", "horizon", "tags"),
    *("unit", "pictures", "first_picture"),
)
NUMBERS: Final = ("width", "height", "fps", "speed_kmh", "horizon", "first_picture")
MAY_BE_UNKNOWN: Final = ("speed_kmh", "horizon")
NAMES_ALONE: Final = frozenset({"title", "tags"})
"""Fields that can be changed without reading the files again."""


def editable(dataset: Dataset, session: Session, labels: Mapping[str, str]) -> pd.DataFrame:
    """The table to be edited: a row per recording, texts as a person types them.

    Parameters
    ----------
    session
        Says which picture is the first one, where somebody gave that.
    labels
        Label of each recording's pictures, by its name.
    """
    table = dataset.recordings
    names = table["name"].tolist()
    entries = session.entries(names)
    first = [entries[name].first_picture if name in entries else None for name in names]
    return pd.DataFrame(
        {
            "name": table["name"].astype(object),
            "width": table["width"].astype(float),
            "height": table["height"].astype(float),
            "fps": table["fps"].astype(float),
            "context": [_context_text(value) for value in table["context"]],
            "speed_kmh": table["speed_kmh"].astype(float),
            "horizon": table["horizon"].astype(float),
            "tags": ["; ".join(tags) for tags in table["tags"]],
            "unit": table["unit"].astype(object),
            "pictures": [labels.get(name, NO_PICTURES) for name in names],
            "first_picture": np.array(first, dtype=float),
        }
    )


def blank(names: Iterable[str]) -> pd.DataFrame:
    """The table of recordings of which nothing is known but their names."""
    name = pd.Series([*names], dtype=object)
    texts = dict.fromkeys(("context", "tags", "unit"), "")
    numbers = dict.fromkeys(NUMBERS, np.nan)
    table = pd.DataFrame({"name": name}).assign(**numbers, **texts, pictures=NO_PICTURES)
    return table[[*COLUMNS]]


def filled(
    table: pd.DataFrame,
    entries: Mapping[str, RecordingEntry],
    pictures: Mapping[str, str | None] | None = None,
) -> tuple[pd.DataFrame, list[str]]:
    """The table with what the rows of a CSV file say, and the pictures that are not among these.

    Parameters
    ----------
    entries
        The rows, by the names of the recordings in the table.
    pictures
        Path of each label of pictures; a file names the label, or the last part of the path.
    """
    label_of = _labels_by_name(pictures or {})
    lost: list[str] = []
    table = table.set_index("name", drop=False)
    for name, entry in entries.items():  # a loop over recordings: at most hundreds
        values: dict[str, Any] = {
            "width": entry.width,
            "height": entry.height,
            "fps": entry.fps,
            "context": None if entry.context is None else _context_text(entry.context),
            "speed_kmh": entry.speed_kmh,
            "horizon": entry.horizon,
            "tags": "; ".join(entry.tags) or None,
            "unit": entry.unit,
            "first_picture": entry.first_picture,
            "name": entry.title,
        }
        if entry.pictures is not None and pictures is not None:
            wanted = PurePosixPath(entry.pictures).name
            values["pictures"] = label_of.get(wanted) or label_of.get(safe_name(wanted))
            lost += [wanted] if values["pictures"] is None else []
        for column, value in values.items():
            if value is not None:
                table.loc[name, column] = value
    return table.reset_index(drop=True), lost


def _labels_by_name(pictures: Mapping[str, str | None]) -> dict[str, str]:
    """Label of pictures, by itself and by the last part of the path where only one has that."""
    by_name: dict[str, list[str]] = {}
    for label, path in pictures.items():
        if path is not None:
            by_name.setdefault(PurePosixPath(path).name, []).append(label)
    labels = {name: owners[0] for name, owners in by_name.items() if len(owners) == 1}
    return labels | {label: label for label in pictures}


def saved(dataset: Dataset, session: Session) -> bytes:
    """The recordings as a CSV file that `nvcore.inputs.recordings_file` reads.

    Recordings are named as in the data, what they are called instead is their title; pictures have
    no folders.
    """
    names = dataset.recordings["name"].tolist()
    entries = session.entries(names)
    own = [entries.get(name, RecordingEntry(name)) for name in names]
    shown = editable(dataset, session, {})
    in_data = [entry.name for entry in own]
    columns: dict[str, Any] = {
        "recording": in_data,
        "tags": [";".join(tags) for tags in dataset.recordings["tags"]],
        "pictures": [PurePosixPath(entry.pictures or "").name for entry in own],
        "first_picture": shown["first_picture"].astype("Int64"),
        "title": [
            name if name != other else "" for name, other in zip(names, in_data, strict=True)
        ],
    }
    return to_csv_bytes(shown.rename(columns={"name": "recording"}).assign(**columns))


def changes_in(
    before: pd.DataFrame, after: pd.DataFrame, pictures: Mapping[str, str | None]
) -> dict[str, dict[str, Any]]:
    """Fields of `RecordingEntry` that differ, by the recording's name before.

    Parameters
    ----------
    pictures
        Path of each label of pictures.

    Raises
    ------
    InputError
        If a value is not possible; with the recording.
    """
    changes: dict[str, dict[str, Any]] = {}
    columns = [column for column in COLUMNS if column in after]
    rows = zip(before.to_dict("records"), after.to_dict("records"), strict=True)
    for old, new in rows:
        change: dict[str, Any] = {}
        for column in columns:
            if _is_same(old[column], new[column]):
                continue
            try:
                change |= _field(column, new[column], pictures)
            except ValueError as error:
                raise InputError(f"recording {old['name']!r}: {column}: {error}") from error
        if change:
            changes[str(old["name"])] = change
    return changes


def _field(column: str, value: Any, pictures: Mapping[str, str | None]) -> dict[str, Any]:
    text = "" if _is_empty(value) else str(value).strip()
    if column == "name":
        if not text:
            raise ValueError("expected a name, found nothing")
        return {"title": text}
    if column == "tags":
        tags = [tag.strip() for tag in text.replace(",", ";").split(";")]
        return {"tags": tuple(dict.fromkeys(tag for tag in tags if tag))}
    if column == "unit":
        return {"unit": text or None}
    if column == "context":
        return {"context": parse_context(text) if text else None}
    if column == "pictures":
        return {"pictures": pictures.get(text)}
    if column == "first_picture":
        return {"first_picture": _whole(float(value)) if text else None}
    if column in MAY_BE_UNKNOWN and not text:
        return {column: None}
    if column == "horizon":
        return {column: _finite(float(value))}
    if not text:
        raise ValueError("expected a positive number, found nothing")
    number = float(value)
    if not 0 < number < np.inf:
        raise ValueError(f"expected a positive number, found {number:g}")
    return {column: number}


def _whole(number: float) -> int:
    if not number.is_integer():
        raise ValueError(f"expected a frame number, found {number:g}")
    return int(number)


def _finite(number: float) -> float:
    if not np.isfinite(number):
        raise ValueError(f"expected a finite number, found {number:g}")
    return number


def _is_same(old: Any, new: Any) -> bool:
    return bool(old == new) or (_is_empty(old) and _is_empty(new))


def _is_empty(value: Any) -> bool:
    return value is None or value == "" or bool(pd.isna(value))


def _context_text(value: float) -> str:
    if np.isnan(value):
        return ""
    word = context_word(value)
    return word if isinstance(word, str) else f"{word:g}"
