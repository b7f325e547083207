"""Decisions on the open comparison: those of the browser's tab, or of the open project."""

from __future__ import annotations

from typing import Any, Final

import pandas as pd

from nvcore.subjects.review.decisions import (
    COLUMNS,
    Decision,
    empty_decisions,
    latest,
    make_decision,
)
from ui.session import state

_TAB: Final = "review_decisions"
_UNDO: Final = "review_undo"
REVIEWER: Final = "reviewer"


def _notes() -> dict[str, Any]:
    return state.workspace().notes


def reviewer() -> str:
    """Return the name of this tab's reviewer, as typed."""
    name: str = _notes().get(REVIEWER, "")
    return name


def decisions() -> pd.DataFrame:
    """Return all decisions in their order."""
    known: pd.DataFrame = _notes().get(_TAB, empty_decisions())
    return known


def add(made: pd.DataFrame) -> None:
    """Append decisions."""
    _notes()[_TAB] = pd.concat([decisions(), made[list(COLUMNS)]], ignore_index=True)


def own(table: pd.DataFrame) -> pd.DataFrame:
    """Return this reviewer's latest decisions, indexed by case."""
    mine = latest(table[table["reviewer"] == reviewer()])
    return mine.set_index("case")


def decide(case: str, decision: str, note: str) -> None:
    """Decide on a case."""
    before = own(decisions())
    last = tuple(before.loc[case, ["decision", "note"]]) if case in before.index else ("", "")
    add(make_decision(case, decision, reviewer=reviewer(), note=note))
    _notes().setdefault(_UNDO, []).append((case, *last))


def can_undo() -> bool:
    """Whether this tab has made a decision that `undo` takes back."""
    return bool(_notes().get(_UNDO))


def undo() -> None:
    """Take back this tab's last decision. The one before applies again."""
    if can_undo():
        case, decision, note = _notes()[_UNDO].pop()
        add(make_decision(case, Decision(decision), reviewer=reviewer(), note=note))
