"""Decisions of reviewers on cases, and the comparison without what they found to be wrong."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace
from datetime import UTC, datetime
from enum import StrEnum
from io import StringIO
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.findings import Cases, Finding, Severity
from nvcore.common.output.csv_text import to_csv_bytes, without_safeguard
from nvcore.common.output.files import write_whole
from nvcore.comparison.compare import Result, compare
from nvcore.comparison.measures.entry import MeasureTable
from nvcore.dataset import Dataset
from nvcore.dataset.schema import NO_TRACK
from nvcore.subjects.review.cases import CaseKind, CaseList
from nvcore.tables.inputs import entries_as_cvat
from nvcore.tables.scorecard import ScoreRow, score_rows

COLUMNS: Final = ("case", "reviewer", "decision", "note", "is_done", "at")
MOST_NOTE: Final = 2000
"""Maximum length of a note or a reviewer's name, characters."""


class Decision(StrEnum):
    """What a reviewer decides on a case. `OPEN` takes a decision back."""

    OPEN = ""
    REAL_MISS = "real miss"
    FALSE_ALARM = "false alarm"
    WRONG_TRUTH = "wrong truth"
    IRRELEVANT = "irrelevant"
    ASK = "ask"


LEAVES_OUT: Final = (Decision.WRONG_TRUTH, Decision.IRRELEVANT)
"""Decisions that take the boxes of a case out of the comparison."""
_IS_DONE: Final = {"true": True, "1": True, "false": False, "0": False}
DISPUTED: Final = "disputed"
"""State of a case on which reviewers disagree."""


def empty_decisions() -> pd.DataFrame:
    """Return a table of decisions without rows: `COLUMNS`."""
    columns = {name: pd.Series(dtype=bool if name == "is_done" else object) for name in COLUMNS}
    return pd.DataFrame(columns)


def make_decision(
    case: str,
    decision: str,
    *,
    reviewer: str = "",
    note: str = "",
    is_done: bool | None = None,
    at: datetime | None = None,
) -> pd.DataFrame:
    """Return one row of a table of decisions.

    Parameters
    ----------
    is_done
        None: done unless the decision is open or a question.
    at
        Time of the decision, UTC; None: now.

    Raises
    ------
    InputError
        If there is no such decision, or a text is too long.
    """
    try:
        made = Decision(decision)
    except ValueError:
        known = ", ".join(of.value for of in Decision if of)
        raise InputError(f"no decision {decision!r}: the decisions are {known}") from None
    for text, noun in ((note, "note"), (reviewer, "reviewer's name")):
        if len(text) > MOST_NOTE:
            raise InputError(f"a {noun} has {MOST_NOTE:,} characters at most")
    done = made not in (Decision.OPEN, Decision.ASK) if is_done is None else is_done
    time = (at or datetime.now(UTC)).isoformat(timespec="seconds")
    return pd.DataFrame([(case, reviewer, made.value, note, done, time)], columns=list(COLUMNS))


def latest(decisions: pd.DataFrame) -> pd.DataFrame:
    """Return each reviewer's latest decision on each case, without those taken back."""
    last = decisions.drop_duplicates(["case", "reviewer"], keep="last")
    return last[last["decision"] != Decision.OPEN].reset_index(drop=True)


def decided(cases: CaseList, decisions: pd.DataFrame) -> pd.DataFrame:
    """Return the cases with what was decided on them.

    Returns
    -------
    The table of the cases with decision (empty: none; `DISPUTED` if reviewers disagree), note and
    reviewer (of the latest decision), and is_done.
    """
    last = latest(decisions)
    groups = last.groupby("case", sort=False)
    summary = groups.last().drop(columns="at")
    is_disputed = (groups["decision"].agg(set).map(len) > 1).to_numpy(bool)
    summary.loc[is_disputed, ["decision", "is_done"]] = DISPUTED, False
    table = cases.table.join(summary, on="case")
    texts = {name: table[name].fillna("") for name in ("decision", "note", "reviewer")}
    return table.assign(**texts, is_done=table["is_done"].eq(True))


def leave_out(dataset: Dataset, cases: CaseList, chosen: Iterable[int]) -> Dataset:
    """Return the dataset without the boxes of some cases.

    Truth boxes become ignore regions: they are neither missed nor matched. False alarms get ignore
    regions of their size, so that no system pays for detections there.

    Parameters
    ----------
    chosen
        Rows of the cases.
    """
    rows = np.unique(np.concatenate([np.empty(0, np.int64), *(cases.boxes[i] for i in chosen)]))
    is_truth = dataset.boxes["source"].to_numpy()[rows] == 0
    ignore = dataset.boxes["ignore"].to_numpy(bool, copy=True)
    ignore[rows[is_truth]] = True
    boxes = dataset.boxes.assign(ignore=ignore)
    added = boxes.iloc[rows[~is_truth]].assign(source=0, ignore=True, track=NO_TRACK, score=np.nan)
    if len(added):
        boxes = pd.concat([boxes, added.astype(boxes.dtypes)], ignore_index=True)
        boxes = boxes.sort_values(["source", "frame_index"], kind="stable", ignore_index=True)
    return replace(dataset, boxes=boxes)


