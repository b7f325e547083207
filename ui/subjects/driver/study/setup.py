"""Form that begins a study, with the study's duration."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.wording import count_text
from nvcore.subjects.driver.inputs.study_tables import LEAST_PEDESTRIANS
from nvcore.subjects.driver.study.pictures import BOXES_FILE, StudyPicture, read_pictures
from nvcore.subjects.driver.study.plan import duration_s, plan_trials
from nvcore.subjects.driver.study.settings import (
    ADAPTATION_S,
    CONSENT,
    DESIGNS,
    LONGEST_S,
    Facts,
    StudySettings,
    Timing,
    asked_of,
)
from nvcore.subjects.driver.study.touch_task import DetectabilityStore, DetectabilityStudy
from ui.session import state
from ui.shell.messages import errors_shown
from ui.subjects.driver.study.files import folder_of, folders
from ui.subjects.people.conduct import ask_terms, offer_start
from ui.subjects.people.studies import Studies
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import docs_link, plain

LIMITS: Final = (
    "A screen goes from white to black, at a few hundred candela per square metre at best: a small "
    "part of the step from a lit street or an oncoming car to a dark road, and black on most "
    "screens still glows. The pupil answers to the whole field of view, of which a screen is a "
    "small part: without control of the room's light its size is not known. Glare, motion, "
    "stereo vision and the periphery are missing. What is measured is how soon people find a "
    "pedestrian in a picture **on this screen**; what that says about a road is for a study on a "
    "road to show."
)
MOST_TIMES_TEXT: Final = 200
"""Maximum length of the field for the times after the change of light, characters."""


@errors_shown()
def draw_setup(studies: Studies[DetectabilityStudy, DetectabilityStore]) -> None:
    """Draw the form that begins a study."""
    st.header("Start a study")
    folder = _choose_folder()
    if folder is None:
        return
    settings = _draw_settings()
    pictures = _pictures(folder)
    _draw_length(pictures, settings)
    if len(pictures) < LEAST_PEDESTRIANS:
        st.warning(
            f"Too few for an estimator, which needs {LEAST_PEDESTRIANS} pedestrians or more at "
            "each time: good for a try.",
            icon=":material/warning:",
        )
    st.info(LIMITS, icon=":material/info:")
    offer_start(studies, lambda store: store.begin(settings, pictures, folder=folder))


def _choose_folder() -> str | None:
    names = folders()
    st.caption(
        f"A folder with pictures of one pedestrian each and a table {BOXES_FILE} "
        "(image, pedestrian, x, y, w, h in pixels). It has to stay where it is while the study "
        f"runs ({docs_link('more', 'pictures', doc='study')})."
    )
    if not names:
        st.info(
            "There is no such folder here. Whoever runs the app names the folder that holds it: "
            "`nvcore app --local-root DIR`. Pictures are not sent for this: participants open the "
            "study on other days and screens, when what was sent is long gone.",
            icon=":material/folder_open:",
        )
        return None
    folder: str = st.selectbox(
        "Pictures", list(names), format_func=names.__getitem__, key="study_folder", width=420
    )
    return folder


def _pictures(name: str) -> tuple[StudyPicture, ...]:
    folder: Path = folder_of(name)
    try:
        changed = (folder / BOXES_FILE).stat().st_mtime_ns
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=BOXES_FILE) from error
    return state.cached("study_pictures", (name, changed), lambda: read_pictures(folder))


def _draw_settings() -> StudySettings:
    design = choose_side_by_side("Design", DESIGNS, "study_design", default="latin")
    with st.expander("Times"):
        st.caption(
            "A run shows its first picture at one of the first half of these times, its second at "
            f"the one half the list later ({docs_link('why', 'a-run', doc='study')})."
        )
        times_text = st.text_input(
            "Seconds from dark to each picture",
            ", ".join(f"{time_s:g}" for time_s in ADAPTATION_S),
            key="study_adaptation_s",
            max_chars=MOST_TIMES_TEXT,
            width=420,
        )
        parts_s = {
            name: column.number_input(
                f"{label}, s", *(0.0, LONGEST_S, usual, 0.1), format="%g", key=f"study_{name}"
            )
            for column, (name, label, usual) in zip(
                st.columns(3) * 2, asked_of(Timing), strict=True
            )
        }
        n_practice = st.number_input("Practice runs", 0, 10, 1, key="study_n_practice", width=200)
    with st.expander("Screen, distance and light, as measured"):
        st.caption(
            "They are kept with the answers; what is not known stays empty. A lux meter at the eye "
            "tells the light. Participants may state a screen and distance of their own."
        )
        facts = {
            name: column.number_input(label, min_value=0.1, value=usual, key=f"study_{name}")
            for column, (name, label, usual) in zip(st.columns(4), asked_of(Facts), strict=True)
        }
    with st.expander("Consent, form, and how long answers are kept"):
        consent, questions, keep_days = ask_terms(
            CONSENT,
            "study",
            "Days until the study is deleted with all answers",
            questions="Own questions, one a line, after age, vision and driving licence",
        )
    # last, because an error would remove all fields below it with their values
    return StudySettings(
        design=design,
        timing=Timing(adaptation_s=_times(times_text), **parts_s),
        facts=Facts(**facts),
        consent=consent,
        questions=questions or (),
        n_practice=int(n_practice),
        keep_days=keep_days,
    )


def _times(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.replace(";", ",").split(",") if part.strip())
    except ValueError as error:
        raise InputError(
            "times after the change of light: expected seconds, separated by commas"
        ) from error


def _draw_length(pictures: tuple[StudyPicture, ...], settings: StudySettings) -> None:
    """Draw the duration and the cost of the design."""
    trials = plan_trials(len(pictures), 0, design=settings.design, timing=settings.timing)
    n_times = len(settings.timing.adaptation_s)
    n_runs = trials[-1].run
    st.markdown(
        f"**{count_text(len(pictures), 'picture')}:** each participant sees "
        f"{count_text(len(trials), 'picture')} in {count_text(n_runs, 'run')}, "
        f"**{length_text(duration_s(trials, settings.timing))}** without breaks."
    )
    if settings.design == "all":
        st.warning(
            f"Everybody sees each picture {n_times} times, and learns where its pedestrian is: "
            "later times come out better than they are, as far as they come later. The order is "
            "random for each participant, so that no time is always the last.",
            icon=":material/psychology:",
        )
    else:
        st.caption(
            f"Over {n_times} participants each picture is shown once at each of the {n_times} "
            f"times; take a multiple of {n_times}. Detectability of a picture at a time is then "
            f"a share among a {plain('sixth' if n_times == 6 else f'{n_times}th part')} of the "
            "participants."
        )


def length_text(seconds: float) -> str:
    """Return a duration in words.

    Examples
    --------
    >>> length_text(50), length_text(600), length_text(7100)
    ('about 50 seconds', 'about 10 minutes', 'about 2.0 hours')
    """
    if seconds < 90:
        return f"about {max(round(seconds / 10) * 10, 10)} seconds"
    if seconds < 5400:
        return f"about {round(seconds / 60)} minutes"
    return f"about {seconds / 3600:.1f} hours"
