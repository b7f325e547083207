"""Tables of the inputs: sources, rows that could not be used, subjects of each finding."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from nvcore.common.findings import Cases, Finding
from nvcore.common.output.cvat import cvat_bytes
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_TRACK
from nvcore.dataset.sources import ReadAs, left_out_text
from nvcore.metrics.proximity.horizon import Horizon, estimate_horizons
from nvcore.tables.columns import column_names

NO_ROW = -1
"""Value for the row of a frame that is not evaluated."""


def inputs_table(dataset: Dataset) -> pd.DataFrame:
    """Tabulate the sources and how they were read.

    Returns
    -------
    One row per source, in the order of ``boxes.source``: the truth, then the systems. Columns:
    subject ("truth" or the system's name), first_file (its name), n_files, format, conversion (in
    words), left_out (unused content of the files, in words), n_boxes (boxes used, including ignored
    ones). No rows for data made in memory.
    """
    source, subjects = pd.factorize(dataset.inputs["subject"])
    first = dataset.inputs.drop_duplicates("subject", ignore_index=True)
    n_boxes = np.bincount(dataset.boxes["source"], minlength=len(subjects))
    return pd.DataFrame(
        {
            "subject": first["subject"],
            "first_file": first["file"],
            "n_files": np.bincount(source, minlength=len(subjects)),
            "format": first["format"],
            "conversion": first["conversion"],
            "left_out": [
                left_out_text(dataset.read_as.get(subject, ReadAs()).left_out)
                for subject in first["subject"]
            ],
            "n_boxes": n_boxes[: len(subjects)],
        }
    )


def left_out_table(dataset: Dataset) -> pd.DataFrame:
    """Count the rows of each source that could not be used: columns subject, reason, n_rows."""
    counts = dataset.left_out.groupby(["subject", "reason"], sort=False).size()
    return counts.rename("n_rows").reset_index()


def open_horizons(dataset: Dataset) -> dict[str, Horizon]:
    """Estimate the horizons of recordings that do not state theirs, by name."""
    is_open = dataset.recordings["horizon"].isna()
    facts = zip(dataset.recordings["name"], is_open, estimate_horizons(dataset), strict=True)
    return {name: horizon for name, is_asked, horizon in facts if is_asked and horizon is not None}


def horizons_table(dataset: Dataset) -> pd.DataFrame:
    """Tabulate estimated horizons of the recordings that do not state theirs.

    Returns
    -------
    One row per recording with an estimate: recording, horizon (row of the picture, px).
    """
    rows = [(name, round(horizon.row_px, 1)) for name, horizon in open_horizons(dataset).items()]
    return pd.DataFrame(rows, columns=["recording", "horizon"])


def finding_entries(dataset: Dataset, findings: Sequence[Finding]) -> pd.DataFrame:
    """Tabulate every place that the findings concern, one row each.

    Parameters
    ----------
    dataset
        Audited dataset.
    findings
        Findings of its audit. Findings about an input as a whole have no rows.

    Returns
    -------
    The columns of ``finding_entries.csv``: finding (number of the row in ``findings.csv``, from 1),
    code, subject, recording, frame, x, y, w, h (px), score, track, file, line. Values that do not
    apply are missing. Rows of one finding are in the order of its cases.
    """
    tables = [
        _entries(dataset, finding.cases).assign(
            finding=number, code=finding.code, subject=finding.subject
        )
        for number, finding in enumerate(findings, start=1)
        if finding.cases is not None
    ]
    if not tables:
        tables = [_entries(dataset, NO_CASES).assign(finding=1, code="", subject="")]
    return pd.concat(tables, ignore_index=True)[column_names("finding_entries.csv")]


NO_CASES = Cases("frames", np.empty(0, np.int64))


def entry_frames(dataset: Dataset, cases: Cases) -> np.ndarray:
    """Return the row of the frames table of each case, `NO_ROW` if not evaluated."""
    if cases.table == "frames":
        return cases.rows.astype(np.int64)
    if cases.table == "boxes":
        of_box: np.ndarray = dataset.boxes["frame_index"].to_numpy()[cases.rows]
        return of_box.astype(np.int64)
    lost = dataset.left_out.iloc[cases.rows]
    codes = pd.Index(dataset.recordings["name"]).get_indexer(pd.Index(lost["recording"]))
    places = pd.MultiIndex.from_frame(dataset.frames[["recording", "frame"]])
    wanted = pd.MultiIndex.from_arrays([codes, lost["frame"].to_numpy()])
    return places.get_indexer(wanted)


def entries_as_cvat(
    dataset: Dataset,
    findings: Sequence[Finding],
    *,
    label: str | None = None,
    file_names: Mapping[int, str] | None = None,
) -> bytes:
    """Return the frames of the findings with their boxes, as CVAT for images XML 1.1.

    CVAT finds pictures by name. A frame with a known file has that name, below the recording's
    (``night_01/I00012.png``) if the findings are about several. Other frames are called
    ``recording/000012.png``, as `nvcore convert` does in COCO. Cases without a box, such as a
    recording without detections, are pictures without boxes. Rows that could not be used are left
    out.

    Parameters
    ----------
    label
        Label of all boxes; None: the code of the finding.
    file_names
        Name of a frame's picture, by its row of the frames table
        (`nvcore.pictures.recordings.picture_names`); None if unknown.
    """
    placed = [(finding, finding.cases) for finding in findings if finding.cases is not None]
    placed = [(finding, cases) for finding, cases in placed if cases.table != "left_out"]
    rows = np.concatenate(
        [np.empty(0, np.int64), *(entry_frames(dataset, cases) for _, cases in placed)]
    )
    frames, picture = np.unique(rows, return_inverse=True)
    recording = dataset.frames["recording"].to_numpy()[frames]
    known = dataset.recordings[["name", "width", "height"]].iloc[recording]
    numbers = dataset.frames["frame"].to_numpy()[frames]
    folders = [f"{name}/" for name in known["name"]]
    own_folders = folders if len({*folders}) > 1 else [""] * len(folders)
    files = [(file_names or {}).get(int(row)) for row in frames]
    names = [
        f"{folder}{number:06d}.png" if file is None else f"{own_folder}{file}"
        for folder, own_folder, number, file in zip(
            folders, own_folders, numbers, files, strict=True
        )
    ]
    boxes = pd.concat(
        [
            _entries(dataset, NO_CASES).assign(label=""),
            *(
                _entries(dataset, cases).assign(label=finding.code if label is None else label)
                for finding, cases in placed
            ),
        ],
        ignore_index=True,
    ).assign(picture=picture.reshape(-1))
    return cvat_bytes(known.assign(name=names), boxes[boxes["x"].notna()])


def _entries(dataset: Dataset, cases: Cases) -> pd.DataFrame:
    """Return place, box and line of each case."""
    if cases.table == "left_out":
        table = dataset.left_out.iloc[cases.rows][["recording", "frame", "file", "line"]]
        table = table.reset_index(drop=True)
    else:
        rows = entry_frames(dataset, cases)
        recording = dataset.frames["recording"].to_numpy()[rows]
        table = pd.DataFrame(
            {
                "recording": dataset.recordings["name"].to_numpy()[recording],
                "frame": dataset.frames["frame"].to_numpy()[rows],
            }
        )
    if cases.table == "boxes":
        names = ["x", "y", "w", "h", "score", "track", "file", "line"]
        boxes = dataset.boxes.iloc[cases.rows][names].reset_index(drop=True)
        table = pd.concat([table, boxes], axis=1)
    for name in ("x", "y", "w", "h", "score", "track", "file", "line"):
        if name not in table:
            table[name] = np.nan
    track, line = (table[name].astype("Int64") for name in ("track", "line"))
    has_line = (line >= 1).fillna(value=False).to_numpy(dtype=bool)
    return table.assign(
        track=track.mask(track == NO_TRACK),
        line=line.mask(~has_line),
        file=_file_names(dataset, table["file"].to_numpy(), has_line),
    )


def _file_names(dataset: Dataset, files: np.ndarray, has_line: np.ndarray) -> np.ndarray:
    """Return the name of each row's input file, or None for rows without one."""
    names = np.array([*dataset.inputs["file"], None], dtype=object)
    number = np.where(has_line, np.nan_to_num(files.astype(float), nan=-1), -1).astype(np.int64)
    is_known = (number >= 0) & (number < len(names) - 1)
    of_row: np.ndarray = names[np.where(is_known, number, -1)]
    return of_row