def compare_without(result: Result, cases: CaseList, chosen: Iterable[int]) -> Result:
    """Return the comparison without the boxes of some cases, at the same thresholds."""
    dataset = leave_out(result.dataset, cases, chosen)
    return compare(dataset, result.params, x=result.x.name, y=result.y.name)


def reviewed_rows(
    result: Result, cases: CaseList, decisions: pd.DataFrame
) -> list[tuple[ScoreRow, ScoreRow]]:
    """Return each row of the scorecard before and after the review.

    The review leaves out the cases that all their reviewers call wrong truth or irrelevant.
    """
    states = decided(cases, decisions)["decision"]
    after = compare_without(result, cases, np.flatnonzero(states.isin(LEAVES_OUT)))
    new = {row.key: row for row in score_rows(after, MeasureTable.SCORECARD)}
    rows = score_rows(result, MeasureTable.SCORECARD)
    return [
        (row._replace(label=_label_of_both(row, new[row.key])), new[row.key])
        for row in rows
        if row.key in new
    ]


def _label_of_both(old: ScoreRow, new: ScoreRow) -> str:
    """Return the label of a measure, with its denominator after the review if that is another."""
    _, _, rest = new.label.rpartition(", of ")
    return old.label if old.label == new.label else f"{old.label}, then {rest}"


def reviewed_measures(result: Result, cases: CaseList, decisions: pd.DataFrame) -> pd.DataFrame:
    """Tabulate every measure before and after the review (see `reviewed_rows`).

    Returns
    -------
    One row per measure of the scorecard: measure, label, x, y, x_reviewed, y_reviewed.
    """
    rows = reviewed_rows(result, cases, decisions)
    table = [(old.key, old.label, old.x, old.y, new.x, new.y) for old, new in rows]
    names = ["measure", "label", "x", "y", "x_reviewed", "y_reviewed"]
    return pd.DataFrame(table, columns=names)


def cases_as_cvat(result: Result, cases: CaseList, chosen: np.ndarray) -> bytes:
    """Return the frames of some cases (bool) with their boxes as CVAT for images XML 1.1.

    The label of a box is the kind of its case. Other boxes of the frames are not in it.
    """
    findings = []
    for kind in CaseKind:
        own = np.flatnonzero(chosen & (cases.table["kind"] == kind).to_numpy())
        if len(own):
            rows = np.unique(np.concatenate([cases.boxes[case] for case in own]))
            places = Cases("boxes", rows)
            findings.append(Finding(Severity.NOTE, kind, "", len(own), "", "", cases=places))
    return entries_as_cvat(result.dataset, findings)


def read_decisions(path: Path) -> pd.DataFrame:
    """Read decisions from a CSV or JSON file.

    Raises
    ------
    InputError
        With the line, if the file lacks a column or holds something else.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path.name}: no decisions can be read ({error})") from error
    return parse_decisions(content, path.name)


def parse_decisions(content: bytes, name: str) -> pd.DataFrame:
    """Read decisions from the content of a file with this name, as `read_decisions` does."""
    try:
        text = content.decode("utf-8-sig")
        if name.endswith(".json"):
            table = pd.DataFrame(json.loads(text), dtype=object).fillna("")
        else:
            table = pd.read_csv(StringIO(text), dtype=str, keep_default_na=False)
        missing = [column for column in COLUMNS if column not in table]
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{name}: no decisions can be read ({error})") from error
    if missing:
        raise InputError(f"{name}: no column {missing[0]}; {', '.join(COLUMNS)} are needed")
    return check_decisions(table, name)


def check_decisions(table: pd.DataFrame, name: str) -> pd.DataFrame:
    """Return decisions of unknown origin as `make_decision` makes them.

    Raises
    ------
    InputError
        With the file's name and the number of the decision, if one of them is something else.
    """
    rows = [empty_decisions()]
    for number, row in enumerate(table[list(COLUMNS)].itertuples(index=False), start=1):
        try:
            made = make_decision(
                str(row.case),
                str(row.decision),
                reviewer=without_safeguard(str(row.reviewer)),
                note=without_safeguard(str(row.note)),
                is_done=_IS_DONE[str(row.is_done).lower()],
                at=datetime.fromisoformat(str(row.at)),
            )
        except (InputError, ValueError, KeyError) as error:
            raise InputError(f"{name}, decision {number}: {error}") from error
        rows.append(made)
    return pd.concat(rows, ignore_index=True)


def format_decisions(decisions: pd.DataFrame, name: str) -> bytes:
    """Return decisions as CSV, or as JSON if the file's name ends so."""
    table = decisions[list(COLUMNS)]
    if name.endswith(".json"):
        return json.dumps(table.to_dict("records"), indent=1, ensure_ascii=False).encode()
    return to_csv_bytes(table)


def write_decisions(decisions: pd.DataFrame, path: Path) -> None:
    """Write decisions as CSV, or as JSON if the name ends so."""
    write_whole(path, format_decisions(decisions, path.name))
