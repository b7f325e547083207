"""Read JSON files as lists of records, with errors that name file, line and record."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from functools import cached_property
from itertools import chain
from typing import Final

import numpy as np

from nvcore.common.errors import FormatError
from nvcore.common.wording import shortened
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.parse.text import read_text

NESTED = ("extra_info", "attributes")
"""Fields of a record in which tools keep further fields (Teledyne FLIR, CVAT)."""


_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")


def read_json(file: SourceFile) -> object:
    """Read a JSON file.

    Raises
    ------
    FormatError
        If it is not JSON.
    """
    text = read_text(file)
    try:
        document: object = json.loads(text)
    except json.JSONDecodeError as error:
        raise file.fault(
            f"expected JSON: {error.msg} (column {error.colno}); is the file complete?",
            error.lineno,
        ) from error
    except (RecursionError, ValueError) as error:
        # ValueError: a whole number of more than 4300 digits
        raise file.fault(
            "expected JSON with lists and numbers of sensible size, found nesting or a number "
            "without end"
        ) from error
    if _SURROGATE.search(text) is not None:
        try:
            json.dumps(document, ensure_ascii=False).encode()
        except UnicodeEncodeError as error:
            raise file.fault(
                r"expected Unicode text, found half a character (\ud800 to \udfff)"
            ) from error
    return document


def short_json(value: object) -> str:
    """Format a JSON value as short text, for errors."""
    is_json = value is None or isinstance(value, (bool, dict, list))
    return shortened(json.dumps(value) if is_json else repr(value), 60)


def first_other(values: Sequence[object], allowed: set[type]) -> int | None:
    """Return the index of the first value of another type."""
    if set(map(type, values)) <= allowed:
        return None
    return next(i for i, value in enumerate(values) if type(value) not in allowed)


_NO_BOX: Final = [math.nan] * 4
_MASKS: Final = (
    "masks (RLE) alone, which are not read: add the box around each mask, as "
    "pycocotools.mask.toBbox gives it"
)


class Records:
    """List of JSON objects that is read by columns.

    Parameters
    ----------
    rows
        The list as it is in the file.
    file
        The file, for errors.
    what
        Term for one record, for errors: "annotation".
    key
        Field of the document that holds the list. Empty if the list is the document.

    Raises
    ------
    FormatError
        If `rows` is not a list of objects.
    """

    def __init__(self, rows: object, file: SourceFile, what: str, key: str = "") -> None:
        self.file = file
        self.what = what
        self.key = key
        if not isinstance(rows, list):
            where = f'"{key}"' if key else "the file"
            raise file.fault(f"expected {where} to be a list of {what}s, found {short_json(rows)}")
        self.rows: list[dict[str, object]] = rows
        self.check_types(rows, {dict}, "an object {...}")

    def __len__(self) -> int:
        return len(self.rows)

    def error(self, index: int, message: str) -> FormatError:
        """Return an error about one record, for the caller to raise."""
        line = _line_of_record(read_text(self.file), self.key, index)
        return self.file.fault(f"{self.what} {index + 1} of {len(self.rows)}: {message}", line)

    def check_types(self, values: Sequence[object], allowed: set[type], expected: str) -> None:
        """Raise FormatError for the first record with a value of another type."""
        first = first_other(values, allowed)
        if first is not None:
            raise self.error(first, f"expected {expected}, found {short_json(values[first])}")

    @cached_property
    def _layers(self) -> list[tuple[list[dict[str, object]], set[str]]]:
        """Return the records, then the objects nested in them, with the names of their fields."""
        layers = [(self.rows, set(chain.from_iterable(self.rows)))]
        for key in NESTED:
            if key in layers[0][1]:
                inner = [row.get(key) for row in self.rows]
                nested = [value if isinstance(value, dict) else {} for value in inner]
                layers.append((nested, set(chain.from_iterable(nested))))
        return layers

    def values(self, *keys: str) -> list[object] | None:
        """Return the first field that any record has, None where a record lacks it.

        None if no record has any of the fields.
        """
        for key in keys:
            for rows, present in self._layers:
                if key in present:
                    return [row.get(key) for row in rows]
        return None

    def required(self, *keys: str) -> list[object]:
        """Return `values` of a field, or raise FormatError if a record lacks it."""
        values = self.values(*keys)
        if values is None:
            values = [None] * len(self.rows)
        if None in values:
            raise self.error(values.index(None), f'expected the field "{keys[0]}", found none')
        return values

    def numbers(self, *keys: str) -> np.ndarray | None:
        """Return the first field that any record has, as float64, NaN where missing."""
        values = self.values(*keys)
        if values is None:
            return None
        self.check_types(values, {int, float, type(None)}, f'a number as "{keys[0]}"')
        return self.to_floats(values, keys[0])

    def flags(self, *keys: str) -> np.ndarray:
        """Mark records in which any of the fields (0, 1, true, false) is set."""
        is_set = np.zeros(len(self.rows), dtype=bool)
        for key in keys:
            values = self.values(key)
            if values is not None:
                self.check_types(values, {int, float, bool, type(None)}, f'0 or 1 as "{key}"')
                is_set |= np.fromiter((bool(value) for value in values), bool, len(values))
        return is_set

    def boxes(self) -> np.ndarray:
        """Return ``bbox`` of every record as float64 of shape (n, 4): x, y, w, h.

        A missing or empty one becomes the box around the polygons of ``segmentation``, or NaN if
        there are none.

        Raises
        ------
        FormatError
            If no record has one, or a record has an invalid one, with the first such record.
        """
        values = self.values("bbox") or [None] * len(self.rows)
        is_lacking = [value is None or value == [] for value in values]
        if any(is_lacking):
            shapes = self.values("segmentation") or [None] * len(self.rows)
            values = [
                _around(shape) if lacks else value
                for value, shape, lacks in zip(values, shapes, is_lacking, strict=True)
            ]
            if all(is_lacking) and values == [_NO_BOX] * len(values):
                found = _MASKS if isinstance(shapes[0], dict) else "none"
                raise self.error(0, f'expected the field "bbox", found {found}')
        expected = "bbox [x, y, width, height]"
        self.check_types(values, {list}, expected)
        boxes: list[list[object]] = values  # type: ignore[assignment]
        if not set(map(len, boxes)) <= {4}:
            first, box = next((i, box) for i, box in enumerate(boxes) if len(box) != 4)
            raise self.error(
                first, f"expected {expected}, found {len(box)} values: {short_json(box)}"
            )
        flat = list(chain.from_iterable(boxes))
        wrong = first_other(flat, {int, float})
        if wrong is not None:
            box = boxes[wrong // 4]
            raise self.error(wrong // 4, f"expected four numbers as bbox, found {short_json(box)}")
        return self.to_floats(flat, "bbox").reshape(-1, 4)

    def to_floats(self, values: list[object], key: str) -> np.ndarray:
        """Convert numbers of a field to float64, None to NaN."""
        try:
            return np.array(values, dtype=float)
        except OverflowError:
            raise self.file.fault(
                f'expected numbers below 1e308 as "{key}" of the {self.what}s'
            ) from None


def _around(shape: object) -> list[float]:
    """Return the box around polygons [[x, y, x, y, ...], ...], NaN if they are invalid."""
    parts = shape if isinstance(shape, list) else []
    try:
        points = np.concatenate([np.array(part, float).reshape(-1, 2) for part in parts])
    except (TypeError, ValueError):  # no numbers, or an odd number of them
        return _NO_BOX
    if not len(points) or not np.isfinite(points).all():
        return _NO_BOX
    low, high = points.min(axis=0), points.max(axis=0)
    return [*low.tolist(), *(high - low).tolist()]


def _line_of_record(text: str, key: str, index: int) -> int | None:
    """Find the line of a record for an error message, by parsing the text again."""
    start = re.search(rf'"{key}"\s*:\s*\[', text) if key else re.search(r"\[", text)
    if start is None:
        return None
    begin = position = start.end()
    for _ in range(index + 1):
        separator = re.compile(r"[\s,]*").match(text, position)
        assert separator is not None
        begin = separator.end()
        try:
            position = json.JSONDecoder().raw_decode(text, begin)[1]
        except ValueError:
            return None
    return text.count("\n", 0, begin) + 1
