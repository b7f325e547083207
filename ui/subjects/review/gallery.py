"""Review page: the cases as crops, with filters, order and keys that decide."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.common.wording import listed, number
from nvcore.comparison.compare import Result
from nvcore.subjects.review.cases import CaseKind, CaseList, find_cases, shots
from nvcore.subjects.review.decisions import MOST_NOTE, Decision, decided, latest
from ui.session import state, store
from ui.session.results import cached_findings, comparison_key
from ui.session.routes import address
from ui.shell.messages import shown_error
from ui.shell.navigate import open_frame
from ui.subjects.review import kept
from ui.subjects.review.crops import version_of
from ui.widgets import drawing
from ui.widgets.buttons import button
from ui.widgets.choices import choose_first, choose_side_by_side
from ui.widgets.script import read_script
from ui.widgets.text import plain

FOLDER: Final = Path(__file__).parent
KEY: Final = "review_gallery"
MOST: Final = 120
"""Number of cases shown at a time."""
DECIDED_BY: Final = {str(key): of.value for key, of in enumerate([*Decision][1:], 1)} | {"0": ""}
"""Decisions by key."""
SYSTEMS: Final = {"": "all", "x": "X", "y": "Y", "xy": "both"}
STATES: Final = {"": "all", "open": "open", "done": "done"}
ORDERS: Final = {"severity": "severity", "time": "recording and time"}
_COMPONENT = st.components.v2.component(
    "nvcore_review",
    css=(FOLDER / "gallery.css").read_text(encoding="utf-8"),
    js=read_script(FOLDER / "gallery.js"),
)


def cases_of(result: Result) -> CaseList:
    """Return the cases of the open comparison."""

    def make() -> CaseList:
        findings = cached_findings(state.cached, result.dataset, result.params, *result.names)
        return find_cases(result, findings)

    cases: CaseList = state.cached("review_cases", comparison_key(result), make)
    return cases


def draw(result: Result, cases: CaseList, decisions: pd.DataFrame, *, seen: int = 0) -> None:
    """Draw filters and order, and the cases that pass.

    Parameters
    ----------
    seen
        Number of the last decision in `decisions`.
    """
    if not len(cases):
        st.info("There is no case: nobody is missed, and there is no false alarm.")
        return
    table = decided(cases, decisions)
    shown = _choose(table)
    first = choose_first("Cases", len(shown), MOST, "review_first")
    mine, n_done = kept.own(decisions), int(table["is_done"].sum())
    others = _others(decisions)
    about = state.cached("review_shots", comparison_key(result), lambda: _described(result, cases))
    rows = shown.iloc[first : first + MOST]
    theme, space, (lo, hi) = state.theme(), state.workspace(), drawing.stretch()
    if rows.empty:
        st.info("No case passes the filters.")
    _COMPONENT(
        key=KEY,
        data={
            "url": f"{address(space)}/crop",
            "query": f"lo={lo:g}&hi={hi:g}&v={version_of(space)}",
            "styles": {
                letter: (theme.style(letter).colour(theme.shade), theme.style(letter).css)
                for letter in "xy"
            },
            "decisions": DECIDED_BY,
            "cases": [
                {
                    **about[i],
                    "decision": row["decision"],
                    "isDone": row["is_done"],
                    "mine": mine["decision"].get(row["case"], ""),
                    "note": mine["note"].get(row["case"], ""),
                    "others": others.get(row["case"], ""),
                }
                for i, row in zip(rows.index.tolist(), rows.to_dict("records"), strict=True)
            ],
            "counts": {"done": n_done, "n": len(table)},
            "selected": store.REVIEW_CASE.get(),
            "heard": store.REVIEW_HEARD.get(),
            "seen": seen,
            "canUndo": kept.can_undo(),
        },
        on_told_change=lambda: _hear(cases),
        on_opened_change=_ask_to_open,
    )
    if store.REVIEW_OPENS.pop():
        opened = [of for of in about if of["id"] == store.REVIEW_CASE.get()]
        for of in opened:
            open_frame(of["recording"], of["rows"][of["at"]])


def draw_conflict(cases: CaseList) -> None:
    """Draw both versions of a case on which two people decided at once, and ask which to keep."""
    if (conflict := kept.conflict()) is None:
        return
    theirs, (mine,) = conflict.theirs, conflict.mine.to_dict("records")
    (case,) = cases.table[cases.table["case"] == theirs["case"]].to_dict("records") or [{}]
    place = f" ({case['recording']}, frame {case['frame']})" if case else ""
    name = theirs["reviewer"] or "somebody"
    with st.container(border=True, horizontal=True, vertical_alignment="center"):
        st.markdown(f"**{plain(name)}** decided on this case meanwhile{plain(place)}.")
        for who, version, is_mine in ((name, theirs, False), ("me", mine, True)):
            label = plain(f"Keep {version['decision'] or 'open'} ({who})")
            if button(label, key=f"review_keep_{is_mine}", help=plain(version["note"])):
                kept.settle(is_mine=is_mine)
                st.rerun()


def _choose(table: pd.DataFrame) -> pd.DataFrame:
    """Draw filters and order, and return the cases that pass, in this order."""
    counts = table["kind"].value_counts()
    kinds = {"": f"all ({len(table)})"} | {
        kind.value: f"{kind.value} ({counts[kind.value]})"
        for kind in CaseKind
        if kind.value in counts
    }
    if store.widget("review_kind").get() not in kinds:
        store.widget("review_kind").set("")
    with st.container(horizontal=True, vertical_alignment="bottom", key="review_filters"):
        kind = choose_side_by_side("Kind", kinds, "review_kind")
        system = choose_side_by_side("By", SYSTEMS, "review_system", default="")
        decision = choose_side_by_side("Decision", STATES, "review_state", default="")
        order = choose_side_by_side("Order", ORDERS, "review_order", default="severity")
    if kind:
        table = table[table["kind"] == kind]
    if system:
        table = table[table["systems"] == system]
    if decision:
        table = table[table["is_done"] == (decision == "done")]
    if order == "time":
        return table.sort_values(["recording", "frame"], kind="stable")
    return table


def _others(decisions: pd.DataFrame) -> dict[str, str]:
    """Return what other reviewers decided on each case, in words."""
    own = kept.reviewer()
    told: dict[str, list[str]] = {}
    for row in latest(decisions[decisions["reviewer"] != own]).to_dict("records"):
        text = f"{row['reviewer'] or 'somebody'}: {row['decision']}"
        told.setdefault(row["case"], []).append(f"{text} – {row['note']}" if row["note"] else text)
    return {case: "; ".join(texts) for case, texts in told.items()}


def _described(result: Result, cases: CaseList) -> list[dict[str, Any]]:
    """Return texts and crops of each case, as the browser gets them."""
    rows = cases.table.to_dict("records")
    return [
        {"id": case["case"], "who": case["systems"], **_texts(result, case), **asdict(shot)}
        for case, shot in zip(rows, shots(result.dataset, cases), strict=True)
    ]


def _texts(result: Result, case: Mapping[Hashable, Any]) -> dict[str, str]:
    """Return the text below a case's crop, and the one for screen readers."""
    letters = [*case["systems"].upper()]
    seconds = "" if np.isnan(case["severity_s"]) else f"{number(case['severity_s'], '.2f')} s"
    kind = CaseKind(case["kind"])
    by = {CaseKind.MISS: " by ", CaseKind.FALSE_ALARM: " of "}.get(kind, "") + listed(letters)
    track = "" if case["encounter"] < 0 else str(result.encounters.track[case["encounter"]])
    person = track and result.objects.say("{one} {track}", track=track)
    place = person, case["recording"], f"frame {case['frame']}"
    told = (f"{kind.value}{by}", case["finding"], seconds, *place)
    short = " ".join(filter(None, [*letters, seconds, case["finding"]]))
    return {
        "text": f"{short}, alarm" if kind is CaseKind.FALSE_ALARM else short,
        "about": ", ".join(filter(None, told)),
    }


