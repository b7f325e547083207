"""Ratings page, for who conducts a rating session: begin, hand out the link, see the progress."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.errors import InputError
from nvcore.ratings.clips import LEAD_S, LENGTH_S, cut_clips
from nvcore.ratings.store import CONSENT, Study
from nvcore.ratings.worth import EXPECTED, Alert, agreement_of_kinds, read_alerts
from nvcore.wording import count_text, minus
from ui.people.form import ask_questions
from ui.people.one_participant import draw_one_participant
from ui.people.studies import CONDUCT, enter
from ui.people.terms import ask_consent, ask_days, draw_addresses
from ui.ratings.participant import ENDS
from ui.ratings.sessions import SESSIONS, shown_thresholds
from ui.ratings.source import ask_for_file
from ui.session import state
from ui.session.store import RATING_ALERTS, RATINGS_PART
from ui.shell.navigate import open_page
from ui.widgets.buttons import button
from ui.widgets.choices import choose_side_by_side, download_csv
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import docs_link, number, plain

PARTS: Final = {"results": "Results", "session": "Rating session", "groups": "Groups"}
NEWS_S: Final = 5.0
"""Interval at which the progress is updated, seconds."""


def choose_part() -> str:
    """The part of the page; a conductor's link opens the rating session."""
    RATINGS_PART.setdefault("session" if CONDUCT in st.query_params else "results")
    return choose_side_by_side("Part", PARTS, RATINGS_PART.key, label_visibility="collapsed")


def draw(result: Result) -> None:
    """The rating session that is open, else the form that begins one."""
    try:
        study = SESSIONS.conducted()
    except InputError as error:
        st.error(plain(str(error)))
        study = None
    if study is None:
        _begin(result)
    else:
        _conduct(study)


def _begin(result: Result) -> None:
    dataset = result.dataset
    names = state.recording_names()
    both = [*result.names]
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
    try:
        chosen = [stretch for stretch in _choose_stretches(result) if stretch[0] in recordings]
        clips = [(of[0], system, *of[1:]) for system in systems for of in chosen]
        st.caption(f"{count_text(len(clips), 'clip')}.")
        alerts = _ask_alerts(result, recordings, systems)
    except InputError as error:
        st.error(plain(str(error)))
        return
    with st.expander("Consent, form, and how long ratings are kept", key="rating_terms"):
        consent = ask_consent(CONSENT, "rating")
        questions = None
        if st.checkbox(
            "Ask for age, sex, driving licence and driving at night", key="rating_has_form"
        ):
            questions = ask_questions("Own questions, one a line, after these", "rating")
        keep_days = ask_days("Days until the session is deleted with all ratings", "rating")
    if button("Start a rating session", type="primary", key="rating_start"):
        try:
            study = SESSIONS.store().begin(
                dataset.fingerprint,
                clips,
                thresholds=shown_thresholds(),
                consent=consent,
                keep_days=keep_days,
                alerts=alerts,
                questions=questions,
            )
        except InputError as error:
            st.error(plain(str(error)))
            return
        SESSIONS.conduct(study)
        st.rerun()


def _choose_stretches(result: Result) -> list[tuple[Any, ...]]:
    """What is rated of the recordings: recording, and start, end and reason of stretches."""
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
    """Alerts of these of which it is asked whether they were worth it: of the page, or a file's."""
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


def _conduct(study: Study) -> None:
    st.header("The rating session")
    for_participants, for_conductor = SESSIONS.addresses(study)
    draw_addresses(for_participants, for_conductor)
    if study.ends_at is not None:
        st.caption(
            f"All ratings are deleted on {study.ends_at:%d %B %Y}. Save them before: then this "
            "address leads nowhere."
        )
    start = state.shared_start().opened
    if state.opened().dataset.fingerprint != start.dataset.fingerprint:
        st.caption(
            "A participant's browser must have the same files open: open them there on the Data "
            "page first, or let them rate on this screen."
        )
    with st.container(horizontal=True):
        if button("Rate on this screen", key="rating_here", icon=":material/play_circle:"):
            enter(study.token)
        if button("Close, and start another", key="rating_close", type="tertiary"):
            SESSIONS.close()
            st.rerun()
        # outside the part that is redrawn every few seconds: a click would miss its button
        store = SESSIONS.store()
        download_csv("Ratings (CSV)", lambda: store.ratings(study), "ratings.csv", "rating_export")
        if study.alerts:
            download_csv(
                "Answers about alerts (CSV)",
                lambda: store.worth(study),
                "alert_answers.csv",
                "worth_export",
            )
        if study.form:
            download_csv(
                "Participants (CSV)", lambda: store.forms(study), "participants.csv", "form_export"
            )
    _draw_progress(study)
    if study.alerts and len(answers := store.worth(study)):
        _draw_worth(answers)
    draw_one_participant(
        "Name or code of the participant",
        "rating",
        lambda name: store.record(study, name),
        lambda name: store.delete(study, name),
        hint="On request. What is deleted is gone from the file for good, and their place in the "
        "order of the clips is free again. Tables that were saved before still have it.",
        nobody="Nobody of that name takes part in this rating session.",
    )


@st.fragment(run_every=NEWS_S)
def _draw_progress(study: Study) -> None:
    st.header("Progress")
    store = SESSIONS.store()
    people = store.participants(study)
    n_ratings, n_clips = int(people["n_rated"].sum()), len(study.clips)
    n_done = int((people["n_rated"] == n_clips).sum())
    columns = st.columns(3)
    columns[0].metric("participants", f"{len(people):,}")
    columns[1].metric("have rated all clips", f"{n_done:,}")
    columns[2].metric("ratings so far", f"{n_ratings:,}")
    if len(people):
        columns_shown = {
            "participant": TableColumn("Participant", is_head=True),
            "n_rated": TableColumn(f"Rated, of {n_clips}"),
            "n_answered": TableColumn(f"Alerts answered, of {len(study.alerts)}"),
        }
        if not study.alerts:
            del columns_shown["n_answered"]
        n_answered = store.worth(study)["participant"].value_counts()
        draw_table(
            people.assign(n_answered=people["participant"].map(n_answered).fillna(0).astype(int)),
            columns_shown,
            key="rating_progress",
            name="Participants",
        )
    else:
        st.caption("Nobody has joined yet. This is looked up every five seconds.")
    if n_ratings:
        st.caption(
            'Whether they agree is told under "Results", with ratings from "Rating session".'
        )


def _draw_worth(answers: pd.DataFrame) -> None:
    """How far the kinds of alerts agree with the answers."""
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
    """A value with its interval, where there is one."""
    value = number(row[of], ".2f")
    if np.isnan(row[f"{of}_low"]):
        return value
    return minus(f"{value} ({row[f'{of}_low']:.2f} to {row[f'{of}_high']:.2f})")
