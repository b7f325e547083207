"""Columns of a CSV file with a header, recognised by synonyms of their names."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import product
from typing import Any, Final

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv

from nvcore.common.errors import FormatError
from nvcore.common.output.csv_text import without_safeguard
from nvcore.common.wording import shortened
from nvcore.dataset.schema import BOX_DTYPES, categories_of
from nvcore.inputs.readers.base import Role, SourceFile
from nvcore.inputs.readers.parse.text import BLOCK, MAX_INTEGER, line_blocks, read_text_bytes

SYNONYMS: Final[dict[str, tuple[str, ...]]] = {
    "frame": (
        *("frame", "video_frame", "frame_number", "frame_no", "frame_nr", "frame_index"),
        *("frame_idx", "frame_id", "frameid", "framenumber", "frameindex"),
    ),
    "x": ("x", "left", "bb_left", "bbox_left", "bbox_x", "xmin", "x_min", "x1", "xtl", "x0"),
    "y": ("y", "top", "bb_top", "bbox_top", "bbox_y", "ymin", "y_min", "y1", "ytl", "y0"),
    "w": ("w", "width", "bb_width", "bbox_width", "bbox_w", "box_width"),
    "h": ("h", "height", "bb_height", "bbox_height", "bbox_h", "box_height"),
    "xc": (
        *("xc", "cx", "x_c", "x_center", "x_centre", "xcenter", "xcentre", "center_x", "centre_x"),
        *("centerx", "centrex"),
        *("bbox_cx", "bbox_xc", "bbox_center_x", "bbox_x_center", "bb_cx", "xmid", "x_mid"),
    ),
    "yc": (
        *("yc", "cy", "y_c", "y_center", "y_centre", "ycenter", "ycentre", "center_y", "centre_y"),
        *("centery", "centrey"),
        *("bbox_cy", "bbox_yc", "bbox_center_y", "bbox_y_center", "bb_cy", "ymid", "y_mid"),
    ),
    "right": ("x2", "xmax", "x_max", "right", "xbr", "bb_right", "bbox_right"),
    "bottom": ("y2", "ymax", "y_max", "bottom", "ybr", "bb_bottom", "bbox_bottom"),
    "score": ("score", "conf", "confidence", "probability", "prob"),
    "track": (
        *("track", "track_id", "trackid", "object_id", "target_id"),
        *("instance_id", "person_id", "ped_id", "identity", "id"),
    ),
    "ignore": ("ignore", "ignored", "is_ignore", "dontcare", "dont_care", "iscrowd"),
    "distance_m": ("distance_m", "distance", "range_m", "range", "dist_m", "dist", "depth_m"),
    "occlusion": ("occlusion", "occ", "occluded", "occlusion_level"),
    "detectability": ("detectability",),
    "recording": (
        *("recording", "recording_id"),
        *("sequence", "sequence_name", "sequence_id", "seq"),
        *("video", "video_id", "video_name", "clip", "scene"),
    ),
    "picture": (
        *("image_name", "file_name", "filename", "im_name", "frame_name"),
        *("image_path", "image_file", "image", "file", "picture"),
    ),
    "attributes": ("attributes", "attribute"),
    "class": (
        *("class", "class_id", "category", "category_id", "label", "label_id", "type", "cls"),
        *("class_name", "category_name", "label_name", "class_label"),
    ),
    "class_name": ("class_name", "category_name", "label_name", "class_label", "name"),
}
"""Synonyms of column names, the plainest first, without case and punctuation."""

OTHER_SCORE: Final = "other_score"
"""Key of `Header.place` for a second column with a name of the score, read as text."""
CLOSE: Final = 0.85
"""Similarity of names (0 to 1, by `difflib`) from which on one may be the other misspelt."""
LEAST_LETTERS: Final = 5
"""Shortest name that is checked for misspellings, since short names are easily similar."""

NUMBERS = (
    *("frame", "x", "y", "w", "h", "xc", "yc", "right", "bottom"),
    *("score", "distance_m", "occlusion", "detectability", "detectability_sd", "period_s"),
)
EXCEL: Final = re.compile(rb"sep=.\n", re.IGNORECASE)
"""First line of Excel's that states the delimiter."""
ALERTED: Final = "alerted"
"""Whether a detection was an alert: a system's own log (`nvcore.subjects.alerts.inputs`)."""
CLAIMS = ("ignore", "is_outside", ALERTED)
_TEXT = pa.dictionary(pa.int32(), pa.string())
MISSING = ["", "nan", "NaN", "NA", "N/A", "null", "None"]
TRUE = ["1", "true", "True", "TRUE", "1.0"]
FALSE = ["0", "false", "False", "FALSE", "0.0"]


