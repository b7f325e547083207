"""Detectability studies on their page. See `ui.subjects.people.studies.Studies`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from itertools import groupby
from typing import Any, Final

import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.wording import count_text
from nvcore.subjects.driver.inputs.study_tables import LATE_S, LEAST_PEDESTRIANS
from nvcore.subjects.driver.study.pictures import PRACTICE_SIZE
from nvcore.subjects.driver.study.plan import duration_s
from nvcore.subjects.driver.study.touch_task import (
    DetectabilityStore,
    DetectabilityStudy,
    about,
    boxes_table,
    participants_table,
    trials_table,
)
from nvcore.subjects.people.store import Person
from ui.session import state
from ui.session.store import PRACTISED
from ui.shell.messages import shown_error
from ui.subjects.driver.study import setup
from ui.subjects.driver.study.files import folder_of
from ui.subjects.driver.study.on_screen import PRACTICE, OnScreen
from ui.subjects.driver.study.screen import ScreenTrial, draw_run
from ui.subjects.people.participant import draw_code
from ui.subjects.people.studies import ON_SCREEN, Progress, Studies, leave_screen
from ui.widgets.choices import download_csv
from ui.widgets.table import TableColumn
from ui.widgets.text import docs_link

COMMANDS: Final = """\
nvcore driver features --images PICTURES --boxes boxes.csv --out features.csv
nvcore driver train trials.csv --features features.csv --out driver.npz
"""
INSTRUCTIONS: Final = """\
Look at the **bright screen**, then at the coarse picture of the place where you will look for a \
pedestrian, then at the **cross**. The screen goes **dark** at once, and after some seconds the \
picture appears, for a moment. Then **touch or click the place** where the pedestrian was, or \
press *Not seen*. By keyboard: arrow keys move a mark (with Shift in small steps), Enter takes its \
place, N is *not seen*. A second picture follows.