def _hear(cases: CaseList) -> None:
    """Apply the browser's messages that are new, unless they are malformed."""
    client, messages = (store.sent(KEY, "told", name) for name in ("client", "messages"))
    if not isinstance(client, str) or not isinstance(messages, list):
        return
    heard = store.REVIEW_HEARD.get()
    last = heard["n"] if heard and heard["client"] == client else 0
    for message in messages:
        if not isinstance(message, Mapping) or type(message.get("n")) is not int:
            return
        if message["n"] <= last:
            continue
        try:
            _apply(message, cases)
        except NvcoreError as error:  # the browser sends it again with the next one
            st.toast(shown_error(error), icon=":material/error:")
            return
        last = message["n"]
        store.REVIEW_HEARD.set({"client": client, "n": last})


def _apply(message: Mapping[str, Any], cases: CaseList) -> None:
    case, decision, note = (str(message.get(name)) for name in ("case", "decision", "note"))
    if message.get("kind") == "undo":
        kept.undo()
    elif case in set(cases.table["case"]) and decision in [*Decision]:
        store.REVIEW_CASE.set(case)
        seen = message.get("seen")
        kept.decide(case, decision, note[:MOST_NOTE], seen=seen if type(seen) is int else None)


def _ask_to_open() -> None:
    """Open the case in the next run, as callbacks cannot open pages."""
    case = store.sent(KEY, "opened", "case")
    if isinstance(case, str):
        store.REVIEW_CASE.set(case)
        store.REVIEW_OPENS.set(True)
