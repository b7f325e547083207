"""Tables of what a new version changed, for the terminal and the dashboard."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.wording import ARROWS, count_text
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import as_shown
from nvcore.evidence.operating_points import point_note
from nvcore.report.gate.outcomes import value_text
from nvcore.report.section import Columns, Table, listing, table
from nvcore.report.sections.results import measure_columns
from nvcore.tables.encounters.changes import Change

HEADS: Final = {"X": "Old", "Y": "New", "X − Y": "Old − new"}
MOST_LISTED: Final = 20


def cases_table(cases: pd.DataFrame) -> Table:
    """Return the cases that changed, the worst first."""
    changed = cases[cases["kind"] != Change.UNCHANGED.value]
    columns: Columns = {
        "Kind": "kind",
        "Recording": "recording",
        "{One}": (lambda row: "" if pd.isna(row["track"]) else row["track"], ""),
        "Frames": (lambda row: f"{row['first_frame']} to {row['last_frame']}", ""),
        "Severity old (s)": ("severity_s_old", ".2f"),
        "Severity new (s)": ("severity_s_new", ".2f"),
    }
    n_more = len(changed) - MOST_LISTED
    notes = [f"and {n_more:,} more, in changes.csv"] if n_more > 0 else []
    return listing("What changed", changed.head(MOST_LISTED), columns, notes=notes)


def tests_table(result: Result, evidence: pd.DataFrame) -> Table:
    """Return the paired tests between the versions."""
    columns: Columns = {"Measure": lambda row: row["label"] + ARROWS[row["better"]]}
    columns |= {HEADS.get(head, head): of for head, of in measure_columns("p (corrected)").items()}
    basis = count_text(len(result.dataset.recordings), "recording")
    basis += f", {count_text(result.venn.n_near, 'encounter')}."
    note = point_note(result)
    shown, more = as_shown(result, evidence), () if note is None else (note,)
    return listing("Tests between the versions", shown, columns, notes=(basis, *more))


def versions_table(measures: pd.DataFrame) -> Table:
    """Return the measures over versions. Values that break the gate's rule are marked."""
    versions, rules = measures["version"].unique(), measures["rule"]
    marks = [" !" if is_met is False else "" for is_met in measures["is_met"].tolist()]
    cells = (measures["value"].map(value_text) + marks).to_numpy().reshape(-1, len(versions))
    names = np.where(rules.isna(), measures["measure"], rules)[:: len(versions)]
    rows = [(name, *row) for name, row in zip(names, cells, strict=True)]
    notes = ["!: breaks the rule."] if any(marks) else []
    head = ("Rule" if rules.notna().any() else "Measure", *versions)
    return table("Versions", head, rows, right=range(1, len(head)), notes=notes)
