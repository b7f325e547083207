"""Page of a participant: terms and form, then one trial after the other, then thanks."""

from __future__ import annotations

from collections.abc import Mapping

import streamlit as st

from nvcore.subjects.people.form import CHOICES, MOST_QUESTION
from nvcore.subjects.people.participants import MOST_NAME
from nvcore.subjects.people.store import Person
from ui.session import state
from ui.shell.messages import errors_shown
from ui.subjects.people.studies import PARTICIPANT, STUDY, B, S, Studies, enter, leave_screen
from ui.widgets.buttons import button, submit_button
from ui.widgets.text import plain


def draw(studies: Studies[S, B]) -> None:
    """Draw the page, without the rest of the app."""
    store = studies.store()
    study: S | None = store.study(st.query_params[STUDY])
    if study is None:
        leave_screen(state.workspace())
        st.title(studies.title)
        st.error(f"This link leads to no {studies.what}, or it is over. Ask for it again.")
    elif studies.is_ready(study):
        code = st.query_params.get(PARTICIPANT, "").strip()
        person = store.by_code(study, code) if code else None
        if person is None:
            leave_screen(state.workspace())
            if code:
                st.error(
                    f"Nobody takes part in this {studies.what} with the code in the address. If "
                    "you have taken part already, ask the person who conducts it for a new code."
                )
            _welcome(studies, study, store)
        elif not studies.draw_trial(store, study, person, store.left(study, person)):
            _thank(studies, study, person)


def draw_code() -> None:
    """Show the participant's personal code, which only the address has."""
    st.caption(
        f"Your code is **{plain(st.query_params.get(PARTICIPANT, ''))}**. Note it down: with it "
        "you go on later, ask for your answers, or have them deleted."
    )


def _welcome(studies: Studies[S, B], study: S, store: B) -> None:
    prefix = studies.prefix
    st.title(studies.title)
    studies.introduce(study)
    for paragraph in study.consent.split("\n\n"):
        st.markdown(plain(" ".join(paragraph.split())))
    if study.ends_at is not None:
        st.markdown(
            f"Your {studies.answers} are kept until **{study.ends_at:%d %B %Y}** and then deleted, "
            "earlier if you ask for it."
        )
    studies.explain()
    with st.form(f"{prefix}_join", border=False):
        answers = {}
        if study.form:
            st.markdown("**About you.** Leave empty what you do not want to say.")
            answers = draw_form(study.form, prefix, usual=studies.usual(study))
        name = ""
        if store.has_names:
            name = st.text_input(
                "Your name, or a pseudonym that you were given",
                key=f"{prefix}_name",
                max_chars=MOST_NAME,
                autocomplete="off",
                width=420,
            )
        agrees = not study.consent or st.checkbox(
            "I have read this and agree to take part", key=f"{prefix}_agrees"
        )
        is_sent = submit_button(studies.begin, type="primary", key=f"{prefix}_begin")
    if is_sent and not agrees:
        st.warning("Without your agreement nothing is kept, and there is nothing to take part in.")
    elif is_sent:
        with errors_shown():  # the form stays as it was filled in
            enter(study.token, store.join(study, answers, name=name)[1])
    with st.expander("I have a code already"):
        code = st.text_input(
            "Your code", key=f"{prefix}_known_code", max_chars=MOST_NAME, width=420
        )
        if button("Go on", key=f"{prefix}_continue"):
            if store.by_code(study, code) is None:
                st.warning(f"Nobody takes part in this {studies.what} with that code.")
            else:
                enter(study.token, code)
    _offer_back(studies, study)


def _thank(studies: Studies[S, B], study: S, person: Person) -> None:
    leave_screen(state.workspace())
    st.title("Thank you")
    studies.draw_end(person)
    draw_code()
    if button("Next participant", key=f"{studies.prefix}_next"):
        enter(study.token)
    _offer_back(studies, study)


def _offer_back(studies: Studies[S, B], study: S) -> None:
    """Draw the button back to the conductor's page, if this browser session conducts the study."""
    if studies.is_own(study) and button(
        studies.back, key=f"{studies.prefix}_back", type="tertiary", icon=":material/arrow_back:"
    ):
        st.query_params.clear()
        studies.conduct(study)
        studies.on_back()
        st.rerun()


def draw_form(
    form: Mapping[str, str], key: str, *, usual: Mapping[str, float | None]
) -> dict[str, str]:
    """Draw the fields with these labels, and return those that were filled in.

    Screen and distance begin with their `usual` values.
    """
    answers: dict[str, str] = {}
    columns = st.columns(3)
    for number, (field, label) in enumerate(form.items()):
        column, own = columns[number % 3], f"{key}_form_{number}"
        if field in CHOICES:
            answers[field] = column.selectbox(label, CHOICES[field], index=None, key=own) or ""
        elif field == "age":
            age = column.number_input(label, 1, 120, None, key=own)
            answers[field] = "" if age is None else str(age)
        elif field in ("screen_inch", "distance_cm"):
            size = column.number_input(label, 1.0, 1000.0, usual.get(field), format="%g", key=own)
            answers[field] = "" if size is None else f"{size:g}"
        else:
            answers[field] = st.text_input(plain(label), key=own, max_chars=MOST_QUESTION).strip()
    return {field: text for field, text in answers.items() if text}
