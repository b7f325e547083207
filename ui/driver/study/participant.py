"""What a participant of a study sees: consent and form, then one run after the other."""

from __future__ import annotations

from dataclasses import asdict
from itertools import groupby
from typing import Any

import streamlit as st

from nvcore.driver.study.plan import Trial, duration_s, plan_trials
from nvcore.driver.study.practice import FIGURES, SIZE
from nvcore.driver.study.records import DetectabilityStudy, Participant
from nvcore.driver.study.store import DetectabilityStore
from nvcore.errors import InputError
from nvcore.people.participants import MOST_NAME
from nvcore.wording import count_text
from ui.driver.study.files import STUDIES, folder_of
from ui.driver.study.on_screen import PRACTICE, OnScreen
from ui.driver.study.screen import draw_run
from ui.driver.study.setup import LIMITS, length_text
from ui.people.form import draw_form
from ui.people.studies import ON_SCREEN, PARTICIPANT, STUDY, enter, leave_screen
from ui.people.terms import draw_consent
from ui.session import state
from ui.session.store import PRACTISED
from ui.shell.messages import shown_error
from ui.widgets.buttons import button, submit_button


def draw() -> None:
    """The page for somebody who takes part: nothing else of the app is in sight."""
    store = STUDIES.store()
    study = store.study(st.query_params[STUDY])
    if study is None:
        leave_screen(state.workspace())
        st.title("Take part in a study")
        st.error("This link leads to no study, or the study is over. Ask for it again.")
        return
    code = st.query_params.get(PARTICIPANT, "")
    participant = store.participant(study, code) if code.strip() else None
    if participant is None:
        if code.strip():
            st.error("Nobody takes part in this study with the code in the address.")
        _welcome(study, store)
        return
    try:
        folder = folder_of(study.folder)
    except InputError as error:
        leave_screen(state.workspace())
        st.error(shown_error(error))
        return
    screen = study.settings.facts.screen_text(dict(participant.form))
    note = OnScreen(store, study, participant.code, folder, screen)
    state.workspace().notes[ON_SCREEN] = note
    _next(note, participant)


def _welcome(study: DetectabilityStudy, store: DetectabilityStore) -> None:
    leave_screen(state.workspace())
    settings = study.settings
    st.title("Take part in a study")
    trials = plan_trials(len(study.pictures), 0, design=settings.design, timing=settings.timing)
    st.markdown(
        f"You will see {count_text(len(trials), 'picture')} in "
        f"{count_text(trials[-1].run, 'short run')}: "
        f"**{length_text(duration_s(trials, settings.timing))}** in all. You may pause after every "
        "run, and go on later."
    )
    draw_consent(settings.consent)
    st.markdown(
        f"Your answers are kept until **{study.ends_at:%d %B %Y}** and then deleted, earlier if "
        "you ask for it."
    )
    with st.expander("What a screen cannot be"):
        st.markdown(LIMITS)
    with st.form("study_join", border=False):
        st.markdown("**About you and your screen.** Leave empty what you do not want to say.")
        form = draw_form(settings.form, "study", usual=asdict(settings.facts))
        agrees = st.checkbox("I have read this and agree to take part", key="study_agrees")
        is_sent = submit_button("Take part", type="primary", key="study_take_part")
    if is_sent and not agrees:
        st.warning("Without your agreement nothing is kept, and there is nothing to take part in.")
    elif is_sent:
        try:
            person = store.join(study, form)
        except InputError as error:
            st.error(shown_error(error))
        else:
            enter(study.token, person.code)
    with st.expander("I have a code already"):
        code = st.text_input("Your code", key="study_known_code", max_chars=MOST_NAME, width=420)
        if button("Go on", key="study_go_on"):
            known = store.participant(study, code)
            if known is None:
                st.warning("Nobody takes part in this study with that code.")
            else:
                enter(study.token, known.code)
    _back(study)