@dataclass(frozen=True)
class Header:
    """First line of a CSV file.

    Attributes
    ----------
    names
        Names of the columns in the file.
    delimiter
        Comma, semicolon or tab.
    place
        Index of each recognised column, by its name in `SYNONYMS`.
    """

    names: tuple[str, ...]
    delimiter: str
    place: dict[str, int]

    @property
    def has_box(self) -> bool:
        """Whether there are all four numbers of a box."""
        sizes = {"w", "h"} <= self.place.keys() or {"right", "bottom"} <= self.place.keys()
        return ({"x", "y"} <= self.place.keys() and sizes) or self.has_centres

    @property
    def has_centres(self) -> bool:
        """Whether boxes are given by their centres, not by a corner."""
        return {"xc", "yc", "w", "h"} <= self.place.keys() and not {"x", "y"} <= self.place.keys()

    @property
    def has_frame(self) -> bool:
        """Whether the frame is known: from its number or from the picture's name."""
        return "frame" in self.place or "picture" in self.place


def read_header(line: str) -> Header:
    """Parse a header line, separated by the commonest of comma, semicolon and tab."""
    line = line.rstrip("\r\n")
    delimiter = max(",;\t", key=line.count)
    try:
        fields = next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:  # a line of more than 131,072 characters is no header
        fields = []
    return header_of([name.strip() for name in fields], delimiter)


def header_of(names: Sequence[str], delimiter: str = ",") -> Header:
    """Make the header with these names of columns."""
    plain = [*map(_plain, names)]
    place = {}
    for column, synonyms in SYNONYMS.items():
        places = [plain.index(name) for name in synonyms if name in plain]
        if places:
            place[column] = places[0]
        if column == "score" and len(places) > 1:
            place[OTHER_SCORE] = places[1]
    if place.get("class_name") in (None, place.get("class")) or "class" not in place:
        place.pop("class_name", None)  # name of a class that also has a number
    return Header(tuple(names), delimiter, place)


def misspelt_columns(header: Header, aside: Sequence[str] = ()) -> list[tuple[str, str]]:
    """Find unused columns whose names are similar to those of missing ones.

    Parameters
    ----------
    header
        The columns of a file.
    aside
        Columns, by their names in `SYNONYMS`, that would not be read either.

    Returns
    -------
    list
        Name in the file, and the similar name in `SYNONYMS`.

    Examples
    --------
    >>> misspelt_columns(header_of(["frame", "x", "y", "w", "h", "Detectabilty", "speed"]))
    [('Detectabilty', 'detectability')]
    """
    missing = [column for column in SYNONYMS if column not in {*header.place, *aside}]
    meant = [name for column in missing for name in SYNONYMS[column] if len(name) >= LEAST_LETTERS]
    known = {name for names in SYNONYMS.values() for name in names}
    unknown = [(name, _plain(name)) for name in header.names if _plain(name) not in known]
    close = [(name, get_close_matches(text, meant, 1, CLOSE)) for name, text in unknown]
    return [(name, matches[0]) for name, matches in close if matches]


def _plain(name: str) -> str:
    """Remove case and punctuation from a column's name, as in `SYNONYMS`."""
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")