**You may stop at any time:** press *Stop* at the edge on the lower right, or Esc. In the dark the \
button is not to be seen, but it works at the same place.
"""


class TouchStudies(Studies[DetectabilityStudy, DetectabilityStore]):
    """Detectability studies."""

    opens = DetectabilityStore
    page = "study"
    what = "study"
    prefix = "study"
    variable = "NVCORE_STUDIES"
    file_name = "studies.sqlite"
    start = "Start the study"
    title = "Take part in a study"
    begin = "Take part"
    here = "Take part on this screen"
    back = "Back to the study"

    def introduce(self, study: DetectabilityStudy) -> None:
        """Draw the number of pictures and the duration."""
        trials = study.plan(0)
        length = setup.length_text(duration_s(trials, study.settings.timing))
        st.markdown(
            f"You will see {count_text(len(trials), 'picture')} in "
            f"{count_text(trials[-1].run, 'short run')}: **{length}** in all. You may pause after "
            "every run, and go on later."
        )

    def explain(self) -> None:
        """Draw the limits of a screen."""
        with st.expander("What a screen cannot be"):
            st.markdown(setup.LIMITS)

    def usual(self, study: DetectabilityStudy) -> Mapping[str, float | None]:
        """Return screen and distance as measured by the conductor."""
        return asdict(study.settings.facts)

    def draw_trial(
        self, store: DetectabilityStore, study: DetectabilityStudy, person: Person, left: list[Any]
    ) -> bool:
        """Draw a practice run, or the next run with trials that have no answer."""
        try:
            folder = folder_of(study.folder)
        except InputError as error:
            leave_screen(state.workspace())
            st.error(shown_error(error))
            return True
        if not left:
            return False
        described = study.settings.facts.screen_text(person.form)
        screen = OnScreen(store, study, person.name, folder, described)
        state.workspace().notes[ON_SCREEN] = screen
        n_practised = PRACTISED.of(person.name).get()
        if not person.has_practised and n_practised < study.settings.n_practice:
            _draw_practice(screen, n_practised)
            return True
        run = [*next(own for _, own in groupby(left, key=lambda trial: trial.run))]
        number, n_runs = run[0].run, person.plan[-1].run
        st.markdown(f"# Run {number} of {n_runs}")
        st.progress((run[0].order - 1) / len(person.plan))
        draw_code()
        if number == 1:
            st.markdown(INSTRUCTIONS)
        pictures = [study.pictures[trial.picture] for trial in run]
        trials = [
            ScreenTrial(of.place, str(of.picture), picture.width, picture.height, of.adaptation_s)
            for of, picture in zip(run, pictures, strict=True)
        ]
        name, title = f"{run[0].order} of {person.name}", f"Begin run {number} of {n_runs}"
        draw_run(screen, name, title, trials)
        return True

    def draw_end(self, person: Person) -> None:
        """Draw a note that all answers are stored."""
        st.success(f"You have answered all {len(person.plan)} pictures, and your answers are kept.")

    def draw_setup(self) -> None:
        """Draw the form that begins a study."""
        setup.draw_setup(self)

    def draw_downloads(self, store: DetectabilityStore, study: DetectabilityStudy) -> None:
        """Draw the buttons that save trials, boxes, participants and settings."""
        tables = {
            "trials": lambda: trials_table(store, study),
            "boxes": lambda: boxes_table(study),
            "participants": lambda: participants_table(store, study),
        }
        for name, make in tables.items():
            download_csv(f"{name.capitalize()} (CSV)", make, f"{name}.csv", f"study_{name}")
        st.download_button(
            "Settings (JSON)",
            data=lambda: json.dumps(about(study), indent=2),
            file_name="study.json",
            mime="application/json",
            on_click="ignore",
            icon=":material/download:",
            key="study_about",
        )

    def progress(self, store: DetectabilityStore, study: DetectabilityStudy) -> Progress:
        """Return the number of answered and of marked trials of each participant."""
        people = participants_table(store, study)
        hint = (
            f"More than {1000 * LATE_S:g} ms early or late, shown for more or less than asked, "
            "shown again after a reload, never reported as shown, or without an answer in time. "
            "They stay in the table, with the reason."
        )
        has_finished = people["n_answered"] == people["n_trials"]
        metrics = {
            "participants": (len(people), None),
            "have seen all pictures": (int(has_finished.sum()), None),
            "trials so far": (int(people["n_answered"].sum()), None),
            "marked": (int(people["n_marked"].sum()), hint),
        }
        columns = {
            "subject": TableColumn("Participant", is_head=True),
            "joined": TableColumn("Joined"),
            "n_trials": TableColumn("Trials"),
            "n_answered": TableColumn("Answered"),
            "n_marked": TableColumn("Marked"),
        }
        return Progress(metrics, people, columns)

    def draw_results(self, store: DetectabilityStore, study: DetectabilityStudy) -> None:
        """Explain how the tables become an estimate."""
        del store, study
        with st.expander("From the answers to an estimate"):
            st.caption(
                "Save trials and boxes. An estimator needs "
                f"{LEAST_PEDESTRIANS} pedestrians or more at each time "
                f"({docs_link('more', 'estimators', doc='driver-reference')}); "
                "the page Driver takes it."
            )
            st.code(COMMANDS, language="sh")


def _draw_practice(screen: OnScreen, n_practised: int) -> None:
    settings, n = screen.study.settings, screen.study.settings.n_practice
    st.title("Practice" if n == 1 else f"Practice {n_practised + 1} of {n}")
    times_s = settings.timing.pairs[n_practised % len(settings.timing.pairs)]
    trials = [
        ScreenTrial(0, f"{PRACTICE}{i}", *PRACTICE_SIZE, time_s) for i, time_s in enumerate(times_s)
    ]
    name = f"practice {n_practised + 1} of {screen.name}"

    def end(run: str) -> None:
        if run != name:
            return
        PRACTISED.of(screen.name).set(n_practised + 1)
        if n_practised + 1 >= n:
            screen.store.end_practice(screen.study, screen.name)

    draw_code()
    st.markdown(INSTRUCTIONS)
    draw_run(screen, name, "Begin the practice", trials, on_end=end)
    st.caption("Answers of the practice are not kept.")


TOUCH: Final = TouchStudies()