def _next(screen: OnScreen, person: Participant) -> None:
    study = screen.study
    left = screen.store.left(study, person)
    n_practised = PRACTISED.of(person.code).get()
    if not person.has_practised and n_practised < study.settings.n_practice:
        _practise(screen, person, n_practised)
    elif left:
        _run(screen, person, next([*run] for _, run in groupby(left, key=lambda trial: trial.run)))
    else:
        _thanks(study, person)


def _practise(screen: OnScreen, person: Participant, n_practised: int) -> None:
    study = screen.study
    n = study.settings.n_practice
    st.title("Practice" if n == 1 else f"Practice {n_practised + 1} of {n}")
    _draw_code(person)
    _draw_instructions()
    times = study.settings.timing.pairs[n_practised % len(study.settings.timing.pairs)]
    size = {"width": SIZE[0], "height": SIZE[1]}
    trials: list[dict[str, Any]] = [
        {"place": 0, "picture": f"{PRACTICE}{i}", **size, "adaptation_s": times[i]}
        for i in range(len(FIGURES))
    ]

    def practised(run: str) -> None:
        if run != name:
            return
        PRACTISED.of(person.code).set(n_practised + 1)
        if n_practised + 1 >= n:
            screen.store.end_practice(study, person.code)

    name = f"practice {n_practised + 1} of {person.code}"
    draw_run(
        name,
        "Begin the practice",
        trials,
        study.settings.timing,
        whose=screen.whose,
        on_end=practised,
    )
    st.caption("Answers of the practice are not kept.")


def _run(screen: OnScreen, person: Participant, run: list[Trial]) -> None:
    study = screen.study
    n_runs = person.plan[-1].run
    st.markdown(f"# Run {run[0].run} of {n_runs}")
    st.progress((run[0].order - 1) / len(person.plan))
    _draw_code(person)
    if run[0].run == 1:
        _draw_instructions()
    trials = []
    for trial in run:
        picture = study.pictures[trial.picture]
        trials.append(
            {
                "place": trial.order,
                "picture": str(trial.picture),
                "width": picture.width,
                "height": picture.height,
                "adaptation_s": trial.adaptation_s,
            }
        )
    draw_run(
        f"{run[0].order} of {person.code}",
        f"Begin run {run[0].run} of {n_runs}",
        trials,
        study.settings.timing,
        whose=screen.whose,
        on_end=lambda _: None,  # what is left is asked of the file
    )


def _draw_code(person: Participant) -> None:
    st.caption(
        f"Your code is **{person.code}**. Note it down: with it you go on later, ask for your "
        "answers, or have them deleted."
    )


def _draw_instructions() -> None:
    st.markdown(
        "Look at the **bright screen**, then at the coarse picture of the place where you will "
        "look for a pedestrian, then at the **cross**. The screen goes **dark** at once, and after "
        "some seconds the picture appears, for a moment. Then **touch or click the place** where "
        "the pedestrian was, or press *Not seen*. By keyboard: arrow keys move a mark (with Shift "
        "in small steps), Enter takes its place, N is *not seen*. A second picture follows."
    )
    st.markdown(
        "**You may stop at any time:** press *Stop* at the edge on the lower right, or Esc. In the "
        "dark the button is not to be seen, but it works at the same place."
    )


def _thanks(study: DetectabilityStudy, person: Participant) -> None:
    leave_screen(state.workspace())
    st.title("Thank you")
    st.success(f"You have answered all {len(person.plan)} pictures, and your answers are kept.")
    _draw_code(person)
    if button("Next participant", key="study_next"):
        enter(study.token)
    _back(study)


def _back(study: DetectabilityStudy) -> None:
    """The way back for who conducts on this very screen."""
    if STUDIES.is_own(study) and button(
        "Back to the study", key="study_back", type="tertiary", icon=":material/arrow_back:"
    ):
        st.query_params.clear()
        STUDIES.conduct(study)
        st.rerun()
