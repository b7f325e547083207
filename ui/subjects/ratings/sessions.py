"""Rating sessions on their page. See `ui.subjects.people.studies.Studies`."""

from __future__ import annotations

from typing import Any, Final

import streamlit as st

from nvcore.common.wording import count_text
from nvcore.subjects.people.store import Person
from nvcore.subjects.ratings.clip_task import RatingStore, RatingStudy
from ui.session import state
from ui.session.store import RATING_THRESHOLDS, RATING_WAITING, RATINGS_PART
from ui.shell.navigate import open_page
from ui.subjects.people.studies import CONDUCT, PARTICIPANT, Progress, Studies, enter
from ui.subjects.ratings import session_setup
from ui.subjects.ratings.clip_screen import ENDS, ClipScreen, offer_change
from ui.subjects.ratings.thresholds import set_thresholds, thresholds_apart
from ui.widgets.buttons import button
from ui.widgets.choices import choose_side_by_side, download_csv
from ui.widgets.table import TableColumn

PARTS: Final = {"results": "Results", "session": "Rating session", "groups": "Groups"}


class RatingSessions(Studies[RatingStudy, RatingStore]):
    """Rating sessions."""

    opens = RatingStore
    page = "ratings"
    what = "rating session"
    answers = "ratings"
    prefix = "rating"
    variable = "NVCORE_RATINGS"
    file_name = "ratings.sqlite"
    start = "Start a rating session"
    title = "Rate clips"
    begin = "Begin"
    here = "Rate on this screen"
    back = "Back to the results"

    def is_ready(self, study: RatingStudy) -> bool:
        """Return True with the session's thresholds set, or go to the page that opens its data."""
        if state.result() is None or not _is_open(study):
            RATING_WAITING.set((study.token, st.query_params.get(PARTICIPANT, "")))
            st.query_params.clear()
            st.rerun()
        RATING_WAITING.pop()
        if apart := thresholds_apart(study):
            if self.is_own(study):
                live = {name: of_page for name, (_, of_page) in apart.items()}
                RATING_THRESHOLDS.set(live | RATING_THRESHOLDS.get())
            set_thresholds({name: of_clips for name, (of_clips, _) in apart.items()})
            st.rerun()
        return True

    def introduce(self, study: RatingStudy) -> None:
        """Explain what is rated, and how."""
        st.markdown(
            f"You will see **{count_text(len(study.clips), 'short clip')}** of drives. A system "
            "that looks out for pedestrians draws a box around everyone it finds.\n\n"
            "Imagine that you drive with this system. After each clip, say **how annoying** its "
            f"mistakes are, from {study.low} ({ENDS[0]}) to {study.high} ({ENDS[1]}). There is no "
            "right or wrong answer. Every rating is kept at once: you may stop at any time and go "
            "on later with a code that you get."
        )
        if study.alerts:
            st.markdown(
                f"Then you see {count_text(len(study.alerts), 'alert')} of such a system, and say "
                "of each whether it was worth it."
            )

    def draw_trial(
        self, store: RatingStore, study: RatingStudy, person: Person, left: list[Any]
    ) -> bool:
        """Draw a clip or an alert."""
        result = state.result()
        assert result is not None
        return ClipScreen(result, store, study, person.name).draw(person.plan, left)

    def draw_end(self, person: Person) -> None:
        """Draw which answers are stored, and offer to change the last rating."""
        n_clips = sum(shown.table == "rating" for shown in person.plan)
        n_alerts = len(person.plan) - n_clips
        alerts = f", all {n_alerts} alerts answered" if n_alerts else ""
        st.success(f"All {n_clips} clips are rated{alerts}, and what you said is kept.")
        offer_change()

    def on_back(self) -> None:
        """Set the thresholds of the conductor's own page."""
        set_thresholds(RATING_THRESHOLDS.pop())

    def draw_setup(self) -> None:
        """Draw the form that begins a session about the open comparison."""
        result = state.result()
        assert result is not None
        session_setup.draw_setup(self, result)

    def draw_notes(self) -> None:
        """Draw what participants' browsers need if files other than those at the start are open."""
        start = state.shared_start().opened
        if state.opened().dataset.fingerprint != start.dataset.fingerprint:
            st.caption(
                "A participant's browser must have the same files open: open them there on the "
                "Data page first, or let them rate on this screen."
            )

    def draw_downloads(self, store: RatingStore, study: RatingStudy) -> None:
        """Draw the buttons that save ratings, answers about alerts, and forms."""
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

    def progress(self, store: RatingStore, study: RatingStudy) -> Progress:
        """Return the number of clips and alerts that each participant has answered."""
        people, n_clips = store.progress(study), len(study.clips)
        n_ratings = int(people["n_rated"].sum())
        columns = {
            "participant": TableColumn("Participant", is_head=True),
            "n_rated": TableColumn(f"Rated, of {n_clips}"),
        }
        if study.alerts:
            columns["n_answered"] = TableColumn(f"Alerts answered, of {len(study.alerts)}")
        metrics = {
            "participants": (len(people), None),
            "have rated all clips": (int((people["n_rated"] == n_clips).sum()), None),
            "ratings so far": (n_ratings, None),
        }
        note = 'Whether they agree is told under "Results", with ratings from "Rating session".'
        return Progress(metrics, people, columns, note if n_ratings else "")

    def draw_results(self, store: RatingStore, study: RatingStudy) -> None:
        """Draw the agreement about alerts, once there are answers."""
        if study.alerts and len(answers := store.worth(study)):
            session_setup.draw_worth(answers)


SESSIONS: Final = RatingSessions()


def choose_part() -> str:
    """Draw the choice of the page's part. A conductor's link opens the rating session."""
    RATINGS_PART.setdefault("session" if CONDUCT in st.query_params else "results")
    return choose_side_by_side("Part", PARTS, RATINGS_PART.key, label_visibility="collapsed")


def draw_waiting() -> None:
    """Draw the next step for a participant whose session belongs to another comparison."""
    waiting = RATING_WAITING.get()
    if waiting is None:
        return
    token, code = waiting
    study = SESSIONS.store().study(token)
    if study is None:
        RATING_WAITING.pop()
    elif _is_open(study):
        st.info("The comparison of the rating session is open now.")
        if button("Go on with the rating session", type="primary", key="rating_go_on"):
            enter(token, code)
    else:
        st.warning(
            "The rating session of this link is about another comparison than the one that is "
            "open. Open its files on the Data page, with the same systems as X and Y, then come "
            "back to this page: it goes on from there. Ratings that were given are kept.",
            icon=":material/folder_open:",
        )
        if button("Open the Data page", type="primary", key="rating_open_data"):
            open_page("data")


def _is_open(study: RatingStudy) -> bool:
    """Return True if the open comparison has the clips of the session."""
    systems = {clip.system for clip in study.clips} | {alert.system for alert in study.alerts}
    return state.opened().dataset.fingerprint == study.fingerprint and systems <= set(
        state.systems()
    )
