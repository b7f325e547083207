"""The file of estimates that ``nvcore driver estimate`` writes, and others write by hand."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.inputs.readers.base import Lines, SourceFile
from nvcore.inputs.readers.csv_columns import Header, csv_content, read_columns, read_header
from nvcore.inputs.readers.meaning.values import checked_numbers
from nvcore.inputs.readers.parse.text import whole_numbers
from nvcore.schema import NO_TRACK, names_as_categories

NEEDED: Final = ("recording", "frame", "x", "y", "w", "h", "detectability")
OPTIONAL: Final = ("track", "sd", "is_outside", "period_s")
_CALLED: Final = {"sd": "detectability_sd"}
"""What some columns are called in a dataset."""


def read_detectability(file: SourceFile) -> pd.DataFrame:
    """Read a file of estimates: ``recording,frame,x,y,w,h,detectability`` and more.

    Columns may stand in any order; track, sd, is_outside and period_s may be missing, others are
    not read. An empty detectability is unknown; where period_s is empty, no change of light is.

    Returns
    -------
    Columns recording (category), frame, x, y, w, h (px), track (`NO_TRACK`: none), detectability,
    detectability_sd, is_outside, is_adapted, line (1-based); one row per row of the file.

    Raises
    ------
    FormatError
        With file and line of what is missing, is no number, or is outside 0 to 1.
    """
    content = csv_content(file, role="truth")
    header = _header(file, content)
    names = list(header.place)
    columns, line, _ = read_columns(file, header, content, names)
    lines = Lines.of(file, line)
    recording = names_as_categories(columns["recording"], len(lines))
    if "" in recording.categories:
        is_empty = np.asarray(recording == "")
        if is_empty.any():
            message = "expected the name of a recording, found an empty field"
            raise lines.fault(int(np.argmax(is_empty)), message)
    table: dict[str, object] = {
        "recording": recording,
        "frame": whole_numbers(columns["frame"].to_numpy(), lines, "frame"),
        **{name: columns[name].to_numpy() for name in "xywh"},
        "track": _tracks(columns, lines),
        "detectability": checked_numbers(
            columns["detectability"].to_numpy(), lines, "detectability", high=1
        ),
        "detectability_sd": np.full(len(lines), np.nan),
        "is_outside": np.zeros(len(lines), dtype=bool),
        "is_adapted": np.zeros(len(lines), dtype=bool),
        "line": line,
    }
    if "detectability_sd" in columns:
        sd = checked_numbers(columns["detectability_sd"].to_numpy(), lines, "sd")
        table["detectability_sd"] = sd
    if "is_outside" in columns:
        table["is_outside"] = columns["is_outside"].to_numpy(dtype=bool)
    if "period_s" in columns:
        period_s = checked_numbers(columns["period_s"].to_numpy(), lines, "period_s")
        table["is_adapted"] = np.isnan(period_s)
    return pd.DataFrame(table, copy=False)


def _header(file: SourceFile, content: bytes) -> Header:
    line = read_header(content[: content.find(b"\n")].decode())
    place = {name.lower(): number for number, name in reversed([*enumerate(line.names)])}
    missing = [name for name in NEEDED if name not in place]
    if missing:
        expected = f"{','.join(NEEDED)}[,{','.join(OPTIONAL)}]"
        raise file.fault(
            f"expected a header line with the columns {expected}; found {', '.join(line.names)}; "
            f"missing: {', '.join(missing)}",
            1,
        )
    known = {_CALLED.get(name, name): place[name] for name in (*NEEDED, *OPTIONAL) if name in place}
    return Header(line.names, line.delimiter, known)


def _tracks(columns: pd.DataFrame, lines: Lines) -> np.ndarray:
    """Track of each row; `NO_TRACK` where there is none, or ids are text."""
    none = np.full(len(lines), NO_TRACK)
    if "track" not in columns or isinstance(columns["track"].dtype, pd.CategoricalDtype):
        return none
    track = columns["track"].to_numpy(dtype=float)
    is_known = ~np.isnan(track)
    none[is_known] = whole_numbers(track[is_known], lines[is_known], "track")
    return none