def read_columns(
    file: SourceFile, header: Header, content: bytes, to_read: Sequence[str]
) -> tuple[pd.DataFrame, np.ndarray, bool]:
    """Read columns: numbers as float64, `CLAIMS` as bool, the rest as text.

    Parameters
    ----------
    file
        The file, for errors.
    header
        Its columns.
    content
        The file from its first line on, without byte order mark.
    to_read
        Columns to read, from `header.place`.

    Returns
    -------
    tuple
        The columns, the 1-based line of each row (int64), and whether the decimal sign is a comma.

    Raises
    ------
    FormatError
        If a line has another number of fields, or a field is not a number, with the first line.
    """
    kinds = {name: _kind(name) for name in to_read}
    signs = (".",) if header.delimiter == "," else (".", ",")
    first = next(name for name in to_read if name in NUMBERS)
    ways = [kinds, {**kinds, "track": _TEXT}] if "track" in kinds else [kinds]
    # files seldom have empty lines, and counting lines takes longer than to try without
    for has_empty_lines in (False, True):
        for decimal, types in product(signs, ways):
            table = _parse(content, header, types, decimal, has_empty_lines=has_empty_lines)
            if table is None or (table[first].null_count and not has_empty_lines):
                continue  # an empty line is a row without numbers
            n_rows = table.num_rows
            line = _lines(content, n_rows) if has_empty_lines else _next_lines(n_rows)
            columns = {name: _column(table[name]) for name in to_read}
            frame = pd.DataFrame(columns, index=range(n_rows), copy=False)
            return frame, line, decimal == ","
    raise _first_fault(file, header, content, to_read)


def _kind(name: str) -> pa.DataType:
    """Return the type to read the values of a column as."""
    if name in (*NUMBERS, "track"):
        return pa.float64()
    return pa.bool_() if name in CLAIMS else _TEXT


def _parse(
    content: bytes,
    header: Header,
    kinds: dict[str, pa.DataType],
    decimal: str,
    *,
    has_empty_lines: bool,
) -> pa.Table | None:
    """Parse columns by pyarrow, or return None if a field or the number of fields is wrong."""
    names = [f"unused {i}" for i in range(len(header.names))]
    for name in kinds:
        names[header.place[name]] = name
    try:
        table = pyarrow.csv.read_csv(
            pa.BufferReader(content),
            read_options=pyarrow.csv.ReadOptions(column_names=names, skip_rows=1, block_size=BLOCK),
            parse_options=pyarrow.csv.ParseOptions(
                delimiter=header.delimiter, ignore_empty_lines=has_empty_lines
            ),
            convert_options=pyarrow.csv.ConvertOptions(
                column_types=kinds,
                include_columns=list(kinds),
                null_values=MISSING,
                strings_can_be_null=False,
                true_values=TRUE,
                false_values=FALSE,
                decimal_point=decimal,
            ),
        )
    except pa.ArrowInvalid:
        return None
    if "track" in kinds and kinds["track"] != _TEXT:
        # track ids that are not whole, or too large for float64, are text, like hashes
        try:
            whole = table["track"].cast(pa.int64())
        except pa.ArrowInvalid:
            return None
        ends = pc.min_max(whole).as_py()
        if max(abs(ends["min"] or 0), abs(ends["max"] or 0)) >= MAX_INTEGER:
            return None
    return table


def _column(column: pa.ChunkedArray) -> Any:
    """Convert a column: missing flags to False, missing numbers to NaN, texts to categories."""
    if pa.types.is_boolean(column.type):
        return pc.fill_null(column, False).to_numpy()
    if pa.types.is_floating(column.type):
        return column.to_numpy()
    # names repeat: each distinct name is parsed once
    coded = column.unify_dictionaries().combine_chunks()
    texts = [without_safeguard(text.strip()) for text in coded.dictionary.to_pylist()]
    codes = coded.indices.to_numpy(zero_copy_only=False)
    names = list(dict.fromkeys(texts))
    if len(names) < len(texts):  # some differed only in blanks
        place = {name: code for code, name in enumerate(names)}
        codes = np.array([place[text] for text in texts], dtype=codes.dtype)[codes]
    return categories_of(codes, names)


