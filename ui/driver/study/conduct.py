"""Study page, for who conducts a study: links, progress, tables, one participant's data."""

from __future__ import annotations

import json
from typing import Final

import streamlit as st

from nvcore.driver.estimators.nested import LEAST_PEDESTRIANS
from nvcore.driver.inputs.trials import LATE_S
from nvcore.driver.study.records import DetectabilityStudy
from nvcore.driver.study.tables import (
    about,
    advance_of,
    boxes_table,
    participants_table,
    trials_table,
)
from nvcore.errors import InputError
from ui.driver.study import setup
from ui.driver.study.files import STUDIES
from ui.people.one_participant import draw_one_participant
from ui.people.studies import enter
from ui.people.terms import draw_addresses
from ui.widgets.buttons import button
from ui.widgets.choices import download_csv
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import docs_link, plain

COMMANDS: Final = """\
nvcore driver features --images PICTURES --boxes boxes.csv --out features.csv
nvcore driver train trials.csv --features features.csv --out driver.npz
"""
NEWS_S: Final = 5.0
"""Interval at which the progress is updated, seconds."""


def draw() -> None:
    """The study that is open, else the form that begins one."""
    try:
        study = STUDIES.conducted()
    except InputError as error:
        st.error(plain(str(error)))
        study = None
    if study is None:
        setup.draw()
    else:
        _conduct(study)


def _conduct(study: DetectabilityStudy) -> None:
    st.header("The study")
    draw_addresses(*STUDIES.addresses(study))
    st.caption(
        f"All answers are deleted on {study.ends_at:%d %B %Y}. Save them before: then this address "
        "leads nowhere."
    )
    store = STUDIES.store()
    with st.container(horizontal=True):
        if button("Take part on this screen", key="study_here", icon=":material/play_circle:"):
            enter(study.token)
        if button("Close, and start another", key="study_close", type="tertiary"):
            STUDIES.close()
            st.rerun()
    with st.container(horizontal=True):
        # outside the part that is redrawn every few seconds: a click would miss its button
        download_csv(
            "Trials (CSV)", lambda: trials_table(store, study), "trials.csv", "study_trials"
        )
        download_csv("Boxes (CSV)", lambda: boxes_table(study), "boxes.csv", "study_boxes")
        download_csv(
            "Participants (CSV)",
            lambda: participants_table(store, study),
            "participants.csv",
            "study_participants",
        )
        st.download_button(
            "Settings (JSON)",
            data=lambda: json.dumps(about(study), indent=2),
            file_name="study.json",
            mime="application/json",
            on_click="ignore",
            icon=":material/download:",
            key="study_about",
        )
    _draw_progress(study)
    with st.expander("From the answers to an estimate"):
        st.caption(
            "Save trials and boxes. An estimator needs "
            f"{LEAST_PEDESTRIANS} pedestrians or more at each time "
            f"({docs_link('more', 'estimators', doc='driver-reference')}); "
            "the page Driver takes it."
        )
        st.code(COMMANDS, language="sh")
    draw_one_participant(
        "Code of the participant",
        "study",
        lambda code: store.record(study, code),
        lambda code: store.delete(study, code),
        hint="On request: a participant tells the code. What is deleted is gone from the file for "
        "good, and their place in the design is free again. Tables that were saved before still "
        "have it.",
        nobody="Nobody takes part in this study with that code.",
    )


@st.fragment(run_every=NEWS_S)
def _draw_progress(study: DetectabilityStudy) -> None:
    st.header("Progress")
    people = participants_table(STUDIES.store(), study)
    so_far = advance_of(people)
    columns = st.columns(4)
    columns[0].metric("participants", f"{so_far.n_participants:,}")
    columns[1].metric("have seen all pictures", f"{so_far.n_finished:,}")
    columns[2].metric("trials so far", f"{so_far.n_trials:,}")
    columns[3].metric(
        "marked",
        f"{so_far.n_marked:,}",
        help=f"More than {1000 * LATE_S:g} ms early or late, shown for more or less than asked, "
        "shown again after a reload, never reported as shown, or without an answer in time. They "
        "stay in the table, with the reason.",
    )
    if people.empty:
        st.caption("Nobody has joined yet. This is looked up every five seconds.")
        return
    draw_table(
        people,
        {
            "subject": TableColumn("Participant", is_head=True),
            "joined": TableColumn("Joined"),
            "n_trials": TableColumn("Trials"),
            "n_answered": TableColumn("Answered"),
            "n_marked": TableColumn("Marked"),
        },
        key="study_progress",
        name="Participants",
    )
