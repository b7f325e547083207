"""Page of a study's conductor: set up, hand out links, see progress, one participant's data."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Final

import streamlit as st

from nvcore.subjects.people.form import KEPT_DAYS, LONGEST_KEPT_DAYS, MOST_TEXT
from nvcore.subjects.people.participants import MOST_NAME
from ui.session import store as session
from ui.shell.messages import errors_shown
from ui.subjects.people.studies import B, S, Studies, enter, is_local
from ui.widgets.buttons import button
from ui.widgets.table import draw_table
from ui.widgets.text import plain

NEWS_S: Final = 5.0
"""Interval at which the progress is updated, seconds."""


def draw(studies: Studies[S, B]) -> None:
    """Draw the study that is open, else the form that begins one."""
    conducted = None
    with errors_shown():
        conducted = studies.conducted()
    if conducted is None:
        studies.draw_setup()
        return
    store, study = conducted
    st.header(f"The {studies.what}")
    _draw_addresses(*studies.addresses(study))
    if study.ends_at is not None:
        st.caption(
            f"All {studies.answers} are deleted on {study.ends_at:%d %B %Y}. Save them before: "
            "then this address leads nowhere."
        )
    studies.draw_notes()
    with st.container(horizontal=True):
        if button(studies.here, key=f"{studies.prefix}_here", icon=":material/play_circle:"):
            enter(study.token)
        if button("Close, and start another", key=f"{studies.prefix}_close", type="tertiary"):
            studies.close()
            st.rerun()
    with st.container(horizontal=True):
        # outside the fragment, whose reruns would lose clicks
        studies.draw_downloads(store, study)
    _draw_progress(studies, study)
    studies.draw_results(store, study)
    _draw_one_participant(studies, store, study)


def _draw_addresses(for_participants: str, for_conductor: str) -> None:
    """Show both addresses, with a warning where they lead nowhere from other screens."""
    st.markdown("Participants open this address on their screen:")
    st.code(for_participants, language=None, wrap_lines=True)
    if is_local(for_participants):
        st.warning(
            "This address works **on this computer only**. For other screens ask whoever runs the "
            "app to open it to the network; then open it by this computer's name or IP address "
            "instead of localhost, and come back with the second address below: both then begin "
            "with that name.",
            icon=":material/wifi_off:",
        )
    st.markdown("With this one **you** come back to progress and results. Keep it to yourself:")
    st.code(for_conductor, language=None, wrap_lines=True)


@st.fragment(run_every=NEWS_S)
def _draw_progress(studies: Studies[S, B], study: S) -> None:
    st.header("Progress")
    progress = studies.progress(studies.store(), study)  # deletes studies that ended meanwhile
    columns = st.columns(len(progress.metrics))
    for column, (label, (n, hint)) in zip(columns, progress.metrics.items(), strict=True):
        column.metric(label, f"{n:,}", help=hint)
    if progress.people.empty:
        st.caption("Nobody has joined yet. This is looked up every five seconds.")
        return
    draw_table(
        progress.people, progress.columns, key=f"{studies.prefix}_progress", name="Participants"
    )
    if progress.note:
        st.caption(progress.note)


def _draw_one_participant(studies: Studies[S, B], store: B, study: S) -> None:
    """Ask for a name or code, then offer that participant's data, a new code, and deletion."""
    prefix = studies.prefix
    st.header("One participant")
    st.caption(
        "On request. A participant who lost the code goes on with a new one. What is deleted is "
        "gone from the file for good, and their place in the design is free again. Tables that "
        "were saved before still have it."
    )
    label = "Name or code of the participant"
    text = st.text_input(label, key=f"{prefix}_code", max_chars=MOST_NAME, width=420).strip()
    person = store.find(study, text) if text else None
    if person is None:
        if text:
            st.warning(f"Nobody with that name or code takes part in this {studies.what}.")
        return

    def remove() -> None:
        with errors_shown():
            store.delete(study, person)
            session.widget(f"{prefix}_code").set("")
            st.toast("The data of this participant are deleted.")

    with st.container(horizontal=True):
        st.download_button(
            "All data of this participant (JSON)",
            data=json.dumps(store.record(study, person), indent=2),
            file_name="participant.json",
            mime="application/json",
            on_click="ignore",
            icon=":material/download:",
            key=f"{prefix}_record",
        )
        with st.popover("New code …", icon=":material/key:"):
            st.markdown("The code that this participant has now will no longer work.")
            wants_code = button("Give a new code", key=f"{prefix}_new_code", type="primary")
        with st.popover("Delete …", icon=":material/delete:"):
            st.markdown(f"Delete all data of **{plain(person.name)}**? There is no way back.")
            st.button("Delete for good", key=f"{prefix}_delete", type="primary", on_click=remove)
    if wants_code:
        with errors_shown():
            code = store.new_code(study, person)
            st.markdown(
                f"**{plain(person.name)}** goes on with the code **{code}**, or by this address. "
                "It is shown only now, and the code before no longer works."
            )
            st.code(studies.addresses(study, code)[0], language=None, wrap_lines=True)


def ask_terms(
    consent: str, prefix: str, days: str, *, questions: str, choice: str = ""
) -> tuple[str, tuple[str, ...] | None, int]:
    """Ask for the text of consent, own questions, and the days that answers are kept.

    With a `choice`, the label of a checkbox, questions are None unless it is ticked.
    """
    text = st.text_area(
        "What participants agree to",
        consent,
        key=f"{prefix}_consent",
        max_chars=MOST_TEXT,
        height=260,
    )
    lines: tuple[str, ...] | None = None
    if not choice or st.checkbox(choice, key=f"{prefix}_has_form"):
        own = st.text_area(questions, key=f"{prefix}_questions", max_chars=MOST_TEXT)
        lines = tuple(line.strip() for line in own.splitlines() if line.strip())
    keep_days = st.number_input(
        days, 1, LONGEST_KEPT_DAYS, KEPT_DAYS, key=f"{prefix}_keep_days", width=420
    )
    return text, lines, int(keep_days)


@errors_shown()
def offer_start(studies: Studies[S, B], begin: Callable[[B], S]) -> None:
    """Draw the button that begins a study, which is then conducted."""
    if button(studies.start, type="primary", key=f"{studies.prefix}_start"):
        studies.conduct(begin(studies.store()))
        st.rerun()