def _lines(content: bytes, n_rows: int) -> np.ndarray:
    """Return the 1-based line of each row, skipping the header and empty lines."""
    n_lines = content.count(b"\n") + (not content.endswith(b"\n"))
    if n_lines == n_rows + 1:
        return _next_lines(n_rows)
    filled = [number for number, text in enumerate(content.split(b"\n"), 1) if text.strip()][1:]
    if len(filled) != n_rows:  # a quoted text over several lines: count the rows
        return _next_lines(n_rows)
    return np.array(filled, dtype=np.int64)


def _next_lines(n_rows: int) -> np.ndarray:
    """Number rows from line 2 on, as in a file without empty lines."""
    return np.arange(2, n_rows + 2, dtype=BOX_DTYPES["line"])


def _first_fault(
    file: SourceFile, header: Header, content: bytes, to_read: Sequence[str]
) -> FormatError:
    """Return an error about the first unreadable line, searching line by line."""
    n_before = 0
    if b'"' not in content:  # else a line may be a part of a text
        n_before, content = _first_odd_block(header, content, to_read)
    text = content.decode("utf-8", "replace")
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=header.delimiter)
    layout = header.delimiter.join(header.names)
    try:
        for row in rows:
            line = n_before + rows.line_num
            if line == 1 or not row or row == [""]:
                continue
            fault = _fault(row, header, to_read, layout)
            if fault is not None:
                return file.fault(fault, line)
    except csv.Error as error:
        return file.fault(f"expected CSV: {error}", n_before + rows.line_num)
    return file.fault(
        f"expected CSV with the columns {layout}, found lines that cannot be told apart; is there "
        "a quotation mark too many?"
    )


def _first_odd_block(header: Header, content: bytes, to_read: Sequence[str]) -> tuple[int, bytes]:
    """Return the first unreadable block and the number of lines before it, else all lines."""
    kinds = {name: _TEXT if name == "track" else _kind(name) for name in to_read}
    signs = (".", ",") if header.delimiter == ";" else (".",)
    for n_before, block in line_blocks(content):
        lines = block if n_before == 0 else b"\n" + block  # after a header
        if all(_parse(lines, header, kinds, sign, has_empty_lines=False) is None for sign in signs):
            return n_before, block
    return 0, content


def _fault(row: list[str], header: Header, to_read: Sequence[str], layout: str) -> str | None:
    """Describe the fault of a row, or return None."""
    if len(row) != len(header.names):
        return f"expected {len(header.names)} fields ({layout}), found {len(row)}"
    for name in to_read:
        value = row[header.place[name]].strip()
        title = header.names[header.place[name]]
        if name in CLAIMS and value not in MISSING + TRUE + FALSE:
            return f"expected 0, 1, true or false as {title}, found {shortened(value, 60)!r}"
        if name in NUMBERS and value not in MISSING:
            try:
                float(value.replace("_", "?"))  # Python reads 1_000, the fast parser does not
            except ValueError:
                return f"expected a number as {title}, found {shortened(value, 60)!r}"
    return None


def csv_content(file: SourceFile, *, role: Role) -> bytes:
    """Read a CSV file from its header on, without byte order mark, with LF line ends.

    Excel's first line ``sep=;`` becomes an empty line after the header, to keep line numbers.

    The empty file of a system that detected nothing becomes a header without rows.

    Raises
    ------
    FormatError
        If it is not UTF-8 text, or is empty ground truth.
    """
    content = read_text_bytes(file)
    if b"\r" in content:
        content = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if excel := EXCEL.match(content):
        header, end, rows = content[excel.end() :].partition(b"\n")
        content = header + end + b"\n" + rows
    if not content or content.isspace():
        if role == "detections":
            return b"frame,x,y,w,h\n"
        raise file.fault(
            "the file is empty; expected a header line such as frame,x,y,w,h,track (the ground "
            "truth of a recording without pedestrians has the header only)"
        )
    return content if b"\n" in content else content + b"\n"  # pyarrow wants the header's end
