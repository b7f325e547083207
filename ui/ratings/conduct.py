"""Ratings page, for who conducts a rating session: begin, hand out the link, see the progress."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.comparison import Result
from nvcore.errors import InputError
from nvcore.ratings.store import CONSENT, Study
from nvcore.wording import count_text
from ui.people.one_participant import draw_one_participant
from ui.people.studies import CONDUCT, enter
from ui.people.terms import ask_consent, ask_days, draw_addresses
from ui.ratings.participant import ENDS
from ui.ratings.sessions import SESSIONS, shown_thresholds
from ui.session import state
from ui.session.store import RATINGS_PART
from ui.widgets.buttons import button
from ui.widgets.choices import choose_side_by_side, download_csv
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import plain

RESULTS: Final = "Results"
SESSION: Final = "Rating session"
NEWS_S: Final = 5.0
"""Interval at which the progress is updated, seconds."""


def choose_part() -> str:
    """The part of the page; a conductor's link opens the rating session."""
    RATINGS_PART.setdefault(SESSION if CONDUCT in st.query_params else RESULTS)
    return choose_side_by_side(
        "Part", [RESULTS, SESSION], RATINGS_PART.key, label_visibility="collapsed"
    )


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
    both = [result.x.name, result.y.name]
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
    clips = [(name, system) for system in systems for name in names if name in recordings]
    st.caption(f"{count_text(len(clips), 'clip')}.")
    with st.expander("Consent, and how long ratings are kept"):
        consent = ask_consent(CONSENT, "rating")
        keep_days = ask_days("Days until the session is deleted with all ratings", "rating")
    if button("Start a rating session", type="primary", key="rating_start"):
        try:
            study = SESSIONS.store().begin(
                dataset.fingerprint,
                clips,
                thresholds=shown_thresholds(),
                consent=consent,
                keep_days=keep_days,
            )
        except InputError as error:
            st.error(plain(str(error)))
            return
        SESSIONS.conduct(study)
        st.rerun()


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
    _draw_progress(study)
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
        draw_table(
            people,
            {
                "participant": TableColumn("Participant", is_head=True),
                "n_rated": TableColumn(f"Rated, of {n_clips}"),
            },
            key="rating_progress",
            name="Participants",
        )
    else:
        st.caption("Nobody has joined yet. This is looked up every five seconds.")
    if n_ratings:
        st.caption(f'Whether they agree is told under "{RESULTS}", with ratings from "{SESSION}".')
