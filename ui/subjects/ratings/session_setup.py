"""Rating sessions for their conductor: the form that begins one, and the answers about alerts."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import count_text, minus
from nvcore.comparison.compare import Result
from nvcore.subjects.alerts.steps import alerts_in
from nvcore.subjects.ratings.clip_task import CONSENT, RatingStore, RatingStudy
from nvcore.subjects.ratings.clips import LEAD_S, LENGTH_S, cut_clips
from nvcore.subjects.ratings.worth import EXPECTED, Alert, agreement_of_kinds, read_alerts
from ui.session import state
from ui.session.store import RATING_ALERTS
from ui.shell.messages import errors_shown
from ui.shell.navigate import open_page
from ui.subjects.people.conduct import ask_terms, offer_start
from ui.subjects.people.studies import Studies
from ui.subjects.ratings.clip_screen import ENDS
from ui.subjects.ratings.thresholds import shown_thresholds
from ui.widgets.buttons import button
from ui.widgets.choices import ask_for_file, choose_side_by_side
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import docs_link, number


@errors_shown()
def draw_setup(sessions: Studies[RatingStudy, RatingStore], result: Result) -> None:
    """Draw the form that begins a session."""
    names, both = state.recording_names(), [*result.names]
    st.header("Start a rating session")
    st.caption(
        "Every participant sees every clip once, in an order of their own that is balanced over "
        "the participants, without the names of the systems and without the ground truth, and "
        f"rates it from 1 ({ENDS[0]}) to 7 ({ENDS[1]}). The score thresholds in use now decide "
        "which boxes are shown."
    )
    recordings = st.multiselect("Recordings", names, default=names, key="rating_recordings")
    whose = st.segmented_control(
        "Whose boxes",
        [*both, "both"],
        default="both",
        required=True,
        key="rating_whose",
        format_func=lambda name: (
            "Both" if name == "both" else f"{'X' if name == result.x.name else 'Y'} {name}"
        ),
    )
    systems = both if whose == "both" else [whose]
    chosen = [stretch for stretch in _choose_stretches(result) if stretch[0] in recordings]
    clips = [(of[0], system, *of[1:]) for system in systems for of in chosen]
    st.caption(f"{count_text(len(clips), 'clip')}.")
    alerts = _ask_alerts(result, recordings, systems)
    with st.expander("Consent, form, and how long ratings are kept", key="rating_terms"):
        consent, questions, keep_days = ask_terms(
            CONSENT,
            "rating",
            "Days until the session is deleted with all ratings",
            questions="Own questions, one a line, after these",
            choice="Ask for age, sex, driving licence and driving at night",
        )
    offer_start(
        sessions,
        lambda store: store.begin(
            result.dataset.fingerprint,
            clips,
            thresholds=shown_thresholds(),
            consent=consent,
            keep_days=keep_days,
            alerts=alerts,
            questions=questions,
        ),
    )


def _choose_stretches(result: Result) -> list[tuple[Any, ...]]:
    """Ask for what to rate. Return recordings, or stretches with start, end and reason."""
    rated = choose_side_by_side(
        "What is rated",
        {"whole": "Whole recordings", "clips": "Clips around encounters and false alerts"},
        "rating_what",
        default="whole",
    )
    if rated == "whole":
        return [(name,) for name in state.recording_names()]
    first, second = st.columns(2)
    length_s = first.number_input(
        "Length of a clip, s", *(1.0, 600.0, LENGTH_S), format="%g", key="rating_length_s"
    )
    lead_s = second.number_input(
        "Before what it is cut around, s", *(0.0, 600.0, LEAD_S), format="%g", key="rating_lead_s"
    )
    st.caption(
        "The same clips for both systems; what begins inside a clip belongs to it "
        f"({docs_link('the rule', 'clips', doc='ratings')})."
    )
    table = state.workspace().cached(
        "rating_stretches",
        (result.dataset.fingerprint, result.params, result.x.name, result.y.name, length_s, lead_s),
        lambda: cut_clips(result, length_s=length_s, lead_s=lead_s).drop(columns="clip"),
    )
    return [*table.itertuples(index=False, name=None)]


def _ask_alerts(result: Result, recordings: list[str], systems: list[str]) -> list[Alert]:
    """Ask which alerts of these recordings and systems are judged, and return them."""
    ways = {"no": "No", "these": "Those of this comparison", "file": "Those of a CSV file"}
    RATING_ALERTS.setdefault("no")
    way = choose_side_by_side(
        "Ask of alerts whether they were worth it, after the clips", ways, RATING_ALERTS.key
    )
    sent: tuple[Any, str] | None = None
    if way == "file":
        sent = ask_for_file(
            "Alerts: alerts.csv of the page Alerts, or your own",
            "rating_alerts",
            "Columns recording, system (x or y, or its name), start_s, duration_s or end_s, and "
            f"kind: {', '.join(EXPECTED)}. Times in seconds since the recording's first frame.",
        )
    elif way == "these" and (view := alerts_in(result)).is_asked:
        sent = view.table, "alerts.csv"
    elif way == "these":
        st.info("Alerts are off. Choose on the page Alerts by which policy detections alert.")
        if button("Open the page Alerts", key="rating_open_alerts"):
            open_page("alerts")
    if sent is None:
        return []
    known = read_alerts(sent[0], result, name=sent[1])
    alerts = [of for of in known if of.recording in recordings and of.system in systems]
    n_of = [(kind, sum(of.kind == kind for of in alerts)) for kind in EXPECTED]
    kinds = ", ".join(f"{n} {kind}" for kind, n in n_of if n) or "none is of what is chosen above"
    st.caption(f"{count_text(len(alerts), 'alert')}: {kinds}. Nobody is told the kind.")
    return alerts


def draw_worth(answers: pd.DataFrame) -> None:
    """Draw the agreement of the kinds of alerts with the answers."""
    st.header("Were the alerts worth it?")
    table = agreement_of_kinds(answers)
    shown = table[["kind", "n_alerts", "n_answers", "n_unsure"]].assign(
        **{
            of: [_with_ends(row, of) for row in table.to_dict("records")]
            for of in ("share", "kappa")
        }
    )
    columns = {
        "kind": TableColumn("Kind", is_head=True),
        "n_alerts": TableColumn("Alerts"),
        "n_answers": TableColumn("Yes or no"),
        "n_unsure": TableColumn("Cannot say"),
        "share": TableColumn(
            "As expected (95 % interval)",
            "Share of the answers that the kind lets expect.",
            is_number=True,
        ),
        "kappa": TableColumn(
            "Cohen's kappa (95 % interval)",
            "Of expected and given answers, beside the alerts that let expect the other answer. "
            "1: always the same, 0: as by chance.",
            is_number=True,
        ),
    }
    draw_table(shown, columns, key="worth", name="Kinds against answers", is_sortable=False)
    st.caption(
        "Needed and wanted alerts let expect a yes, all others a no. Intervals are from resampling "
        f"the recordings ({docs_link('how', 'was-this-alert-worth-it', doc='ratings')})."
    )


def _with_ends(row: dict[Hashable, Any], of: str) -> str:
    """Return a value with its interval, if it has one."""
    value = number(row[of], ".2f")
    if np.isnan(row[f"{of}_low"]):
        return value
    return minus(f"{value} ({row[f'{of}_low']:.2f} to {row[f'{of}_high']:.2f})")
