"""What a participant of a rating session sees: one clip after the other, and the scale."""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
import streamlit as st

from nvcore.analysis import Result
from nvcore.errors import InputError
from nvcore.ratings.store import MOST_NAME, RatingStore, Study
from ui import ratings_links, state
from ui.navigate import open_page
from ui.ratings_links import PARTICIPANT, STUDY
from ui.text import plain
from ui.viewed import viewed
from ui.viewer import viewer

ENDS: Final = ("not annoying at all", "very annoying")
"""Of the scale (paper, figure 9)."""
HEIGHT_PX: Final = 640
WAITING: Final = "rating_waiting"
Letter = Literal["x", "y"]


def draw() -> None:
    """The page for somebody who takes part: nothing else of the app is in sight."""
    token = st.query_params[STUDY]
    store = ratings_links.store()
    study = store.study(token)
    if study is None:
        st.title("Rate clips")
        st.error("This link leads to no rating session. Ask for it again.")
        return
    result = state.result()
    if result is None or not _is_open(study):
        st.session_state[WAITING] = token, st.query_params.get(PARTICIPANT)
        st.query_params.clear()
        st.rerun()
    st.session_state.pop(WAITING, None)
    _show_its_boxes(study)
    name = st.query_params.get(PARTICIPANT, "")
    if not name.strip() or len(name.strip()) > MOST_NAME:
        _welcome(study, store)
        return
    order = store.order(study, name)
    rated = store.rated(study, name)
    left = [clip for clip in order if clip not in rated]
    if left:
        _clip(result, study, store, name, left)
    else:
        _thanks(study)


def draw_waiting() -> None:
    """For whom a participant's link was opened while another comparison is open."""
    if WAITING not in st.session_state:
        return
    token, name = st.session_state[WAITING]
    study = ratings_links.store().study(token)
    if study is None:
        del st.session_state[WAITING]
        return
    if not _is_open(study):
        st.warning(
            "The rating session of this link is about another comparison than the one that is "
            "open. Open its files on the Data page, with the same systems as X and Y, then come "
            "back to this page: it goes on from there. Ratings that were given are kept.",
            icon=":material/folder_open:",
        )
        if st.button("Open the Data page", type="primary", key="rating_open_data"):
            open_page("data")
        return
    st.info("The comparison of the rating session is open now.")
    if st.button("Go on with the rating session", type="primary", key="rating_go_on"):
        enter(token, name)


def enter(token: str, name: str | None = None) -> None:
    """Show the rating session to a participant, on this screen."""
    st.query_params.clear()
    st.query_params[STUDY] = token
    if name:
        st.query_params[PARTICIPANT] = name
    st.rerun()


def _is_open(study: Study) -> bool:
    """Whether what is open has the clips of the study."""
    dataset = state.workspace().dataset
    assert dataset is not None
    named = {system for _, system in study.clips}
    return dataset.fingerprint == study.fingerprint and named <= set(state.systems())


def _show_its_boxes(study: Study) -> None:
    """Take the study's thresholds: everybody sees the same boxes."""
    live = ratings_links.shown_thresholds()
    for letter, system in zip("xy", state.systems(), strict=True):
        span = None if system is None else state.score_span(system)
        if span is None or system not in study.thresholds:
            continue
        wanted = study.thresholds[system]
        if wanted is not None:
            wanted = None if wanted <= span[0] else min(wanted, span[1])
        if live[system] != wanted:
            state.set_threshold(letter, wanted)
            st.rerun()


def _welcome(study: Study, store: RatingStore) -> None:
    st.title("Rate clips")
    n = len(study.clips)
    st.markdown(
        f"You will see **{n} short clip{'s' if n != 1 else ''}** of drives. A system that "
        "looks out for pedestrians draws a box around everyone it finds.\n\n"
        "Imagine that you drive with this system. After each clip, say **how annoying** its "
        f"mistakes are, from {study.low} ({ENDS[0]}) to {study.high} ({ENDS[1]}). There is no "
        "right or wrong answer. Every rating is kept at once: you may stop at any time and go on "
        "later with the same name."
    )
    with st.form("rating_join", border=False):
        name = st.text_input(
            "Your name, or the code that you were given", key="rating_name", max_chars=MOST_NAME,
            autocomplete="off", width=420,
        )  # fmt: skip
        is_sent = st.form_submit_button("Begin", type="primary")
    if is_sent:
        try:
            store.order(study, name or "")
        except InputError as error:
            st.error(plain(str(error)))
        else:
            st.query_params[PARTICIPANT] = (name or "").strip()
            st.rerun()
    _back(study)


def _clip(result: Result, study: Study, store: RatingStore, name: str, left: list[int]) -> None:
    clip, n = left[0], len(study.clips)
    number = n - len(left) + 1
    st.markdown(f"# Clip {number} of {n}")
    st.progress((number - 1) / n)
    recording, system = study.clips[clip]
    letter: Letter = "x" if system == result.x.name else "y"
    if not _played(result, state.recording_names().index(recording), letter, clip, name):
        st.caption("Watch the clip to its end; then say how annoying it was.")
        return
    with st.container(key="rating_scale"):
        st.markdown("**How annoying would it be to drive with this system?**")
        chosen = _scale(study, clip)
    if chosen is not None:
        store.rate(study, name, clip, chosen)
        st.rerun()


def _scale(study: Study, clip: int) -> int | None:
    """The buttons of the scale; the value of the one that was pressed."""
    values = range(study.low, study.high + 1)
    chosen = None
    for value, column in zip(values, st.columns(len(values)), strict=True):
        if column.button(str(value), key=f"rating_{clip}_{value}", width="stretch"):
            chosen = value
    left, right = st.columns(2)
    left.caption(f"{study.low} = {ENDS[0]}")
    right.caption(f"{study.high} = {ENDS[1]}", text_alignment="right")
    return chosen


def _played(result: Result, recording: int, letter: Letter, clip: int, name: str) -> bool:
    """Show the clip; whether it was seen to its end."""
    first, last = result.dataset.frame_columns.first[recording : recording + 2].tolist()
    lo, hi = state.STRETCH
    nothing = np.full(last - first, np.nan)
    row = viewer(
        **viewed(result, recording),
        traces={"x": nothing, "y": nothing},
        low=0.0,
        intervals=((), ()),
        misses=(),
        names=("", ""),
        seek=(0, 0),
        lo=lo,
        hi=hi,
        height_px=HEIGHT_PX,
        key=f"clip_{clip}_of_{name}",
        only=letter,
    )
    return row is None or row == last - first - 1


def _thanks(study: Study) -> None:
    st.title("Thank you")
    st.success(f"All {len(study.clips)} clips are rated, and your ratings are kept.")
    if st.button("Next participant", key="rating_next"):
        del st.query_params[PARTICIPANT]
        st.rerun()
    _back(study)


def _back(study: Study) -> None:
    """The way back for who conducts on this very screen."""
    if ratings_links.is_own(study) and st.button(
        "Back to the results", key="rating_back", type="tertiary", icon=":material/arrow_back:"
    ):
        st.query_params.clear()
        ratings_links.conduct(study)
        st.rerun()
