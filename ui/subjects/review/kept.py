"""Decisions on the open comparison: those of the browser's tab, or of the open project."""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.evidence.looks import ONLY_LOOK, Look, look_of, setting_of
from nvcore.subjects.review.calls import open_store
from nvcore.subjects.review.decisions import COLUMNS, empty_decisions, latest, make_decision
from nvcore.subjects.review.store import ConflictError, Project, ProjectStore
from ui.access.login import login
from ui.access.people import person_of
from ui.session import state

REVIEWER: Final = "review_reviewer"
TOKENS: Final = "review_tokens"
"""Tokens of the projects that this tab has opened."""
_TAB: Final = "review_decisions"
_UNDO: Final = "review_undo"
_PROJECT: Final = "review_project"
_READ: Final = "review_read"
_CONFLICTS: Final = "review_conflicts"


class Conflict(NamedTuple):
    """Decision that was not stored, since somebody else decided on the case meanwhile."""

    mine: pd.DataFrame
    theirs: Mapping[str, Any]


def notes() -> dict[str, Any]:
    """Return the values that outlast a reload of the page."""
    return state.workspace().notes


def who() -> str:
    """Return the log-in of this session's person. Empty if there is none."""
    settings = login()
    person = None if settings is None else person_of(st.context.cookies, settings)
    return "" if person is None else person.email or person.key


def reviewer() -> str:
    """Return the name of the reviewer: the log-in, else as typed."""
    return who() or str(notes().get(REVIEWER, ""))


def call(name: str) -> None:
    """Name this tab's reviewer. Decisions that are not in a project change hands."""
    before, table = reviewer(), notes().get(_TAB)
    notes()[REVIEWER] = name
    if table is not None:
        mine = table["reviewer"] == before
        notes()[_TAB] = table.assign(reviewer=table["reviewer"].mask(mine, reviewer()))


def call_guest() -> None:
    """Name a reviewer without a name, the same in each tab of a browser."""
    if not reviewer():
        cookie = str(st.context.cookies.get("_streamlit_xsrf") or secrets.token_hex())
        call(f"guest {hashlib.sha256(cookie.encode()).hexdigest()[:4]}")


def may_open(store: ProjectStore, token: str) -> bool:
    """Whether this session's person may open a project. Without log-in, the token is enough."""
    return login() is None or store.is_member(token, who())


def use(token: str, n_opened: int) -> None:
    """Keep decisions in a project, as long as the opening with this number is shown."""
    leave()
    call_guest()
    notes()[_PROJECT] = token, n_opened
    notes()[TOKENS] = [*dict.fromkeys([token, *notes().get(TOKENS, [])])]


def leave() -> None:
    """Keep decisions in the tab."""
    for name in (_PROJECT, _UNDO, _READ, _CONFLICTS):
        notes().pop(name, None)


def project() -> tuple[ProjectStore, Project] | None:
    """Return the project of the open comparison, unless it was deleted."""
    token, n_opened = notes().get(_PROJECT, ("", 0))
    if not token:
        return None
    store = open_store()
    found = store.project(token)
    if found is None or not may_open(store, token):
        return None
    if n_opened != state.workspace().n_opened:  # something was added: decisions go along
        leave()
        notes()[_TAB] = store.decisions(token)[list(COLUMNS)]
        return None
    return store, found


def count_look(result: Result) -> Look:
    """Count a verdict on the open project, so that p is corrected for all looks at it."""
    if (opened := project()) is None:
        return ONLY_LOOK
    store, of = opened
    return look_of(store.look(of.token, setting_of(result, state.protocol())), result.dataset)


def has_news() -> bool:
    """Read decisions that were made since the last call, and return whether there were any."""
    if (opened := project()) is None:
        return False
    store, of = opened
    known = notes().get(_READ)
    new = store.decisions(of.token, since=seen())
    notes()[_READ] = new if known is None else pd.concat([known, new], ignore_index=True)
    return bool(len(new))


def seen() -> int:
    """Return the number of the last decision that was read of the project. 0: none."""
    known = notes().get(_READ)
    return 0 if known is None or known.empty else int(known["n"].iloc[-1])


def decisions() -> pd.DataFrame:
    """Return all decisions in their order."""
    if project() is None:
        known: pd.DataFrame = notes().get(_TAB, empty_decisions())
        return known
    has_news()
    read: pd.DataFrame = notes()[_READ]
    return read


def add(made: pd.DataFrame, *, seen: int | None = None) -> None:
    """Append decisions (see `nvcore.subjects.review.store.ProjectStore.decide`)."""
    if (opened := project()) is not None:
        opened[0].decide(opened[1].token, made, seen=seen)
    else:
        notes()[_TAB] = pd.concat([decisions(), made[list(COLUMNS)]], ignore_index=True)


def import_(made: pd.DataFrame) -> None:
    """Append decisions of a file. With log-in, nobody's name is signed by others."""
    own = who()
    if own:
        names = made["reviewer"]
        made = made.assign(reviewer=names.where(names == own, names + f" (by {own})"))
    add(made)


def own(table: pd.DataFrame) -> pd.DataFrame:
    """Return this reviewer's latest decisions, indexed by case."""
    return latest(table[table["reviewer"] == reviewer()]).set_index("case")


def decide(case: str, decision: str, note: str, *, seen: int | None = None) -> None:
    """Decide on a case. A conflict in a project waits for `settle`."""
    before = own(decisions())
    last = tuple(before.loc[case, ["decision", "note"]]) if case in before.index else ("", "")
    made = make_decision(case, decision, reviewer=reviewer(), note=note)
    try:
        add(made, seen=seen)
    except ConflictError as error:
        notes().setdefault(_CONFLICTS, []).append(Conflict(made, error.theirs))
    else:
        notes().setdefault(_UNDO, []).append((case, *last))


def can_undo() -> bool:
    """Whether this tab has made a decision that `undo` takes back."""
    return bool(notes().get(_UNDO))


def undo() -> None:
    """Take back this tab's last decision. The one before applies again."""
    if can_undo():
        case, decision, note = notes()[_UNDO][-1]
        add(make_decision(case, decision, reviewer=reviewer(), note=note))
        notes()[_UNDO].pop()


def conflict() -> Conflict | None:
    """Return the first conflict that is not settled, or None."""
    waiting: list[Conflict] = notes().get(_CONFLICTS, [])
    return waiting[0] if waiting else None


def settle(*, is_mine: bool) -> None:
    """Store this reviewer's decision of the first conflict, or the other one as theirs."""
    first = notes()[_CONFLICTS][0]
    if is_mine:
        add(first.mine)
    else:
        decide(*(first.theirs[name] for name in ("case", "decision", "note")))
    notes()[_CONFLICTS].pop(0)
