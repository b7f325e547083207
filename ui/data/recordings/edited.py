"""What a person changed in the table of recordings, as entries of the session."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.errors import InputError
from nvcore.inputs.session import RecordingEntry
from nvcore.params.traffic import context_word, parse_context

NO_PICTURES: Final = "no pictures"
COLUMNS: Final = ("name", "width", "height", "fps", "context", "tags", "pictures")
NAMES_ALONE: Final = frozenset({"title", "tags"})
"""Fields that can be changed without reading the files again."""


def editable(dataset: Dataset, pictures: Mapping[str, str]) -> pd.DataFrame:
    """The table to be edited: a row per recording, texts as a person types them.

    Parameters
    ----------
    pictures
        Label of each recording's pictures, by its name.
    """
    table = dataset.recordings
    return pd.DataFrame(
        {
            "name": table["name"].astype(object),
            "width": table["width"].astype(float),
            "height": table["height"].astype(float),
            "fps": table["fps"].astype(float),
            "context": [_context_text(value) for value in table["context"]],
            "tags": ["; ".join(tags) for tags in table["tags"]],
            "pictures": [pictures.get(name, NO_PICTURES) for name in table["name"]],
        }
    )


def filled(table: pd.DataFrame, entries: Iterable[RecordingEntry]) -> pd.DataFrame:
    """The table with what the rows of a CSV file say, by the names of the recordings."""
    table = table.set_index("name", drop=False)
    for entry in entries:  # a loop over recordings: at most hundreds
        values: dict[str, Any] = {
            "width": entry.width,
            "height": entry.height,
            "fps": entry.fps,
            "context": None if entry.context is None else _context_text(entry.context),
            "tags": "; ".join(entry.tags) or None,
            "name": entry.title,
        }
        for column, value in values.items():
            if value is not None:
                table.loc[entry.name, column] = value
    return table.reset_index(drop=True)


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
    rows = zip(before.to_dict("records"), after.to_dict("records"), strict=True)
    for old, new in rows:
        change: dict[str, Any] = {}
        for column in COLUMNS:
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
    if column == "context":
        return {"context": parse_context(text) if text else None}
    if column == "pictures":
        return {"pictures": pictures.get(text)}
    if not text:
        raise ValueError("expected a positive number, found nothing")
    number = float(value)
    if not 0 < number < np.inf:
        raise ValueError(f"expected a positive number, found {number:g}")
    return {column: number}


def _is_same(old: Any, new: Any) -> bool:
    return bool(old == new) or (_is_empty(old) and _is_empty(new))


def _is_empty(value: Any) -> bool:
    return value is None or value == "" or bool(pd.isna(value))


def _context_text(value: float) -> str:
    if np.isnan(value):
        return ""
    word = context_word(value)
    return word if isinstance(word, str) else f"{word:g}"
